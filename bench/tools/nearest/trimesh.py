"""Measures trimesh with embreex, on one thread; see finder.py."""

from __future__ import annotations

from typing import Any

import embreex
import numpy as np
import trimesh
from tools.nearest.finder import Array, Finder, measure


class Trimesh(Finder):
    """trimesh.proximity, and containment by its rays."""

    def __init__(self) -> None:
        self.tool = f"trimesh {trimesh.__version__} + embreex {embreex.__version__}"

    def build(self, vertices: Array, faces: Array) -> None:
        """Trees are built when the first point asks."""
        self.mesh: Any = trimesh.Trimesh(vertices, faces, process=False)
        self.mesh.nearest.on_surface(np.zeros((1, 3)))

    def distances(self, points: Array) -> Array:
        """With everything that comes along."""
        return np.asarray(self.mesh.nearest.on_surface(points)[1])

    def contains(self, points: Array) -> Array:
        """By the crossings of two rays."""
        return np.asarray(self.mesh.contains(points))


def main() -> None:
    """Measures it."""
    measure(Trimesh())
