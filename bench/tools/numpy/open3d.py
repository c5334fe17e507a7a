"""Measures Open3D; see caster.py."""

from __future__ import annotations

import sys

import numpy as np
import open3d
from tools.numpy.caster import Array, Caster, measure

core = open3d.core


class Open3d(Caster):
    """RaycastingScene."""

    def __init__(self) -> None:
        self.tool = f"Open3D {open3d.__version__}"
        self.threads = int(sys.argv[2])

    def build(self, vertices: Array, faces: Array) -> None:
        """The tree is built when the first ray asks for it."""
        self.scene = open3d.t.geometry.RaycastingScene(nthreads=self.threads)
        self.scene.add_triangles(core.Tensor(vertices), core.Tensor(faces))
        self.scene.cast_rays(core.Tensor([[0, 0, 0, 0, 0, 1]], dtype=core.float32))

    @staticmethod
    def rays(origins: Array, directions: Array) -> open3d.core.Tensor:
        """Six numbers a ray, as Open3D wants them; whoever calls it has to make them too."""
        return core.Tensor(np.hstack([origins, directions]))

    def closest(self, origins: Array, directions: Array) -> Array:
        """Faces, with t, weights and normals."""
        answer = self.scene.cast_rays(self.rays(origins, directions), nthreads=self.threads)
        faces = answer["primitive_ids"].numpy().astype(np.int64)
        return np.where(faces == self.scene.INVALID_ID, -1, faces)

    def all_hits(self, origins: Array, directions: Array) -> int:
        """All hits with t, faces and weights."""
        rays = self.rays(origins, directions)
        answer = self.scene.list_intersections(rays, nthreads=self.threads)
        return len(answer["primitive_ids"])

    def counts(self, origins: Array, directions: Array) -> Array:
        """Counts alone."""
        rays = self.rays(origins, directions)
        counts = self.scene.count_intersections(rays, nthreads=self.threads).numpy()
        return np.asarray(counts, dtype=np.int64)


def main() -> None:
    """Measures it."""
    measure(Open3d())
