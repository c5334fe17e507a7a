"""An independent judge: Moeller and Trumbore's test (1997) of all rays with all triangles.

In float64, with nothing clever. It knows how sure it is: a ray that passes so close to an edge
that rounding could decide is told apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from meshes import Floats, Ints, Shape
from numpy.typing import NDArray

# Barycentrics in float64 of coordinates near one are good to some 1e-13 at the grazing angles
# that random rays come to; within a thousandfold of that the answer is not trusted.
UNSURE = 1e-10


@dataclass(frozen=True)
class Crossings:
    """Every crossing, sorted by ray and then by t."""

    ray: Ints
    face: Ints
    t: Floats
    uv: Floats
    unsure: NDArray[np.bool_]
    """For each ray whether a rounding error could change what it hits."""

    def closest(self, ray_count: int) -> tuple[Ints, Floats]:
        """The face and t of the first crossing of each ray; -1 and inf for a miss."""
        face = np.full(ray_count, -1, dtype=np.int64)
        t = np.full(ray_count, np.inf)
        rays, first = np.unique(self.ray, return_index=True)
        face[rays] = self.face[first]
        t[rays] = self.t[first]
        return face, t


def crossings(shape: Shape, rays: Floats) -> Crossings:
    """All crossings of rays (n, 6) or (n, 8) with the triangles of a shape."""
    a, b, c = np.moveaxis(shape.corners(), 1, 0)
    edge1, edge2 = b - a, c - a
    found = []
    unsure = np.zeros(len(rays), dtype=bool)
    for index, row in enumerate(rays):
        origin, direction = row[:3], row[3:6]
        t_min, t_max = row[6:8] if len(row) == 8 else (0.0, np.inf)
        p = np.cross(direction, edge2)
        determinant = np.einsum("ij,ij->i", edge1, p)
        s = origin - a
        q = np.cross(s, edge1)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("ij,ij->i", s, p) / determinant
            v = q @ direction / determinant
            t = np.einsum("ij,ij->i", edge2, q) / determinant
        margin = np.minimum(np.minimum(u, v), 1.0 - u - v)
        reaches = (t >= t_min) & (t <= t_max)
        unsure[index] = np.any((np.abs(margin) < UNSURE) & reaches)
        hit = np.flatnonzero((margin >= 0.0) & reaches)
        hit = hit[np.argsort(t[hit], kind="stable")]
        found.append((np.full(len(hit), index), hit, t[hit], np.stack([u[hit], v[hit]], axis=-1)))
    ray, face, t, uv = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Crossings(ray.astype(np.int64), face.astype(np.int64), t, uv, unsure)
