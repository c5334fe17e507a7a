"""An independent judge of distances and winding numbers: every point against every triangle.

In float64, with nothing clever: the foot of the perpendicular if it is inside of the triangle, else
the nearest of three segments; solid angles after Van Oosterom and Strackee (1983).
"""

from __future__ import annotations

import numpy as np
from meshes import Floats, Shape


def dot(a: Floats, b: Floats) -> Floats:
    """The inner products of rows."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def distances_to(shape: Shape, points: Floats) -> Floats:
    """The distance (n, m) of each point to each triangle, none of which may be without area."""
    corners = shape.corners()
    return np.stack([to_triangles(corners, point) for point in points])


def to_triangles(corners: Floats, point: Floats) -> Floats:
    """The distance (m,) of a point to triangles (m, 3, 3)."""
    following = np.roll(corners, -1, axis=1)
    edges, spokes = following - corners, point - corners
    # The nearest point of each edge.
    share = np.clip(dot(spokes, edges) / dot(edges, edges), 0, 1)
    gaps = spokes - share[..., None] * edges
    to_edges = np.sqrt(dot(gaps, gaps)).min(axis=1)
    # The foot of the perpendicular, if it is on the inner side of all three edges.
    normals = np.cross(edges[:, 0], edges[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    sides = dot(np.cross(edges, spokes), normals[:, None, :])
    to_plane = np.abs(dot(spokes[:, 0], normals))
    return np.asarray(np.where((sides >= 0).all(axis=1), to_plane, to_edges))


def winding_numbers(shape: Shape, points: Floats) -> Floats:
    """How often a surface goes round each point."""
    corners = shape.corners()
    numbers = []
    for point in points:
        a, b, c = np.moveaxis(corners - point, 1, 0)
        x, y, z = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        volume = dot(a, np.cross(b, c))
        below = x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y
        numbers.append(np.arctan2(volume, below).sum() / (2 * np.pi))
    return np.array(numbers)
