"""Measures halfline's Python package; see finder.py."""

from __future__ import annotations

import sys

import halfline
import numpy as np
from tools.nearest.finder import Array, Finder, measure


class Halfline(Finder):
    """halfline.Scene."""

    def __init__(self) -> None:
        self.tool = f"halfline {halfline.__version__}"
        halfline.set_thread_count(int(sys.argv[2]))

    def build(self, vertices: Array, faces: Array) -> None:
        """The tree, and that over faces without area, which the first point makes."""
        self.scene = halfline.Scene(vertices, faces)
        self.scene.closest_points(np.zeros((1, 3)))

    def distances(self, points: Array) -> Array:
        """With everything that comes along."""
        return self.scene.closest_points(points).distance

    def windings(self, points: Array) -> Array:
        """The boundary of open meshes is found when the first point asks."""
        return self.scene.winding_number(points)

    def contains(self, points: Array) -> Array:
        """By winding number."""
        return self.scene.contains(points)


def main() -> None:
    """Measures it."""
    measure(Halfline())
