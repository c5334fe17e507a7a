"""halfline against trimesh + embreex and Open3D: load, build, trace, memory.

Run by `make bench-cli`. Every measurement is a process of its own; the tools take turns, so that a
machine whose speed drifts treats all alike; medians are printed, and everything measured goes to
bench/out/cli.json. All tools read the same files and cast the same rays, on the same number of
threads (trimesh + embreex knows only one). A rival that cannot be installed or run is named.
"""

from __future__ import annotations

import argparse
import gzip
import json
import os
import platform
import shutil
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from common.harness import (
    DRAGON,
    OUT,
    ROOT,
    ToolError,
    apart,
    print_table,
    processor,
    python_of,
    run,
    tool_command,
)

SCAN_TRIANGLES = 5_500_000
RAYS = ("primary", "random")
LOAD_CLAIM = 3.0

# What each rival is called here, the key of its module, environment and lock file, and whether
# only its older mesh reader is meant.
RIVALS = (
    ("trimesh + embreex", "embreex", False),
    ("Open3D", "open3d", False),
    ("Open3D, older reader", "open3d", True),
)

Figures = dict[str, Any]


class Halfline:
    """The command that this project builds."""

    name = "halfline"

    def __init__(self, binary: Path) -> None:
        self.binary = binary
        version = run([binary, "--version"], 1).stdout.split()[-1]
        self.tool = f"halfline {version}"

    def measure(self, mesh: Path, rays: dict[str, Path], threads: int) -> list[Figures]:
        """One process for each kind of rays; every one loads and builds."""
        found = []
        for kind, path in rays.items():
            hits = path.with_suffix(".halfline.npz")
            options = ["--json", "--quiet", "--threads", str(threads)]
            done = run([self.binary, "query", mesh, path, "-o", hits, *options], threads)
            answer = json.loads(done.stdout)
            found.append(
                {
                    "tool": self.tool,
                    "threads": threads,
                    "load_seconds": answer["load_seconds"],
                    "build_seconds": answer["build_seconds"],
                    "trace_seconds": {kind: answer["trace_seconds"]},
                    "faces": {kind: str(hits)},
                    "peak_bytes": done.peak_bytes,
                }
            )
        return found

    def info(self, mesh: Path) -> Figures:
        """What `halfline info` says."""
        answer: Figures = json.loads(run([self.binary, "info", mesh, "--json"], 1).stdout)
        return answer


class Rival:
    """A library that is measured by a script in a virtual environment of its own."""

    def __init__(self, name: str, key: str, *, legacy_reader: bool = False) -> None:
        self.name = name
        self.key = key
        self.legacy_reader = legacy_reader
        self.python = python_of(key)

    def measure(self, mesh: Path, rays: dict[str, Path], threads: int) -> list[Figures]:
        """One process that loads, builds, and casts all rays."""
        arguments = [] if self.legacy_reader else [f"{kind}={path}" for kind, path in rays.items()]
        tool = tool_command(self.python, f"cli.{self.key}", mesh, str(threads), *arguments)
        done = run(tool, threads)
        report: Figures = json.loads(done.stdout.splitlines()[-1])
        if self.legacy_reader:
            report["tool"] += ", older reader"
        return [report | {"peak_bytes": done.peak_bytes}]


Tool = Halfline | Rival


def find_rivals() -> tuple[list[Rival], dict[str, str]]:
    """The rivals that can be installed, and why the others cannot."""
    found, missing = [], {}
    for name, key, legacy_reader in RIVALS:
        try:
            found.append(Rival(name, key, legacy_reader=legacy_reader))
        except ToolError as error:  # noqa: PERF203
            missing[name] = str(error)
            print(f"{name} is left out: {error}")
    return found, missing


