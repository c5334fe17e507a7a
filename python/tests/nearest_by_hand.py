"""An independent judge of nearest points: each point against each face, and its three edges.

In float64, with nothing clever: a point is nearest to where it falls onto the plane of a triangle
if that is inside it, and else to one of the edges, each of which is a segment that clamps. On small
multiples of powers of two, as on the gridded cube, every step is exact, and ties are ties.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from meshes import Floats, Ints, Shape
from numpy.typing import NDArray

FEATURES = ("face", "edge", "vertex")


@dataclass(frozen=True)
class Nearest:
    """The nearest point of each of n points on each of m faces."""

    squared: Floats
    """Squared distances, (n, m); infinite for faces with a corner that is not finite."""
    point: Floats
    """(n, m, 3)."""
    feature: NDArray[np.str_]
    """(n, m)."""

    @property
    def face(self) -> Ints:
        """The nearest face, the lowest of several."""
        return np.asarray(self.squared.argmin(axis=1), dtype=np.int64)

    def at(self, face: Ints) -> tuple[Floats, Floats, NDArray[np.str_]]:
        """Distance, point and feature of one face for each point."""
        rows = np.arange(len(face)), face
        return np.sqrt(self.squared[rows]), self.point[rows], self.feature[rows]


def nearest(shape: Shape, points: Floats) -> Nearest:
    """The nearest points of all faces of a shape to points (n, 3)."""
    corners = shape.corners()
    found = _onto_planes(corners, points)
    for first in range(3):
        begin, end = corners[:, first], corners[:, (first + 1) % 3]
        found = _nearer(found, _onto_segments(begin, end, points))
    found.squared[:, ~np.isfinite(corners).all(axis=(1, 2))] = np.inf
    return found


def _onto_planes(corners: Floats, points: Floats) -> Nearest:
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    area = np.einsum("mi,mi->m", normal, normal)
    away = points[:, None] - a
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.einsum("nmi,mi->nm", away, normal) / area
        onto = points[:, None] - along[..., None] * normal
        u = np.einsum("nmi,mi->nm", np.cross(onto - a, c - a), normal) / area
        v = np.einsum("nmi,mi->nm", np.cross(b - a, onto - a), normal) / area
        inside = (u > 0.0) & (v > 0.0) & (u + v < 1.0)
    squared = np.where(inside, along**2 * area, np.inf)
    return Nearest(squared, onto, np.full(squared.shape, "face", dtype="<U6"))


def _onto_segments(begin: Floats, end: Floats, points: Floats) -> Nearest:
    way = end - begin
    length = np.einsum("mi,mi->m", way, way)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.einsum("nmi,mi->nm", points[:, None] - begin, way) / length
    t = np.where(length > 0.0, np.clip(t, 0.0, 1.0), 0.0)
    onto = np.where((t < 1.0)[..., None], begin + t[..., None] * way, end)
    rest = points[:, None] - onto
    feature = np.where((t > 0.0) & (t < 1.0), "edge", "vertex").astype("<U6")
    return Nearest(np.einsum("nmi,nmi->nm", rest, rest), onto, feature)


def _nearer(one: Nearest, other: Nearest) -> Nearest:
    is_other = other.squared < one.squared
    return Nearest(
        np.where(is_other, other.squared, one.squared),
        np.where(is_other[..., None], other.point, one.point),
        np.where(is_other, other.feature, one.feature),
    )
