"""The questions of `Scene` over Dask arrays of rays."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any

import dask.array as da
import numpy as np
from dask.base import DaskMethodsMixin, tokenize
from numpy.typing import ArrayLike, DTypeLike, NDArray

from halfline._arrays import float_type
from halfline._hits import Hits, _surface
from halfline._scene import Scene
from halfline.dask._trees import Tree, scene_of, tree_of

# All of a hit, so that each ray is cast once whatever is asked of it.
_HIT = np.dtype([("t", np.float64), ("face", np.int64), ("uv", np.float64, (2,))])


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
    where arguments differ, made the same; the last axis becomes one chunk. Chunks of some hundred
    thousand rays are best. Sizes of chunks that Dask does not know (NaN) must be those of all
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
    records = _ask("intersect", tree, _HIT, origins, directions, t_min, t_max)
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

    Args:
        scene: As for `intersect`.
        origins: As for `intersect`.
        directions: As for `intersect`.
        t_min: As for `intersect`.
        t_max: As for `intersect`.

    Returns:
        A Dask array of the rays' leading dimensions, bool.

    Raises:
        TypeError: As `intersect`.
        ValueError: As `intersect`.
        OSError: As `intersect`.
        FormatError: As `intersect`.
        MissingTreeError: As `intersect`.
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

    Args:
        scene: As for `intersect`.
        origins: As for `intersect`.
        directions: As for `intersect`.
        t_min: As for `intersect`.
        t_max: As for `intersect`.

    Returns:
        A Dask array of the rays' leading dimensions, int64.

    Raises:
        TypeError: As `intersect`.
        ValueError: As `intersect`.
        OSError: As `intersect`.
        FormatError: As `intersect`.
        MissingTreeError: As `intersect`.
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
    records = np.empty(answer.shape, dtype=_HIT)
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


def _t(records: NDArray[Any]) -> NDArray[np.float64]:
    return np.array(records["t"])


def _face(records: NDArray[Any]) -> NDArray[np.int64]:
    return np.array(records["face"])


def _hit(records: NDArray[Any]) -> NDArray[np.bool_]:
    return np.asarray(records["face"] >= 0)


def _uv(records: NDArray[Any]) -> NDArray[np.float64]:
    return np.array(records["uv"])


def _point(records: NDArray[Any], *, tree: Tree) -> NDArray[np.float64]:
    return _surface(scene_of(tree).mesh, records["face"], records["uv"]).point


def _normal(records: NDArray[Any], *, tree: Tree) -> NDArray[np.float64]:
    return _surface(scene_of(tree).mesh, records["face"], records["uv"]).normal
