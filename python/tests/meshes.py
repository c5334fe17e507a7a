"""Meshes made with NumPy, and writers of their own: nothing here is shared with halfline."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Shape:
    """Vertices (n, 3) and triangles (m, 3)."""

    vertices: Floats
    faces: Ints

    def corners(self) -> Floats:
        """The corners of every triangle, (m, 3, 3)."""
        return self.vertices[self.faces]


def bumpy_sphere(rows: int = 24, columns: int = 48) -> Shape:
    """A closed sphere whose radius wavers, so that rays meet it up to many times.

    The coordinates are rounded to single precision: files of either precision hold them exactly.
    """
    polar = np.linspace(0.0, np.pi, rows + 1)[1:-1]
    azimuth = np.arange(columns) * (2.0 * np.pi / columns)
    theta, phi = np.meshgrid(polar, azimuth, indexing="ij")
    radius = 1.0 + 0.3 * np.sin(5.0 * theta) * np.cos(7.0 * phi)
    ring = np.stack(
        [
            radius * np.sin(theta) * np.cos(phi),
            radius * np.sin(theta) * np.sin(phi),
            radius * np.cos(theta),
        ],
        axis=-1,
    ).reshape(-1, 3)
    vertices = np.vstack([ring, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    vertices = vertices.astype(np.float32).astype(np.float64)
    north, south = len(ring), len(ring) + 1

    faces: list[tuple[int, int, int]] = []
    for column in range(columns):
        beside = (column + 1) % columns
        faces.append((north, column, beside))
        last = (rows - 2) * columns
        faces.append((south, last + beside, last + column))
        for row in range(rows - 2):
            a, b = row * columns + column, row * columns + beside
            c, d = a + columns, b + columns
            faces += [(a, c, b), (b, c, d)]
    return Shape(vertices, np.array(faces, dtype=np.int64))


def gridded_cube(cells: int) -> Shape:
    """The closed surface of the cube [0, cells]^3, with a vertex at every whole coordinate.

    Each unit square is cut along one diagonal or the other, as on a chessboard.
    """
    corners: dict[tuple[int, ...], int] = {}
    faces = []
    for axis in range(3):
        for side in (0, cells):
            for x, y in np.ndindex(cells, cells):
                square = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
                points = [tuple(np.roll([side, *p], axis).tolist()) for p in square]
                a, b, c, d = (corners.setdefault(p, len(corners)) for p in points)
                faces += [(a, b, c), (a, c, d)] if (x + y) % 2 else [(a, b, d), (b, c, d)]
    return Shape(np.array(list(corners), dtype=float), np.array(faces, dtype=np.int64))


def random_rays(count: int, seed: int) -> Floats:
    """Rays from the shell around the unit ball to points within it: (n, 6), directions unscaled."""
    random = np.random.default_rng(seed)
    away = random.normal(size=(count, 3))
    origins = 3.0 * away / np.linalg.norm(away, axis=1, keepdims=True)
    targets = random.uniform(-1.0, 1.0, size=(count, 3))
    return np.hstack([origins, targets - origins])


def write_ply(path: Path, shape: Shape, dtype: str = "<f4") -> Path:
    """A binary little-endian PLY with coordinates of `dtype`, <f4 or <f8."""
    name = {"<f4": "float", "<f8": "double"}[dtype]
    header = "\n".join(
        [
            "ply",
            "format binary_little_endian 1.0",
            f"element vertex {len(shape.vertices)}",
            *[f"property {name} {axis}" for axis in "xyz"],
            f"element face {len(shape.faces)}",
            "property list uchar int vertex_indices",
            "end_header\n",
        ]
    )
    faces = np.empty(len(shape.faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = shape.faces
    path.write_bytes(header.encode() + shape.vertices.astype(dtype).tobytes() + faces.tobytes())
    return path


def write_stl(path: Path, shape: Shape) -> Path:
    """A binary STL."""
    facets = np.zeros(
        len(shape.faces), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("bytes", "<u2")]
    )
    facets["corners"] = shape.corners()
    path.write_bytes(b"\0" * 80 + np.uint32(len(facets)).tobytes() + facets.tobytes())
    return path


def write_obj(path: Path, shape: Shape) -> Path:
    """An OBJ, counting from one."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in shape.vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (shape.faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def write_off(path: Path, shape: Shape) -> Path:
    """An OFF."""
    lines = ["OFF", f"{len(shape.vertices)} {len(shape.faces)} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in shape.vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in shape.faces.tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
