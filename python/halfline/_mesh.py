"""Meshes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfline._arrays import FloatArray, faces_of, natural, path_of, vertices_of
from halfline._html import table
from halfline._native import Mesh as NativeMesh
from halfline._progress import Progress, reporting

if TYPE_CHECKING:
    from halfline._native import _Extras


class MeshLike(Protocol):
    """Anything with vertices and faces, such as trimesh's `Trimesh`."""

    @property
    def vertices(self) -> Any:
        """Shape (n, 3)."""

    @property
    def faces(self) -> Any:
        """Shape (m, 3)."""


Path: TypeAlias = str | bytes | os.PathLike[str] | os.PathLike[bytes]


class Mesh:
    """Vertices and triangles, which never change.

    The arrays given are copied once; coordinates keep their precision, and faces their order: the
    face index of every hit is a row of `faces`.

    Args:
        vertices: Coordinates, shape (n, 3), float32 or float64. Integers and float16 are converted.
            A vertex may be infinite or NaN; its faces are never hit.
        faces: Indices of vertices, shape (m, 3), any integers.

    Raises:
        TypeError: For other dtypes.
        ValueError: For other shapes, and for an index that has no vertex.
    """

    __slots__ = ("__weakref__", "_bounds", "_faces", "_native", "_vertices")

    _native: NativeMesh
    _vertices: FloatArray | None
    _faces: NDArray[np.uint32] | None
    _bounds: NDArray[np.float64] | None

    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        self._hold(NativeMesh.from_arrays(vertices_of(vertices), faces_of(faces)))

    @classmethod
    def _of(cls, native: NativeMesh) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._hold(native)
        return mesh

    def _hold(self, native: NativeMesh) -> None:
        self._native = native
        self._vertices = self._faces = self._bounds = None

    @property
    def vertices(self) -> FloatArray:
        """Coordinates, shape (n, 3), float32 or float64: a read-only view that keeps the mesh."""
        if self._vertices is None:
            self._vertices = np.asarray(self._native.vertices)
        return self._vertices

    @property
    def faces(self) -> NDArray[np.uint32]:
        """Indices of vertices, shape (m, 3), uint32: a read-only view that keeps the mesh."""
        if self._faces is None:
            self._faces = np.asarray(self._native.faces)
        return self._faces

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Least and largest coordinates, shape (2, 3), float64.

        Of all finite vertices that a face uses; NaN if there are none. Read-only.
        """
        if self._bounds is None:
            found = self._native.bounds()
            bounds = np.full((2, 3), np.nan) if found is None else np.array(found)
            bounds.flags.writeable = False
            self._bounds = bounds
        return self._bounds

    def save(self, path: Path, *, progress: Progress = None) -> None:
        """Writes the mesh as binary PLY, with its colours of vertices.

        The file appears whole or not at all.

        Args:
            path: Where to; the name ends in .ply.
            progress: As for `load`, with the stage "write".

        Raises:
            ValueError: For a name that does not end in .ply.
            OSError: If the file cannot be written.
            KeyboardInterrupt: On Ctrl-C.
        """
        name = path_of("path", path)
        if not name.lower().endswith(".ply"):
            raise ValueError(f"path: expected a name that ends in .ply, found {name!r}")
        with reporting(progress) as report:
            self._native.save(name, report)

    def __copy__(self) -> Mesh:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Mesh:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickle, (self.vertices, self.faces, self._native.extras())

    def __repr__(self) -> str:
        native = self._native
        return (
            f"<halfline.Mesh: {native.triangle_count:,} triangles, "
            f"{native.vertex_count:,} vertices, {self._precision}>"
        )

    @property
    def _precision(self) -> str:
        return "float32" if self._native.is_single_precision else "float64"

    def _figures(self) -> list[tuple[str, str]]:
        least, largest = self.bounds.tolist()
        spans = zip("xyz", least, largest, strict=True)
        return [
            ("triangles", f"{self._native.triangle_count:,}"),
            ("vertices", f"{self._native.vertex_count:,}, {self._precision}"),
            *((f"{axis}", f"{low:.6g} to {high:.6g}") for axis, low, high in spans),
        ]

    def _repr_html_(self) -> str:
        return table("Mesh", self._figures())


def _unpickle(vertices: FloatArray, faces: NDArray[np.uint32], extras: _Extras) -> Mesh:
    """The mesh that these were taken from, with what its file said about it."""
    bare = NativeMesh.from_arrays(vertices_of(vertices), faces_of(faces))
    *arrays, materials = extras
    is_bare = not materials and all(array is None for array in arrays)
    return Mesh._of(bare if is_bare else bare.with_extras(extras))


def mesh_of(mesh: Mesh | MeshLike | ArrayLike, faces: ArrayLike | None) -> Mesh:
    """The mesh that a scene is asked to be of.

    Raises:
        TypeError: For what is none.
    """
    if faces is not None:
        if hasattr(mesh, "vertices"):
            raise TypeError("faces: expected none beside a mesh, which has its own")
        return Mesh(mesh, faces)
    if isinstance(mesh, Mesh):
        return mesh
    if isinstance(mesh, str | os.PathLike):
        raise TypeError(
            "mesh: expected a mesh, found a path: halfline.load reads meshes, halfline.open trees"
        )
    try:
        vertices, found = mesh.vertices, mesh.faces  # type: ignore[union-attr]
    except AttributeError:
        raise TypeError(
            "mesh: expected a halfline.Mesh, something with .vertices and .faces, or vertices and "
            f"faces, found {type(mesh).__name__}"
        ) from None
    return Mesh(vertices, found)


def load(path: Path, *, progress: Progress = None) -> Mesh:
    """Reads a mesh from a PLY, STL, OBJ, OFF, glTF or GLB file, each also gzipped.

    The format is known by the content, or else by the extension. Polygons are cut into triangles,
    and the vertices of STL files are welded where they are equal.

    Args:
        path: The file, which must be a regular one: a pipe or a device is refused.
        progress: True for a bar (of tqdm, where it is installed), or a callable
            `progress(stage, done, total)` with the stage "load" and bytes of the file.

    Returns:
        The mesh, with coordinates in the file's precision.

    Raises:
        FormatError: If the file is not what it should be; a ValueError.
        OSError: If the file cannot be read, in the subclass that says why, or is no regular file.
        KeyboardInterrupt: On Ctrl-C.
    """
    with reporting(progress) as report:
        return Mesh._of(NativeMesh.load(path_of("path", path), report))


def generate(kind: str, triangles: int, seed: int = 0, *, progress: Progress = None) -> Mesh:
    """Makes a mesh to try things on, the same for the same arguments on every machine.

    Args:
        kind: "scan", "sphere", "soup", "layers", "sticks", "terrain" or "hall"; or one of Haines's
            Standard Procedural Databases (1987): "balls", "gears", "mount", "rings", "teapot",
            "tetra", "tree". `halfline generate --help` says what they are. z points up.
        triangles: How many triangles it should have; some kinds only come near.
        seed: Another seed gives another mesh, for scan, soup, sticks, terrain, hall and mount;
            from 0 to 2^64 - 1.
        progress: True for a bar, or a callable `progress(stage, done, total)` with the stage "load"
            and triangles.

    Returns:
        The mesh, with coordinates in float32.

    Raises:
        ValueError: For an unknown kind, and for numbers out of range.
        KeyboardInterrupt: On Ctrl-C.
    """
    count = natural("triangles", triangles)
    number = natural("seed", seed)
    with reporting(progress) as report:
        return Mesh._of(NativeMesh.generate(kind, count, number, report))
