"""Hits that are not yet computed."""

from __future__ import annotations

from typing import Any

import dask.array as da
import numpy as np
from numpy.typing import NDArray

from halfline._hits import Hits, surface_of
from halfline.dask._lazy_answers import LazyAnswers
from halfline.dask._trees import Tree, scene_of

HIT = np.dtype([("t", np.float64), ("face", np.int64), ("uv", np.float64, (2,))])


class LazyHits(LazyAnswers[Hits]):
    """The closest hit of each ray, not yet computed: what `Hits` has, as Dask arrays.

    A ray that hits nothing has `t` infinite, `face` -1, `uv` zero, and NaN for `point` and
    `normal`.

    All of them come from one task for each chunk of rays: to compute several together,
    `dask.compute(hits.t, hits.face)`, casts each ray once. It is a collection of Dask itself:
    `hits.compute()` and `dask.compute(hits)` give a `halfline.Hits`, `hits.persist()` the same as
    this whose rays are cast already or are being cast, on the cluster if there is one.
    """

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

    @staticmethod
    def _of_records(tree: Tree, records: NDArray[Any]) -> Hits:
        return _hits_of(tree, _t(records), _face(records), _uv(records))


def records_of_hits(hits: Hits) -> NDArray[Any]:
    """One record for each ray."""
    records = np.empty(hits.shape, dtype=HIT)
    records["t"], records["face"], records["uv"] = hits.t, hits.face, hits.uv
    return records


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
