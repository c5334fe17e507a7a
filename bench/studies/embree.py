"""halfline against Embree 4, ray by ray kind, on the same meshes.

Run by `make bench-embree`. Embree is the library inside PyPI's embreex wheel, called through its C
interface by the program in bench/peers, in every configuration: medium and high quality, single
rays and packets of 4, 8 and 16 with either flag, robust or not. Each cell is held against the best
of those that are not robust, though halfline is. obvhs, a tree library from crates.io, is asked as
well, and tinybvh where there are a C++ compiler and AVX2, each with two trees.

With HALFLINE_SIMD=avx2 in the environment, both halfline and Embree keep to AVX2.

The tools take turns within one process, and the process is launched several times: printed are
medians over all turns, and how far they lie apart. One thread is pinned to a core and measured in
the CPU time of the process, several are measured on the wall.

The meshes are the bunny, the Stanford dragon and three generated ones. Prints a table for each
mesh, what the trees cost, and how it all ends; writes bench/out/embree.json, a chart of it,
embree.svg, and what the trees cost, embree-builds.json.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from dataclasses import asdict
from pathlib import Path
from statistics import mean, median
from typing import Any

import charts.embree
from common.embree_program import (
    COUNTS,
    EMBREE,
    HALFLINE,
    OBVHS,
    ROBUST,
    TINYBVH,
    Build,
    Cell,
    Program,
    builds_of,
    cells_of,
)
from common.harness import DRAGON, OUT, ROOT, ToolError, print_table, run

FILES = {
    "bunny": ROOT / "data" / "stl-models" / "objects" / "bunny.bin.stl",
    "dragon": DRAGON,
}

# What is generated, and how large.
GENERATED = {"scan": 5_200_000, "hall": 1_000_000, "soup": 1_000_000}

BUILDERS = ("halfline", "Embree High", "Embree Medium")


def prepare(halfline: Path, mesh: str) -> Path:
    """The file of a mesh, generated if it is not there."""
    if mesh in FILES:
        return FILES[mesh]
    path = OUT / f"{mesh}-{GENERATED[mesh]}.ply"
    if not path.exists():
        options = ["--triangles", str(GENERATED[mesh]), "--quiet", "--output", str(path)]
        run([halfline, "generate", mesh, *options], 1)
    return path


def figures(
    mesh: str, launch: dict[str, Any], cell: Cell, work: dict[str, float]
) -> dict[str, Any]:
    """A cell as embree.json holds it; rates are Mrays/s. Any of its launches tells the machine."""
    ours, theirs = cell.best(HALFLINE), cell.best(EMBREE)
    assert ours is not None
    assert theirs is not None
    return {
        "mesh": mesh,
        "rays": cell.rays,
        "threads": launch["threads"],
        "processor": launch["processor"],
        "instruction_sets": launch["instruction_sets"],
        "halfline": cell.rate(HALFLINE),
        "halfline_spread": ours.spread,
        "embree": cell.rate(EMBREE),
        "embree_config": theirs.way,
        "embree_spread": theirs.spread,
        "embree_robust": cell.rate(ROBUST),
        "obvhs": cell.rate(OBVHS),
        "tinybvh": cell.rate(TINYBVH),
        "ratio": theirs.seconds / ours.seconds,
        "agreement": cell.agreement,
        **{name: work[name] for name in COUNTS},
    }


def number(value: float | None, digits: int = 2) -> str:
    """A number of a table, or a dash."""
    return "-" if value is None else f"{value:.{digits}f}"


def rate_and_spread(cell: dict[str, Any], tool: str) -> str:
    """A rate, and how far its turns lie apart."""
    return f"{cell[tool]:.2f} ±{cell[f'{tool}_spread'] / 2:3.0%}"


def print_cells(title: str, cells: list[dict[str, Any]], single: list[dict[str, Any]]) -> None:
    """The cells of a mesh; those of several threads beside those of one."""
    rows = [
        ["Mrays/s", "halfline", "Embree", "ratio", "Embree's best", "robust", "obvhs", "tinybvh"]
    ]

    if single:
        rows[0] += ["halfline / 1 thread", "Embree / 1 thread"]
    else:
        rows[0] += [name.removesuffix("_per_ray").replace("_", " ") for name in COUNTS]
    for index, cell in enumerate(cells):
        row = [cell["rays"], *(rate_and_spread(cell, tool) for tool in ("halfline", "embree"))]
        row += [number(cell["ratio"]), cell["embree_config"]]
        row += [number(cell[tool]) for tool in ("embree_robust", "obvhs", "tinybvh")]
        if single:
            row += [number(cell[tool] / single[index][tool]) for tool in ("halfline", "embree")]
        else:
            row += [number(cell[name], 3 if name == "exact_per_ray" else 1) for name in COUNTS]
        rows.append(row)
    print_table(title, rows)


def print_builds(builds: dict[tuple[str, int], dict[str, Build]], sizes: dict[str, int]) -> None:
    """What the trees cost."""
    for threads in dict.fromkeys(threads for _, threads in builds):
        rows = [["seconds to build", *BUILDERS, "high / halfline"]]
        for mesh, triangles in sizes.items():
            found = builds[mesh, threads]
            seconds = [found[tool].seconds for tool in BUILDERS]
            row = [f"{mesh}, {triangles:,} triangles", *map(number, seconds)]
            rows.append([*row, number(seconds[1] / seconds[0])])
        print_table(f"Building on {counted(threads, 'thread')}, medians", rows)

    rows = [["bytes a triangle", *BUILDERS]]
    peaks = [["the most while building / finished tree", *BUILDERS]]
    for mesh, triangles in sizes.items():
        found = next(found for (name, _), found in builds.items() if name == mesh)
        trees = [found[tool] for tool in BUILDERS]
        rows.append([mesh, *(number((tree.bytes or 0) / triangles, 0) for tree in trees)])
        peaks.append(
            [mesh, *(number((tree.peak_bytes or 0) / (tree.bytes or 1)) for tree in trees)]
        )
    print_table("Trees, without the mesh", rows)
    print_table("Memory of the builders, without the mesh", peaks)


def counted(count: int, what: str) -> str:
    """One or several."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def geometric_mean(values: list[float]) -> float:
    """The number whose logarithm is the mean of the logarithms."""
    return math.exp(sum(map(math.log, values)) / len(values))


