"""What rays hit: answers as arrays."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfline._arrays import vectors_of
from halfline._html import table

if TYPE_CHECKING:
    from halfline._mesh import Mesh


class _Surface(NamedTuple):
    """Where hits are on the mesh."""

    point: NDArray[np.float64]
    normal: NDArray[np.float64]


def surface_of(mesh: Mesh, face: NDArray[np.int64], uv: NDArray[np.float64]) -> _Surface:
    """Where places on a mesh are, and the normals there; NaN for no face."""
    points = np.empty((*face.shape, 3))
    normals = np.empty((*face.shape, 3))
    face = np.ascontiguousarray(face, dtype=np.int64)
    mesh._native.surface(face, np.ascontiguousarray(uv, dtype=np.float64), points, normals)
    return _Surface(points, normals)


class Hits:
    """The closest hit of each ray, with the leading dimensions of the rays.

    A ray that hits nothing has `t` infinite, `face` -1, `uv` zero, and NaN for `point` and
    `normal`.

    Indexing works on the leading dimensions: `hits[3]`, `hits[hits.hit]`, `hits[..., 0]`.
    `len(hits)` and iteration are those of the first of them, as of an array.

    Attributes:
        t: Ray parameters in units of the rays' directions, shape (...), float64: the double that is
            nearest to the exact one.
        face: Indices into the mesh's faces, shape (...), int64.
        uv: Barycentric weights of the second and third vertex of the face, shape (..., 2), float64;
            the first has 1 - u - v.
    """

    __slots__ = ("_at", "_mesh", "face", "t", "uv")

    def __init__(
        self,
        mesh: Mesh,
        t: NDArray[np.float64],
        face: NDArray[np.int64],
        uv: NDArray[np.float64],
    ) -> None:
        self.t = t
        self.face = face
        self.uv = uv
        self._mesh = mesh
        self._at: _Surface | None = None

    @property
    def mesh(self) -> Mesh:
        """The mesh that was hit."""
        return self._mesh

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading dimensions of the rays."""
        return self.t.shape

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Whether each ray hits anything, shape (...), bool."""
        return np.asarray(self.face >= 0)

    @property
    def point(self) -> NDArray[np.float64]:
        """Where the hits are, in the mesh's coordinates, shape (..., 3), float64; NaN for misses.

        Computed from the face and `uv` when first asked for, so it is as near to the face far from
        the origin of the ray as near to it.
        """
        return self._surface().point

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normals of the faces that were hit, shape (..., 3), float64; NaN for misses.

        They point to where the face's vertices run counter-clockwise, whichever way the ray came.
        Computed when first asked for.
        """
        return self._surface().normal

    def origins_towards(self, directions: ArrayLike) -> NDArray[np.float64]:
        """Where rays along `directions` may start that leave the surface at the hits.

        Each is so little off the hit, on the side to which its ray goes, that the ray does not hit
        the same face again; no margin is to be chosen. docs/numerics.md derives how little, after
        Pharr, Jakob and Humphreys, "Physically Based Rendering", section 6.8.6.

        Args:
            directions: Shape (..., 3), broadcast to the hits.

        Returns:
            The hits' leading dimensions and 3, float64; NaN for misses.

        Raises:
            TypeError: For other dtypes.
            ValueError: For a shape that does not broadcast to the hits.
        """
        spread = vectors_of("directions", directions, self.shape)
        origins = np.empty(spread.shape)
        face = np.ascontiguousarray(self.face, dtype=np.int64)
        uv = np.ascontiguousarray(self.uv, dtype=np.float64)
        self._mesh._native.origins_towards(face, uv, spread, origins)
        return origins

    def _surface(self) -> _Surface:
        if self._at is None:
            self._at = surface_of(self._mesh, self.face, self.uv)
        return self._at

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("the hit of a single ray has no length")
        return self.shape[0]

    def __bool__(self) -> bool:
        if self.shape:
            raise ValueError("hits are neither true nor false: ask for .hit.any() or .hit.all()")
        return bool(self.face >= 0)

    def __getitem__(self, index: Any) -> Hits:
        within = (*index, slice(None)) if isinstance(index, tuple) else (index, slice(None))
        t, face = np.asarray(self.t[index]), np.asarray(self.face[index])
        return Hits(self._mesh, t, face, np.asarray(self.uv[within]))

    def __iter__(self) -> Iterator[Hits]:
        return (self[index] for index in range(len(self)))

    def __reduce__(self) -> tuple[type[Hits], tuple[Any, ...]]:
        return Hits, (self._mesh, self.t, self.face, self.uv)

    def __repr__(self) -> str:
        if not self.shape:
            if self.face < 0:
                return "<halfline.Hits: a miss>"
            (x, y, z), (u, v) = self.point.tolist(), self.uv.tolist()
            return (
                f"<halfline.Hits: face {int(self.face)} at t={float(self.t):.6g}, "
                f"uv=({u:.6g}, {v:.6g}), point=({x:.6g}, {y:.6g}, {z:.6g})>"
            )
        figures = [f"{figure} {name}" for name, figure in self._figures()]
        return f"<halfline.Hits of shape {self.shape}: {', '.join(figures)}>"

    def _figures(self) -> list[tuple[str, str]]:
        hit = np.count_nonzero(self.face >= 0)
        figures = [("rays", f"{self.t.size:,}"), ("hit", f"{hit:,}")]
        if hit:
            t = self.t[self.hit]
            figures.append(("as t", f"{t.min():.6g} to {t.max():.6g}"))
        return figures

    def _repr_html_(self) -> str:
        return table("Hits", [("shape", str(self.shape)), *self._figures()])


