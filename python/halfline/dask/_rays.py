"""The questions of `Scene` over Dask arrays of rays."""

from __future__ import annotations

import os
from typing import Any

import dask.array as da
import numpy as np
from numpy.typing import ArrayLike

from halfline._scene import Scene
from halfline.dask._chunks import ask_of_chunks
from halfline.dask._lazy_hits import HIT, LazyHits, records_of_hits
from halfline.dask._trees import Tree, tree_of


def intersect(
    scene: Scene | str | os.PathLike[str],
    origins: da.Array | ArrayLike,
    directions: da.Array | ArrayLike,
    *,
    t_min: da.Array | ArrayLike = 0.0,
    t_max: da.Array | ArrayLike = np.inf,
) -> LazyHits:
    """The closest hit of each ray, as `Scene.intersect`; nothing is computed yet.

    Leading dimensions are broadcast against each other, and the chunks along them are kept or,
    where arguments differ, made the same; the last axis becomes one chunk. Chunks of about a
    million rays are best. Sizes of chunks that Dask does not know (NaN) must be those of all
    arguments.

    Args:
        scene: A scene from a file, or the path of a tree file. Where the workers do not see that
            path, call `publish` first.
        origins: Where rays begin, shape (..., 3). What is no Dask array becomes one, and a large
            one is then part of the graph: better make it of files or on the workers.
        directions: How far one unit of t reaches, shape (..., 3).
        t_min: Smallest t that counts, itself included: a number, or shape (...).
        t_max: Largest t that counts, itself included: a number, or shape (...).

    Returns:
        `t`, `face`, `uv`, `point`, `normal` and `hit` of the rays' leading dimensions as Dask
        arrays; a miss has t infinite and face -1.

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
    rays = origins, directions, t_min, t_max
    return LazyHits(scene, tree, _ask("intersect", tree, HIT, *rays, pack=records_of_hits))


def occluded(
    scene: Scene | str | os.PathLike[str],
    origins: da.Array | ArrayLike,
    directions: da.Array | ArrayLike,
    *,
    t_min: da.Array | ArrayLike = 0.0,
    t_max: da.Array | ArrayLike = np.inf,
) -> da.Array:
    """Whether each ray hits anything, as `Scene.occluded`; nothing is computed yet.

    Arguments and exceptions are those of `intersect`.

    Returns:
        A Dask array of the rays' leading dimensions, bool.
    """
    tree, _ = tree_of(scene)
    return _ask("occluded", tree, np.dtype(np.bool_), origins, directions, t_min, t_max)


def count_intersections(
    scene: Scene | str | os.PathLike[str],
    origins: da.Array | ArrayLike,
    directions: da.Array | ArrayLike,
    *,
    t_min: da.Array | ArrayLike = 0.0,
    t_max: da.Array | ArrayLike = np.inf,
) -> da.Array:
    """How many hits each ray has, as `Scene.count_intersections`; nothing is computed yet.

    Arguments and exceptions are those of `intersect`.

    Returns:
        A Dask array of the rays' leading dimensions, int64.
    """
    tree, _ = tree_of(scene)
    return _ask("count_intersections", tree, np.dtype(np.int64), origins, directions, t_min, t_max)


def _ask(
    question: str,
    tree: Tree,
    dtype: np.dtype[Any],
    origins: Any,
    directions: Any,
    t_min: Any,
    t_max: Any,
    **options: Any,
) -> da.Array:
    vectors = {"origins": origins, "directions": directions}
    numbers = {"t_min": t_min, "t_max": t_max}
    return ask_of_chunks(question, tree, dtype, vectors, numbers, **options)
