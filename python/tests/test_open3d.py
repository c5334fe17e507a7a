"""`halfline.open3d` beside what Open3D 0.20 answered when tools/record_open3d.py asked it."""

from __future__ import annotations

import inspect
import pickle
import subprocess
import sys
from types import SimpleNamespace
from typing import Any

import halfline
import numpy as np
import pytest
from halfline.open3d import RaycastingScene
from meshes import gridded_cube
from numpy.typing import DTypeLike
from open3d_recording import FACE, RECORDING, TRIANGLE, Array, filled, same, same_answers


def sorted_hits(listed: dict[str, Array]) -> dict[str, Array]:
    """A list of hits in the order that is ours: Open3D lists those of a ray in any."""
    order = np.lexsort((listed["t_hit"], listed["ray_ids"]))
    return {key: array if key == "ray_splits" else array[order] for key, array in listed.items()}


def test_the_recording_has_hits_and_misses_of_each_geometry() -> None:
    assert RECORDING.head["open3d"] == "0.20.0"
    assert set(RECORDING["cast.geometry_ids"].ravel().tolist()) == {0, 2, 2**32 - 1}
    assert set(RECORDING["list.geometry_ids"].tolist()) == {0, 1, 2}
    for name in ("occluded", "occluded_within", "occupancy"):
        assert set(RECORDING[name].ravel().tolist()) == {0, 1}
    assert RECORDING["count"].max() > 5


@pytest.mark.parametrize("prefix", ["empty_", ""])
def test_answers_are_those_of_open3d(prefix: str) -> None:
    scene = RaycastingScene() if prefix else filled()
    rays = RECORDING["rays"]
    same_answers(scene.cast_rays(rays), RECORDING.answer(f"{prefix}cast"))
    same_answers(scene.list_intersections(rays), sorted_hits(RECORDING.answer(f"{prefix}list")))
    same(scene.count_intersections(rays), RECORDING[f"{prefix}count"])
    same(scene.test_occlusions(rays), RECORDING[f"{prefix}occluded"])


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("within", {"tnear": 0.7, "tfar": 0.8}),
        ("reversed", {"tnear": 0.8, "tfar": 0.7}),
        ("behind", {"tnear": -2.0}),
    ],
)
def test_occlusions_between_two_distances_are_those_of_open3d(
    name: str, options: dict[str, float]
) -> None:
    found = filled().test_occlusions(RECORDING["rays"], **options, nthreads=1)
    same(found, RECORDING[f"occluded_{name}"])


def test_no_rays_give_empty_answers() -> None:
    scene, none = filled(), RECORDING["rays"][:0]
    same_answers(scene.cast_rays(none), RECORDING.answer("cast_none"))
    same(scene.count_intersections(none), RECORDING["count_none"])
    # Open3D 0.20 crashes here.
    listed = scene.list_intersections(none)
    shapes = {"ray_splits": (1,), "primitive_uvs": (0, 2)}
    assert {key: array.shape for key, array in listed.items()} == {
        key: shapes.get(key, (0,)) for key in RECORDING.answer("list")
    }


@pytest.mark.parametrize("name", RECORDING.cameras)
def test_pinhole_rays_are_those_of_open3d(name: str) -> None:
    camera, expected = RECORDING.cameras[name], RECORDING[f"pinhole_{name}"]
    same(RaycastingScene.create_rays_pinhole(*camera), expected)
    create: Any = RaycastingScene().create_rays_pinhole
    names = (
        ("intrinsic_matrix", "extrinsic_matrix", "width_px", "height_px")
        if len(camera) == 4
        else ("fov_deg", "center", "eye", "up", "width_px", "height_px")
    )
    same(create(**dict(zip(names, camera, strict=True))), expected)


def test_a_camera_that_cannot_be_gives_no_directions() -> None:
    for rays in (
        RaycastingScene.create_rays_pinhole(90.0, [0, 0, 0], [0, 2, 0], [0, 1, 0], 3, 2),
        RaycastingScene.create_rays_pinhole(np.zeros((3, 3)), np.eye(4), 3, 2),
    ):
        assert rays.shape == (2, 3, 6)
        assert not np.isfinite(rays[..., 3:]).any()
        assert not filled().test_occlusions(rays).any()


