"""Nearest points that are not yet computed."""

from __future__ import annotations

from typing import Any

import dask.array as da
import numpy as np
from numpy.typing import NDArray

from halfline._hits import surface_of
from halfline._nearest import WORDS, Nearest, words_of
from halfline.dask._lazy_answers import LazyAnswers
from halfline.dask._trees import Tree, scene_of

NEAR = np.dtype(
    [
        ("distance", np.float64),
        ("point", np.float64, (3,)),
        ("face", np.int64),
        ("uv", np.float64, (2,)),
        ("code", np.uint8),
    ]
)


class LazyNearest(LazyAnswers[Nearest]):
    """The nearest point of a mesh for each point, not yet computed: `Nearest` as Dask arrays.

    Where nothing is within `max_distance`, `distance` is infinite, `face` -1, `point`, `uv` and
    `normal` NaN, and `feature` empty.

    All of them come from one task for each chunk of points: to compute several together,
    `dask.compute(near.distance, near.face)`, finds each once. It is a collection of Dask itself:
    `near.compute()` and `dask.compute(near)` give a `halfline.Nearest`, `near.persist()` the same
    as this that is computed already or is being computed, on the cluster if there is one.
    """

    @property
    def distance(self) -> da.Array:
        """How far the nearest point is, shape (...), float64; 0 on the surface."""
        return self._part(_distance, np.float64)

    @property
    def point(self) -> da.Array:
        """The nearest point, shape (..., 3), float64."""
        return self._part(_near_point, np.float64, 3)

    @property
    def face(self) -> da.Array:
        """The face that it belongs to, the lowest of several, shape (...), int64."""
        return self._part(_near_face, np.int64)

    @property
    def uv(self) -> da.Array:
        """Barycentric weights of the face's second and third vertex, shape (..., 2), float64."""
        return self._part(_near_uv, np.float64, 2)

    @property
    def feature(self) -> da.Array:
        """What of the face is nearest: "face", "edge", "vertex" or "", shape (...)."""
        return self._part(_feature, WORDS.dtype)

    @property
    def found(self) -> da.Array:
        """Whether anything is within `max_distance`, shape (...), bool."""
        return self._part(_found, np.bool_)

    @property
    def normal(self) -> da.Array:
        """Unit normals of the nearest faces, shape (..., 3), float64."""
        return self._part(_near_normal, np.float64, 3, tree=self._tree)

    @staticmethod
    def _of_records(tree: Tree, records: NDArray[Any]) -> Nearest:
        return _nearest_of(tree, *(np.array(records[name]) for name in NEAR.names or ()))


def records_of_nearest(near: Nearest) -> NDArray[Any]:
    """One record for each point."""
    records = np.empty(near.shape, dtype=NEAR)
    records["distance"], records["point"], records["face"] = near.distance, near.point, near.face
    records["uv"], records["code"] = near.uv, near._code
    return records


class _FileNearest(Nearest):
    """Nearest points that pickle without their mesh, which is in a file."""

    __slots__ = ("_tree",)

    _tree: Tree

    def __reduce__(self) -> tuple[Any, ...]:
        parts = (self.distance, self.point, self.face, self.uv, self._code)
        return _nearest_of, (self._tree, *parts)


def _nearest_of(tree: Tree, *parts: Any) -> Nearest:
    near = _FileNearest(scene_of(tree).mesh, *parts)
    near._tree = tree
    return near


def _distance(records: NDArray[Any]) -> NDArray[np.float64]:
    return np.array(records["distance"])


def _near_point(records: NDArray[Any]) -> NDArray[np.float64]:
    return np.array(records["point"])


def _near_face(records: NDArray[Any]) -> NDArray[np.int64]:
    return np.array(records["face"])


def _near_uv(records: NDArray[Any]) -> NDArray[np.float64]:
    return np.array(records["uv"])


def _feature(records: NDArray[Any]) -> NDArray[np.str_]:
    return words_of(records["face"], records["code"])


def _found(records: NDArray[Any]) -> NDArray[np.bool_]:
    return np.asarray(records["face"] >= 0)


def _near_normal(records: NDArray[Any], *, tree: Tree) -> NDArray[np.float64]:
    return surface_of(scene_of(tree).mesh, records["face"], records["uv"]).normal
