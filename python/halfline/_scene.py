"""Scenes: meshes that answer questions about rays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfline import _native
from halfline._arrays import count_of, rays_of
from halfline._hits import AllHits, Hits
from halfline._html import table
from halfline._mesh import Mesh, MeshLike
from halfline._progress import Progress, reporting


class Scene:
    """A mesh with a kd-tree over it, which answers questions about rays.

    `Scene(mesh)`, `Scene(vertices, faces)`, and `Scene(anything)` with `.vertices` and `.faces` build
    the tree, on all threads (see `set_thread_count`). A scene never changes; it may be asked from many
    threads at once, in children of `fork`, and after it was pickled.

    All questions take rays as `origins` and `directions`, arrays of shape (..., 3) whose leading
    dimensions are broadcast against each other and kept in the answer. A direction need not have unit
    length: `t` is in units of the direction. What is C-contiguous float32 or float64, each as it
    likes, is not copied; other layouts, integers and float16 are; no number is rounded. A ray with a
    NaN or an infinite coordinate, without a direction, or with `t_min > t_max` hits nothing.

    Every hit is that of the exact ray with the exact triangles: no ray slips between triangles that
    share an edge or a vertex, and each crossing of a closed surface counts once. docs/numerics.md
    derives it. The tree is that of Wald and Havran, "On building fast kd-trees for ray tracing, and on
    doing that in O(N log N)" (2006), with the changes that ARCHITECTURE.md tells.

    Args:
        mesh: A `Mesh`, or anything with `vertices` and `faces`; or the vertices, shape (n, 3).
        faces: Indices of vertices, shape (m, 3), any integers; only with vertices.
        preset: "fast" for the first answers soonest, "balanced" for about as many rays as there are
            triangles and more, "best" for the most rays a second. The answers are the same.
        progress: True for a bar (of tqdm, where it is installed), or a callable
            `progress(stage, done, total)` with the stage "build".

    Raises:
        TypeError: For what is no mesh.
        ValueError: For wrong arrays, more than 2^29 triangles, or an unknown preset.
        KeyboardInterrupt: On Ctrl-C.
    """

    __slots__ = ("__weakref__", "_mesh", "_native")

    def __init__(
        self,
        mesh: Mesh | MeshLike | ArrayLike,
        faces: ArrayLike | None = None,
        *,
        preset: str = "balanced",
        progress: Progress = None,
    ) -> None:
        self._mesh = _mesh_of(mesh, faces)
        with reporting(progress) as report:
            self._native = _native.Scene.build(self._mesh._native, preset, report)

    @property
    def mesh(self) -> Mesh:
        """The mesh."""
        return self._mesh

    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        progress: Progress = None,
    ) -> Hits:
        """The closest hit of each ray; of equally close ones that with the lowest face index.

        Args:
            origins: Where rays begin, shape (..., 3).
            directions: How far one unit of t reaches, shape (..., 3).
            t_min: Smallest t that counts, itself included: a number, or shape (...).
            t_max: Largest t that counts, itself included: a number, or shape (...).
            progress: True for a bar, or a callable `progress(stage, done, total)` with the stage
                "trace" and rays.

        Returns:
            `t`, `face`, `uv`, `point`, `normal` and `hit` of the rays' leading dimensions; a miss has
            t infinite and face -1.

        Raises:
            TypeError: For arrays of complex numbers, objects, strings, booleans or longdouble.
            ValueError: For shapes that do not end in 3 or cannot be broadcast.
            KeyboardInterrupt: On Ctrl-C.
        """
        shape, *rays = rays_of(origins, directions, t_min, t_max)
        t = np.empty(shape)
        face = np.empty(shape, dtype=np.int64)
        uv = np.empty((*shape, 2))
        if progress is None:
            self._native.intersect(*rays, t, face, uv)
        else:
            with reporting(progress) as report:
                self._native.intersect(*rays, t, face, uv, report)
        return Hits(self._mesh, t, face, uv)

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        progress: Progress = None,
    ) -> NDArray[np.bool_]:
        """Whether each ray hits anything, which is quicker than to find what.

        Args:
            origins: As for `intersect`.
            directions: As for `intersect`.
            t_min: As for `intersect`.
            t_max: As for `intersect`; with directions from point to point and `t_max=1`, whether
                something lies between.
            progress: As for `intersect`.

        Returns:
            The rays' leading dimensions, bool.

        Raises:
            TypeError: As `intersect`.
            ValueError: As `intersect`.
            KeyboardInterrupt: On Ctrl-C.
        """
        shape, *rays = rays_of(origins, directions, t_min, t_max)
        flags = np.empty(shape, dtype=np.bool_)
        with reporting(progress) as report:
            self._native.occluded(*rays, flags, report)
        return flags

    def count_intersections(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        progress: Progress = None,
    ) -> NDArray[np.int64]:
        """How many hits each ray has: the lengths of the rows of `intersect_all`.

        From a point inside a closed surface the number is odd, from outside it is even.

        Args:
            origins: As for `intersect`.
            directions: As for `intersect`.
            t_min: As for `intersect`.
            t_max: As for `intersect`.
            progress: As for `intersect`.

        Returns:
            The rays' leading dimensions, int64.

        Raises:
            TypeError: As `intersect`.
            ValueError: As `intersect`.
            KeyboardInterrupt: On Ctrl-C.
        """
        shape, *rays = rays_of(origins, directions, t_min, t_max)
        counts = np.empty(shape, dtype=np.int64)
        with reporting(progress) as report:
            self._native.count_intersections(*rays, counts, report)
        return counts

    def intersect_all(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        progress: Progress = None,
    ) -> AllHits:
        """All hits of each ray: every crossing, and every contact with the border of an open surface.

        A ray through an edge or a vertex of a closed surface crosses it once there, or not at all
        where it only touches it.

        Args:
            origins: As for `intersect`.
            directions: As for `intersect`.
            t_min: As for `intersect`.
            t_max: As for `intersect`.
            progress: As for `intersect`.

        Returns:
            `splits`, `t`, `face`, `uv`, `point`, `normal` and `ray`, in compressed sparse rows.

        Raises:
            TypeError: As `intersect`.
            ValueError: As `intersect`.
            MemoryError: If there are more hits than there is memory for.
            KeyboardInterrupt: On Ctrl-C.
        """
        shape, *rays = rays_of(origins, directions, t_min, t_max)
        with reporting(progress) as report:
            splits, t, face, uv = self._native.intersect_all(count_of(shape), *rays, report)
        return AllHits(self._mesh, shape, splits, t, face, uv.reshape(-1, 2))

    def info(self) -> dict[str, Any]:
        """The figures of mesh and tree, as `halfline info --json` names them.

        Returns:
            `triangles`, `vertices`, `precision`, `bounds` (two points, or None), `skipped` (triangles
            that no ray can hit), `skipped_degenerate`, `skipped_non_finite`, `preset`, `tree` (a dict,
            with `bytes` among others) and `build_seconds`.
        """
        bounds = self._mesh.bounds
        return {
            "triangles": self._mesh._native.triangle_count,
            "vertices": self._mesh._native.vertex_count,
            "precision": self._mesh._precision,
            "bounds": None if np.isnan(bounds).any() else bounds.tolist(),
            **self._native.info(),
        }

    def __copy__(self) -> Scene:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # HOOK: a scene that was opened from a tree file pickles as its path and hash here.
        return _build, (self._mesh, self._native.preset)

    def __repr__(self) -> str:
        mesh = self._mesh._native
        return (
            f"<halfline.Scene: {mesh.triangle_count:,} triangles, {self._mesh._precision}, "
            f"preset {self._native.preset!r}>"
        )

    def _repr_html_(self) -> str:
        info = self.info()
        tree = info["tree"]
        rows = [
            ("skipped", f"{info['skipped']:,} triangles that no ray can hit"),
            ("tree", f"{tree['bytes'] / 1e6:,.1f} MB, preset {info['preset']!r}"),
            ("built in", f"{info['build_seconds']:.3g} s"),
        ]
        return table("Scene", [*self._mesh._figures(), *rows])


def _build(mesh: Mesh, preset: str) -> Scene:
    """What a scene in memory pickles as."""
    return Scene(mesh, preset=preset)


def _mesh_of(mesh: Mesh | MeshLike | ArrayLike, faces: ArrayLike | None) -> Mesh:
    if faces is not None:
        return Mesh(mesh, faces)  # type: ignore[arg-type]
    if isinstance(mesh, Mesh):
        return mesh
    try:
        vertices, found = mesh.vertices, mesh.faces  # type: ignore[union-attr]
    except AttributeError:
        raise TypeError(
            "mesh: expected a halfline.Mesh, something with .vertices and .faces, or vertices and "
            f"faces, found {type(mesh).__name__}"
        ) from None
    return Mesh(vertices, found)
