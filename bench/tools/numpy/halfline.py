"""Measures halfline's Python package; see caster.py."""

from __future__ import annotations

import sys

import halfline
from tools.numpy.caster import Array, Caster, measure


class Halfline(Caster):
    """halfline.Scene."""

    def __init__(self) -> None:
        self.tool = f"halfline {halfline.__version__}"
        self.threads = int(sys.argv[2])
        halfline.set_thread_count(self.threads)

    def build(self, vertices: Array, faces: Array) -> None:
        """The tree."""
        self.scene = halfline.Scene(vertices, faces)

    def closest(self, origins: Array, directions: Array) -> Array:
        """Faces, with t and weights in double precision besides."""
        return self.scene.intersect(origins, directions).face

    def all_hits(self, origins: Array, directions: Array) -> int:
        """All hits with t, faces and weights."""
        return len(self.scene.intersect_all(origins, directions).t)

    def counts(self, origins: Array, directions: Array) -> Array:
        """Counts alone."""
        return self.scene.count_intersections(origins, directions)


def main() -> None:
    """Measures it."""
    measure(Halfline())
