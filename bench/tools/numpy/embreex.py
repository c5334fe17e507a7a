"""Measures trimesh with embreex; see caster.py. It knows one thread only."""

from __future__ import annotations

from typing import Any

import embreex
import numpy as np
import trimesh
from tools.numpy.caster import Array, Caster, measure


class Embreex(Caster):
    """mesh.ray of trimesh."""

    def __init__(self) -> None:
        self.tool = f"trimesh {trimesh.__version__} + embreex {embreex.__version__}"
        self.threads = 1

    def build(self, vertices: Array, faces: Array) -> None:
        """Embree builds its tree when the first ray asks for it."""
        self.mesh: Any = trimesh.Trimesh(vertices, faces, process=False)
        self.mesh.ray.intersects_first(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))

    def closest(self, origins: Array, directions: Array) -> Array:
        """Faces alone."""
        return np.asarray(self.mesh.ray.intersects_first(origins, directions))

    def all_hits(self, origins: Array, directions: Array) -> int:
        """All hits with faces and places."""
        faces, _, _ = self.mesh.ray.intersects_id(
            origins, directions, multiple_hits=True, return_locations=True
        )
        return len(faces)

    def counts(self, origins: Array, directions: Array) -> Array:
        """There are no counts but those of all hits."""
        _, rays = self.mesh.ray.intersects_id(origins, directions, multiple_hits=True)
        return np.bincount(rays, minlength=len(origins))


def main() -> None:
    """Measures it."""
    measure(Embreex())
