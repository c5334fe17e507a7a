"""A question of `Scene` as one task for each chunk of rays or points."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import dask.array as da
import numpy as np
from numpy.typing import NDArray

from halfline._arrays import float_type
from halfline.dask._trees import Tree, scene_of


def ask_of_chunks(
    question: str,
    tree: Tree,
    dtype: np.dtype[Any],
    vectors: Mapping[str, Any],
    numbers: Mapping[str, Any],
    *,
    pack: Callable[[Any], NDArray[Any]] | None = None,
    **options: Any,
) -> da.Array:
    """The answers of a method of `Scene`, lazy.

    Args:
        question: The method's name.
        tree: What it is asked about.
        dtype: Of an answer; records for those that have parts.
        vectors: Positional arguments of the method, shape (..., 3), by name.
        numbers: Keyword arguments, numbers or of shape (...), by name. Leading dimensions of all
            are broadcast against each other.
        pack: Makes records of answers that have parts.
        **options: Other keyword arguments, the same for all chunks.
    """
    columns: dict[str, da.Array | float] = {
        **{name: _vectors(name, value) for name, value in vectors.items()},
        **{name: _numbers(name, value) for name, value in numbers.items()},
    }
    leading = {
        name: column.shape[:-1] if name in vectors else column.shape
        for name, column in columns.items()
        if not isinstance(column, float)
    }
    ndim = max(map(len, leading.values()))
    _check_broadcast(leading, tuple(columns))

    # Axes count from the last leading one, since shapes are broadcast from there.
    arguments: list[Any] = []
    for name, column in columns.items():
        if isinstance(column, float):
            arguments += [column, None]
        else:
            axes = tuple(range(ndim - len(leading[name]), ndim))
            arguments += [column, (*axes, ndim) if name in vectors else axes]
    is_known = all(not math.isnan(size) for shape in leading.values() for size in shape)
    answers: da.Array = da.blockwise(
        _answer,
        tuple(range(ndim)),
        *arguments,
        token=f"halfline-{question}",
        question=question,
        tree=tree,
        names=tuple(numbers),
        pack=pack,
        options=options,
        # Chunks of unknown sizes cannot be cut to fit; where there are as many they are taken as
        # equal.
        align_arrays=is_known,
        concatenate=True,
        meta=np.empty((0,) * ndim, dtype=dtype),
        dtype=dtype,
    )
    return answers


def _answer(
    *columns: Any,
    question: str,
    tree: Tree,
    names: tuple[str, ...],
    pack: Callable[[Any], NDArray[Any]] | None,
    options: dict[str, Any],
) -> Any:
    """The task: what a scene answers to a chunk."""
    first = len(columns) - len(names)
    numbers = dict(zip(names, columns[first:], strict=True))
    answer = getattr(scene_of(tree), question)(*columns[:first], **numbers, **options)
    return answer if pack is None else pack(answer)


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


def _check_broadcast(leading: Mapping[str, tuple[int, ...]], names: tuple[str, ...]) -> None:
    known = [tuple(1 if math.isnan(n) else n for n in shape) for shape in leading.values()]
    try:
        np.broadcast_shapes(*known)
    except ValueError:
        found = ", ".join(f"{name} {shape}" for name, shape in leading.items() if shape)
        raise ValueError(
            f"{', '.join(names)}: expected leading dimensions that broadcast together, "
            f"found {found}"
        ) from None
