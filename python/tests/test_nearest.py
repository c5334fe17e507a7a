"""`Scene`'s questions about points, beside judges that look at every face."""

from __future__ import annotations

import pickle
import re
from pathlib import Path
from typing import Any

import halfline
import numpy as np
import pytest
from meshes import Floats, Shape, bumpy_sphere, gridded_cube
from nearest_by_hand import nearest
from solid_angles import winding_numbers
from test_arrays import FORMS, WRONG

PARTS = ("distance", "point", "face", "uv", "feature", "normal", "found")
NUMBERS = ("signed_distance", "winding_number", "contains")
ALL = ("closest_points", *NUMBERS)

# Points whose numbers are exact in every type that is tried: multiples of 1/8 within (-2, 2).
POINTS = np.round(np.random.default_rng(6).uniform(-2.0, 2.0, size=(500, 3)) * 8.0) / 8.0


def open_sphere() -> Shape:
    """The bumpy sphere without the faces of its top."""
    shape = bumpy_sphere(12, 20)
    is_low = shape.corners()[..., 2].max(axis=1) < 0.6
    return Shape(shape.vertices, shape.faces[is_low])


def soup() -> Shape:
    """Faces in all directions, some without area, some with a corner that is not finite."""
    random = np.random.default_rng(7)
    corners = random.uniform(-1.0, 1.0, size=(120, 1, 3)) + random.normal(size=(120, 3, 3)) * 0.2
    corners[5] = corners[5, :1]
    corners[6, 2] = corners[6, 0]
    corners[7, 2] = 2.0 * corners[7, 1] - corners[7, 0]
    corners[8, 1, 1] = np.nan
    corners[9, 2, 0] = np.inf
    corners[11] = corners[10]
    return Shape(corners.reshape(-1, 3), np.arange(360).reshape(-1, 3))


SHAPES = {
    "bumpy": bumpy_sphere(12, 20),
    "open": open_sphere(),
    "grid": gridded_cube(3),
    "soup": soup(),
    "one": Shape(np.eye(3), np.array([[0, 1, 2]])),
}


@pytest.fixture(scope="module")
def scene() -> halfline.Scene:
    """Something to be near to."""
    return scene_of(SHAPES["bumpy"])


def scene_of(shape: Shape) -> halfline.Scene:
    return halfline.Scene(shape.vertices, shape.faces)


def points_near(shape: Shape) -> Floats:
    """Points all around, on the faces, and at vertices."""
    random = np.random.default_rng(8)
    finite = shape.corners()[np.isfinite(shape.corners()).all(axis=(1, 2))]
    around = random.uniform(-1.7, 1.7, size=(150, 3))
    some = finite[random.integers(0, len(finite), 50)]
    weights = random.dirichlet([1.0, 1.0, 1.0], size=50)
    on = np.einsum("ni,nij->nj", weights, some)
    off = on + random.normal(size=on.shape) * 1e-3
    return np.vstack([around, on, off, some[:20, 0]])


@pytest.mark.parametrize("name", SHAPES)
def test_the_nearest_points_are_those_of_the_judge(name: str) -> None:
    shape = SHAPES[name]
    points = points_near(shape)
    near = scene_of(shape).closest_points(points)
    judged = nearest(shape, points)
    distance, _, _ = judged.at(judged.face)
    assert near.found.all()
    np.testing.assert_allclose(near.distance, distance, rtol=1e-12, atol=1e-15)
    # The face that was told is as near, and no lower one is nearer by more than rounding.
    at_face, point, feature = judged.at(near.face)
    np.testing.assert_allclose(at_face, distance, rtol=1e-12, atol=1e-15)
    lower = np.where(np.arange(len(shape.faces)) < near.face[:, None], judged.squared, np.inf)
    assert (np.sqrt(lower.min(axis=1)) >= near.distance * (1.0 - 1e-12) - 1e-15).all()
    np.testing.assert_allclose(near.point, point, atol=1e-12)
    is_clear = at_face > 1e-6
    is_face = (near.feature == "face") & is_clear
    np.testing.assert_array_equal(near.feature[is_clear] == "face", feature[is_clear] == "face")
    # What is told of the point agrees with itself.
    a, b, c = np.moveaxis(shape.corners()[near.face], 1, 0)
    u, v = near.uv[:, :1], near.uv[:, 1:]
    np.testing.assert_allclose((1.0 - u - v) * a + u * b + v * c, near.point, atol=1e-12)
    away = np.linalg.norm(points - near.point, axis=1)
    np.testing.assert_allclose(away, near.distance, atol=1e-12)
    normal = np.cross(b - a, c - a)[is_face]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    np.testing.assert_allclose(near.normal[is_face], normal, atol=1e-12)
    if len(shape.faces) > 1:
        assert {*near.feature.tolist()} == {"face", "edge", "vertex"}


