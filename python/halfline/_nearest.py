"""What is nearest to points: answers as arrays."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfline._hits import surface_of
from halfline._html import table

if TYPE_CHECKING:
    from halfline._mesh import Mesh

FEATURES = ("face", "edge", "vertex")
"""By their codes."""

WORDS = np.array([*FEATURES, ""])


class Nearest:
    """The point of a mesh that is nearest to each of some points, with their leading dimensions.

    Where nothing is within `max_distance`, `distance` is infinite, `face` -1, `point`, `uv` and
    `normal` NaN, and `feature` empty.

    Indexing works on the leading dimensions: `near[3]`, `near[near.found]`, `near[..., 0]`.
    `len(near)` and iteration are those of the first of them, as of an array.

    Attributes:
        distance: How far the nearest point is, shape (...), float64; 0 on the surface.
        point: The nearest point, shape (..., 3), float64.
        face: The face that it belongs to, the one with the lowest index of several, shape (...),
            int64.
        uv: Barycentric weights of the second and third vertex of the face, shape (..., 2), float64;
            the first has 1 - u - v.
    """

    __slots__ = ("_code", "_mesh", "_normal", "distance", "face", "point", "uv")

    def __init__(
        self,
        mesh: Mesh,
        distance: NDArray[np.float64],
        point: NDArray[np.float64],
        face: NDArray[np.int64],
        uv: NDArray[np.float64],
        code: NDArray[np.uint8],
    ) -> None:
        self.distance = distance
        self.point = point
        self.face = face
        self.uv = uv
        self._mesh = mesh
        self._code = code
        self._normal: NDArray[np.float64] | None = None

    @property
    def mesh(self) -> Mesh:
        """The mesh that is near."""
        return self._mesh

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading dimensions of the points."""
        return self.distance.shape

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether anything is within `max_distance`, shape (...), bool."""
        return np.asarray(self.face >= 0)

    @property
    def feature(self) -> NDArray[np.str_]:
        """What of the face is nearest: "face" for its inside, "edge" or "vertex", shape (...)."""
        return words_of(self.face, self._code)

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normals of the nearest faces, shape (..., 3), float64.

        They point to where the face's vertices run counter-clockwise. At an edge or a vertex it is
        that of the face with the lowest index of those that meet there. Computed when first asked
        for.
        """
        if self._normal is None:
            self._normal = surface_of(self._mesh, self.face, self.uv).normal
        return self._normal

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("the nearest point of a single point has no length")
        return self.shape[0]

    def __bool__(self) -> bool:
        if self.shape:
            raise ValueError(
                "what is near is neither true nor false: ask for .found.any() or .all()"
            )
        return bool(self.face >= 0)

    def __getitem__(self, index: Any) -> Nearest:
        within = (*index, slice(None)) if isinstance(index, tuple) else (index, slice(None))
        return Nearest(
            self._mesh,
            np.asarray(self.distance[index]),
            np.asarray(self.point[within]),
            np.asarray(self.face[index]),
            np.asarray(self.uv[within]),
            np.asarray(self._code[index]),
        )

    def __iter__(self) -> Iterator[Nearest]:
        return (self[index] for index in range(len(self)))

    def __reduce__(self) -> tuple[type[Nearest], tuple[Any, ...]]:
        parts = (self.distance, self.point, self.face, self.uv, self._code)
        return Nearest, (self._mesh, *parts)

    def __repr__(self) -> str:
        if not self.shape:
            if self.face < 0:
                return "<halfline.Nearest: nothing>"
            x, y, z = self.point.tolist()
            return (
                f"<halfline.Nearest: face {int(self.face)} at distance "
                f"{float(self.distance):.6g}, point=({x:.6g}, {y:.6g}, {z:.6g}), "
                f"in its {FEATURES[int(self._code)] if self._code else 'inside'}>"
            )
        figures = [f"{figure} {name}" for name, figure in self._figures()]
        return f"<halfline.Nearest of shape {self.shape}: {', '.join(figures)}>"

    def _figures(self) -> list[tuple[str, str]]:
        found = np.count_nonzero(self.face >= 0)
        figures = [("points", f"{self.distance.size:,}"), ("found", f"{found:,}")]
        if found:
            distance = self.distance[self.found]
            figures.append(("as distance", f"{distance.min():.6g} to {distance.max():.6g}"))
        return figures

    def _repr_html_(self) -> str:
        return table("Nearest", [("shape", str(self.shape)), *self._figures()])


def words_of(face: NDArray[np.int64], code: NDArray[np.uint8]) -> NDArray[np.str_]:
    """The features of faces by their codes; empty for no face."""
    return np.asarray(WORDS[np.where(face < 0, len(FEATURES), code)], dtype=WORDS.dtype)
