"""Rays aimed at vertices and edges from inside: halfline, trimesh + embreex and Open3D.

Run by `make bench-watertight`. From inside a closed surface every ray hits, and crosses it an odd
number of times; a ray that hits nothing leaked. The same rays, in single precision, which all tools
take, go through every tool on the same mesh. Each mesh is aimed at from the first point inside that
`halfline doctor` finds, its middle if that is inside, at every vertex and every edge's middle,
and from three more points at a third of them each.

Then a sphere of radius 1 lies where maps put it, at (500000, 5400000, 100) metres, in a PLY of
double precision. The truth is computed in double precision with the sphere moved back to the
origin, which loses nothing; told is how far from it each tool's hits lie.

Everything goes to bench/out/watertight.json.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from common.harness import (
    OUT,
    ROOT,
    ToolError,
    print_table,
    processor,
    python_of,
    run,
    tool_command,
)
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]
Ints = NDArray[np.int64]
Figures = dict[str, Any]
Arrays = dict[str, NDArray[Any]]

MAP_ORIGIN = np.array([500_000.0, 5_400_000.0, 100.0])
RIVALS = ("embreex", "open3d")
TOOLS = ["halfline", *RIVALS]

# What a tool says of rays: arrays hit, crossings, point; and its name and times.
Caster = Callable[[Path, Floats], tuple[Arrays, Figures]]


@dataclass(frozen=True)
class Shape:
    """Vertices (n, 3) and triangles (m, 3)."""

    vertices: Floats
    faces: Ints

    def edges(self) -> Ints:
        """The two vertices of each edge, (e, 2)."""
        sides = np.concatenate(
            [self.faces[:, [0, 1]], self.faces[:, [1, 2]], self.faces[:, [2, 0]]]
        )
        return np.unique(np.sort(sides, axis=1), axis=0)


def icosphere(levels: int) -> Shape:
    """The icosahedron, each triangle cut into four `levels` times, blown up to the unit sphere."""
    golden = (1 + 5**0.5) / 2
    vertices = np.array([[s, t * golden, 0] for s in (-1, 1) for t in (-1, 1)], dtype=float)
    vertices = np.vstack([np.roll(vertices, axis, axis=1) for axis in range(3)])
    # Its faces are the triples at edge length 2 from each other, fronts outside.
    near = np.abs(np.linalg.norm(vertices[:, None] - vertices, axis=2) - 2) < 0.1
    triples = [
        (a, b, c)
        for a in range(12)
        for b in range(a)
        for c in range(b)
        if near[a, b] and near[b, c] and near[c, a]
    ]
    outward = [np.linalg.det(vertices[list(triple)]) > 0 for triple in triples]
    faces = np.array(
        [t if out else t[::-1] for t, out in zip(triples, outward, strict=True)], dtype=np.int64
    )
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    for _ in range(levels):
        shape = Shape(vertices, faces)
        edges = shape.edges()
        middles = vertices[edges].sum(axis=1)
        middles /= np.linalg.norm(middles, axis=1, keepdims=True)
        keys = edges[:, 0] * len(vertices) + edges[:, 1]

        def middle(a: Ints, b: Ints, keys: Ints = keys, count: int = len(vertices)) -> Ints:
            return count + np.searchsorted(keys, np.minimum(a, b) * count + np.maximum(a, b))

        a, b, c = faces.T
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = np.concatenate([np.stack(part, axis=1) for part in parts])
        vertices = np.vstack([vertices, middles])
    return Shape(vertices, faces)


def write_ply(path: Path, shape: Shape, dtype: str) -> None:
    """A binary PLY with coordinates of `dtype`, <f4 or <f8."""
    name = {"<f4": "float", "<f8": "double"}[dtype]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(shape.vertices)}"]
    lines += [f"property {name} {axis}" for axis in "xyz"]
    lines += [f"element face {len(shape.faces)}", "property list uchar int vertex_indices"]
    faces = np.empty(len(shape.faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = shape.faces
    header = "\n".join([*lines, "end_header\n"]).encode("ascii")
    path.write_bytes(header + shape.vertices.astype(dtype).tobytes() + faces.tobytes())


def read_ply(path: Path) -> Shape:
    """A binary PLY of halfline's own making: float coordinates, triangles, nothing else."""
    content = path.read_bytes()
    end = content.index(b"end_header\n") + len(b"end_header\n")
    counts = {
        line.split()[1]: int(line.split()[2])
        for line in content[:end].decode("ascii").splitlines()
        if line.startswith("element")
    }
    vertex_bytes = 12 * counts["vertex"]
    vertices = np.frombuffer(content[end : end + vertex_bytes], dtype="<f4").reshape(-1, 3)
    facets = np.frombuffer(
        content[end + vertex_bytes :], dtype=[("count", "u1"), ("corners", "<i4", 3)]
    )
    if len(facets) != counts["face"] or not (facets["count"] == 3).all():
        raise ToolError(f"{path.name} is not as halfline generates it")
    return Shape(vertices.astype(np.float64), facets["corners"].astype(np.int64))


