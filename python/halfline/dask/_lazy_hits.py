"""Hits that are not yet computed."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any

import dask.array as da
import numpy as np
from dask.base import DaskMethodsMixin, tokenize
from numpy.typing import DTypeLike, NDArray

from halfline._hits import Hits, surface_of
from halfline._scene import Scene
from halfline.dask._trees import Tree, scene_of

# All of a hit, so that each ray is cast once whatever is asked of it.
HIT = np.dtype([("t", np.float64), ("face", np.int64), ("uv", np.float64, (2,))])


class LazyHits(DaskMethodsMixin):
    """The closest hit of each ray, not yet computed: what `Hits` has, as Dask arrays.

    A ray that hits nothing has `t` infinite, `face` -1, `uv` zero, and NaN for `point` and
    `normal`.

    All of them come from one task for each chunk of rays: to compute several together,
    `dask.compute(hits.t, hits.face)`, casts each ray once. It is a collection of Dask itself:
    `hits.compute()` and `dask.compute(hits)` give a `halfline.Hits`, `hits.persist()` the same as
    this whose rays are cast already or are being cast, on the cluster if there is one.
    """

    def __init__(self, scene: Scene, tree: Tree, records: da.Array) -> None:
        self._scene = scene
        self._tree = tree
        self._records = records

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading dimensions of the rays; NaN where Dask does not know them."""
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

    @property
    def t(self) -> da.Array:
        """Ray parameters in units of the rays' directions, shape (...), float64."""
        return self._part(_t, np.float64)

    @property
    def face(self) -> da.Array:
        """Indices into the mesh's faces, shape (...), int64."""
        return self._part(_face, np.int64)

    @property
    def hit(self) -> da.Array:
        """Whether each ray hits anything, shape (...), bool."""
        return self._part(_hit, np.bool_)

    @property
    def uv(self) -> da.Array:
        """Barycentric weights of the face's second and third vertex, shape (..., 2), float64."""
        return self._part(_uv, np.float64, 2)

    @property
    def point(self) -> da.Array:
        """Where the hits are, in the mesh's coordinates, (..., 3), float64; NaN for misses."""
        return self._part(_point, np.float64, 3, tree=self._tree)

    @property
    def normal(self) -> da.Array:
        """Unit normals of the faces that were hit, shape (..., 3), float64; NaN for misses."""
        return self._part(_normal, np.float64, 3, tree=self._tree)

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
        return f"<halfline.dask.LazyHits of shape {self.shape}, chunks {self.chunks}>"

    def compute(self, **options: Any) -> Hits:
        """Casts the rays.

        Args:
            **options: As for `dask.compute`.
        """
        hits: Hits = super().compute(**options)
        return hits

    def persist(self, **options: Any) -> LazyHits:
        """The same with the rays cast, or on a cluster being cast.

        Args:
            **options: As for `dask.persist`.
        """
        hits: LazyHits = super().persist(**options)
        return hits

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
        return "halfline.dask.LazyHits", self._records.name

    @property
    def __dask_optimize__(self) -> Any:
        # The very function of arrays: what has another one is optimised, and so computed, apart.
        return da.Array.__dask_optimize__

    __dask_scheduler__ = staticmethod(da.Array.__dask_scheduler__)

    def __dask_postcompute__(self) -> tuple[Callable[..., Hits], tuple[Any, ...]]:
        finalize, more = self._records.__dask_postcompute__()
        return _hits_of_results, (self._tree, finalize, more)

    def __dask_postpersist__(self) -> tuple[Callable[..., LazyHits], tuple[Any, ...]]:
        rebuild, more = self._records.__dask_postpersist__()
        return _persisted, (self._scene, self._tree, rebuild, more)


class _FileHits(Hits):
    """Hits that pickle without their mesh, which is in a file."""

    __slots__ = ("_tree",)

    _tree: Tree

    def __reduce__(self) -> tuple[Any, ...]:
        return _hits_of, (self._tree, self.t, self.face, self.uv)


def _hits_of(
    tree: Tree, t: NDArray[np.float64], face: NDArray[np.int64], uv: NDArray[np.float64]
) -> Hits:
    hits = _FileHits(scene_of(tree).mesh, t, face, uv)
    hits._tree = tree
    return hits


def _hits_of_results(
    results: Any, tree: Tree, finalize: Callable[..., Any], more: tuple[Any, ...]
) -> Hits:
    records = np.asarray(finalize(results, *more))
    return _hits_of(tree, _t(records), _face(records), _uv(records))


def _persisted(
    graph: Mapping[Any, Any],
    scene: Scene,
    tree: Tree,
    rebuild: Callable[..., Any],
    more: tuple[Any, ...],
    *,
    rename: Mapping[str, str] | None = None,
) -> LazyHits:
    records = rebuild(graph, *more, **({} if rename is None else {"rename": rename}))
    return LazyHits(scene, tree, records)


def _t(records: NDArray[Any]) -> NDArray[np.float64]:
    return np.array(records["t"])


def _face(records: NDArray[Any]) -> NDArray[np.int64]:
    return np.array(records["face"])


def _hit(records: NDArray[Any]) -> NDArray[np.bool_]:
    return np.asarray(records["face"] >= 0)


def _uv(records: NDArray[Any]) -> NDArray[np.float64]:
    return np.array(records["uv"])


def _point(records: NDArray[Any], *, tree: Tree) -> NDArray[np.float64]:
    return surface_of(scene_of(tree).mesh, records["face"], records["uv"]).point


def _normal(records: NDArray[Any], *, tree: Tree) -> NDArray[np.float64]:
    return surface_of(scene_of(tree).mesh, records["face"], records["uv"]).normal
