"""What the doubles take for inside: of surfaces without holes by parity, of others by winding."""

from __future__ import annotations

import halfline
import numpy as np
import pytest
from halfline._inside import is_closed, is_enclosed
from meshes import Floats, Ints, gridded_cube

# Opposite sides of this cube are turned alike: it is closed, and has no orientation.
CUBE = gridded_cube(2)

POINTS = np.random.default_rng(1).uniform(-1.0, 3.0, size=(300, 3))
INSIDE = ((POINTS > 0.0) & (POINTS < 2.0)).all(axis=1)


def apart() -> tuple[Floats, Ints]:
    """Each face with corners of its own, as in an STL file."""
    return CUBE.corners().reshape(-1, 3), np.arange(3 * len(CUBE.faces)).reshape(-1, 3)


def apart_with_both_zeros() -> tuple[Floats, Ints]:
    """Corners of its own for each face, whose zeros have one sign or the other."""
    vertices, faces = apart()
    vertices[::2] = np.where(vertices[::2] == 0.0, -0.0, vertices[::2])
    return vertices, faces


def with_more(*faces: list[int]) -> tuple[Floats, Ints]:
    vertices = np.vstack([CUBE.vertices, [[np.nan, 0.0, 0.0]]])
    return vertices, np.vstack([CUBE.faces, *faces])


NAN = len(CUBE.vertices)

CLOSED = {
    "as it is": (CUBE.vertices, CUBE.faces),
    "apart": apart(),
    "apart, with both zeros": apart_with_both_zeros(),
    "with faces that are points and segments": with_more([0, 0, 0], [3, 3, 9], [5, 2, 5]),
    "with a face that is not finite": with_more([0, 1, NAN]),
    "with the same face twice": with_more([0, 1, 9], [0, 1, 9]),
    "nothing": (np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)),
}


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_surfaces_without_holes_go_by_parity(name: str, dtype: type) -> None:
    vertices, faces = CLOSED[name]
    scene = halfline.Scene(vertices.astype(dtype), faces)
    assert is_closed(scene.mesh)
    inside = is_enclosed(scene, POINTS)
    np.testing.assert_array_equal(inside, INSIDE if len(faces) else np.zeros(300, dtype=bool))
    # The second time it is known.
    np.testing.assert_array_equal(is_enclosed(scene, POINTS[7]), inside[7])


@pytest.mark.parametrize("name", ["without a face", "with one more"])
def test_others_go_by_winding_numbers(name: str) -> None:
    sphere = halfline.generate("sphere", 1280)
    loose = np.array([[0, 200, 400]])
    faces = sphere.faces[1:] if name == "without a face" else np.vstack([sphere.faces, loose])
    for each in (faces, faces[:, ::-1]):
        scene = halfline.Scene(sphere.vertices, each)
        assert not is_closed(scene.mesh)
        away = np.linalg.norm(POINTS, axis=1)
        numbers = scene.winding_number(POINTS)
        found = is_enclosed(scene, POINTS)
        np.testing.assert_array_equal(found, np.abs(np.rint(numbers)) == 1.0)
        assert found[away < 0.5].all()
        assert not found[away > 1.5].any()


def test_what_is_not_finite_is_outside() -> None:
    sphere = halfline.generate("sphere", 320)
    for faces in (sphere.faces, sphere.faces[1:]):
        scene = halfline.Scene(sphere.vertices, faces)
        points = [[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0]]
        assert is_enclosed(scene, points).tolist() == [True, False, False]
