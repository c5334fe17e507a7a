#!/usr/bin/env python3
"""Records what Open3D answers, for python/tests/test_open3d.py.

    .venv-open3d/bin/python tools/record_open3d.py python/tests/open3d.json

Open3D is far larger than everything else that the tests need, so they compare with the recording.
`make record` makes it anew.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import open3d

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python" / "tests"))

from meshes import bumpy_sphere, random_rays

SEED = 5

Arrays = dict[str, np.ndarray[Any, Any]]


def scene_arrays() -> Arrays:
    """Two closed meshes, the second inside the first and one triangle before it, as float32."""
    shape = bumpy_sphere(12, 20)
    vertices = shape.vertices.astype(np.float32)
    triangle = np.array([[1.5, -2.0, -2.0], [1.5, 2.0, -2.0], [1.5, 0.0, 2.0]], dtype=np.float32)
    return {
        "outer_vertices": vertices,
        "outer_triangles": shape.faces.astype(np.uint32),
        "inner_vertices": vertices * np.float32(0.25),
        "inner_triangles": shape.faces.astype(np.uint32)[::-1].copy(),
        "triangle_vertices": triangle,
        "triangle_triangles": np.array([[0, 1, 2]], dtype=np.uint32),
    }


def questions() -> Arrays:
    """Rays in general position, rays that hit nothing, and points."""
    rays = random_rays(60, SEED)
    rays[40:50, 3:] *= -1.0
    rays[50, 3:] = 0.0
    rays[51, 0] = np.nan
    rays[52, 3] = np.inf
    points = np.random.default_rng(SEED).uniform(-1.3, 1.3, size=(40, 3))
    return {
        "rays": rays.astype(np.float32).reshape(3, 20, 6),
        "points": points.astype(np.float32).reshape(8, 5, 3),
    }


def cameras() -> dict[str, list[Any]]:
    """Arguments of `create_rays_pinhole`."""
    turned = [
        [0.0, 1.0, 0.0, 1.0],
        [-1.0, 0.0, 0.0, 2.0],
        [0.0, 0.0, 1.0, 3.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
    return {
        "matrices": [[[100.0, 2.0, 31.5], [0.0, 90.0, 24.5], [0.0, 0.0, 1.0]], turned, 3, 2],
        "scaled": [[[100.0, 2.0, 31.5], [0.0, 90.0, 24.5], [0.0, 0.0, 2.0]], turned, 3, 2],
        "towards": [70.0, [0.1, 0.2, 0.3], [1.0, 2.0, 3.0], [0.0, 1.0, 0.2], 4, 3],
        "wide": [120.0, [0.0, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 1.0], 2, 1],
        "no_width": [90.0, [0.0, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 1.0], 0, 2],
    }


def answers(arrays: Arrays, asked: Arrays) -> Arrays:
    """What Open3D says."""
    scene = open3d.t.geometry.RaycastingScene()
    ray_tensor = open3d.core.Tensor(asked["rays"])
    found: dict[str, Any] = {
        "empty_cast": scene.cast_rays(ray_tensor),
        "empty_list": scene.list_intersections(ray_tensor),
        "empty_count": scene.count_intersections(ray_tensor),
        "empty_occluded": scene.test_occlusions(ray_tensor),
    }
    ids = [
        scene.add_triangles(
            open3d.core.Tensor(arrays[f"{name}_vertices"]),
            open3d.core.Tensor(arrays[f"{name}_triangles"]),
        )
        for name in ("outer", "inner", "triangle")
    ]
    assert ids == [0, 1, 2]
    closed = open3d.t.geometry.RaycastingScene()
    closed.add_triangles(
        open3d.core.Tensor(arrays["outer_vertices"]), open3d.core.Tensor(arrays["outer_triangles"])
    )
    points = open3d.core.Tensor(asked["points"])
    found |= {
        "cast": scene.cast_rays(ray_tensor),
        "list": scene.list_intersections(ray_tensor),
        "count": scene.count_intersections(ray_tensor),
        "occluded": scene.test_occlusions(ray_tensor),
        "occluded_within": scene.test_occlusions(ray_tensor, tnear=0.7, tfar=0.8),
        "occluded_reversed": scene.test_occlusions(ray_tensor, tnear=0.8, tfar=0.7),
        "occluded_behind": scene.test_occlusions(ray_tensor, tnear=-2.0),
        "cast_none": scene.cast_rays(ray_tensor[:0]),
        "count_none": scene.count_intersections(ray_tensor[:0]),
        "occupancy": closed.compute_occupancy(points),
        "occupancy_voted": closed.compute_occupancy(points, nsamples=3),
        "empty_closest": open3d.t.geometry.RaycastingScene().compute_closest_points(points),
        "closest": scene.compute_closest_points(points),
        "closest_none": scene.compute_closest_points(points[:0]),
        "distance": scene.compute_distance(points),
        "distance_none": scene.compute_distance(points[:0]),
        "signed_distance": closed.compute_signed_distance(points),
        "signed_distance_voted": closed.compute_signed_distance(points, nsamples=3),
    }
    for name, camera in cameras().items():
        found[f"pinhole_{name}"] = scene.create_rays_pinhole(*camera)
    flat: Arrays = {}
    for name, value in found.items():
        if isinstance(value, dict):
            flat |= {f"{name}.{key}": tensor.numpy() for key, tensor in value.items()}
        else:
            flat[name] = value.numpy()
    return flat


def written(array: np.ndarray[Any, Any]) -> str:
    """An array in JSON; every float as the shortest decimal that gives it back."""
    plain = array.ravel().tolist()
    if array.dtype == np.float32:
        plain = [float(str(number)) for number in array.ravel()]
    return json.dumps({"dtype": array.dtype.name, "shape": array.shape, "data": plain})


def main() -> None:
    """Records."""
    arrays, asked = scene_arrays(), questions()
    everything = {**arrays, **asked, **answers(arrays, asked)}
    head = {
        "open3d": open3d.__version__,
        "invalid_id": open3d.t.geometry.RaycastingScene.INVALID_ID,
        "cameras": cameras(),
    }
    lines = [f'"{name}": {written(array)}' for name, array in everything.items()]
    text = f'{json.dumps(head)[:-1]}, "arrays": {{\n' + ",\n".join(lines) + "\n}}\n"
    Path(sys.argv[1]).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