@pytest.mark.parametrize("vertex_dtype", [np.float32, np.float64])
def test_float64_rays_are_answered_in_float64(vertex_dtype: DTypeLike) -> None:
    vertices, faces = RECORDING["outer_vertices"], RECORDING["outer_triangles"]
    # Their last bits are lost in float32.
    moved = (vertices + 1e-12).astype(vertex_dtype)
    scene = RaycastingScene()
    scene.add_triangles(moved, faces)
    rays = RECORDING["rays"].astype(np.float64)
    rays[..., :3] += 1e-12
    found = scene.cast_rays(rays)
    hits = halfline.Scene(moved, faces).intersect(rays[..., :3], rays[..., 3:])
    np.testing.assert_array_equal(found["t_hit"], hits.t, strict=True)
    np.testing.assert_array_equal(found["primitive_uvs"], hits.uv, strict=True)
    normals = found["primitive_normals"]
    np.testing.assert_array_equal(normals[hits.hit], hits.normal[hits.hit], strict=True)
    assert not normals[~hits.hit].any()
    listed = scene.list_intersections(rays)
    assert {key: array.dtype.name for key, array in listed.items()} == {
        "ray_splits": "uint32",
        "ray_ids": "uint32",
        "t_hit": "float64",
        "geometry_ids": "uint32",
        "primitive_ids": "uint32",
        "primitive_uvs": "float64",
    }


def test_geometry_of_both_precisions_is_not_rounded() -> None:
    triangle = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
    scene = RaycastingScene()
    scene.add_triangles(triangle.astype(np.float32), [[0, 1, 2]])
    scene.add_triangles(triangle + 2.0**-40, np.array([[0, 1, 2]], dtype=np.int16))
    ray = np.array([[0.25, 0.25, 0.0, 0.0, 0.0, 1.0]])
    listed = scene.list_intersections(ray)
    assert listed["t_hit"].tolist() == [1.0, 1.0 + 2.0**-40]
    assert listed["geometry_ids"].tolist() == [0, 1]


class Tensor:
    """What there is of an Open3D tensor."""

    def __init__(self, array: Array) -> None:
        self._array = array

    def numpy(self) -> Array:
        """What it holds."""
        return self._array


RAY = np.array([[0.25, 0.25, 0, 0, 0, 1]], dtype=np.float32)


@pytest.mark.parametrize(
    "arguments",
    [
        ((TRIANGLE, FACE), {}),
        ((TRIANGLE.tolist(), FACE.tolist()), {}),
        ((TRIANGLE,), {"triangle_indices": FACE.astype(np.int64)}),
        ((), {"vertex_positions": Tensor(TRIANGLE), "triangle_indices": Tensor(FACE)}),
        ((halfline.Mesh(TRIANGLE, FACE),), {}),
        ((), {"mesh": SimpleNamespace(vertices=TRIANGLE, triangles=FACE)}),
        (
            (
                SimpleNamespace(
                    vertex={"positions": Tensor(TRIANGLE)}, triangle={"indices": Tensor(FACE)}
                ),
            ),
            {},
        ),
    ],
)
def test_meshes_are_taken_in_many_forms(arguments: tuple[tuple[Any, ...], dict[str, Any]]) -> None:
    positional, named = arguments
    scene = RaycastingScene(nthreads=2, device="CPU:0")
    assert scene.add_triangles(*positional, **named) == 0
    assert scene.add_triangles(*positional, **named) == 1
    assert scene.cast_rays(RAY)["t_hit"].tolist() == [1.0]
    assert scene.count_intersections(Tensor(RAY), nthreads=2).tolist() == [2]


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ((), TypeError, "expected vertex_positions and triangle_indices, or mesh, found 0"),
        ((1, 2, 3), TypeError, "found 3 arguments"),
        ((TRIANGLE,), TypeError, "mesh: expected something with .* found ndarray"),
        ((TRIANGLE[:, :2], FACE), ValueError, r"vertices: expected shape \(n, 3\)"),
        ((TRIANGLE, FACE[:, :2]), ValueError, r"faces: expected shape \(m, 3\)"),
        ((TRIANGLE, FACE.astype(float)), TypeError, "faces: expected integers"),
        ((TRIANGLE, FACE + 1), ValueError, "3"),
    ],
)
def test_what_is_no_mesh_is_refused(
    arguments: tuple[Any, ...], error: type[Exception], words: str
) -> None:
    scene: Any = filled()
    with pytest.raises(error, match=words):
        scene.add_triangles(*arguments)
    assert scene.add_triangles(TRIANGLE, FACE) == 3


def test_one_argument_by_a_wrong_name_is_refused() -> None:
    scene: Any = RaycastingScene()
    with pytest.raises(TypeError, match="found 0 arguments, vertex_positions"):
        scene.add_triangles(vertex_positions=TRIANGLE)
    with pytest.raises(TypeError, match="found 1 arguments, vertex_positions"):
        scene.add_triangles(TRIANGLE, vertex_positions=TRIANGLE)


