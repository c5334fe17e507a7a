"""A drop-in replacement for Open3D's ray caster.

    scene = halfline.open3d.RaycastingScene()
    scene.add_triangles(vertices, triangles)
    distances = scene.cast_rays(rays)["t_hit"]    # rays (..., 6); inf where nothing is hit
    distances = scene.compute_signed_distance(points)    # points (..., 3); negative inside

Rays and answers are NumPy arrays. Open3D's tensors and meshes are taken too; Open3D itself is not
imported here.
"""

from __future__ import annotations

from typing import Any, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from halfline._arrays import FloatArray, floats
from halfline._inside import is_enclosed
from halfline._mesh import Mesh
from halfline._pinhole import Given, rays_through, towards, untensored
from halfline._scene import Scene

__all__ = ["RaycastingScene"]


class _Built(NamedTuple):
    """All geometries in one scene."""

    scene: Scene
    first_faces: NDArray[np.int64]
    """The first face of each geometry."""


class RaycastingScene:
    """Casts rays at one or several meshes, with the methods of Open3D's `RaycastingScene`.

    It takes the place of `open3d.t.geometry.RaycastingScene` of Open3D 0.20: argument names, order
    and defaults, keys, shapes, dtypes and what a miss is are the same. The answers are those of the
    exact rays and triangles, as of `halfline.Scene`, and are rounded to float32 only at the end.
    They differ from Open3D's in this:

    - Float64 vertices and rays, which Open3D refuses, are taken as they are; such rays are answered
      in float64.
    - A ray through an edge or a vertex that faces share crosses the surface there once; Open3D may
      count none, one or several. A ray that only touches a closed surface there does not cross it.
    - `list_intersections` sorts the hits of each ray, which Open3D lists in any order.
    - A single ray or point, of shape (6,) or (3,), is answered, and so is `list_intersections` of
      no rays, which ends the process in Open3D.
    - Wrong arguments raise ValueError and TypeError, where Open3D raises RuntimeError; so do
      indices that have no vertex, at which Open3D reads what is not there.
    - Of equally near faces that with the lowest IDs is told; Open3D tells any.
    - Inside is where a ray crosses the surface an odd number of times, without Open3D's errors on
      rays through edges. Meshes with holes have an inside as well: where the winding number is odd
      when rounded.
    - Where a scene has no triangle, distances are infinite; Open3D's are those to the origin.

    The tree is built by the first question after geometry was added. Questions may be asked from
    many threads at once, but not while geometry is added.

    Args:
        nthreads: Has no effect, here and in all methods: `halfline.set_thread_count` says how many
            threads work.
        device: Has no effect: all is done by the CPU.
    """

    INVALID_ID: int = 2**32 - 1
    """The ID of geometry and primitive where there is no hit."""

    def __init__(self, nthreads: int = 0, device: object = None) -> None:
        self._meshes: list[Mesh] = []
        self._built: _Built | None = None

    @overload
    def add_triangles(self, vertex_positions: Given, triangle_indices: Given) -> int: ...
    @overload
    def add_triangles(self, mesh: Any) -> int: ...
    def add_triangles(self, *args: Any, **kwargs: Any) -> int:
        """Adds a mesh, which is copied.

        `add_triangles(vertex_positions, triangle_indices)` takes arrays, `add_triangles(mesh)` a
        mesh of Open3D, new (`vertex.positions`, `triangle.indices`) or legacy (`vertices`,
        `triangles`), or anything with `vertices` and `faces`.

        Args:
            *args: Vertices, shape (n, 3), float32 or float64, and indices of the three vertices of
                each triangle, shape (m, 3), any integers. Or a mesh.
            **kwargs: The same as `vertex_positions` and `triangle_indices`, or as `mesh`.

        Returns:
            The geometry ID of the mesh: 0 for the first, 1 for the next.

        Raises:
            TypeError: For other arguments, for what is no mesh, and for other dtypes.
            ValueError: For other shapes, and for an index that has no vertex.
        """
        vertices, triangles = _triangles(*args, **kwargs)
        self._meshes.append(Mesh(untensored(vertices), untensored(triangles)))
        self._built = None
        return len(self._meshes) - 1

    def cast_rays(self, rays: Given, nthreads: int = 0) -> dict[str, NDArray[Any]]:
        """The first hit of each ray; of equally close ones that with the lowest IDs.

        Args:
            rays: Origin and direction of each, shape (..., 6), float32 or float64. Directions may
                have any length, which is the unit of `t_hit`.
            nthreads: Has no effect.

        Returns:
            `t_hit`, shape (...), infinite for a miss; `geometry_ids` and `primitive_ids`, shape
            (...), uint32, INVALID_ID for a miss; `primitive_uvs`, barycentric weights of the second
            and third vertex, shape (..., 2), and `primitive_normals`, of length one, shape
            (..., 3), zero for a miss. Floats are of the dtype of the rays.

        Raises:
            TypeError: For arrays that are not of real numbers, or of longdouble.
            ValueError: For other shapes.
        """
        array = _array("rays", rays, 6)
        built = self._build()
        hits = built.scene.intersect(array[..., :3], array[..., 3:])
        geometry, primitive = self._ids(built, hits.face)
        normals = np.where(hits.hit[..., None], hits.normal, 0.0)
        return {
            "t_hit": hits.t.astype(array.dtype, copy=False),
            "geometry_ids": geometry,
            "primitive_ids": primitive,
            "primitive_uvs": hits.uv.astype(array.dtype, copy=False),
            "primitive_normals": normals.astype(array.dtype, copy=False),
        }

    def test_occlusions(
        self, rays: Given, tnear: float = 0.0, tfar: float = np.inf, nthreads: int = 0
    ) -> NDArray[np.bool_]:
        """Whether each ray hits anything.

        Exceptions are those of `cast_rays`.

        Args:
            rays: Origin and direction of each, shape (..., 6), as `cast_rays` takes them.
            tnear: Smallest t that counts, itself included; nothing behind the origin counts.
            tfar: Largest t that counts, itself included.
            nthreads: Has no effect.

        Returns:
            Shape (...), bool.
        """
        array = _array("rays", rays, 6)
        begin, end = max(float(tnear), 0.0), float(tfar)
        scene = self._build().scene
        return scene.occluded(array[..., :3], array[..., 3:], t_min=begin, t_max=end)

    def count_intersections(self, rays: Given, nthreads: int = 0) -> NDArray[np.int32]:
        """How many hits each ray has; arguments and exceptions are those of `cast_rays`.

        Returns:
            Shape (...), int32.
        """
        array = _array("rays", rays, 6)
        counts = self._build().scene.count_intersections(array[..., :3], array[..., 3:])
        return np.asarray(counts, dtype=np.int32)

    def list_intersections(self, rays: Given, nthreads: int = 0) -> dict[str, NDArray[Any]]:
        """All hits of each ray, by ray, by distance along the ray, and by IDs.

        Arguments and exceptions are those of `cast_rays`, and one more.

        Returns:
            `ray_splits`, where the hits of each ray begin, and the number of all, shape (n + 1,)
            for n rays in C order, uint32; and of the m hits `ray_ids`, `geometry_ids` and
            `primitive_ids`, shape (m,), uint32, `t_hit`, shape (m,), and `primitive_uvs`, shape
            (m, 2), which are of the dtype of the rays. A ray that misses has no hits.

        Raises:
            OverflowError: If there are 2^32 hits, which uint32 cannot count.
        """
        array = _array("rays", rays, 6)
        built = self._build()
        hits = built.scene.intersect_all(array[..., :3], array[..., 3:])
        if len(hits.t) > self.INVALID_ID:
            raise OverflowError(f"rays: expected fewer than 2**32 hits, found {len(hits.t)}")
        geometry, primitive = self._ids(built, hits.face)
        return {
            "ray_splits": hits.splits.astype(np.uint32),
            "ray_ids": hits.ray.astype(np.uint32),
            "t_hit": hits.t.astype(array.dtype, copy=False),
            "geometry_ids": geometry,
            "primitive_ids": primitive,
            "primitive_uvs": hits.uv.astype(array.dtype, copy=False),
        }

    def compute_closest_points(
        self, query_points: Given, nthreads: int = 0
    ) -> dict[str, NDArray[Any]]:
        """The point of all geometry that is nearest to each point.

        Args:
            query_points: Shape (..., 3), float32 or float64.
            nthreads: Has no effect.

        Returns:
            `points`, the nearest points, shape (..., 3); `geometry_ids` and `primitive_ids`, shape
            (...), uint32; `primitive_uvs`, barycentric weights of the second and third vertex,
            shape (..., 2), and `primitive_normals`, of length one, shape (..., 3). Where there is
            no triangle, and for a point with a NaN or an infinite coordinate, IDs are INVALID_ID
            and the rest zero. Floats are of the dtype of the points.

        Raises:
            TypeError: For arrays that are not of real numbers, or of longdouble.
            ValueError: For other shapes.
        """
        points = _array("query_points", query_points, 3)
        built = self._build()
        near = built.scene.closest_points(points)
        geometry, primitive = self._ids(built, near.face)
        found = near.found[..., None]
        return {
            "points": np.where(found, near.point, 0.0).astype(points.dtype, copy=False),
            "geometry_ids": geometry,
            "primitive_ids": primitive,
            "primitive_uvs": np.where(found, near.uv, 0.0).astype(points.dtype, copy=False),
            "primitive_normals": _numbers(near.normal).astype(points.dtype, copy=False),
        }

    def compute_distance(self, query_points: Given, nthreads: int = 0) -> NDArray[Any]:
        """How far points are from the nearest triangle.

        Arguments and exceptions are those of `compute_closest_points`.

        Returns:
            Shape (...), of the dtype of the points: 0 on a surface, infinite where there is no
            triangle, and NaN for a point with a NaN or an infinite coordinate.
        """
        points = _array("query_points", query_points, 3)
        return self._distance(points).astype(points.dtype, copy=False)

    def compute_signed_distance(
        self, query_points: Given, nthreads: int = 0, nsamples: int = 1
    ) -> NDArray[Any]:
        """How far points are from the nearest triangle: negative inside.

        Inside is what `compute_occupancy` says. Arguments and exceptions are its.

        Returns:
            As `compute_distance`.
        """
        points = _array("query_points", query_points, 3)
        _check_samples(nsamples)
        distance = self._distance(points)
        is_negative = is_enclosed(self._build().scene, points) & (distance > 0.0)
        return np.where(is_negative, -distance, distance).astype(points.dtype, copy=False)

    def compute_occupancy(
        self, query_points: Given, nthreads: int = 0, nsamples: int = 1
    ) -> NDArray[Any]:
        """Whether points lie inside.

        Exactly, if the geometry has no holes: then points on the surface are inside.

        Args:
            query_points: Shape (..., 3), float32 or float64.
            nthreads: Has no effect.
            nsamples: Has no effect, since there is nothing to vote on, but must be odd.

        Returns:
            1 for a point inside, else 0, shape (...), of the dtype of the points.

        Raises:
            TypeError: For arrays that are not of real numbers, or of longdouble.
            ValueError: For other shapes, and for numbers of rays that are not odd.
        """
        points = _array("query_points", query_points, 3)
        _check_samples(nsamples)
        return is_enclosed(self._build().scene, points).astype(points.dtype)

    def _distance(self, points: FloatArray) -> NDArray[np.float64]:
        distance = self._build().scene.closest_points(points).distance
        is_finite = np.isfinite(points).all(axis=-1)
        return np.where(is_finite, distance, np.nan)

    @overload
    @staticmethod
    def create_rays_pinhole(
        intrinsic_matrix: Given, extrinsic_matrix: Given, width_px: int, height_px: int
    ) -> NDArray[np.float32]: ...
    @overload
    @staticmethod
    def create_rays_pinhole(
        fov_deg: float,
        center: Given,
        eye: Given,
        up: Given,
        width_px: int,
        height_px: int,
    ) -> NDArray[np.float32]: ...
    @staticmethod
    def create_rays_pinhole(*args: Any, **kwargs: Any) -> NDArray[np.float32]:
        """Rays through the centres of the pixels of a pinhole camera.

        `create_rays_pinhole(intrinsic_matrix, extrinsic_matrix, width_px, height_px)` takes the
        upper triangular matrix of the camera, shape (3, 3), and the one that takes the world to the
        camera, shape (4, 4): there, x goes along the rows, y from row to row, and z ahead.
        `create_rays_pinhole(fov_deg, center, eye, up, width_px, height_px)` takes the horizontal
        field of view, the point to look at, where the camera is, and the vector along which the
        image goes from row to row: what is up comes last, as in Open3D.

        Args:
            *args: As above.
            **kwargs: As above.

        Returns:
            Shape (height_px, width_px, 6), float32, for `cast_rays`. Directions reach the plane at
            distance one from the camera; they are not finite if matrix or vectors determine none.

        Raises:
            TypeError: For other arguments and dtypes.
            ValueError: For other shapes, and for negative sizes.
        """
        if len(args) + len(kwargs) == 4:
            return rays_through(*args, **kwargs)
        return towards(*args, **kwargs)

    def _build(self) -> _Built:
        built = self._built
        if built is None:
            built = self._built = _build(self._meshes)
        return built

    def _ids(
        self, built: _Built, face: NDArray[np.int64]
    ) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """The geometry and the primitive of each face of the scene, of -1 INVALID_ID."""
        if len(built.first_faces) <= 1:
            geometry = np.where(face < 0, self.INVALID_ID, 0)
            primitive = face
        else:
            geometry = np.searchsorted(built.first_faces, face, side="right") - 1
            primitive = np.where(face < 0, face, face - built.first_faces[geometry])
        # Of -1 this makes INVALID_ID.
        return geometry.astype(np.uint32), primitive.astype(np.uint32)


