"""Measures Open3D; see finder.py."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import open3d
from tools.nearest.finder import Array, Finder, measure


class Open3D(Finder):
    """open3d.t.geometry.RaycastingScene, which takes single precision."""

    def __init__(self) -> None:
        self.tool = f"Open3D {open3d.__version__}"
        self.threads = int(sys.argv[2])

    def build(self, vertices: Array, faces: Array) -> None:
        """Embree builds its tree when it is first asked."""
        self.scene: Any = open3d.t.geometry.RaycastingScene(nthreads=self.threads)
        self.scene.add_triangles(np.float32(vertices), np.uint32(faces))
        self.scene.compute_distance(np.zeros((1, 3), dtype=np.float32))

    def distances(self, points: Array) -> Array:
        """Distances alone."""
        answers = self.scene.compute_distance(np.float32(points), nthreads=self.threads)
        return np.asarray(answers.numpy())

    def contains(self, points: Array) -> Array:
        """By one ray."""
        answers = self.scene.compute_occupancy(np.float32(points), nthreads=self.threads)
        return np.asarray(answers.numpy())


def main() -> None:
    """Measures it."""
    measure(Open3D())
