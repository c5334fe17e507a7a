"""halfline's Python package against trimesh + embreex and Open3D, as NumPy users have them.

Run by `make bench-numpy`. Every measurement is a process of its own, and the tools take turns;
medians are printed, and everything measured goes to bench/out/numpy.json. All tools get the same
arrays: vertices and faces, and single-precision rays. embreex knows one thread only; the others get
as many as --threads says. What the tools find is compared, too.
"""

from __future__ import annotations

import argparse
import gzip
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

SCAN_TRIANGLES = 5_500_000
SIDE = 1000
MANY = 200_000
RIVALS = {"trimesh + embreex": "embreex", "Open3D": "open3d"}

# What is compared: its name, the figure of the reports, and how it is shown.
RATIOS = {
    "build": "build_seconds",
    "coherent": "coherent_seconds",
    "incoherent": "incoherent_seconds",
    "all hits": "all_seconds",
    "counts": "counts_seconds",
    "scene memory": "scene_bytes",
    "peak memory": "peak_bytes",
    "Ctrl-C": "interrupt_seconds",
}

Figures = dict[str, Any]


def prepare(name: str) -> tuple[Path, Path, int]:
    """Files with the arrays of a mesh and of its rays, and its number of triangles."""
    OUT.mkdir(exist_ok=True)
    if name == "dragon":
        path = OUT / "dragon.ply"
        if not path.exists():
            path.write_bytes(gzip.decompress(DRAGON.read_bytes()))
        mesh = halfline.load(path)
    else:
        mesh = halfline.generate("scan", SCAN_TRIANGLES, 0)
    arrays, rays = OUT / f"{name}.npz", OUT / f"{name}-rays.npz"
    np.savez(arrays, vertices=mesh.vertices.astype(np.float32), faces=mesh.faces)

    # A pinhole at three quarters, a little above, that sees the whole box.
    low, high = mesh.bounds
    center, diagonal = (low + high) / 2, float(np.linalg.norm(high - low))
    toward = -np.array([0.5, 0.35, 0.8]) / np.linalg.norm([0.5, 0.35, 0.8])
    right = np.cross(toward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, toward)
    x, y = np.meshgrid(*[(np.arange(SIDE) + 0.5) / SIDE - 0.5] * 2)
    directions = 1.5 * toward + x[..., None] * right - y[..., None] * up
    eye = np.broadcast_to(center - 1.4 * diagonal * toward, directions.shape)

    # From a sphere around the box to anywhere in it.
    random = np.random.default_rng(0)
    away = random.normal(size=(SIDE * SIDE, 3))
    origins = center + diagonal * away / np.linalg.norm(away, axis=1, keepdims=True)
    targets = random.uniform(low, high, size=origins.shape)
    single = np.float32
    np.savez(
        rays,
        coherent_origins=eye.reshape(-1, 3).astype(single),
        coherent_directions=directions.reshape(-1, 3).astype(single),
        incoherent_origins=origins.astype(single),
        incoherent_directions=(targets - origins).astype(single),
        many_origins=origins[:MANY].astype(single),
        many_directions=(targets - origins)[:MANY].astype(single),
    )
    return arrays, rays, len(mesh.faces)


def medians(runs: list[Figures]) -> Figures:
    """The middle of each figure of some runs."""
    first = runs[0]
    return {
        key: median(run[key] for run in runs) if isinstance(value, int | float) else value
        for key, value in first.items()
    }


def print_figures(mesh: str, triangles: int, figures: dict[str, Figures]) -> None:
    """What every tool took, and how that compares with halfline."""
    rows = [["", "threads", "build s", "coherent", "incoherent", "all hits", "counts"]]
    rows[0] += ["scene MB", "peak MB", "Ctrl-C s", "ticks/s"]
    for tool in figures.values():
        rate = [
            tool[f"{rays}_rays"] / tool[f"{kind}_seconds"] / 1e6
            for kind, rays in (
                ("coherent", "coherent"),
                ("incoherent", "incoherent"),
                ("all", "many"),
                ("counts", "many"),
            )
        ]
        rows.append(
            [tool["tool"], f"{tool['threads']:.0f}", f"{tool['build_seconds']:.2f}"]
            + [f"{value:.2f}" for value in rate]
            + [f"{tool['scene_bytes'] / 1e6:.0f}", f"{tool['peak_bytes'] / 1e6:.0f}"]
            + [f"{tool['interrupt_seconds']:.2f} of {tool['call_seconds']:.1f}"]
            + [f"{tool['ticks_busy']:.0f} of {tool['ticks_idle']:.0f}"]
        )
    print_table(f"{mesh}, {triangles:,} triangles, medians; millions of rays a second", rows)
    ours = figures["halfline"]
    rows = [["theirs / halfline's", *RATIOS]]
    for name, theirs in figures.items():
        if name != "halfline":
            ratios = [theirs[key] / max(ours[key], 1e-9) for key in RATIOS.values()]
            rows.append([name, *(f"{ratio:.2f}" for ratio in ratios)])
    print_table(f"{mesh}, ratios: above 1, halfline is quicker or smaller", rows)
    rows = [["found", "coherent hits", "incoherent hits", "all hits", "counted"]]
    keys = ("coherent_hits", "incoherent_hits", "all_hits", "counted")
    rows += [[tool["tool"], *(f"{tool[key]:,.0f}" for key in keys)] for tool in figures.values()]
    print_table(f"{mesh}, what the tools find", rows)


def main() -> int:
    """Prepares, measures, prints, and writes bench/out/numpy.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--repetitions", type=int, default=3, help="processes of each tool")
    parser.add_argument("--mesh", choices=("dragon", "scan"), action="append")
    options = parser.parse_args()

    pythons, left_out = {"halfline": (Path(sys.executable), "halfline")}, {}
    for name, key in RIVALS.items():
        try:
            pythons[name] = (make_environment(key) / "bin" / "python", key)
        except ToolError as error:  # noqa: PERF203
            left_out[name] = str(error)
            print(f"{name} is left out: {error}")
    results = {}
    for mesh in options.mesh or ("dragon", "scan"):
        arrays, rays, triangles = apart(prepare, mesh)
        runs: dict[str, list[Figures]] = {}
        for repetition in range(options.repetitions):
            for name, (python, key) in pythons.items():
                print(f"{mesh}: {name}, run {repetition + 1} of {options.repetitions}", flush=True)
                threads = options.threads
                tool = tool_command(python, f"numpy.{key}", arrays, str(threads), rays)
                done = run(tool, threads)
                runs.setdefault(name, []).append(json.loads(done.stdout.splitlines()[-1]))
        figures = {name: medians(found) for name, found in runs.items()}
        print_figures(mesh, triangles, figures)
        results[mesh] = {"triangles": triangles, "medians": figures, "runs": runs}
    machine = {"processor": processor(), "cores": os.cpu_count(), "system": platform.platform()}
    answer = {"machine": machine, "left_out": left_out, "meshes": results}
    output = OUT / "numpy.json"
    output.write_text(json.dumps(answer, indent=1) + "\n", encoding="utf-8")
    print(f"Everything measured is in {output.relative_to(ROOT)}")
    return 0