def welded(shape: Shape) -> Shape:
    """The same with equal vertices made one."""
    vertices, index = np.unique(shape.vertices, axis=0, return_inverse=True)
    return Shape(vertices, index.reshape(-1)[shape.faces])


def halfline_caster(binary: Path, threads: int) -> Caster:
    """The command, asked for the closest hits and for all."""
    version = run([binary, "--version"], 1).stdout.split()[-1]

    def cast(mesh: Path, rays: Floats) -> tuple[Arrays, Figures]:
        rays_path, hits_path = OUT / "aimed.npy", OUT / "aimed-halfline.npz"
        np.save(rays_path, rays)
        seconds, found = {}, {}
        for question, options in {"closest": [], "all": ["--all"]}.items():
            options = [*options, "--json", "--quiet", "--threads", str(threads)]
            done = run([binary, "query", mesh, rays_path, "-o", hits_path, *options], threads)
            seconds[question] = json.loads(done.stdout)["trace_seconds"]
            with np.load(hits_path) as hits:
                found[question] = dict(hits)
        hit = found["closest"]["face"] >= 0
        exact = rays.astype(np.float64)
        point = np.full((len(rays), 3), np.nan)
        point[hit] = exact[hit, :3] + found["closest"]["t"][hit, None] * exact[hit, 3:]
        answer = {"hit": hit, "crossings": np.diff(found["all"]["splits"]), "point": point}
        return answer, {"tool": f"halfline {version}", **seconds}

    return cast


def rival_caster(key: str, threads: int) -> Caster:
    """A library, in an environment and a process of its own."""
    python = python_of(key)

    def cast(mesh: Path, rays: Floats) -> tuple[Arrays, Figures]:
        rays_path, hits_path = OUT / "aimed.npy", OUT / f"aimed-{key}.npz"
        np.save(rays_path, rays)
        done = run(tool_command(python, f"watertight.{key}", mesh, rays_path, hits_path), threads)
        with np.load(hits_path) as hits:
            return dict(hits), json.loads(done.stdout.splitlines()[-1])

    return cast


def aimed_rays(shape: Shape, origins: Floats) -> dict[str, Floats]:
    """For each kind of target, and for the first origin and the others, rays in single precision.

    A direction is the target less the origin in double precision, rounded once.
    """
    targets = {
        "vertices": shape.vertices,
        "edge midpoints": shape.vertices[shape.edges()].mean(axis=1),
    }
    cases = {}
    for kind, points in targets.items():
        parts = [
            np.hstack([np.broadcast_to(origin, aimed.shape), aimed - origin])
            for number, origin in enumerate(origins)
            for aimed in [points if number == 0 else points[number - 1 :: len(origins) - 1]]
        ]
        cases[f"{kind}, first origin"] = parts[0].astype(np.float32)
        if len(parts) > 1:
            cases[f"{kind}, {len(parts) - 1} others"] = np.vstack(parts[1:]).astype(np.float32)
    return cases


def count_leaks(name: str, path: Path, shape: Shape, binary: Path, tools: dict[str, Caster]) -> Any:
    """Casts the aimed rays of one mesh with all tools, and prints the table."""
    done = run([binary, "doctor", path, "--rays", "1000", "--json", "--quiet"], 1)
    doctor = json.loads(done.stdout)
    if not (doctor["closed"] and doctor["from_inside"]):
        raise ToolError(f"{name} has no inside: {doctor['verdict']}")
    cases = aimed_rays(welded(shape), np.array(doctor["origins"]))

    names: dict[str, str] = {}
    results: dict[str, dict[str, Figures]] = {}
    for case, rays in cases.items():
        results[case] = {}
        for key, cast in tools.items():
            hits, figures = cast(path, rays)
            names[key] = figures["tool"]
            results[case][key] = {
                "rays": len(rays),
                "leaks": int((~hits["hit"]).sum()),
                "even": int((hits["crossings"] % 2 == 0).sum()),
                "closest_seconds": figures["closest"],
                "all_seconds": figures["all"],
            }
    rows = [
        ["aimed at", "rays", *(f"{key}: {what}" for key in tools for what in ("leaks", "even"))]
    ]
    for case, found in results.items():
        row = [case, f"{len(cases[case]):,}"]
        row += [f"{found[key][what]:,}" for key in tools for what in ("leaks", "even")]
        rows.append(row)
    size = f"{len(shape.faces):,} triangles, {len(shape.vertices):,} vertices"
    print_table(f"{name}, {size}, closed; from {doctor['origins'][0]} and others inside", rows)
    return {"origins": doctor["origins"], "tools": names, "cases": results}


