"""What trimesh asks about points: which place of the surface is nearest, and whether it is inside.

`halfline.trimesh` has it by the names of trimesh. trimesh itself is not imported.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfline._arrays import FloatArray, floats
from halfline._hits import surface_of
from halfline._inside import is_enclosed, places_of
from halfline._mesh import Mesh, MeshLike
from halfline._nearest import FEATURES, Nearest
from halfline._scene import Scene

OnSurface: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]
"""Nearest points (n, 3), distances (n,), and faces (n,)."""

# What trimesh calls `tol.merge`: so far outside, a point still counts as on the surface.
_ON_SURFACE = 1e-8

_FACE, _EDGE = FEATURES.index("face"), FEATURES.index("edge")

# So many points at a time look at the faces around an edge or a vertex, which bounds the memory.
_POINTS_AT_ONCE = 1 << 18


class ProximityQuery:
    """Finds what of a trimesh mesh is nearest to points, as `trimesh.proximity.ProximityQuery`.

        mesh.nearest = halfline.trimesh.ProximityQuery(mesh)

    Everything in trimesh that goes through `mesh.nearest` then asks halfline. The answers are those
    of exact arithmetic, as of `halfline.Scene`, and differ from trimesh's in this:

    - The nearest point is the nearest one. trimesh takes faces whose squared distances differ by
      less than 1e-8 for equally near, and may tell the one that is farther.
    - Of faces that meet at the nearest point, on an edge or a vertex, all are looked at for the one
      that faces the point most, where trimesh looks at two.
    - The sign is that of `RayMeshIntersector.contains_points`, whichever way faces are oriented.
      trimesh takes the side of the nearest face where the point is straight above it.
    - No points give no answers, where trimesh raises ValueError.

    The tree is that of `mesh.ray` if that is a `halfline.trimesh.RayMeshIntersector`. Otherwise it
    is built by the first question, and again by the first one after the mesh's vertices or faces
    changed, which the mesh's hash tells. Copies of a mesh begin with trimesh's own; `pickle` keeps
    this one, without its tree.

    Args:
        mesh: A `trimesh.Trimesh`, or anything with `vertices`, `faces` and a hash of them.
    """

    def __init__(self, mesh: MeshLike) -> None:
        self._mesh = mesh
        self._surface: _Kept | None = None
        self._vertices: _Kept | None = None

    @property
    def scene(self) -> Scene:
        """The `halfline.Scene` of the mesh as it is now."""
        return self._kept().scene

    def on_surface(self, points: ArrayLike) -> OnSurface:
        """The point of the surface that is nearest to each point.

        Args:
            points: Shape (n, 3).

        Returns:
            The nearest points, shape (n, 3), float64; their distances, shape (n,), float64; and the
            indices of their faces, shape (n,), int64. Of faces that meet there it is the one that
            faces the point most, and of those the lowest.

        Raises:
            TypeError: For arrays that are not of real numbers, or of longdouble.
            ValueError: For other shapes, for NaN and infinite coordinates, and for a mesh without
                faces.
        """
        array = _points(points)
        kept = self._kept()
        near = _found(kept.scene.closest_points(array))
        return near.point, near.distance, kept.fans().most_facing(array, near)

    def vertex(self, points: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """The vertex of the mesh that is nearest to each point, whether any face has it or not.

        It is found by the mesh's own `kdtree`, which is SciPy's, and without SciPy by halfline.
        Arguments and exceptions are those of `on_surface`.

        Returns:
            Distances, shape (n,), float64, and indices of vertices, shape (n,), int64: any of
            several that are equally near.
        """
        array = _points(points)
        if len(self._mesh.vertices) == 0:
            raise ValueError("mesh: expected a vertex to be near to, found none")
        try:
            distance, index = self._mesh.kdtree.query(array)  # type: ignore[attr-defined]
        except (AttributeError, ImportError):
            near = _found(self._points_scene().closest_points(array))
            distance, index = near.distance, near.face
        return distance, np.asarray(index, dtype=np.int64)

    def signed_distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """How far points are from the surface: positive inside, negative outside.

        Up to 1e-8 from the surface it is positive on either side, as trimesh has it. Arguments and
        exceptions are those of `on_surface`.

        Returns:
            Shape (n,), float64.
        """
        array = _points(points)
        scene = self.scene
        distance = _found(scene.closest_points(array)).distance
        is_positive = (distance <= _ON_SURFACE) | is_enclosed(scene, array)
        return np.where(is_positive, distance, -distance)

    def _points_scene(self) -> Scene:
        now = hash(self._mesh)
        if self._vertices is None or self._vertices.hash != now:
            vertices = np.asarray(self._mesh.vertices)
            # A face that is a point is as near as that point.
            faces = np.repeat(np.arange(len(vertices))[:, None], 3, axis=1)
            self._vertices = _Kept(now, Scene(vertices, faces))
        return self._vertices.scene

    def _kept(self) -> _Kept:
        now = hash(self._mesh)
        ray = getattr(self._mesh, "ray", None)
        shared = getattr(ray, "scene", None) if getattr(ray, "mesh", None) is self._mesh else None
        kept = self._surface
        if isinstance(shared, Scene):
            if kept is None or kept.scene is not shared:
                kept = self._surface = _Kept(now, shared)
        elif kept is None or kept.hash != now:
            kept = self._surface = _Kept(now, Scene(self._mesh))
        return kept

    def __getstate__(self) -> dict[str, Any]:
        return {"_mesh": self._mesh, "_surface": None, "_vertices": None}

    def __copy__(self) -> ProximityQuery:
        return ProximityQuery(self._mesh)

    def __deepcopy__(self, memo: dict[int, Any]) -> ProximityQuery:
        # As of an intersector: the mesh owns it, so the copy is of the same mesh.
        return self.__copy__()

    def __repr__(self) -> str:
        return f"<halfline.trimesh.ProximityQuery of {self._mesh!r}>"


def closest_point(mesh: MeshLike, points: ArrayLike) -> OnSurface:
    """The point of a mesh that is nearest to each point, as `trimesh.proximity.closest_point`.

    It builds a tree in each call, unless `mesh.nearest` or `mesh.ray` is of halfline and has one.

    Args:
        mesh: A `trimesh.Trimesh`, or anything with `vertices`, `faces` and a hash of them.
        points: Shape (n, 3).

    Returns:
        As `ProximityQuery.on_surface`.

    Raises:
        TypeError: As `ProximityQuery.on_surface`.
        ValueError: As `ProximityQuery.on_surface`.
    """
    return _query(mesh).on_surface(points)


def signed_distance(mesh: MeshLike, points: ArrayLike) -> NDArray[np.float64]:
    """How far points are from a mesh, positive inside, as `trimesh.proximity.signed_distance`.

    Arguments, exceptions and the cost are those of `closest_point`.

    Returns:
        As `ProximityQuery.signed_distance`.
    """
    return _query(mesh).signed_distance(points)


def contains(mesh: MeshLike, points: ArrayLike) -> NDArray[np.bool_]:
    """Whether points are inside a mesh, as `mesh.contains` with halfline's intersector.

    Arguments and the cost are those of `closest_point`; NaN and infinite points are outside.

    Returns:
        As `RayMeshIntersector.contains_points`.
    """
    array = rows_of_points(points)
    return is_enclosed(_query(mesh).scene, array)


def rows_of_points(points: ArrayLike) -> FloatArray:
    """Points of shape (n, 3).

    Raises:
        TypeError: For arrays that are not of real numbers, or of longdouble.
        ValueError: For other shapes.
    """
    array = floats("points", points, "(n, 3)")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"points: expected shape (n, 3), found {array.shape}")
    return array


class _Kept:
    """The tree of a mesh as it was when it had a hash."""

    def __init__(self, hash_of_mesh: int, scene: Scene) -> None:
        self.hash = hash_of_mesh
        self.scene = scene
        self._fans: _Fans | None = None

    def fans(self) -> _Fans:
        """The faces around each vertex."""
        if self._fans is None:
            self._fans = _Fans(self.scene.mesh)
        return self._fans


class _Edges(NamedTuple):
    """The ends of the edges that are nearest to points, twice the same for a vertex."""

    begin: NDArray[np.int64]
    end: NDArray[np.int64]


class _Fans:
    """The faces around each vertex, where vertices with the same coordinates are one."""

    def __init__(self, mesh: Mesh) -> None:
        places = places_of(np.asarray(mesh.vertices))
        self._corners = places[np.asarray(mesh.faces, dtype=np.int64)]
        flat = self._corners.ravel()
        # By vertex, and then by face.
        self._faces = np.argsort(flat, kind="stable") // 3
        self._counts = np.bincount(flat, minlength=len(places))
        self._starts = np.cumsum(self._counts) - self._counts
        every = np.arange(len(self._corners), dtype=np.int64)
        self._normals = surface_of(mesh, every, np.zeros((len(every), 2))).normal

    def most_facing(self, points: FloatArray, near: Nearest) -> NDArray[np.int64]:
        """The faces at the nearest points, where there are several those that face the points."""
        faces: NDArray[np.int64] = near.face.copy()
        code = near._code
        rows = np.flatnonzero((code != _FACE) & (near.distance > 0.0))
        for first in range(0, len(rows), _POINTS_AT_ONCE):
            some = rows[first : first + _POINTS_AT_ONCE]
            ends = self._ends(near.face[some], near.uv[some], code[some] == _EDGE)
            faces[some] = self._among(ends, points[some] - near.point[some])
        return faces

    def _ends(
        self,
        faces: NDArray[np.int64],
        uv: NDArray[np.float64],
        is_edge: NDArray[np.bool_],
    ) -> _Edges:
        """The ends of the edges on which points lie that have one weight of zero, or two."""
        # Last is the weight that is known by a difference only, and so may be zero by rounding.
        weights = np.column_stack([uv, 1.0 - uv.sum(axis=1)])
        corners = self._corners[faces][:, [1, 2, 0]]
        each = np.arange(len(faces))
        opposite = weights.argmin(axis=1)
        at = weights.argmax(axis=1)
        begin = corners[each, np.where(is_edge, (opposite + 1) % 3, at)]
        end = corners[each, np.where(is_edge, (opposite + 2) % 3, at)]
        return _Edges(begin, end)

    def _among(self, edges: _Edges, towards: NDArray[np.float64]) -> NDArray[np.int64]:
        """Of the faces at each edge the one whose normal goes towards the point most."""
        counts = self._counts[edges.begin]
        splits = np.cumsum(counts) - counts
        row = np.repeat(np.arange(len(counts)), counts)
        within = np.arange(len(row)) - splits[row]
        faces = self._faces[self._starts[edges.begin][row] + within]
        along = np.einsum("ij,ij->i", self._normals[faces], towards[row])
        # Faces without area face nothing, but there may be no other.
        along = np.nan_to_num(along, nan=np.finfo(np.float64).min)
        is_there = np.any(self._corners[faces] == edges.end[row][:, None], axis=1)
        along[~is_there] = -np.inf
        most = np.maximum.reduceat(along, splits)
        chosen = np.where(is_there & (along == most[row]), faces, len(self._corners))
        return np.asarray(np.minimum.reduceat(chosen, splits))


def _query(mesh: MeshLike) -> ProximityQuery:
    nearest = getattr(mesh, "nearest", None)
    return nearest if isinstance(nearest, ProximityQuery) else ProximityQuery(mesh)


def _points(points: ArrayLike) -> FloatArray:
    array = rows_of_points(points)
    if not np.isfinite(array).all():
        raise ValueError("points: expected finite coordinates, found NaN or infinite ones")
    return array


def _found(near: Nearest) -> Nearest:
    # An index of -1 would be taken for that of the last face.
    if not near.found.all():
        raise ValueError("mesh: expected a face to be near to, found none")
    return near
