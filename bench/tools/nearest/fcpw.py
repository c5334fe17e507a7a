"""Measures FCPW; see finder.py."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import fcpw
import numpy as np
from tools.nearest.finder import Array, Finder, measure


class Fcpw(Finder):
    """fcpw.scene_3D, which takes single precision; its threads are as many as the cores."""

    def __init__(self) -> None:
        self.tool = f"FCPW {version('fcpw')}"

    def build(self, vertices: Array, faces: Array) -> None:
        """The tree that its documentation recommends, for vectors."""
        self.scene: Any = fcpw.scene_3D()
        self.scene.set_object_count(1)
        self.scene.set_object_vertices(np.float32(vertices), 0)
        self.scene.set_object_triangles(np.int32(faces), 0)
        self.scene.build(fcpw.aggregate_type.bvh_surface_area, True, False, False)

    def distances(self, points: Array) -> Array:
        """They lie in a list of objects."""
        found = fcpw.interaction_3D_list()
        farthest = np.full(len(points), np.inf, dtype=np.float32)
        self.scene.find_closest_points(np.float32(points), farthest, found, False)
        return np.array([one.d for one in found])

    def contains(self, points: Array) -> Array:
        """By a ray."""
        flags = np.zeros(len(points), dtype=np.int32)
        self.scene.contains(np.float32(points), flags)
        return flags


def main() -> None:
    """Measures it."""
    measure(Fcpw())
