"""What `halfline.open3d` says of points, beside what Open3D 0.20 answered."""

from __future__ import annotations

import halfline
import numpy as np
import pytest
from halfline.open3d import RaycastingScene
from numpy.typing import DTypeLike
from open3d_recording import FACE, RECORDING, TRIANGLE, filled, same, same_answers

POINT_METHODS = (
    "compute_closest_points",
    "compute_distance",
    "compute_occupancy",
    "compute_signed_distance",
)


@pytest.mark.parametrize(("name", "rays"), [("occupancy", 1), ("occupancy_voted", 3)])
def test_occupancy_is_that_of_open3d(name: str, rays: int) -> None:
    scene = filled(("outer",))
    same(scene.compute_occupancy(RECORDING["points"], nsamples=rays), RECORDING[name])


def test_nearest_points_are_those_of_open3d() -> None:
    scene, points, expected = filled(), RECORDING["points"], RECORDING.answer("closest")
    found = scene.compute_closest_points(points, nthreads=1)
    same(found["points"], expected["points"])
    same(scene.compute_distance(points), RECORDING["distance"])
    same(found["geometry_ids"], expected["geometry_ids"])
    assert set(found["geometry_ids"].ravel().tolist()) == {0, 1, 2}
    assert set(found) == set(expected)
    # On edges and vertices Open3D tells any of the faces.
    vertices, triangles = RECORDING["outer_vertices"], RECORDING["outer_triangles"]
    near = halfline.Scene(vertices, triangles).closest_points(points)
    is_sure = (near.feature == "face") & (expected["geometry_ids"] == 0)
    assert is_sure.sum() > 5
    for key in ("primitive_ids", "primitive_uvs", "primitive_normals"):
        assert found[key].shape == expected[key].shape
        same(found[key][is_sure], expected[key][is_sure])


def test_nothing_is_near_in_an_empty_scene() -> None:
    scene, points = RaycastingScene(), RECORDING["points"]
    same_answers(scene.compute_closest_points(points), RECORDING.answer("empty_closest"))
    # Open3D tells the distance to the origin.
    assert np.isposinf(scene.compute_distance(points)).all()
    assert np.isposinf(scene.compute_signed_distance(points)).all()


@pytest.mark.parametrize(("name", "rays"), [("signed_distance", 1), ("signed_distance_voted", 3)])
def test_signed_distances_are_those_of_open3d(name: str, rays: int) -> None:
    found = filled(("outer",)).compute_signed_distance(RECORDING["points"], nsamples=rays)
    same(found, RECORDING[name])
    assert 5 < np.count_nonzero(found < 0.0) < 35


@pytest.mark.parametrize("vertex_dtype", [np.float32, np.float64])
def test_float64_points_are_answered_in_float64(vertex_dtype: DTypeLike) -> None:
    # Their last bits are lost in float32.
    moved = (RECORDING["outer_vertices"] + 1e-12).astype(vertex_dtype)
    faces = RECORDING["outer_triangles"]
    scene = RaycastingScene()
    scene.add_triangles(moved, faces)
    points = RECORDING["points"].astype(np.float64) + 1e-12
    assert scene.compute_occupancy(points).dtype == np.float64
    near = halfline.Scene(moved, faces).closest_points(points)
    closest = scene.compute_closest_points(points)
    np.testing.assert_array_equal(scene.compute_distance(points), near.distance, strict=True)
    np.testing.assert_array_equal(closest["points"], near.point, strict=True)
    np.testing.assert_array_equal(closest["primitive_uvs"], near.uv, strict=True)
    np.testing.assert_array_equal(closest["primitive_normals"], near.normal, strict=True)
    np.testing.assert_array_equal(abs(scene.compute_signed_distance(points)), near.distance)


def test_no_points_give_empty_answers() -> None:
    scene, none = filled(), RECORDING["points"][:0]
    same_answers(scene.compute_closest_points(none), RECORDING.answer("closest_none"))
    same(scene.compute_distance(none), RECORDING["distance_none"])
    same(scene.compute_signed_distance(none), RECORDING["distance_none"])
    same(scene.compute_occupancy(none), RECORDING["distance_none"])


