"""The program in bench/peers: builds it, launches it, puts what it measured together."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from common.harness import OUT, ROOT, ToolError, make_environment, run

# What the program calls the one who answers.
HALFLINE, EMBREE, ROBUST, OBVHS = "halfline", "embree", "embree_robust", "obvhs"
TINYBVH = "tinybvh"

# What it counts, which does not depend on the machine's noise.
COUNTS = ("nodes_per_ray", "leaves_per_ray", "cache_lines_per_ray", "exact_per_ray")


def embree_library() -> Path:
    """The shared library of Embree 4, from an environment made for it."""
    environment = make_environment("embreex")
    found = sorted(environment.glob("lib/python*/site-packages/embreex.libs/libembree4*"))
    if not found:
        raise ToolError("embreex: its wheel for this machine brings no libembree4")
    return found[0]


@dataclass(frozen=True)
class Program:
    """The program, built, and what it needs."""

    path: Path
    library: Path
    core: int
    """Where one thread is pinned to."""

    @classmethod
    def built(cls, core: int) -> Program:
        """Builds it, with tinybvh where that can be compiled."""
        library = embree_library()
        manifest = ["--manifest-path", str(ROOT / "bench" / "peers" / "Cargo.toml")]
        has_tinybvh = platform.machine() in ("x86_64", "AMD64") and shutil.which("c++") is not None
        features = ["--features", "tinybvh"] if has_tinybvh else []
        run(["cargo", "build", "--release", "--locked", *features, *manifest], 1)
        about = run(["cargo", "metadata", "--no-deps", "--format-version", "1", *manifest], 1)
        target = Path(json.loads(about.stdout)["target_directory"])
        return cls(target / "release" / "peers", library, core)

    def launch(self, name: str, mesh: str, threads: int, **options: Any) -> dict[str, Any]:
        """What one launch measures of one mesh; on one thread it is pinned."""
        pinned = threads == 1 and shutil.which("taskset") is not None
        pin = ["taskset", "--cpu-list", str(self.core)] if pinned else []
        out = OUT / f"launch-{os.getpid()}.json"
        command = [*pin, str(self.path), str(self.library), str(out), f"--threads={threads}"]
        command += [f"--{option}={value}" for option, value in options.items()]
        # Huge pages for all.
        environment = os.environ | {"GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}
        done = subprocess.run(
            [*command, f"{name}={mesh}"], env=environment, stderr=subprocess.PIPE, text=True
        )
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines()
            raise ToolError(f"peers: {lines[-1] if lines else f'exit code {done.returncode}'}")
        measured = json.loads(out.read_text(encoding="utf-8"))
        out.unlink()
        found: dict[str, Any] = measured["meshes"][0]
        # The file tells its clock and what it ran on once for all meshes.
        return {name: value for name, value in measured.items() if name != "meshes"} | found


def spread(values: list[float]) -> float:
    """How far the turns differ, as a share of their median."""
    return (max(values) - min(values)) / median(values)


@dataclass(frozen=True)
class Answer:
    """How quick a tool is in one cell, in the quickest way of asking it."""

    way: str
    seconds: float
    spread: float


@dataclass(frozen=True)
class Cell:
    """One kind of rays on one mesh: the turns of all launches."""

    rays: str
    count: int
    turns: dict[tuple[str, str], list[float]]
    """Seconds, by who answers and the way of asking."""
    agreement: float
    """The least share of rays that a way answers as halfline does: the same place, or nothing."""
    work: dict[str, float]
    """Counts per ray, by name, if any launch counted."""

    def best(self, kind: str) -> Answer | None:
        """A tool's quickest way, by the medians of all turns."""
        answers = [
            Answer(way, median(turns), spread(turns))
            for (whose, way), turns in self.turns.items()
            if whose == kind
        ]
        return min(answers, key=lambda answer: answer.seconds, default=None)

    def rate(self, kind: str) -> float | None:
        """Mrays/s in a tool's quickest way."""
        answer = self.best(kind)
        return None if answer is None else self.count / answer.seconds / 1e6


def cells_of(launches: Iterable[dict[str, Any]]) -> list[Cell]:
    """The cells of one mesh, from launches with the same options."""
    cells: dict[str, Cell] = {}
    for cell in (cell for launch in launches for cell in launch["cells"]):
        known = cells.get(cell["rays"]) or Cell(cell["rays"], cell["count"], {}, 1.0, {})
        # A way that was hopeless in one launch may have been measured in another.
        for way in cell["ways"]:
            if way["seconds"]:
                turns = known.turns.setdefault((way["kind"], way["name"]), [])
                turns += way["seconds"]
        agreement = min(known.agreement, *(way["agreement"] for way in cell["ways"]))
        work = cell["work"] or known.work
        cells[cell["rays"]] = Cell(known.rays, known.count, known.turns, agreement, work)
    return list(cells.values())


@dataclass(frozen=True)
class Build:
    """What a tool's tree costs."""

    tool: str
    seconds: float
    bytes: int | None
    """Of the finished tree, where that is known, as is the next."""
    peak_bytes: int | None
    """The most that building held at a time, the mesh not among it."""


def builds_of(launches: list[dict[str, Any]]) -> dict[str, Build]:
    """What the trees of one mesh cost, medians over launches."""
    seconds: dict[str, list[float]] = {}
    for build in (build for launch in launches for build in launch["builds"]):
        seconds.setdefault(build["tool"], []).append(build["seconds"])
    return {
        build["tool"]: Build(
            build["tool"], median(seconds[build["tool"]]), build["bytes"], build["peak_bytes"]
        )
        for build in launches[0]["builds"]
    }
