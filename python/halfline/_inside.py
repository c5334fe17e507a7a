"""Inside and outside as trimesh and Open3D mean them: whichever way faces are oriented."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from halfline._mesh import Mesh
    from halfline._scene import Scene

_closed: WeakKeyDictionary[Scene, bool] = WeakKeyDictionary()


def is_enclosed(scene: Scene, points: ArrayLike) -> NDArray[np.bool_]:
    """Whether points are inside, by the parity of crossings or by the winding number.

    Where each edge has an even number of faces, which is a surface without holes, every ray from a
    point meets it as often modulo two, and inside it is odd: that is what the namesakes count.
    Where there are holes they count what one ray or a few happen to meet. Here it is then the
    winding number, rounded, that is odd: it is the same number modulo two wherever the surface is
    closed and oriented, and one point is as good as its neighbour.

    Returns:
        The points' leading dimensions, bool; False for a point with a NaN or an infinite
        coordinate. A point on a surface without holes is inside, one on another may be either.
    """
    closed = _closed.get(scene)
    if closed is None:
        closed = _closed[scene] = is_closed(scene.mesh)
    if closed:
        return scene.contains(points, rule="parity")
    turns = np.abs(np.rint(scene.winding_number(points)))
    return np.asarray(turns % 2.0 == 1.0)


def is_closed(mesh: Mesh) -> bool:
    """Whether each edge has an even number of faces; vertices are the same where they are equal."""
    vertices = np.asarray(mesh.vertices)
    faces = np.asarray(mesh.faces, dtype=np.int64)
    is_finite = np.isfinite(vertices).all(axis=1)
    if not is_finite.all():
        faces = faces[is_finite[faces].all(axis=1)]
    # What is closed by indices is so by coordinates.
    return _has_pairs_only(faces) or _has_pairs_only(places_of(vertices)[faces])


def places_of(vertices: NDArray[Any]) -> NDArray[np.int64]:
    """A number for each vertex, the same for those with the same coordinates."""
    # Comparisons take both zeros for one.
    order = np.lexsort(vertices.T)
    differs = np.any(vertices[order[1:]] != vertices[order[:-1]], axis=1)
    places = np.zeros(len(vertices), dtype=np.int64)
    places[order[1:]] = np.cumsum(differs)
    return places


def _has_pairs_only(faces: NDArray[np.int64]) -> bool:
    begin, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    # A face that has a corner twice has an edge without length.
    keys = np.sort((low << 32 | high)[low != high])
    return len(keys) % 2 == 0 and bool(np.all(keys[::2] == keys[1::2]))
