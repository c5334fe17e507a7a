"""Which arrays are taken, and what is said about those that are not."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import halfline
import numpy as np
import pytest
from meshes import bumpy_sphere, random_rays
from numpy.typing import NDArray

Array = NDArray[Any]

# Rays whose numbers are exact in every type that is tried: multiples of 1/8 within (-8, 8).
RAYS = np.round(random_rays(500, seed=5) * 8.0) / 8.0
ORIGINS, DIRECTIONS = RAYS[:, :3].copy(), RAYS[:, 3:].copy()


@pytest.fixture(scope="module")
def scene() -> halfline.Scene:
    """Something to hit."""
    shape = bumpy_sphere()
    return halfline.Scene(shape.vertices, shape.faces)


class WithArray:
    """Something that only knows how to become an array."""

    def __init__(self, array: Array) -> None:
        self.array = array

    def __array__(self, dtype: Any = None, copy: Any = None) -> Array:
        return self.array if dtype is None else self.array.astype(dtype)


def every_other_row(array: Array) -> Array:
    wide = np.full((2 * len(array), 3), np.nan, dtype=array.dtype)
    wide[::2] = array
    return wide[::2]


def part_of_wider_rows(array: Array) -> Array:
    wide = np.full((len(array), 8), np.nan, dtype=array.dtype)
    wide[:, 2:5] = array
    return wide[:, 2:5]


def read_only(array: Array) -> Array:
    array = array.copy()
    array.flags.writeable = False
    return array


def misaligned(array: Array) -> Array:
    memory = np.empty(array.nbytes + 1, dtype=np.uint8)
    moved = memory[1:].view(array.dtype).reshape(array.shape)
    moved[...] = array
    assert not moved.flags.aligned
    return moved


def byte_swapped(array: Array) -> Array:
    return array.astype(array.dtype.newbyteorder())


FORMS: dict[str, Callable[[Array], Any]] = {
    "as it is": lambda array: array,
    "every other row": every_other_row,
    "part of wider rows": part_of_wider_rows,
    "Fortran order": np.asfortranarray,
    "reversed": lambda array: array[::-1].copy()[::-1],
    "read-only": read_only,
    "misaligned": misaligned,
    "byte-swapped": byte_swapped,
    "list": lambda array: array.tolist(),
    "tuple of arrays": lambda array: tuple(array),
    "with __array__": WithArray,
    "subclass": lambda array: array.view(type("Special", (np.ndarray,), {})),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_every_form_of_an_array_is_taken(scene: halfline.Scene, form: str, dtype: Any) -> None:
    expected = scene.intersect(ORIGINS, DIRECTIONS)
    assert 100 < expected.hit.sum() < 500
    make = FORMS[form]
    hits = scene.intersect(make(ORIGINS.astype(dtype)), make(DIRECTIONS.astype(dtype)))
    np.testing.assert_array_equal(hits.t, expected.t)
    np.testing.assert_array_equal(hits.face, expected.face)
    np.testing.assert_array_equal(hits.uv, expected.uv)


@pytest.mark.parametrize("form", [form for form in FORMS if form != "list"])
def test_every_form_of_a_range_is_taken(scene: halfline.Scene, form: str) -> None:
    t_max = np.linspace(0.5, 1.5, 500)
    expected = scene.occluded(ORIGINS, DIRECTIONS, t_max=t_max)
    spread = FORMS[form](np.tile(t_max[:, np.newaxis], (1, 3)))
    # The first column of whatever that is.
    column = np.asarray(spread)[:, 0]
    np.testing.assert_array_equal(scene.occluded(ORIGINS, DIRECTIONS, t_max=column), expected)
    assert 50 < expected.sum() < 450


@pytest.mark.parametrize("dtype", [np.int8, np.int16, np.int32, np.int64, np.uint8, np.uint64])
def test_integers_are_taken(scene: halfline.Scene, dtype: Any) -> None:
    unsigned = np.dtype(dtype).kind == "u"
    origins = np.array([[0, 0, 0], [1, 1, 1]], dtype=dtype)
    directions = np.array([[1, 2, 3], [2, 1, 0] if unsigned else [-1, -1, -1]], dtype=dtype)
    hits = scene.intersect(origins, directions, t_min=dtype(0), t_max=dtype(100))
    expected = scene.intersect(origins.astype(float), directions.astype(float))
    np.testing.assert_array_equal(hits.t, expected.t)
    assert hits.hit.any()


def test_precisions_may_be_mixed(scene: halfline.Scene) -> None:
    # 0.1 is no single-precision number: it would show if directions were rounded.
    origins = ORIGINS.astype(np.float32)
    directions = DIRECTIONS + 0.1
    hits = scene.intersect(origins, directions)
    np.testing.assert_array_equal(hits.t, scene.intersect(ORIGINS, directions).t)
    rounded = scene.intersect(origins, directions.astype(np.float32))
    assert np.any(hits.t != rounded.t)


def test_a_range_is_not_rounded_to_the_precision_of_the_rays() -> None:
    square = halfline.Scene([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    origins = np.array([[0.75, 0.25, 0.1]], dtype=np.float32)
    down = np.array([0, 0, -1], dtype=np.float32)
    assert not square.occluded(origins, down, t_max=0.1).any()
    assert square.occluded(origins, down, t_max=np.float32(0.1)).all()


def test_arguments_are_not_changed(scene: halfline.Scene) -> None:
    origins, directions = ORIGINS.copy(), DIRECTIONS.copy()
    scene.intersect_all(origins, directions)
    np.testing.assert_array_equal(origins, ORIGINS)
    np.testing.assert_array_equal(directions, DIRECTIONS)


def test_one_array_may_be_both(scene: halfline.Scene) -> None:
    both = ORIGINS - 1.0 / 16.0
    np.testing.assert_array_equal(scene.occluded(both, both), scene.occluded(both, both.copy()))


WRONG: list[tuple[str, Any, type[Exception], str]] = [
    ("a number", 1.0, ValueError, "expected shape (..., 3), found ()"),
    ("pairs", np.zeros((5, 2)), ValueError, "expected shape (..., 3), found (5, 2)"),
    ("columns", np.zeros((3, 5)), ValueError, "expected shape (..., 3), found (3, 5)"),
    ("ragged", [[1, 2, 3], [1, 2]], ValueError, "found what NumPy cannot make an array of"),
    ("complex", np.zeros((5, 3), complex), TypeError, "found complex128"),
    ("bool", np.zeros((5, 3), bool), TypeError, "found bool"),
    ("objects", np.zeros((5, 3), object), TypeError, "found object"),
    ("None", None, TypeError, "found object"),
    ("strings", [["1", "2", "3"]], TypeError, "found str"),
    ("dates", np.zeros((5, 3), "M8[s]"), TypeError, "found datetime64[s]"),
    ("masked", np.ma.zeros((5, 3)), TypeError, "found a masked one"),
    ("longdouble", np.zeros((5, 3), np.longdouble), TypeError, "convert it with .astype"),
]


@pytest.mark.parametrize(
    ("value", "kind", "message"), [w[1:] for w in WRONG], ids=[w[0] for w in WRONG]
)
@pytest.mark.parametrize("name", ["origins", "directions"])
@pytest.mark.parametrize("ask", ["intersect", "occluded", "count_intersections", "intersect_all"])
def test_what_is_no_array_of_rays_is_refused_by_name(
    scene: halfline.Scene, ask: str, name: str, value: Any, kind: type[Exception], message: str
) -> None:
    arguments = {"origins": np.zeros((5, 3)), "directions": np.ones((5, 3)), name: value}
    with pytest.raises(kind, match=f"^{name}: .*{re.escape(message)}"):
        getattr(scene, ask)(**arguments)


@pytest.mark.parametrize("name", ["t_min", "t_max"])
def test_a_wrong_range_is_refused_by_name(scene: halfline.Scene, name: str) -> None:
    wrong: list[Any] = ["1", None, True, 1j]
    for value in wrong:
        options = {name: value}
        with pytest.raises(TypeError, match=f"^{name}: expected float32, float64 or integers"):
            scene.occluded(ORIGINS, DIRECTIONS, **options)


def test_shapes_that_do_not_fit_are_refused(scene: halfline.Scene) -> None:
    message = r"broadcast together, found origins \(5,\), directions \(4,\)$"
    with pytest.raises(ValueError, match=message):
        scene.intersect(np.zeros((5, 3)), np.ones((4, 3)))
    message = r"found origins \(5,\), directions \(5,\), t_max \(3,\)$"
    with pytest.raises(ValueError, match=message):
        scene.intersect(np.zeros((5, 3)), np.ones((5, 3)), t_max=np.ones(3))


def test_options_are_keywords(scene: halfline.Scene) -> None:
    ask: Any = scene.intersect
    with pytest.raises(TypeError, match="positional"):
        ask(ORIGINS, DIRECTIONS, 0.0)