def test_geometry_may_be_added_after_questions() -> None:
    scene = RaycastingScene()
    assert not scene.test_occlusions(RAY)[0]
    # Neither geometry without triangles nor its place among others shifts any ID.
    assert scene.add_triangles(TRIANGLE[:0], FACE[:0]) == 0
    scene.add_triangles(TRIANGLE, np.vstack([FACE, FACE + 0]))
    assert scene.add_triangles(TRIANGLE[:0], FACE[:0]) == 2
    scene.add_triangles(TRIANGLE - np.array([0, 0, 0.5], dtype=np.float32), FACE)
    listed = scene.list_intersections(RAY)
    assert listed["geometry_ids"].tolist() == [3, 1, 1]
    assert listed["primitive_ids"].tolist() == [0, 0, 1]
    assert scene.add_triangles(TRIANGLE - np.array([0, 0, 0.75], dtype=np.float32), FACE) == 4
    assert scene.cast_rays(RAY)["geometry_ids"].tolist() == [4]


def test_the_scene_keeps_its_own_copy() -> None:
    vertices = TRIANGLE.copy()
    scene = RaycastingScene()
    scene.add_triangles(vertices, FACE)
    vertices[:] = 0.0
    assert scene.cast_rays(RAY)["t_hit"].tolist() == [1.0]


def test_a_single_ray_is_answered_without_dimensions() -> None:
    scene = filled()
    ray = RECORDING["rays"][0, 1]
    found = scene.cast_rays(ray)
    assert found["t_hit"].shape == ()
    assert found["primitive_normals"].shape == (3,)
    assert found["primitive_ids"] == RECORDING["cast.primitive_ids"][0, 1]
    assert scene.list_intersections(ray)["ray_splits"].tolist() == [0, RECORDING["count"][0, 1]]


@pytest.mark.parametrize(
    "method", ["cast_rays", "test_occlusions", "count_intersections", "list_intersections"]
)
def test_wrong_rays_are_refused(method: str) -> None:
    ask = getattr(filled(), method)
    with pytest.raises(ValueError, match=r"rays: expected shape \(..., 6\), found \(2, 5\)"):
        ask(np.zeros((2, 5)))
    with pytest.raises(TypeError, match=r"rays: expected float32.*complex"):
        ask(np.zeros((2, 6), dtype=complex))


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ((np.eye(2), np.eye(4), 2, 2), ValueError, r"intrinsic_matrix: expected shape \(3, 3\)"),
        ((np.eye(3), np.eye(3), 2, 2), ValueError, r"extrinsic_matrix: expected shape \(4, 4\)"),
        ((np.eye(3), np.eye(4), -1, 2), ValueError, "width_px: expected a number of pixels"),
        ((np.eye(3), np.eye(4), 2, 2.5), TypeError, "float"),
        ((90, [0, 0], [0, 0, 1], [0, 1, 0], 2, 2), ValueError, r"center: expected shape \(3,\)"),
        ((90, [0, 0, 0]), TypeError, "argument"),
    ],
)
def test_wrong_cameras_are_refused(
    arguments: tuple[Any, ...], error: type[Exception], words: str
) -> None:
    create: Any = RaycastingScene.create_rays_pinhole
    with pytest.raises(error, match=words):
        create(*arguments)


def test_every_crossing_of_a_closed_surface_counts_once() -> None:
    shape = gridded_cube(4)
    scene = RaycastingScene()
    scene.add_triangles(shape.vertices.astype(np.float32), shape.faces)
    inside = np.full_like(shape.vertices, 2.0) + np.array([0.125, 0.0625, -0.125])
    rays = np.hstack([inside, shape.vertices - inside]).astype(np.float32)
    assert (scene.count_intersections(rays) == 1).all()
    assert (scene.compute_occupancy(inside.astype(np.float32)) == 1.0).all()


def test_methods_and_arguments_are_those_of_open3d() -> None:
    found = {
        name: list(inspect.signature(getattr(RaycastingScene, name)).parameters)
        for name in dir(RaycastingScene)
        if not name.startswith("_") and name != "INVALID_ID"
    }
    asked, points = ["self", "rays"], ["self", "query_points", "nthreads"]
    assert found == {
        "add_triangles": ["self", "args", "kwargs"],
        "cast_rays": [*asked, "nthreads"],
        "compute_closest_points": points,
        "compute_distance": points,
        "compute_occupancy": [*points, "nsamples"],
        "compute_signed_distance": [*points, "nsamples"],
        "count_intersections": [*asked, "nthreads"],
        "create_rays_pinhole": ["args", "kwargs"],
        "list_intersections": [*asked, "nthreads"],
        "test_occlusions": [*asked, "tnear", "tfar", "nthreads"],
    }
    assert RECORDING.head["invalid_id"] == RaycastingScene.INVALID_ID


def test_scenes_are_pickled() -> None:
    again = pickle.loads(pickle.dumps(filled()))
    same_answers(again.cast_rays(RECORDING["rays"]), RECORDING.answer("cast"))
    assert again.add_triangles(TRIANGLE, FACE) == 3


def test_neither_double_imports_its_namesake() -> None:
    script = (
        "import sys, halfline.open3d, halfline.trimesh\n"
        "print(sorted({'open3d', 'trimesh', 'scipy', 'rtree'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"