def write_rays(bounds: list[list[float]], stem: Path, side: int) -> dict[str, Path]:
    """Camera rays and random rays about a box, `side` squared of each, in single precision."""
    low, high = np.array(bounds)
    center, diagonal = (low + high) / 2, float(np.linalg.norm(high - low))

    # A pinhole at three quarters, a little above, that sees the whole box.
    toward = -np.array([0.5, 0.35, 0.8]) / np.linalg.norm([0.5, 0.35, 0.8])
    right = np.cross(toward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, toward)
    x, y = np.meshgrid(*[(np.arange(side) + 0.5) / side - 0.5] * 2)
    directions = 1.5 * toward + x[..., None] * right - y[..., None] * up
    eye = np.broadcast_to(center - 1.4 * diagonal * toward, directions.shape)
    primary = np.concatenate([eye, directions], axis=-1).reshape(-1, 6)

    random = np.random.default_rng(0)
    away = random.normal(size=(side * side, 3))
    origins = center + diagonal * away / np.linalg.norm(away, axis=1, keepdims=True)
    targets = random.uniform(low, high, size=origins.shape)
    paths = {}
    for kind, rays in {
        "primary": primary,
        "random": np.hstack([origins, targets - origins]),
    }.items():
        paths[kind] = stem.with_name(f"{stem.name}-{kind}.npy")
        np.save(paths[kind], rays.astype(np.float32))
    return paths


def prepare_meshes(halfline: Halfline, scan_triangles: int) -> dict[str, Path]:
    """The dragon as plain ASCII PLY, and the generated scan as binary PLY."""
    OUT.mkdir(exist_ok=True)
    dragon = OUT / "dragon.ply"
    if not dragon.exists():
        partial = dragon.with_suffix(".partial")
        with gzip.open(DRAGON) as source, partial.open("wb") as target:
            shutil.copyfileobj(source, target)
        partial.replace(dragon)
    scan = OUT / "scan.ply"
    run([halfline.binary, "generate", "scan", "-n", str(scan_triangles), "-o", scan, "--quiet"], 1)
    return {"dragon": dragon, "scan": scan}


def summary(runs: list[Figures]) -> Figures:
    """The medians of one tool's runs on one mesh."""

    def middle(values: list[float | None]) -> float | None:
        known = [value for value in values if value is not None]
        return median(known) if known else None

    return {
        "tool": runs[0]["tool"],
        "threads": runs[0]["threads"],
        "load_seconds": middle([r["load_seconds"] for r in runs]),
        "build_seconds": middle([r.get("build_seconds") for r in runs]),
        "trace_seconds": {
            kind: middle([r["trace_seconds"].get(kind) for r in runs]) for kind in RAYS
        },
        "peak_bytes": middle([r["peak_bytes"] for r in runs]),
        "tree_bytes": middle([r.get("tree_bytes") for r in runs]),
    }


def agreement(ours: dict[str, str], theirs: dict[str, str]) -> dict[str, float]:
    """For each kind of rays the share of them that hit the same face."""
    shares = {}
    for kind, path in theirs.items():
        with np.load(ours[kind]) as hits:
            shares[kind] = float(np.mean(hits["face"] == np.load(path)))
    return shares


def cell(value: float | None, scale: float = 1.0, digits: int = 2) -> str:
    """A number of the table, or a dash."""
    return "-" if value is None else f"{value * scale:.{digits}f}"


def print_figures(mesh: str, triangles: int, ray_count: int, figures: dict[str, Figures]) -> None:
    """The medians of every tool, and how they compare with halfline's."""
    rows = [["", "threads", "load s", "build s", *(f"{kind} Mrays/s" for kind in RAYS)]]
    rows[0] += ["peak MB", "tree bytes/triangle"]
    for tool in figures.values():
        row = [tool["tool"], str(tool["threads"])]
        row += [cell(tool["load_seconds"]), cell(tool["build_seconds"])]
        for seconds in tool["trace_seconds"].values():
            row.append(cell(None if seconds is None else ray_count / seconds / 1e6))
        row += [cell(tool["peak_bytes"], 1e-6, 0), cell(tool["tree_bytes"], 1 / triangles, 0)]
        rows.append(row)
    print_table(f"{mesh}, {triangles:,} triangles, medians", rows)

    print("Tree: halfline's own count; for the others by how much the process grew while it built,")
    print("with the copies of the vertices that Embree keeps.")

    ours = figures["halfline"]

    def ratio(theirs: float | None, mine: float | None) -> str:
        return "-" if theirs is None or mine is None else f"{theirs / mine:.2f}"

    rows = [["theirs / halfline's", "load", "build", *RAYS, "peak", "tree"]]
    for name, theirs in figures.items():
        if name == "halfline":
            continue
        row = [name, *(ratio(theirs[key], ours[key]) for key in ("load_seconds", "build_seconds"))]
        row += [ratio(theirs["trace_seconds"][k], ours["trace_seconds"][k]) for k in RAYS]
        row += [ratio(theirs[key], ours[key]) for key in ("peak_bytes", "tree_bytes")]
        rows.append(row)
    if len(rows) > 1:
        print_table(f"{mesh}, ratios: above 1, halfline is quicker or smaller", rows)


