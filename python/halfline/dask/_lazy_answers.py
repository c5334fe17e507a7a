"""Answers that are not yet computed: what they have as Dask arrays, made of one task each chunk."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import dask.array as da
import numpy as np
from dask.base import DaskMethodsMixin, tokenize
from numpy.typing import DTypeLike, NDArray

from halfline._scene import Scene
from halfline.dask._trees import Tree

if TYPE_CHECKING:
    from typing_extensions import Self

Answer = TypeVar("Answer")
"""What comes of them."""

Lazy = TypeVar("Lazy", bound="LazyAnswers[Any]")


class LazyAnswers(DaskMethodsMixin, Generic[Answer]):
    """A collection of Dask that is an array of records, one for each ray or point.

    A record is all of an answer, so that each is asked for once whatever is wanted of it.
    """

    def __init__(self, scene: Scene, tree: Tree, records: da.Array) -> None:
        self._scene = scene
        self._tree = tree
        self._records = records

    @staticmethod
    def _of_records(tree: Tree, records: NDArray[Any]) -> Answer:
        """What `compute` gives."""
        raise NotImplementedError

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading dimensions; NaN where Dask does not know them."""
        shape: tuple[int, ...] = self._records.shape
        return shape

    @property
    def ndim(self) -> int:
        """How many leading dimensions there are."""
        return len(self.shape)

    @property
    def chunks(self) -> tuple[tuple[int, ...], ...]:
        """The sizes of the chunks along each of them."""
        chunks: tuple[tuple[int, ...], ...] = self._records.chunks
        return chunks

    def _part(
        self, function: Callable[..., Any], dtype: DTypeLike, width: int | None = None, **more: Tree
    ) -> da.Array:
        ndim = self.ndim
        shape = (0,) * ndim if width is None else (0,) * ndim + (width,)
        part: da.Array = da.map_blocks(
            function,
            self._records,
            name=f"halfline-{function.__name__[1:]}-{tokenize(self._records.name, *more.values())}",
            chunks=self.chunks if width is None else (*self.chunks, (width,)),
            new_axis=None if width is None else [ndim],
            meta=np.empty(shape, dtype=dtype),
            dtype=dtype,
            **more,
        )
        return part

    def __repr__(self) -> str:
        return f"<halfline.dask.{type(self).__name__} of shape {self.shape}, chunks {self.chunks}>"

    def compute(self, **options: Any) -> Answer:
        """The answers.

        Args:
            **options: As for `dask.compute`.
        """
        answer: Answer = super().compute(**options)
        return answer

    def persist(self, **options: Any) -> Self:
        """The same with the answers there, or on a cluster on their way.

        Args:
            **options: As for `dask.persist`.
        """
        same: Self = super().persist(**options)
        return same

    # The protocol of Dask's collections is that of the records.

    def __dask_graph__(self) -> Any:
        return self._records.__dask_graph__()

    def __dask_keys__(self) -> list[Any]:
        keys: list[Any] = self._records.__dask_keys__()
        return keys

    def __dask_layers__(self) -> Sequence[str]:
        layers: Sequence[str] = self._records.__dask_layers__()
        return layers

    def __dask_tokenize__(self) -> tuple[str, Hashable]:
        return f"halfline.dask.{type(self).__name__}", self._records.name

    @property
    def __dask_optimize__(self) -> Any:
        # The very function of arrays: what has another one is optimised, and so computed, apart.
        return da.Array.__dask_optimize__

    __dask_scheduler__ = staticmethod(da.Array.__dask_scheduler__)

    def __dask_postcompute__(self) -> tuple[Callable[..., Answer], tuple[Any, ...]]:
        finalize, more = self._records.__dask_postcompute__()
        return _computed, (type(self), self._tree, finalize, more)

    def __dask_postpersist__(self) -> tuple[Callable[..., Self], tuple[Any, ...]]:
        rebuild, more = self._records.__dask_postpersist__()
        return _persisted, (type(self), self._scene, self._tree, rebuild, more)


def _computed(
    results: Any,
    kind: type[LazyAnswers[Answer]],
    tree: Tree,
    finalize: Callable[..., Any],
    more: tuple[Any, ...],
) -> Answer:
    return kind._of_records(tree, np.asarray(finalize(results, *more)))


def _persisted(
    graph: Mapping[Any, Any],
    kind: type[Lazy],
    scene: Scene,
    tree: Tree,
    rebuild: Callable[..., Any],
    more: tuple[Any, ...],
    *,
    rename: Mapping[str, str] | None = None,
) -> Lazy:
    records = rebuild(graph, *more, **({} if rename is None else {"rename": rename}))
    return kind(scene, tree, records)
