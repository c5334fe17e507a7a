"""Measures libigl; see finder.py."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import igl
import numpy as np
from tools.nearest.finder import Array, Finder, measure


class Libigl(Finder):
    """igl.AABB and two kinds of winding numbers; its threads are as many as the cores."""

    def __init__(self) -> None:
        self.tool = f"libigl {version('libigl')}"

    def build(self, vertices: Array, faces: Array) -> None:
        """Its tree."""
        self.vertices, self.faces = np.float64(vertices), np.int64(faces)
        self.tree: Any = igl.AABB()
        self.tree.init(self.vertices, self.faces)

    def distances(self, points: Array) -> Array:
        """It gives their squares."""
        squares = self.tree.squared_distance(self.vertices, self.faces, points)[0]
        return np.asarray(np.sqrt(squares))

    def windings(self, points: Array) -> Array:
        """The sum of all solid angles."""
        return np.asarray(igl.winding_number(self.vertices, self.faces, points))

    def approximate_windings(self, points: Array) -> Array:
        """By a tree of expansions, which it builds in each call."""
        return np.asarray(igl.fast_winding_number(self.vertices, self.faces, points))


def main() -> None:
    """Measures it."""
    measure(Libigl())