def compare(
    mesh: str, path: Path, tools: list[Tool], options: argparse.Namespace
) -> dict[str, Any]:
    """Measures all tools on one mesh, prints the tables, and returns everything."""
    halfline = tools[0]
    assert isinstance(halfline, Halfline)
    info = halfline.info(path)
    rays = apart(write_rays, info["bounds"], OUT / mesh, options.side)
    runs: dict[str, list[Figures]] = {}
    failures: dict[str, str] = {}
    for repetition in range(options.repetitions):
        for tool in tools:
            if tool.name in failures:
                continue
            print(f"{mesh}: {tool.name}, run {repetition + 1} of {options.repetitions}", flush=True)
            try:
                runs.setdefault(tool.name, []).extend(tool.measure(path, rays, options.threads))
            except ToolError as error:
                if tool is halfline:
                    raise
                failures[tool.name] = str(error)
                runs.pop(tool.name, None)
                print(f"{mesh}: {tool.name} failed: {error}")
    figures = {name: summary(found) for name, found in runs.items()}
    figures["halfline"]["tree_bytes"] = info["tree"]["bytes"]
    print_figures(mesh, info["triangles"], options.side**2, figures)

    hits = {kind: path for run in runs["halfline"] for kind, path in run["faces"].items()}
    same = {
        name: apart(agreement, hits, found[0]["faces"])
        for name, found in runs.items()
        if name != "halfline" and found[0]["faces"]
    }
    for name, shares in same.items():
        told = ", ".join(f"{share:.4%} of the {kind} rays" for kind, share in shares.items())
        print(f"{name} hits the same face as halfline with {told}.")
    return {
        "triangles": info["triangles"],
        "rays_of_each_kind": options.side**2,
        "medians": figures,
        "same_face": same,
        "failures": failures,
        "runs": runs,
    }


def main() -> int:
    """Prepares, measures, prints, and writes bench/out/cli.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--halfline", type=Path, required=True, help="the built command")
    parser.add_argument("--threads", type=int, default=1, help="threads for every tool")
    parser.add_argument("--repetitions", type=int, default=3, help="processes of each tool")
    parser.add_argument("--side", type=int, default=1000, help="square root of the ray count")
    parser.add_argument("--scan-triangles", type=int, default=SCAN_TRIANGLES)
    options = parser.parse_args()

    halfline = Halfline(options.halfline.resolve())
    rivals, missing = find_rivals()
    tools: list[Tool] = [halfline, *rivals]
    meshes = prepare_meshes(halfline, options.scan_triangles)
    results = {mesh: compare(mesh, path, tools, options) for mesh, path in meshes.items()}

    loads = {n: f["load_seconds"] for n, f in results["scan"]["medians"].items()}
    ours = loads.pop("halfline")
    if loads:
        times = min(loads.values()) / ours
        verdict = "holds" if times >= LOAD_CLAIM else "does NOT hold"
        print(f"\nThe scan loads {times:.1f} times as fast as with the fastest rival.")
        print(f"The claim of {LOAD_CLAIM:.0f} times {verdict}.")
    machine = {"processor": processor(), "cores": os.cpu_count(), "system": platform.platform()}
    answer = {"machine": machine, "left_out": missing, "meshes": results}
    output = OUT / "cli.json"
    output.write_text(json.dumps(answer, indent=1) + "\n", encoding="utf-8")
    print(f"Everything measured is in {output.relative_to(ROOT)}")
    return 0
