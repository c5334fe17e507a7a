"""From a file to a picture: `halfline render` against VTK's software rasteriser.

Run by `make bench-vtk`. Both read the generated scan of 5.2 million triangles from binary PLY, look
at it the same way, and write a PNG of 1280 x 720; halfline takes one sample a pixel, and casts
shadows and looks at how hidden a place is besides, which VTK does not. VTK is asked through
PyVista, off-screen, and draws with Mesa on the processor, on as many threads as it likes; so does
halfline. What is measured is each whole process on the wall, in turns, medians, after one turn that
does not count; told is also what PyVista needs without importing itself. Writes bench/out/vtk.json
and the two pictures, vtk-halfline.png and vtk-pyvista.png.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from common.embree_program import spread
from common.harness import (
    OUT,
    ROOT,
    ToolError,
    make_environment,
    print_table,
    processor,
    run,
    tool_command,
)

TRIANGLES = 5_200_000
SIZE = "1280,720"

# How VTK draws without a screen, in the order of trying, and what Debian calls what they need.
WINDOWS = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")
PACKAGES = "libegl1 and libgl1-mesa-dri, or libosmesa6"

Command = Sequence[str | Path]


def timed(command: Command) -> dict[str, Any]:
    """Runs a tool that ends with a JSON object, and adds what its process took."""
    start = time.perf_counter()
    done = run(command, os.cpu_count() or 1)
    seconds = time.perf_counter() - start
    report = json.loads(done.stdout[done.stdout.index("{") :])
    return {
        **report,
        "process_seconds": seconds,
        "process_cpu_seconds": done.cpu_seconds,
        "process_peak_bytes": done.peak_bytes,
    }


def halfline_command(halfline: Path, mesh: Path, view: dict[str, Any]) -> Command:
    """Draws the mesh with halfline; as soon as it can, if it can choose that."""

    def vector(name: str) -> str:
        return ",".join(str(x) for x in view[name])

    known = run([halfline, "render", "--help"], 1).stdout
    preset = ["--preset", "fast"] if "--preset" in known else []
    camera = ["--up", "+Z", "--camera-position", vector("position")]
    camera += ["--camera-focal-point", vector("focal_point")]
    camera += ["--camera-view-angle", str(view["angle_degrees"])]
    output = ["-o", str(OUT / "vtk-halfline.png"), "--resolution", SIZE, "--samples", "1"]
    return [halfline, "render", mesh, *output, *camera, *preset, "--json", "--quiet"]


def pyvista_command(mesh: Path, view: dict[str, Any]) -> Command:
    """Draws the mesh with PyVista, in the first way that works here."""
    python = make_environment("pyvista") / "bin" / "python"
    picture = OUT / "vtk-pyvista.png"
    reason = ""
    for window in WINDOWS:
        # On the processor, even where there is something better.
        variables = [f"VTK_DEFAULT_OPENGL_WINDOW={window}", "LIBGL_ALWAYS_SOFTWARE=1"]
        drawing = tool_command(python, "vtk.pyvista", mesh, picture, json.dumps(view), SIZE)
        command: Command = ["env", *variables, *drawing]
        try:
            timed(command)
        except ToolError as error:
            reason = re.sub("\x1b\\[[0-9;]*m", "", str(error))
        else:
            return command
    raise ToolError(f"cannot draw without a screen, which takes {PACKAGES}: {reason}")


def print_turns(turns: dict[str, list[dict[str, Any]]]) -> dict[str, float]:
    """The medians, in a table; returns those of the whole processes."""
    rows = [["", "whole process s", "spread", "CPU s", "peak MB", "of which s"]]
    medians = {}
    for name, reports in turns.items():

        def middle(key: str, reports: list[dict[str, Any]] = reports) -> float:
            return float(median(report[key] for report in reports))

        parts = [
            f"{key.removesuffix('_seconds')} {middle(key):.2f}"
            for key in reports[0]
            if key.endswith("_seconds") and not key.startswith("process_")
        ]
        medians[name] = middle("process_seconds")
        apart = spread([report["process_seconds"] for report in reports])
        told = [f"{middle('process_cpu_seconds'):.2f}", f"{middle('process_peak_bytes') / 1e6:.0f}"]
        rows.append([name, f"{medians[name]:.2f}", f"{apart:.0%}", *told, ", ".join(parts)])
    count = len(next(iter(turns.values())))
    print_table(f"scan of {TRIANGLES:,} triangles, {SIZE}, medians of {count} turns", rows)
    return medians


def race(options: argparse.Namespace) -> None:
    """Prepares, measures, prints, writes."""
    OUT.mkdir(parents=True, exist_ok=True)
    mesh = OUT / f"scan-{TRIANGLES}.ply"
    generate = ["generate", "scan", "--triangles", str(TRIANGLES), "--json", "--quiet"]
    view = json.loads(run([options.halfline, *generate, "-o", mesh], 1).stdout)["view"]
    commands = {"halfline": halfline_command(options.halfline, mesh, view)}
    timed(commands["halfline"])
    left_out = None
    try:
        commands["PyVista"] = pyvista_command(mesh, view)
    except ToolError as error:
        left_out = str(error)
        print(f"PyVista is left out: {error}")

    turns: dict[str, list[dict[str, Any]]] = {name: [] for name in commands}
    for _ in range(options.repetitions):
        for name, command in commands.items():
            turns[name].append(timed(command))
    medians = print_turns(turns)
    answer: dict[str, Any] = {
        "processor": processor(),
        "cores": os.cpu_count(),
        "left_out": left_out,
    }
    if left_out is None:
        theirs = turns["PyVista"][0]
        print(f"\n{theirs['tool']}, drawing with {theirs['renderer']}")
        without = median(
            turn["process_seconds"] - turn["import_seconds"] for turn in turns["PyVista"]
        )
        answer["ratio"] = medians["PyVista"] / medians["halfline"]
        answer["ratio_without_import"] = without / medians["halfline"]
        print(f"PyVista takes {answer['ratio']:.2f} times as long as halfline,", end=" ")
        print(f"{answer['ratio_without_import']:.2f} times without importing itself.")
    output = OUT / "vtk.json"
    output.write_text(
        json.dumps({**answer, "medians": medians, "turns": turns}, indent=1) + "\n",
        encoding="utf-8",
    )
    print(f"Everything measured is in {output.relative_to(ROOT)}, the pictures beside it")


def main() -> int:
    """The whole race."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--halfline", type=Path, required=True, help="the built command")
    parser.add_argument("--repetitions", type=int, default=5, help="turns of each tool")
    try:
        race(parser.parse_args())
    except (ToolError, OSError) as error:
        print(f"bench vtk: {error}", file=sys.stderr)
        return 1
    return 0