def print_machine(launch: dict[str, Any]) -> None:
    """What it all ran on."""
    version = int(launch["embree_version"])
    told = ".".join(str(version // place % 100) for place in (10000, 100, 1))
    sets = launch["instruction_sets"]
    print(f"\nProcessor: {launch['processor'] or 'not told'}.")
    print(f"Instruction sets: halfline {sets['halfline']}, Embree {told} {sets['embree']}.")
    others = [build["tool"] for build in launch["builds"][1:]]
    print(f"Rivals: {'; '.join(others)}.")


def print_end(threads: int, cells: list[dict[str, Any]]) -> None:
    """How halfline stands against everyone, all cells together."""
    every = [float(cell["ratio"]) for cell in cells]
    by_mesh: dict[str, list[float]] = {}
    for cell in cells:
        by_mesh.setdefault(cell["mesh"], []).append(cell["ratio"])
    worst = min(cells, key=lambda cell: float(cell["ratio"]))
    means = ", ".join(f"{mesh} {geometric_mean(ratios):.2f}" for mesh, ratios in by_mesh.items())
    print(f"\n{counted(threads, 'thread')}, halfline / Embree's best that is not robust:")
    print(f"  mean {mean(every):.2f}, geometric mean {geometric_mean(every):.2f} ({means})")
    print(f"  {sum(ratio < 1.0 for ratio in every)} of {len(every)} cells below 1.0")
    print(f"  worst cell {worst['mesh']} {worst['rays']}, {worst['ratio']:.2f}")
    for name, rival in (
        ("robust Embree", "embree_robust"),
        ("obvhs", "obvhs"),
        ("tinybvh", "tinybvh"),
    ):
        ratios = {
            f"{cell['mesh']} {cell['rays']}": cell["halfline"] / cell[rival]
            for cell in cells
            if cell[rival] is not None
        }
        if not ratios:
            print(f"  / {name}: not asked")
            continue
        least = min(ratios, key=lambda cell: ratios[cell])
        typical = geometric_mean(list(ratios.values()))
        print(f"  / {name}: geometric mean {typical:.2f}, worst cell {least}, {ratios[least]:.2f}")


def print_scaling(
    threads: int,
    cells: dict[int, list[dict[str, Any]]],
    builds: dict[tuple[str, int], dict[str, Build]],
) -> None:
    """What several threads give in terms of one."""
    print(f"\n{counted(threads, 'thread')} / 1 thread (least, median, most):")
    for tool, builder in (("halfline", "halfline"), ("embree", "Embree High")):
        rays = [
            several[tool] / one[tool] for several, one in zip(cells[threads], cells[1], strict=True)
        ]
        build = [
            found[builder].seconds / builds[mesh, threads][builder].seconds
            for (mesh, count), found in builds.items()
            if count == 1
        ]
        for what, factors in (("rays", rays), ("builds", build)):
            told = ", ".join(
                number(value) for value in (min(factors), median(factors), max(factors))
            )
            print(f"  {builder}'s {what}: {told}")


def compare(options: argparse.Namespace) -> None:
    """Launches, prints, writes."""
    OUT.mkdir(parents=True, exist_ok=True)
    program = Program.built(options.core)
    paths = {mesh: prepare(options.halfline, mesh) for mesh in options.meshes}
    launches: dict[tuple[str, int], list[dict[str, Any]]] = {}
    for number_of_launch in range(options.launches):
        for threads in options.threads:
            for mesh, path in paths.items():
                start = time.monotonic()
                # Counts are the same every time.
                count = int(number_of_launch == 0 and threads == options.threads[0])
                measured = program.launch(
                    mesh, str(path), threads, rounds=options.rounds, rays=options.rays, count=count
                )
                launches.setdefault((mesh, threads), []).append(measured)
                print(
                    f"launch {number_of_launch + 1} of {options.launches}, {mesh}, "
                    f"{counted(threads, 'thread')}: {time.monotonic() - start:.0f} s",
                    flush=True,
                )

    first = options.threads[0]
    sizes = {mesh: int(launches[mesh, first][0]["triangles"]) for mesh in paths}
    print_machine(launches[options.meshes[0], first][0])
    turns = options.launches * options.rounds
    print(f"\nRates are medians of {turns} turns ± half of the distance between quickest and")
    print(
        "slowest; robust is Embree's best robust way, obvhs and tinybvh the quicker of their trees."
    )
    cells: dict[int, list[dict[str, Any]]] = {threads: [] for threads in options.threads}
    for mesh, triangles in sizes.items():
        work = {cell.rays: cell.work for cell in cells_of(launches[mesh, first])}
        for threads in options.threads:
            found = [
                figures(mesh, launches[mesh, threads][0], cell, work[cell.rays])
                for cell in cells_of(launches[mesh, threads])
            ]
            single = (
                [] if threads == 1 else [cell for cell in cells.get(1, []) if cell["mesh"] == mesh]
            )
            title = f"{mesh}, {triangles:,} triangles, {counted(threads, 'thread')}"
            print_cells(title, found, single)
            cells[threads] += found
    builds = {key: builds_of(found) for key, found in launches.items()}
    print_builds(builds, sizes)
    for threads, found in cells.items():
        print_end(threads, found)
        if threads > 1 and 1 in cells:
            print_scaling(threads, cells, builds)
    every = [cell for found in cells.values() for cell in found]
    least = math.floor(min(cell["agreement"] for cell in every) * 1e4) / 1e4
    print(f"\nAll tools find halfline's places for at least {least:.2%} of the rays of each cell.")

    write("embree.json", every)
    costs = [
        {"mesh": mesh, "triangles": sizes[mesh], "threads": threads, **asdict(build)}
        for (mesh, threads), found in builds.items()
        for build in found.values()
    ]
    write("embree-builds.json", costs)
    charts.embree.main()
    print("Everything is in bench/out: embree.json, embree-builds.json, and a chart, embree.svg.")


def write(name: str, values: list[dict[str, Any]]) -> None:
    """A list as a file of bench/out."""
    (OUT / name).write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """The whole comparison."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--halfline", type=Path, required=True, help="the built command")
    parser.add_argument("--launches", type=int, default=3, help="of the whole program")
    parser.add_argument("--rounds", type=int, default=1, help="turns of each tool in a launch")
    parser.add_argument("--rays", type=int, default=1 << 20, help="rays of each kind, at most")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--core", type=int, default=0, help="what one thread is pinned to")
    meshes = [*FILES, *GENERATED]
    parser.add_argument("--meshes", nargs="+", choices=meshes, default=meshes)
    try:
        compare(parser.parse_args())
    except (ToolError, OSError) as error:
        print(f"bench embree: {error}", file=sys.stderr)
        return 1
    return 0
