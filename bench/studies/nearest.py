"""Closest points, winding numbers and containment against Open3D, trimesh, libigl and FCPW.

Run by `make bench-nearest`. Every measurement is a process of its own, on as many cores as threads,
and the tools take turns; medians are printed, and everything measured goes to
bench/out/nearest.json. All get the same vertices, faces and points, which are rounded to single
precision, so that nobody has to round them. Points lie near to the surface (within the mean length
of an edge), 5 % of the scene's size off it, anywhere in its box, and on a regular grid there; and
at the centre of a sphere, where every face is about as near. An answer counts as wrong where it
differs from halfline's, which is exact, by more than 1e-5 of the scene's size in distance, by 1e-3
in winding number, or in containment.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from pathlib import Path
from statistics import median
from typing import Any

import halfline
import numpy as np
from common.harness import (
    DRAGON,
    OUT,
    ROOT,
    ToolError,
    apart,
    make_environment,
    print_table,
    processor,
    run,
    tool_command,
)
from numpy.typing import NDArray

SCAN_TRIANGLES = 5_200_000
POINTS = 200_000
OFF = 0.05
# Faces that are taken away from the open mesh: some 10,000 edges are open then.
HOLES = 3400

SPHERE_TRIANGLES = 1_310_720

MESHES = ("dragon", "scan", "open dragon", "sphere")
# By environment: in one with Open3D nothing else has to agree with what it needs.
RIVALS = {
    "Open3D": ("open3d", "open3d"),
    "trimesh": ("embreex", "trimesh"),
    "libigl": ("nearest", "libigl"),
    "FCPW": ("nearest", "fcpw"),
}

TOLERANCE = {"distance": 1e-5, "winding": 1e-3, "approximate winding": 1e-3, "contains": 0.5}

Figures = dict[str, Any]
Array = NDArray[np.float64]


def mesh_of(name: str) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Vertices and faces."""
    if name in ("scan", "sphere"):
        count = SCAN_TRIANGLES if name == "scan" else SPHERE_TRIANGLES
        mesh = halfline.generate(name, count)
    else:
        mesh = halfline.load(DRAGON)
    vertices, faces = mesh.vertices.astype(np.float32), mesh.faces.astype(np.int64)
    if name == "open dragon":
        holes = np.random.default_rng(1).choice(len(faces), HOLES, replace=False)
        faces = np.delete(faces, holes, axis=0)
    return vertices, faces


def points_of(vertices: NDArray[np.float32], faces: NDArray[np.int64]) -> dict[str, Array]:
    """Points of all kinds."""
    random = np.random.default_rng(0)
    corners = vertices.astype(np.float64)[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    chosen = random.choice(len(faces), POINTS, p=areas / areas.sum())
    weights = random.dirichlet((1, 1, 1), POINTS)
    surface = np.einsum("nk,nkd->nd", weights, corners[chosen])
    normal = normals[chosen] / areas[chosen, None]
    low, high = corners.min((0, 1)), corners.max((0, 1))
    size = float(np.linalg.norm(high - low))
    edge = float(np.linalg.norm(corners[chosen, 1] - corners[chosen, 0], axis=1).mean())
    side = round(POINTS ** (1 / 3))
    lines = (np.linspace(low[axis], high[axis], side) for axis in range(3))
    kinds = {
        "near": surface + normal * random.uniform(-edge, edge, (POINTS, 1)),
        "off": surface + normal * random.choice((-OFF, OFF), (POINTS, 1)) * size,
        "box": random.uniform(low, high, (POINTS, 3)),
        "grid": np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3),
    }
    return {kind: np.float64(np.float32(points)) for kind, points in kinds.items()}


def prepare(name: str) -> tuple[Path, Path, int, float]:
    """Files with the arrays of a mesh and of points, its number of triangles, and its size."""
    OUT.mkdir(exist_ok=True)
    stem = name.replace(" ", "-")
    arrays, points = OUT / f"nearest-{stem}.npz", OUT / f"nearest-{stem}-points.npz"
    vertices, faces = mesh_of(name)
    np.savez(arrays, vertices=vertices, faces=faces)
    kinds: dict[str, Any] = (
        {"centre": np.zeros((1, 3))} if name == "sphere" else dict(points_of(vertices, faces))
    )
    np.savez(points, **kinds)
    return arrays, points, len(faces), float(np.linalg.norm(np.ptp(vertices, axis=0)))


def medians(runs: list[Figures]) -> Figures:
    """The middle of each figure of some runs."""
    middle = dict(runs[0])
    middle["build_seconds"] = median(run["build_seconds"] for run in runs)
    middle["rates"] = {
        kind: median(run["rates"][kind] for run in runs) for kind in runs[0]["rates"]
    }
    return middle


