"""What a ray costs as meshes grow from a thousand to ten million triangles.

Run by `make bench-growth`. A generated scan and a soup, at nine sizes each; rays of a camera and
random chords; one thread, pinned, in CPU time, halfline against Embree in the quickest of its
configurations, robust ones left out. What a ray looks at is counted beside the time: counts tell
what a tree does, time tells what memory makes of it. Prints a table for each kind of mesh, and
writes bench/out/growth.json and a chart, bench/out/growth.svg.
"""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

import charts.growth
from common.embree_program import COUNTS, EMBREE, HALFLINE, Program, cells_of
from common.harness import OUT, ToolError, print_table

FAMILIES = ("scan", "soup")
SIZES = [step * 10**power for power in range(3, 7) for step in (1, 3)] + [10**7]
RAYS = ("primary", "random")


def measure(
    program: Program, family: str, triangles: int, rays: int, rounds: int
) -> list[dict[str, Any]]:
    """Both kinds of rays on one mesh, in nanoseconds a ray."""
    options = {"rounds": rounds, "rays": rays, "only": ",".join(RAYS)}
    source = f"{family}:{triangles}"
    launch = program.launch(family, source, 1, rivals="embree", count=1, **options)
    figures = []
    for cell in cells_of([launch]):
        ours, theirs = cell.best(HALFLINE), cell.best(EMBREE)
        assert ours is not None
        assert theirs is not None
        figures.append(
            {
                "family": family,
                "triangles": launch["triangles"],
                "rays": cell.rays,
                "halfline_nanoseconds": ours.seconds / cell.count * 1e9,
                "embree_nanoseconds": theirs.seconds / cell.count * 1e9,
                "embree_config": theirs.way,
                "ratio": theirs.seconds / ours.seconds,
                **{name: cell.work[name] for name in COUNTS},
            }
        )
    return figures


def print_figures(family: str, rays: str, figures: list[dict[str, Any]]) -> None:
    """The sizes of one family, one below the other."""
    rows = [["triangles", "halfline ns", "Embree ns", "ratio", "Embree's best"]]
    rows[0] += [name.removesuffix("_per_ray").replace("_", " ") for name in COUNTS]
    for row in figures:
        times = [f"{row[f'{tool}_nanoseconds']:.0f}" for tool in ("halfline", "embree")]
        counts = [f"{row[name]:.{3 if name == 'exact_per_ray' else 1}f}" for name in COUNTS]
        told = [*times, f"{row['ratio']:.2f}", row["embree_config"], *counts]
        rows.append([f"{row['triangles']:,}", *told])
    print_table(f"{family}, {rays} rays: medians per ray", rows)


def grow(options: argparse.Namespace) -> None:
    """Measures, prints, writes."""
    OUT.mkdir(parents=True, exist_ok=True)
    program = Program.built(options.core)
    figures: list[dict[str, Any]] = []
    for triangles in options.sizes:
        for family in FAMILIES:
            print(f"{family}, {triangles:,} triangles", flush=True)
            figures += measure(program, family, triangles, options.rays, options.rounds)
    for family in FAMILIES:
        for rays in RAYS:
            wanted = [row for row in figures if (row["family"], row["rays"]) == (family, rays)]
            print_figures(family, rays, wanted)
    (OUT / "growth.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    charts.growth.main()
    print("\nEverything is in bench/out: growth.json, and a chart, growth.svg.")


def main() -> int:
    """The whole measurement."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--rounds", type=int, default=3, help="turns of each tool")
    parser.add_argument("--rays", type=int, default=200_000, help="rays of each kind, at most")
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, help="triangles")
    parser.add_argument("--core", type=int, default=0, help="what the thread is pinned to")
    try:
        grow(parser.parse_args())
    except (ToolError, OSError) as error:
        print(f"bench growth: {error}", file=sys.stderr)
        return 1
    return 0