def test_on_a_grid_ties_go_to_the_lowest_face_and_features_are_exact() -> None:
    shape = gridded_cube(3)
    # All multiples of a half in and around the cube: its middle is as far from six faces and more.
    axis = np.arange(-1.0, 4.25, 0.5)
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    near = scene_of(shape).closest_points(points)
    judged = nearest(shape, points)
    np.testing.assert_array_equal(near.face, judged.face)
    distance, point, feature = judged.at(judged.face)
    np.testing.assert_array_equal(near.distance, distance)
    np.testing.assert_array_equal(near.point, point)
    np.testing.assert_array_equal(near.feature, feature)
    tied = (judged.squared == judged.squared.min(axis=1, keepdims=True)).sum(axis=1)
    assert tied.max() >= 12
    on_surface = distance == 0.0
    assert on_surface.sum() > 100
    np.testing.assert_array_equal(near.point[on_surface], points[on_surface])


@pytest.mark.parametrize("name", SHAPES)
def test_the_winding_numbers_are_sums_of_solid_angles(name: str) -> None:
    shape = SHAPES[name]
    points = np.random.default_rng(9).uniform(-1.5, 1.5, size=(200, 3))
    scene = scene_of(shape)
    numbers = scene.winding_number(points)
    judged = winding_numbers(shape, points)
    # The judge's sums are of some hundred angles.
    np.testing.assert_allclose(numbers, judged, atol=2e-9)
    if name == "bumpy":
        np.testing.assert_array_equal(numbers, np.rint(judged))
        assert {*numbers.tolist()} == {0.0, 1.0}
    is_clear = np.abs(judged - 0.5) > 1e-8
    inside = scene.contains(points)
    np.testing.assert_array_equal(inside[is_clear], judged[is_clear] > 0.5)
    signed = scene.signed_distance(points)
    np.testing.assert_array_equal(np.abs(signed), scene.closest_points(points).distance)
    np.testing.assert_array_equal(signed < 0.0, inside)


def test_parity_is_for_surfaces_without_orientation() -> None:
    # Opposite sides of this cube are turned alike, so they do not wind around anything together.
    cube = scene_of(gridded_cube(4))
    points = np.random.default_rng(10).uniform(-1.0, 5.0, size=(500, 3))
    inside = ((points > 0.0) & (points < 4.0)).all(axis=1)
    np.testing.assert_array_equal(cube.contains(points, rule="parity"), inside)
    assert (cube.contains(points) != inside).any()
    with pytest.raises(ValueError, match="rule: expected 'winding' or 'parity', found 'odd'"):
        cube.contains(points, rule="odd")


def test_what_is_on_the_surface_is_contained_and_has_no_distance(scene: halfline.Scene) -> None:
    shape = SHAPES["bumpy"]
    a, b, _ = np.moveaxis(shape.corners(), 1, 0)
    # Vertices are on it exactly, and so are those of middles that need no rounding.
    points = np.vstack([shape.vertices, (0.5 * (a + b)).astype(np.float32)])
    distance = scene.signed_distance(points)
    on = distance == 0.0
    assert on[: len(shape.vertices)].all()
    assert not np.signbit(distance[on]).any()
    assert scene.contains(points[on]).all()
    assert scene.contains(points[on], rule="parity").all()
    np.testing.assert_array_equal(scene.closest_points(points[on]).point, points[on])


def parts_of(scene: halfline.Scene, points: Any, **options: Any) -> list[np.ndarray[Any, Any]]:
    near = scene.closest_points(points, **options)
    numbers = [getattr(scene, name)(points) for name in NUMBERS]
    return [*(getattr(near, part) for part in PARTS), *numbers]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_every_form_of_an_array_is_taken(scene: halfline.Scene, form: str, dtype: Any) -> None:
    given = FORMS[form](POINTS.astype(dtype))
    for found, expected in zip(parts_of(scene, given), parts_of(scene, POINTS), strict=True):
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("dtype", [np.int8, np.int32, np.int64, np.uint8, np.uint64])
def test_integers_are_taken(scene: halfline.Scene, dtype: Any) -> None:
    points = np.array([[0, 0, 0], [1, 2, 3], [0, 1, 1]], dtype=dtype)
    for found, expected in zip(
        parts_of(scene, points, max_distance=dtype(3)),
        parts_of(scene, points.astype(float), max_distance=3.0),
        strict=True,
    ):
        np.testing.assert_array_equal(found, expected)


def test_points_are_not_rounded_to_the_precision_of_the_mesh() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float32)
    square = halfline.Scene(corners, [[0, 1, 2]])
    point = np.array([0.1, 0.1, 1e-20])
    near = square.closest_points(point)
    assert near.distance == 1e-20
    assert near.point.tolist() == [0.1, 0.1, 0.0]
    assert square.closest_points(point.astype(np.float32)).distance == np.float32(1e-20)


