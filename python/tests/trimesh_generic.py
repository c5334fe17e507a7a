"""What trimesh's own tests import as `generic`, which its source distribution leaves out.

That module, and the models that it loads, are in trimesh's repository only. Here are the names that
the tests of rays and proximity use, and models that have what those tests say of the originals.
"""

from __future__ import annotations

import logging
import tempfile
import time
import unittest
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import halfline
import numpy as np
import trimesh

__all__ = [
    "Point",
    "Polygon",
    "Trimesh",
    "data",
    "deque",
    "get_mesh",
    "get_meshes",
    "log",
    "np",
    "random",
    "random_transforms",
    "time",
    "tol",
    "transforms",
    "trimesh",
    "unittest",
]

Trimesh = trimesh.Trimesh
log = logging.getLogger("trimesh")
tol = trimesh.constants.tol
tol.strict = True


def random(shape: Any) -> np.ndarray[Any, Any]:
    """The same numbers from 0 to 1 in every call."""
    return np.asarray(np.random.RandomState(1).random_sample(shape))


def random_transforms(count: int, translate: float = 1000.0) -> Iterator[np.ndarray[Any, Any]]:
    """The same rigid motions in every call."""
    turns, shifts = random((count, 3)), (random((count, 3)) - 0.5) * translate
    for turn, shift in zip(turns, shifts, strict=True):
        motion = np.array(trimesh.transformations.random_rotation_matrix(turn))
        motion[:3, 3] = shift
        yield motion


class Point:
    """What there is of a point of shapely."""

    def __init__(self, xy: Any) -> None:
        self.xy = np.asarray(xy, dtype=np.float64)


class Polygon:
    """What there is of a polygon of shapely: a triangle, and a margin around it."""

    def __init__(self, corners: Any, margin: float = 0.0) -> None:
        self._corners = np.asarray(corners, dtype=np.float64)
        self._margin = margin

    def buffer(self, margin: float) -> Polygon:
        """The triangle with a margin."""
        return Polygon(self._corners, self._margin + margin)

    def distance(self, point: Point) -> float:
        """How far a point is from it; 0 inside."""
        away = point.xy - self._corners
        ways = np.roll(self._corners, -1, axis=0) - self._corners
        sides = ways[:, 0] * away[:, 1] - ways[:, 1] * away[:, 0]
        if (sides >= 0.0).all() or (sides <= 0.0).all():
            return 0.0
        along = np.clip((away * ways).sum(axis=1) / (ways * ways).sum(axis=1), 0.0, 1.0)
        distance = np.linalg.norm(away - along[:, None] * ways, axis=1).min()
        return max(float(distance) - self._margin, 0.0)

    def intersects(self, point: Point) -> bool:
        """Whether a point is in it."""
        return self.distance(point) == 0.0


def _block(low: float, high: float) -> Any:
    return trimesh.creation.box(bounds=[[low] * 3, [high] * 3])


def _seven_eighths() -> Any:
    """A cube without the eighth that has the coordinates greater than zero."""
    return trimesh.boolean.difference([_block(-8.0, 8.0), _block(0.0, 16.0)])


def _teapot() -> Any:
    mesh = halfline.generate("teapot", 3000)
    teapot = trimesh.Trimesh(mesh.vertices, mesh.faces)
    assert not teapot.is_watertight
    return teapot.apply_scale(20.0 / teapot.scale)


def _part() -> Any:
    """A block with a hole through it and a pocket."""
    hole = trimesh.creation.cylinder(radius=0.5, height=4.0, sections=24)
    pocket = trimesh.creation.box(bounds=[[0.8, -0.7, 0.3], [1.7, 0.7, 2.0]])
    block = trimesh.creation.box(bounds=[[-2.0, -1.0, -1.0], [2.0, 1.0, 1.0]])
    return trimesh.boolean.difference([block, hole, pocket])


def _beside_a_notch() -> Any:
    """The origin lies inside, in the plane of the face that is nearest to it."""
    notch = trimesh.creation.box(bounds=[[1.0, 0.0, -20.0], [20.0, 20.0, 20.0]])
    return trimesh.boolean.difference([_block(-8.0, 8.0), notch])


_MODELS: dict[str, Callable[[], Any]] = {
    "1002_tray_bottom.STL": lambda: trimesh.creation.box(extents=[9.0, 6.0, 0.25]),
    "20mm-xyz-cube.stl": lambda: _block(0.0, 20.0),
    "7_8ths_cube.stl": _seven_eighths,
    "featuretype.STL": _part,
    "origin_inside.STL": _beside_a_notch,
    "teapot.stl": _teapot,
    "unit_cube.STL": trimesh.creation.box,
    "unit_sphere.STL": lambda: trimesh.creation.icosphere(subdivisions=3),
}


def get_mesh(file_name: str, **options: Any) -> Any:
    """Loads a model from an STL file, as the original loads its own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / file_name
        _MODELS[file_name]().export(path)
        return trimesh.load(str(path), **options)


def get_meshes(count: int) -> Iterator[Any]:
    """Some of the models."""
    return (get_mesh(name) for name in [*_MODELS][:count])


def _rays() -> dict[str, Any]:
    """Rays to cast at models by both of trimesh's intersectors."""
    names = ["unit_cube.STL", "unit_sphere.STL", "featuretype.STL", "teapot.stl"]
    rays = {}
    for name in names:
        low, high = get_mesh(name).bounds
        random_state = np.random.RandomState(2)
        targets = random_state.uniform(low, high, size=(100, 3))
        origins = targets + random_state.normal(size=(100, 3)) * (high - low).max()
        rays[name] = {"ray_origins": origins, "ray_directions": targets - origins}
    options = [
        {"file_name": name, "use_embree": embree} for name in names for embree in (True, False)
    ]
    return {"load_kwargs": options, "rays": rays}


data = {"ray_data": _rays()}
transforms = [*random_transforms(5)]