def closest_points(shape: Shape, rays: Floats) -> Floats:
    """Where rays hit first, by every ray against every triangle in double precision.

    T. Moller, B. Trumbore 1997. A ray that passes within rounding of an edge may be judged to miss
    both triangles, and is NaN like one that misses.
    """
    corners = shape.vertices[shape.faces]
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    points = np.full((len(rays), 3), np.nan)
    for i, ray in enumerate(rays):
        origin, direction = ray[:3], ray[3:]
        p = np.cross(direction, ac)
        determinant = np.einsum("ij,ij->i", ab, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("ij,ij->i", origin - a, p) / determinant
            q = np.cross(origin - a, ab)
            v = q @ direction / determinant
            t = np.einsum("ij,ij->i", ac, q) / determinant
        t = t[(u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0)]
        if len(t):
            points[i] = origin + t.min() * direction
    return points


def map_rays(count: int) -> Floats:
    """Rays from 8 m away at points of the unit ball, exact in single precision on the map too."""
    random = np.random.default_rng(0)
    away = random.normal(size=(count, 3))
    away *= 8.0 / np.linalg.norm(away, axis=1, keepdims=True)
    # Single precision has steps of half a metre at 5,400,000.
    origins = np.round(away * 2.0) / 2.0
    targets = random.uniform(-0.5, 0.5, size=(count, 3))
    return np.hstack([origins, (targets - origins).astype(np.float32).astype(np.float64)])


def measure_map_errors(tools: dict[str, Caster], count: int) -> Any:
    """How far hits lie from the truth on a sphere in map coordinates."""
    local = icosphere(4)
    moved = Shape(local.vertices + MAP_ORIGIN, local.faces)
    path = OUT / "aimed-map.ply"
    write_ply(path, moved, "<f8")
    rays = map_rays(count)
    # The sum was rounded, the difference is not: the numbers are within a factor of two of each
    # other, or (z) have few enough bits before the point.
    truth = closest_points(Shape(moved.vertices - MAP_ORIGIN, local.faces), rays)
    sure = np.isfinite(truth).all(axis=1)
    rays_on_map = rays + np.concatenate([MAP_ORIGIN, np.zeros(3)])

    results = {}
    rows = [["tool", "rays", "missed", "median error", "99 %", "largest error"]]
    for key, cast in tools.items():
        hits, figures = cast(path, rays_on_map)
        errors = np.linalg.norm(hits["point"] - MAP_ORIGIN - truth, axis=1)[sure & hits["hit"]]
        missed = int((sure & ~hits["hit"]).sum())
        middle, high, most = (float(np.quantile(errors, q)) for q in (0.5, 0.99, 1.0))
        results[key] = {
            "tool": figures["tool"],
            "rays": int(sure.sum()),
            "missed": missed,
            "median_error": middle,
            "error_of_99_percent": high,
            "largest_error": most,
        }
        rows.append(
            [key, f"{sure.sum():,}", str(missed), *(f"{e:.2g} m" for e in (middle, high, most))]
        )
    print_table(f"A sphere 2 m wide at {MAP_ORIGIN.tolist()}: how far off hits are", rows)
    return results


def main() -> int:
    """Prepares meshes and tools, casts, prints, and writes bench/out/watertight.json."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--halfline", type=Path, required=True, help="the built command")
    parser.add_argument(
        "--tool", choices=TOOLS, action="append", help="only this one; may be given several times"
    )
    parser.add_argument("--threads", type=int, default=1, help="threads for halfline and Open3D")
    parser.add_argument("--levels", type=int, default=7, help="subdivisions of the sphere")
    parser.add_argument("--triangles", type=int, default=100_000, help="of the other meshes")
    parser.add_argument("--map-rays", type=int, default=5000, help="rays at the map's sphere")
    options = parser.parse_args()

    binary = options.halfline.resolve()
    tools: dict[str, Caster] = {}
    left_out = {}
    for key in options.tool or TOOLS:
        try:
            if key == "halfline":
                tools[key] = halfline_caster(binary, options.threads)
            else:
                tools[key] = rival_caster(key, options.threads)
        except ToolError as error:  # noqa: PERF203
            left_out[key] = str(error)
            print(f"{key} is left out: {error}")

    OUT.mkdir(exist_ok=True)
    meshes = {"sphere": OUT / "aimed-sphere.ply"}
    sphere = icosphere(options.levels)
    write_ply(meshes["sphere"], sphere, "<f4")
    for kind in ("scan", "tetra"):
        meshes[kind] = OUT / f"aimed-{kind}.ply"
        run([binary, "generate", kind, "-n", str(options.triangles), "-o", meshes[kind]], 1)
    results = {
        name: count_leaks(name, path, read_ply(path), binary, tools)
        for name, path in meshes.items()
    }
    maps = measure_map_errors(tools, options.map_rays)

    answer = {
        "processor": processor(),
        "threads": options.threads,
        "left_out": left_out,
        "meshes": results,
        "map_coordinates": maps,
    }
    output = OUT / "watertight.json"
    output.write_text(json.dumps(answer, indent=1) + "\n", encoding="utf-8")
    print(f"\nEverything counted is in {output.relative_to(ROOT)}")
    return 0