@pytest.mark.parametrize("shape", [(), (1,), (7,), (2, 3), (1, 0, 2), (3, 1, 2, 2)])
def test_leading_dimensions_are_kept(scene: halfline.Scene, shape: tuple[int, ...]) -> None:
    points = np.random.default_rng(11).uniform(-1.5, 1.5, size=(*shape, 3))
    near = scene.closest_points(points)
    assert near.shape == shape
    widths = {"point": (3,), "normal": (3,), "uv": (2,)}
    dtypes = {"face": "int64", "found": "bool", "feature": "str192"}
    for part in PARTS:
        array = getattr(near, part)
        assert array.shape == shape + widths.get(part, ())
        assert array.dtype.name == dtypes.get(part, "float64")
    for name, dtype in zip(NUMBERS, ("float64", "float64", "bool"), strict=True):
        answer = getattr(scene, name)(points)
        assert (answer.shape, answer.dtype.name) == (shape, dtype)
    flat = scene.closest_points(points.reshape(-1, 3))
    np.testing.assert_array_equal(near.distance.ravel(), flat.distance)


def test_no_points_give_no_answers(scene: halfline.Scene) -> None:
    nothing: list[Any] = [[], np.empty((0, 3)), np.empty((0, 3), np.float32)]
    for points in nothing:
        assert scene.closest_points(points).point.shape == (0, 3)
        for name in NUMBERS:
            assert getattr(scene, name)(points).shape == (0,)
    assert scene.closest_points(np.zeros((0, 3)), max_distance=np.zeros(1)).shape == (0,)


def test_nothing_is_near_in_a_mesh_without_faces() -> None:
    empty = halfline.Scene(np.zeros((0, 3)), np.zeros((0, 3), dtype=int))
    near = empty.closest_points([[0, 0, 0], [1, 2, 3]])
    assert not near.found.any()
    assert empty.winding_number([0, 0, 0]) == 0.0
    assert not empty.contains([0, 0, 0])
    assert empty.signed_distance([0, 0, 0]) == np.inf


def test_what_is_not_finite_is_near_to_nothing(scene: halfline.Scene) -> None:
    points = np.zeros((7, 3))
    points[range(6), [0, 1, 2] * 2] = [np.nan, np.nan, np.nan, np.inf, -np.inf, np.inf]
    near = scene.closest_points(points)
    assert near.found.tolist() == [False] * 6 + [True]
    nothing = near[:6]
    assert np.isposinf(nothing.distance).all()
    assert (nothing.face == -1).all()
    assert np.isnan(nothing.point).all()
    assert np.isnan(nothing.uv).all()
    assert np.isnan(nothing.normal).all()
    assert nothing.feature.tolist() == [""] * 6
    for name in ("signed_distance", "winding_number"):
        assert np.isnan(getattr(scene, name)(points)).tolist() == [True] * 6 + [False]
    for rule in ("winding", "parity"):
        assert scene.contains(points, rule=rule).tolist() == [False] * 6 + [True]


def test_only_what_is_within_max_distance_counts(scene: halfline.Scene) -> None:
    everything = scene.closest_points(POINTS)
    exactly = everything.distance
    assert scene.closest_points(POINTS, max_distance=exactly).found.all()
    less = scene.closest_points(POINTS, max_distance=np.nextafter(exactly, -1.0))
    assert not less.found[exactly > 0.0].any()
    half = scene.closest_points(POINTS, max_distance=0.5)
    np.testing.assert_array_equal(half.found, exactly <= 0.5)
    assert 50 < half.found.sum() < 450
    for part in PARTS:
        found, expected = getattr(half[half.found], part), getattr(everything[half.found], part)
        np.testing.assert_array_equal(found, expected)
    for none in (-1.0, np.nan, -np.inf, np.full(500, np.nan)):
        assert not scene.closest_points(POINTS, max_distance=none).found.any()
    on = SHAPES["bumpy"].vertices
    assert scene.closest_points(on, max_distance=0.0).found.all()


def test_max_distance_is_broadcast(scene: halfline.Scene) -> None:
    points = POINTS[:12].reshape(3, 4, 3)
    most = np.linspace(0.1, 1.5, 4)
    near = scene.closest_points(points, max_distance=most)
    assert near.shape == (3, 4)
    np.testing.assert_array_equal(near.found, scene.closest_points(points).distance <= most)
    grown = scene.closest_points(points[0, 0], max_distance=np.float32(most)[:, None])
    assert grown.shape == (4, 1)
    np.testing.assert_array_equal(
        grown.found[:, 0], scene.closest_points(points[0, 0]).distance <= np.float32(most)
    )
    message = r"^points, max_distance: .* found points \(3, 4\), max_distance \(3,\)$"
    with pytest.raises(ValueError, match=message):
        scene.closest_points(points, max_distance=np.ones(3))
    wrong: list[Any] = ["1", None, True, 1j]
    for value in wrong:
        with pytest.raises(TypeError, match=r"^max_distance: expected float32, float64 or int"):
            scene.closest_points(points, max_distance=value)