def test_a_single_point_is_answered_without_dimensions() -> None:
    scene = filled()
    point, distance = RECORDING["points"][0, 1], RECORDING["distance"][0, 1]
    assert scene.compute_closest_points(point)["points"].shape == (3,)
    assert scene.compute_closest_points(point)["primitive_ids"].shape == ()
    same(scene.compute_distance(point), distance)
    assert scene.compute_occupancy(point).shape == ()
    assert abs(scene.compute_signed_distance(point)) == scene.compute_distance(point)


def test_points_that_are_not_finite_are_near_to_nothing() -> None:
    scene = filled()
    points = np.array([[np.nan, 0, 0], [0, np.inf, 0], [0, 0, 0]], dtype=np.float32)
    found = scene.compute_closest_points(points)
    assert found["primitive_ids"][:2].tolist() == [2**32 - 1] * 2
    assert not found["points"][:2].any()
    assert not found["primitive_normals"][:2].any()
    assert np.isnan(scene.compute_distance(points)).tolist() == [True, True, False]
    assert np.isnan(scene.compute_signed_distance(points)).tolist() == [True, True, False]
    assert scene.compute_occupancy(points)[:2].tolist() == [0.0, 0.0]


def test_the_nearest_of_equally_near_faces_is_that_with_the_lowest_ids() -> None:
    scene = RaycastingScene()
    scene.add_triangles(TRIANGLE + np.array([0, 0, 2], dtype=np.float32), FACE)
    scene.add_triangles(TRIANGLE, np.vstack([FACE, FACE]))
    found = scene.compute_closest_points(np.array([[0.25, 0.25, 2], [0.25, 0.25, 1.5]]))
    assert found["geometry_ids"].tolist() == [0, 1]
    assert found["primitive_ids"].tolist() == [0, 0]
    assert found["points"].tolist() == [[0.25, 0.25, 3.0], [0.25, 0.25, 1.0]]
    assert found["primitive_uvs"].tolist() == [[0.25, 0.25]] * 2
    assert found["primitive_normals"].tolist() == [[0.0, 0.0, 1.0]] * 2


def test_points_on_a_surface_have_no_sign() -> None:
    scene = filled(("outer",))
    distance = scene.compute_signed_distance(RECORDING["outer_vertices"])
    np.testing.assert_array_equal(distance, np.zeros(len(distance), dtype=np.float32), strict=True)
    assert not np.signbit(distance).any()


@pytest.mark.parametrize("turned", [False, True])
def test_the_inside_does_not_depend_on_orientation_or_leak_through_holes(turned: bool) -> None:
    vertices, faces = RECORDING["outer_vertices"], RECORDING["outer_triangles"]
    open_faces = faces[5:, ::-1] if turned else faces[5:]
    points = RECORDING["points"]
    for some in (faces[:, ::-1], open_faces):
        scene = RaycastingScene()
        scene.add_triangles(vertices, some)
        same(scene.compute_occupancy(points), RECORDING["occupancy"])


@pytest.mark.parametrize("method", POINT_METHODS)
def test_wrong_points_are_refused(method: str) -> None:
    ask = getattr(filled(), method)
    with pytest.raises(ValueError, match=r"query_points: expected shape \(..., 3\)"):
        ask(np.zeros((2, 6)))
    with pytest.raises(TypeError, match=r"query_points: expected float32.*complex"):
        ask(np.zeros((2, 3), dtype=complex))


@pytest.mark.parametrize("method", POINT_METHODS[2:])
@pytest.mark.parametrize("votes", [0, 2, -1])
def test_an_even_number_of_votes_is_refused(method: str, votes: int) -> None:
    with pytest.raises(ValueError, match=f"nsamples: expected an odd number.*found {votes}"):
        getattr(filled(), method)(np.zeros((2, 3)), nsamples=votes)
