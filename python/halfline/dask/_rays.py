"""The questions of `Scene` over Dask arrays of rays."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any

import dask.array as da
import numpy as np
from numpy.typing import ArrayLike

from halfline._arrays import float_type
from halfline._hits import Hits
from halfline._scene import Scene
from halfline.dask._lazy_hits import HIT, LazyHits
from halfline.dask._trees import Tree, scene_of, tree_of


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
    records = _ask("intersect", tree, HIT, origins, directions, t_min, t_max)
    return LazyHits(scene, tree, records)


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
) -> da.Array:
    """A question of `Scene` as one task for each chunk of rays."""
    columns = {
        "origins": _vectors("origins", origins),
        "directions": _vectors("directions", directions),
        "t_min": _numbers("t_min", t_min),
        "t_max": _numbers("t_max", t_max),
    }
    leading = {
        name: column.shape[:-1] if name in ("origins", "directions") else column.shape
        for name, column in columns.items()
        if not isinstance(column, float)
    }
    ndim = max(map(len, leading.values()))
    _check_broadcast(leading)

    # Axes count from the last leading one, since shapes are broadcast from there.
    arguments: list[Any] = []
    for name, column in columns.items():
        if isinstance(column, float):
            arguments += [column, None]
        else:
            axes = tuple(range(ndim - len(leading[name]), ndim))
            arguments += [column, (*axes, ndim) if name in ("origins", "directions") else axes]
    is_known = all(not math.isnan(size) for shape in leading.values() for size in shape)
    answers: da.Array = da.blockwise(
        _answer,
        tuple(range(ndim)),
        *arguments,
        token=f"halfline-{question}",
        question=question,
        tree=tree,
        # Chunks of unknown sizes cannot be cut to fit; where there are as many they are taken as
        # equal.
        align_arrays=is_known,
        concatenate=True,
        meta=np.empty((0,) * ndim, dtype=dtype),
        dtype=dtype,
    )
    return answers


def _answer(
    origins: Any, directions: Any, t_min: Any, t_max: Any, *, question: str, tree: Tree
) -> Any:
    """The task: what a scene answers to a chunk of rays."""
    answer = getattr(scene_of(tree), question)(origins, directions, t_min=t_min, t_max=t_max)
    if not isinstance(answer, Hits):
        return answer
    records = np.empty(answer.shape, dtype=HIT)
    records["t"], records["face"], records["uv"] = answer.t, answer.face, answer.uv
    return records


def _vectors(name: str, value: Any) -> da.Array:
    array = _array(name, value)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name}: expected shape (..., 3), found {array.shape}")
    return array.rechunk({array.ndim - 1: 3}) if array.numblocks[-1] > 1 else array


def _numbers(name: str, value: Any) -> da.Array | float:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    return _array(name, value)


def _array(name: str, value: Any) -> da.Array:
    array = value if isinstance(value, da.Array) else da.asarray(value)
    float_type(name, array.dtype)
    return array


def _check_broadcast(leading: Mapping[str, tuple[int, ...]]) -> None:
    known = [tuple(1 if math.isnan(n) else n for n in shape) for shape in leading.values()]
    try:
        np.broadcast_shapes(*known)
    except ValueError:
        found = ", ".join(f"{name} {shape}" for name, shape in leading.items() if shape)
        raise ValueError(
            "origins, directions, t_min, t_max: expected leading dimensions that broadcast "
            f"together, found {found}"
        ) from None