@pytest.mark.parametrize(
    ("value", "kind", "message"), [w[1:] for w in WRONG], ids=[w[0] for w in WRONG]
)
@pytest.mark.parametrize("name", ALL)
def test_what_is_no_array_of_points_is_refused(
    scene: halfline.Scene, name: str, value: Any, kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=f"^points: .*{re.escape(message)}"):
        getattr(scene, name)(value)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_number_of_threads_makes_no_difference(scene: halfline.Scene, count: int) -> None:
    points = np.random.default_rng(12).uniform(-1.5, 1.5, size=(20_000, 3))
    before = halfline.thread_count()
    expected = parts_of(scene, points)
    try:
        halfline.set_thread_count(count)
        found = parts_of(scene, points)
    finally:
        halfline.set_thread_count(before)
    for one, other in zip(found, expected, strict=True):
        assert one.tobytes() == other.tobytes()
    # Nor does the number of points that are asked about together.
    for one, other in zip(parts_of(scene, points[77]), expected, strict=True):
        assert one.tobytes() == other[77:78].tobytes()


@pytest.mark.parametrize("index", [3, -1, slice(2, 9, 3), [4, 4, 0], np.arange(12) % 3 == 1, ...])
def test_some_of_the_nearest_are_those(scene: halfline.Scene, index: Any) -> None:
    near = scene.closest_points(POINTS[:12], max_distance=0.7)
    some = near[index]
    assert some.shape == np.arange(12)[index].shape
    for part in PARTS:
        np.testing.assert_array_equal(getattr(some, part), getattr(near, part)[index])


def test_the_nearest_are_a_sequence(scene: halfline.Scene) -> None:
    near = scene.closest_points(POINTS[:12].reshape(3, 4, 3))
    assert len(near) == 3 == len([*near])
    assert [row.distance.tolist() for row in near] == near.distance.tolist()
    np.testing.assert_array_equal(near[1, 2].point, near.point[1, 2])
    np.testing.assert_array_equal(near[..., 0].uv, near.uv[:, 0])
    with pytest.raises(TypeError, match="nearest point of a single point has no length"):
        len(near[0, 0])
    with pytest.raises(ValueError, match=r"\.found\.any\(\) or \.all\(\)"):
        bool(near)
    assert near[0, 0]
    assert not scene.closest_points([9, 9, 9], max_distance=1)
    assert near.mesh is scene.mesh


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_the_nearest_are_pickled(scene: halfline.Scene, protocol: int) -> None:
    near = scene.closest_points(POINTS, max_distance=0.6)
    again = pickle.loads(pickle.dumps(near, protocol))
    assert type(again) is halfline.Nearest
    for part in PARTS:
        np.testing.assert_array_equal(getattr(again, part), getattr(near, part))


def test_they_say_what_they_are(scene: halfline.Scene) -> None:
    square = halfline.Scene([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    near = square.closest_points([[1, 1, 2], [-3, -4, 0], [9, 9, 9]], max_distance=6)
    assert repr(near) == "<halfline.Nearest of shape (3,): 3 points, 2 found, 2 to 5 as distance>"
    assert [repr(one) for one in near] == [
        "<halfline.Nearest: face 0 at distance 2, point=(1, 1, 0), in its inside>",
        "<halfline.Nearest: face 0 at distance 5, point=(0, 0, 0), in its vertex>",
        "<halfline.Nearest: nothing>",
    ]
    assert repr(near[2:]) == "<halfline.Nearest of shape (1,): 1 points, 0 found>"
    html = near._repr_html_()
    assert "Nearest" in html
    assert "2 to 5" in html


def test_options_are_keywords(scene: halfline.Scene) -> None:
    ask: Any = scene.closest_points
    with pytest.raises(TypeError, match="positional"):
        ask(POINTS, 1.0)
    inside: Any = scene.contains
    with pytest.raises(TypeError, match="positional"):
        inside(POINTS, "parity")


def test_a_scene_from_a_file_answers_alike(scene: halfline.Scene, tmp_path: Path) -> None:
    scene.save(tmp_path / "bumpy.hlt")
    opened = halfline.open(tmp_path / "bumpy.hlt")
    for one, other in zip(parts_of(opened, POINTS), parts_of(scene, POINTS), strict=True):
        np.testing.assert_array_equal(one, other)