def wrong(ours: Any, theirs: Any, size: float) -> dict[str, str]:
    """How many of a tool's answers are wrong, of how many that were compared."""
    told = {}
    for kind in theirs.files:
        question = kind.split(",")[0]
        judge = kind.replace("approximate ", "")
        if judge not in ours.files:
            continue
        count = min(len(ours[judge]), len(theirs[kind]))
        apart_by = np.abs(ours[judge][:count] - theirs[kind][:count])
        allowed = TOLERANCE[question] * (size if question == "distance" else 1.0)
        told[kind] = f"{np.count_nonzero(~(apart_by <= allowed)):,} of {count:,}"
    return told


def print_figures(title: str, figures: dict[str, Figures], errors: dict[str, Any]) -> None:
    """What every tool took, how that compares with halfline, and what is wrong."""
    ours = figures["halfline"]
    kinds = list(dict.fromkeys(kind for tool in figures.values() for kind in tool["rates"]))
    rows = [["millions of points a second", *figures]]
    for kind in kinds:
        rates = [tool["rates"].get(kind) for tool in figures.values()]
        rows.append([kind, *("" if rate is None else f"{rate / 1e6:.4g}" for rate in rates)])
    rows.append(["build, seconds", *(f"{tool['build_seconds']:.2f}" for tool in figures.values())])
    rows.append(["scene, MB", *(f"{tool['scene_bytes'] / 1e6:.0f}" for tool in figures.values())])
    print_table(title, rows)
    rivals = [name for name in figures if name != "halfline"]
    rows = [["halfline / theirs", *rivals]]
    for kind in kinds:
        own = ours["rates"].get(kind.replace("approximate ", ""))
        rates = [figures[name]["rates"].get(kind) for name in rivals]
        rows.append([kind, *("" if not (own and rate) else f"{own / rate:.1f}" for rate in rates)])
    print_table(f"{title}: ratios", rows)
    rows = [["wrong", *rivals]]
    rows += [[kind, *(errors[name].get(kind, "") for name in rivals)] for kind in kinds]
    print_table(f"{title}: answers that are not halfline's", rows)


def main() -> int:
    """Prepares, measures, prints, and writes bench/out/nearest.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, action="append", help="1 and all, if not given")
    parser.add_argument("--repetitions", type=int, default=3, help="processes of each tool")
    parser.add_argument("--mesh", choices=MESHES, action="append")
    options = parser.parse_args()

    pythons, left_out = {"halfline": (Path(sys.executable), "halfline")}, {}
    for name, (environment, tool) in RIVALS.items():
        try:
            python = make_environment(environment) / "bin" / "python"
            run([python, "-c", f"import {'igl' if tool == 'libigl' else tool}"], 1)
            pythons[name] = (python, tool)
        except ToolError as error:  # noqa: PERF203
            left_out[name] = str(error)
            print(f"{name} is left out: {error}")
    results = {}
    for mesh in options.mesh or MESHES:
        arrays, points, triangles, size = apart(prepare, mesh)
        for threads in options.threads or sorted({1, os.cpu_count() or 1}):
            runs: dict[str, list[Figures]] = {}
            answers = {name: OUT / f"nearest-{tool}.npz" for name, (_, tool) in pythons.items()}
            for repetition in range(options.repetitions):
                for name, (python, tool) in list(pythons.items()):
                    print(
                        f"{mesh}, {threads} threads: {name}, run {repetition + 1} of "
                        f"{options.repetitions}",
                        flush=True,
                    )
                    files = (arrays, str(threads), points, answers[name])
                    try:
                        done = run(tool_command(python, f"nearest.{tool}", *files), threads)
                    except ToolError as error:
                        left_out[name] = str(error)
                        print(f"{name} is left out: {error}")
                        del pythons[name]
                        continue
                    runs.setdefault(name, []).append(json.loads(done.stdout.splitlines()[-1]))
            figures = {name: medians(found) for name, found in runs.items()}
            ours = np.load(answers["halfline"])
            errors = {name: wrong(ours, np.load(answers[name]), size) for name in figures}
            title = f"{mesh}, {triangles:,} triangles, {threads} threads"
            print_figures(title, figures, errors)
            results[title] = {"medians": figures, "runs": runs, "wrong": errors}
    machine = {"processor": processor(), "cores": os.cpu_count(), "system": platform.platform()}
    answer = {"machine": machine, "left_out": left_out, "meshes": results}
    output = OUT / "nearest.json"
    output.write_text(json.dumps(answer, indent=1) + "\n", encoding="utf-8")
    print(f"Everything measured is in {output.relative_to(ROOT)}")
    return 0
