"""The questions of `Scene` over Dask arrays of points."""

from __future__ import annotations

import os

import dask.array as da
import numpy as np
from numpy.typing import ArrayLike

from halfline._scene import Scene
from halfline.dask._chunks import ask_of_chunks
from halfline.dask._lazy_nearest import NEAR, LazyNearest, records_of_nearest
from halfline.dask._trees import tree_of


def closest_points(
    scene: Scene | str | os.PathLike[str],
    points: da.Array | ArrayLike,
    *,
    max_distance: da.Array | ArrayLike = np.inf,
) -> LazyNearest:
    """The nearest point of the mesh, as `Scene.closest_points`; nothing is computed yet.

    Leading dimensions are broadcast against each other, and the chunks along them are kept or,
    where arguments differ, made the same; the last axis becomes one chunk. Chunks of about a
    million points are best. Sizes of chunks that Dask does not know (NaN) must be those of all
    arguments.

    Args:
        scene: A scene from a file, or the path of a tree file. Where the workers do not see that
            path, call `publish` first.
        points: Shape (..., 3). What is no Dask array becomes one, and a large one is then part of
            the graph: better make it of files or on the workers.
        max_distance: Farthest that counts, itself included: a number, or shape (...).

    Returns:
        `distance`, `point`, `face`, `uv`, `feature`, `normal` and `found` of the points' leading
        dimensions as Dask arrays.

    Raises:
        TypeError: For arrays of complex numbers, objects, strings, booleans or longdouble, and for
            what is no scene.
        ValueError: For shapes that do not end in 3 or cannot be broadcast, and for a scene in
            memory: save it and open the file.
        OSError: If the file cannot be opened.
        FormatError: If it is no tree.
        MissingTreeError: When computed by a worker that has no such file.
    """
    tree, scene = tree_of(scene)
    most = {"max_distance": max_distance}
    records = ask_of_chunks(
        "closest_points", tree, NEAR, {"points": points}, most, pack=records_of_nearest
    )
    return LazyNearest(scene, tree, records)


def signed_distance(
    scene: Scene | str | os.PathLike[str], points: da.Array | ArrayLike
) -> da.Array:
    """How far points are from the surface, negative inside, as `Scene.signed_distance`; lazy.

    Arguments and exceptions are those of `closest_points`.

    Returns:
        A Dask array of the points' leading dimensions, float64.
    """
    tree, _ = tree_of(scene)
    return ask_of_chunks("signed_distance", tree, np.dtype(np.float64), {"points": points}, {})


def winding_number(scene: Scene | str | os.PathLike[str], points: da.Array | ArrayLike) -> da.Array:
    """How often the surface winds around each point, as `Scene.winding_number`; lazy.

    Arguments and exceptions are those of `closest_points`.

    Returns:
        A Dask array of the points' leading dimensions, float64.
    """
    tree, _ = tree_of(scene)
    return ask_of_chunks("winding_number", tree, np.dtype(np.float64), {"points": points}, {})


def contains(
    scene: Scene | str | os.PathLike[str], points: da.Array | ArrayLike, *, rule: str = "winding"
) -> da.Array:
    """Whether each point is inside, as `Scene.contains`; nothing is computed yet.

    Arguments and exceptions are those of `closest_points`, and one more of each.

    Args:
        scene: As above.
        points: As above.
        rule: "winding" or "parity", as for `Scene.contains`.

    Returns:
        A Dask array of the points' leading dimensions, bool.

    Raises:
        ValueError: For another rule, when computed.
    """
    tree, _ = tree_of(scene)
    return ask_of_chunks("contains", tree, np.dtype(np.bool_), {"points": points}, {}, rule=rule)