def _build(meshes: list[Mesh]) -> _Built:
    counts = [len(mesh.faces) for mesh in meshes]
    first_faces = np.cumsum([0, *counts])[:-1]
    if len(meshes) == 1:
        return _Built(Scene(meshes[0]), first_faces)
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    # What is float32 stays so unless something is not.
    vertices = np.concatenate([np.empty((0, 3), np.float32), *(mesh.vertices for mesh in meshes)])
    faces = [
        mesh.faces + offset for mesh, offset in zip(meshes, offsets[:-1].tolist(), strict=True)
    ]
    indices = np.concatenate([np.empty((0, 3), np.uint32), *faces])
    return _Built(Scene(vertices, indices), first_faces)


def _check_samples(nsamples: int) -> None:
    if nsamples < 1 or nsamples % 2 == 0:
        raise ValueError(f"nsamples: expected an odd number of rays, found {nsamples}")


def _numbers(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Normals with zeros where there are none."""
    return np.nan_to_num(normals, nan=0.0)


def _array(name: str, value: Any, width: int) -> FloatArray:
    array = floats(name, untensored(value), f"(..., {width})")
    if array.ndim == 0 or array.shape[-1] != width:
        raise ValueError(f"{name}: expected shape (..., {width}), found {array.shape}")
    return array


def _triangles(*args: Any, **kwargs: Any) -> tuple[Any, Any]:
    names = ("mesh",) if len(args) + len(kwargs) == 1 else ("vertex_positions", "triangle_indices")
    given = dict(zip(names, args, strict=False)) | kwargs
    if len(args) > len(names) or len(given) != len(args) + len(kwargs) or set(given) != set(names):
        raise TypeError(
            "add_triangles: expected vertex_positions and triangle_indices, or mesh, found "
            f"{len(args)} arguments{''.join(f', {name}' for name in kwargs)}"
        )
    if len(names) == 2:
        return given["vertex_positions"], given["triangle_indices"]
    mesh = given["mesh"]
    if hasattr(mesh, "vertex") and hasattr(mesh, "triangle"):
        return mesh.vertex["positions"], mesh.triangle["indices"]
    for faces in ("triangles", "faces"):
        if hasattr(mesh, "vertices") and hasattr(mesh, faces):
            return mesh.vertices, getattr(mesh, faces)
    raise TypeError(
        "mesh: expected something with .vertex and .triangle, .vertices and .triangles, or "
        f".vertices and .faces, found {type(mesh).__name__}"
    )
