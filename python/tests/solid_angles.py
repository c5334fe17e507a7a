"""An independent judge of winding numbers: the solid angles of all faces, summed.

After A. van Oosterom and J. Strackee, "The Solid Angle of a Plane Triangle" (1983), in float64.
"""

from __future__ import annotations

import numpy as np
from meshes import Floats, Shape


def winding_numbers(shape: Shape, points: Floats) -> Floats:
    """The winding numbers of points (n, 3), of counter-clockwise faces positive inside."""
    corners = shape.corners()
    corners = corners[np.isfinite(corners).all(axis=(1, 2))]
    numbers = np.empty(len(points))
    for index, point in enumerate(points):
        a, b, c = np.moveaxis(corners - point, 1, 0)
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        ab, bc, ca = (np.einsum("ij,ij->i", *pair) for pair in ((a, b), (b, c), (c, a)))
        angles = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
        numbers[index] = angles.sum() / (4.0 * np.pi)
    return numbers