class AllHits:
    """All hits of each ray, in compressed sparse rows.

    The hits of ray i are `splits[i]:splits[i + 1]` of the other arrays, sorted by `t` and then by
    `face`; a ray that hits nothing has none. For rays with several leading dimensions, which are
    `all_hits.shape`, `splits` counts through the rays in C order.

    Indexing, `len` and iteration are those of an array of rays: `all_hits[i]` gives the hits of
    one ray as `Hits`, `all_hits[2:5]` and `all_hits[mask]` those of some as `AllHits`. The number
    of all hits is `len(all_hits.t)`.

    Attributes:
        splits: Where the hits of each ray begin, and the number of all at the end, shape (n + 1,)
            for n rays, int64.
        t: Ray parameters in units of the rays' directions, shape (m,), float64.
        face: Indices into the mesh's faces, shape (m,), int64.
        uv: Barycentric weights of the second and third vertex of the face, shape (m, 2), float64.

    Examples:
        >>> import halfline
        >>> scene = halfline.Scene(halfline.generate("sphere", 1280))
        >>> hits = scene.intersect_all([[0, 0, 3], [0, 9, 3], [0, 0, 0]], [0, 0, -1])
        >>> hits.t
        array([2., 4., 1.])
        >>> hits.splits
        array([0, 2, 2, 3])
        >>> hits[0].t
        array([2., 4.])
    """

    __slots__ = ("_at", "_mesh", "_ray", "face", "shape", "splits", "t", "uv")

    def __init__(
        self,
        mesh: Mesh,
        shape: tuple[int, ...],
        splits: NDArray[np.int64],
        t: NDArray[np.float64],
        face: NDArray[np.int64],
        uv: NDArray[np.float64],
    ) -> None:
        self.shape = shape
        self.splits = splits
        self.t = t
        self.face = face
        self.uv = uv
        self._mesh = mesh
        self._at: _Surface | None = None
        self._ray: NDArray[np.int64] | None = None

    @property
    def mesh(self) -> Mesh:
        """The mesh that was hit."""
        return self._mesh

    @property
    def ray(self) -> NDArray[np.int64]:
        """The index of the ray of each hit, shape (m,), int64: rays count in C order.

        Computed when first asked for.
        """
        if self._ray is None:
            counts = np.diff(self.splits)
            self._ray = np.repeat(np.arange(len(counts), dtype=np.int64), counts)
        return self._ray

    @property
    def count(self) -> NDArray[np.int64]:
        """How many hits each ray has, shape (...), int64."""
        return np.diff(self.splits).reshape(self.shape)

    @property
    def point(self) -> NDArray[np.float64]:
        """Where the hits are, in the mesh's coordinates, shape (m, 3), float64.

        Computed when first asked for.
        """
        return self._surface().point

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normals of the faces that were hit, shape (m, 3), float64.

        They point to where the face's vertices run counter-clockwise, whichever way the ray came.
        Computed when first asked for.
        """
        return self._surface().normal

    def _surface(self) -> _Surface:
        if self._at is None:
            self._at = surface_of(self._mesh, self.face, self.uv)
        return self._at

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("the hits of a single ray have no length: ask for .count or .t")
        return self.shape[0]

    def __bool__(self) -> bool:
        raise ValueError("hits are neither true nor false: ask for .count.any() or .count.all()")

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, int) and len(self.shape) == 1:
            if not -self.shape[0] <= index < self.shape[0]:
                raise IndexError(f"ray {index} is out of range for {self.shape[0]} rays")
            return self._of_ray(index % self.shape[0])
        rays = np.asarray(np.arange(len(self.splits) - 1).reshape(self.shape)[index])
        if rays.ndim == 0:
            return self._of_ray(int(rays))
        first = self.splits[rays.ravel()]
        counts = self.splits[rays.ravel() + 1] - first
        splits = np.concatenate([[0], np.cumsum(counts)])
        rows = np.arange(splits[-1]) + np.repeat(first - splits[:-1], counts)
        return AllHits(self._mesh, rays.shape, splits, self.t[rows], self.face[rows], self.uv[rows])

    def _of_ray(self, ray: int) -> Hits:
        row = slice(int(self.splits[ray]), int(self.splits[ray + 1]))
        return Hits(self._mesh, self.t[row], self.face[row], self.uv[row])

    def __iter__(self) -> Iterator[Any]:
        if len(self.shape) == 1:
            return (self._of_ray(ray) for ray in range(self.shape[0]))
        return (self[index] for index in range(len(self)))

    def __reduce__(self) -> tuple[type[AllHits], tuple[Any, ...]]:
        return AllHits, (self._mesh, self.shape, self.splits, self.t, self.face, self.uv)

    def __repr__(self) -> str:
        figures = [f"{figure} {name}" for name, figure in self._figures()]
        return f"<halfline.AllHits of rays of shape {self.shape}: {', '.join(figures)}>"

    def _figures(self) -> list[tuple[str, str]]:
        counts = np.diff(self.splits)
        return [
            ("rays", f"{len(counts):,}"),
            ("hits", f"{len(self.t):,}"),
            ("on one ray at most", f"{counts.max(initial=0):,}"),
        ]

    def _repr_html_(self) -> str:
        return table("AllHits", [("shape of the rays", str(self.shape)), *self._figures()])
