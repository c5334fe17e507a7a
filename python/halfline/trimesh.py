"""A drop-in replacement for trimesh's ray casters and proximity queries.

    mesh.ray = halfline.trimesh.RayMeshIntersector(mesh)
    mesh.nearest = halfline.trimesh.ProximityQuery(mesh)

Everything in trimesh that goes through `mesh.ray` and `mesh.nearest` then asks halfline:
`mesh.contains`, `trimesh.proximity.thickness`, registration, voxels by rays. `closest_point`,
`signed_distance` and `contains` are functions of a mesh and points. trimesh itself is not imported
here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfline._arrays import FloatArray, floats
from halfline._inside import is_enclosed
from halfline._mesh import MeshLike
from halfline._proximity import (
    ProximityQuery,
    closest_point,
    contains,
    rows_of_points,
    signed_distance,
)
from halfline._scene import Scene

__all__ = [
    "ProximityQuery",
    "RayMeshIntersector",
    "closest_point",
    "contains",
    "signed_distance",
]


class _Hits(NamedTuple):
    """Rows of hits, by ray and then along the ray."""

    face: NDArray[np.int64]
    ray: NDArray[np.int64]
    location: NDArray[np.float64] | None


class RayMeshIntersector:
    """Casts rays at a trimesh mesh, with the methods of trimesh's own intersectors.

    It takes the place of `trimesh.ray.ray_pyembree.RayMeshIntersector`, whose argument names, order
    and defaults these are, and of `trimesh.ray.ray_triangle.RayMeshIntersector`, all of whose
    arguments it knows by name. The answers are those of the exact rays and triangles in double
    precision, as of `halfline.Scene`, and differ from trimesh's in this:

    - A ray through an edge or a vertex that faces share crosses the surface there once, and
      `intersects_id` tells one of the faces, where trimesh's may tell both, or none. A ray that
      only touches a closed surface there, or lies in the plane of a face, does not cross it.
    - Hits begin at the origin of the ray, itself included: ray_triangle's begin a millionth before.
    - Hits come in the order of the rays, and those of a ray in the order in which it meets them.
    - `intersects_first` gives int64, as ray_triangle's does.

    The tree is built by the first question, and again by the first one after the mesh's vertices or
    faces changed, which the mesh's hash tells. `Trimesh.copy` and `copy.deepcopy` give a mesh with
    trimesh's default intersector, whatever `ray` was; `pickle` keeps this one, without its tree.

    Args:
        geometry: The mesh: a `trimesh.Trimesh`, or anything with `vertices`, `faces` and a hash of
            them. Also called `mesh`, as by ray_triangle.
        scale_to_box: Has no effect: nothing needs to be scaled.
        mesh: The same as `geometry`.

    Raises:
        TypeError: If there is not exactly one mesh.
    """

    def __init__(
        self,
        geometry: MeshLike | None = None,
        scale_to_box: bool = True,
        *,
        mesh: MeshLike | None = None,
    ) -> None:
        found = [given for given in (geometry, mesh) if given is not None]
        if len(found) != 1:
            raise TypeError("geometry: expected one mesh")
        self.mesh = found[0]
        self._scale_to_box = scale_to_box
        self._built: tuple[int, Scene] | None = None

    @property
    def scene(self) -> Scene:
        """The `halfline.Scene` of the mesh as it is now."""
        now = hash(self.mesh)
        if self._built is None or self._built[0] != now:
            self._built = now, Scene(self.mesh)
        return self._built[1]

    def intersects_location(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        """Where rays hit the mesh.

        Args:
            ray_origins: Where rays begin, shape (n, 3).
            ray_directions: Where they go, of any length, shape (n, 3).
            multiple_hits: Whether to tell all hits of a ray, however many, or the first one only.

        Returns:
            Points of the hits, shape (m, 3), float64; the index of the ray of each, shape (m,),
            int64; and of its face, shape (m,), int64. A ray that misses does not occur in them.

        Raises:
            TypeError: For arrays that are not of real numbers, or of longdouble.
            ValueError: For other shapes, and for shapes that differ.
        """
        hits = self._hits(ray_origins, ray_directions, multiple_hits, None, True)
        assert hits.location is not None
        return hits.location, hits.ray, hits.face

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: int = 100,
        return_locations: bool = False,
    ) -> Any:
        """Which faces rays hit.

        Exceptions are those of `intersects_location`.

        Args:
            ray_origins: Where rays begin, shape (n, 3).
            ray_directions: Where they go, of any length, shape (n, 3).
            multiple_hits: Whether to tell all hits of a ray, or the first one only.
            max_hits: How many hits of a ray to tell at most, the first ones.
            return_locations: Whether to tell where they are.

        Returns:
            The index of the face of each hit, shape (m,), int64; of its ray, shape (m,), int64; and
            with `return_locations` its point, shape (m, 3), float64. A ray that misses does not
            occur in them.
        """
        hits = self._hits(ray_origins, ray_directions, multiple_hits, max_hits, return_locations)
        return tuple(hits) if return_locations else (hits.face, hits.ray)

    def intersects_first(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike
    ) -> NDArray[np.int64]:
        """The first face that each ray hits.

        Exceptions are those of `intersects_location`.

        Args:
            ray_origins: Where rays begin, shape (n, 3).
            ray_directions: Where they go, of any length, shape (n, 3).

        Returns:
            Indices of faces, -1 for a miss, shape (n,), int64.
        """
        return self.scene.intersect(*_rays(ray_origins, ray_directions)).face

    def intersects_any(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike
    ) -> NDArray[np.bool_]:
        """Whether each ray hits the mesh.

        Exceptions are those of `intersects_location`.

        Args:
            ray_origins: Where rays begin, shape (n, 3).
            ray_directions: Where they go, of any length, shape (n, 3).

        Returns:
            Shape (n,), bool.
        """
        return self.scene.occluded(*_rays(ray_origins, ray_directions))

    def contains_points(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points lie inside the mesh.

        In a mesh without holes that is the parity of the crossings of a ray, exactly, and a point
        on the surface is inside. In one with holes, where trimesh's answer depends on what two rays
        meet, it is whether the winding number is odd when rounded: the inside ends where half of
        the sphere of directions is covered. Neither depends on which side faces are seen from.

        Args:
            points: Shape (n, 3).

        Returns:
            Shape (n,), bool; False for a point with a NaN or an infinite coordinate.

        Raises:
            TypeError: For arrays that are not of real numbers, or of longdouble.
            ValueError: For other shapes.
        """
        return is_enclosed(self.scene, rows_of_points(points))

    def _hits(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool,
        max_hits: int | None,
        locate: bool,
    ) -> _Hits:
        rays = _rays(ray_origins, ray_directions)
        limit = None if max_hits is None else max(max_hits, 0)
        if not multiple_hits:
            hits = self.scene.intersect(*rays)
            first = np.flatnonzero(hits.hit).astype(np.int64, copy=False)
            if limit == 0:
                first = first[:0]
            hits = hits[first]
            return _Hits(hits.face, first, hits.point if locate else None)
        every = self.scene.intersect_all(*rays)
        face, ray = every.face, every.ray
        keep: Any = slice(None)
        if limit is not None and np.diff(every.splits).max(initial=0) > limit:
            keep = np.arange(len(face)) - every.splits[ray] < limit
        return _Hits(face[keep], ray[keep], every.point[keep] if locate else None)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_built": None}

    def __copy__(self) -> RayMeshIntersector:
        return RayMeshIntersector(self.mesh, self._scale_to_box)

    def __deepcopy__(self, memo: dict[int, Any]) -> RayMeshIntersector:
        # As trimesh's: the mesh owns the intersector, so the copy is of the same mesh.
        return self.__copy__()

    def __repr__(self) -> str:
        return f"<halfline.trimesh.RayMeshIntersector of {self.mesh!r}>"


def _rays(ray_origins: ArrayLike, ray_directions: ArrayLike) -> tuple[FloatArray, FloatArray]:
    origins = floats("ray_origins", ray_origins, "(n, 3)")
    directions = floats("ray_directions", ray_directions, "(n, 3)")
    if origins.shape != directions.shape or origins.ndim != 2 or origins.shape[1] != 3:
        raise ValueError(
            "ray_origins, ray_directions: expected the same shape (n, 3), found "
            f"{origins.shape} and {directions.shape}"
        )
    return origins, directions
