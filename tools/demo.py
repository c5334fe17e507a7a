#!/usr/bin/env python3
"""The demonstration: a scan of 5.5 million triangles, generated and rendered as a user would.

Run by `make demo` with the path at which cargo puts the command. That is built first, without what
a picture of a scan does not need; but a whole command that is already there stays whole.
"""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

TRIANGLES = 5_500_000
ROOT = Path(__file__).resolve().parent.parent
OUT = Path("out")

BUILD_WHOLE = ["cargo", "build", "--release", "--locked", "--package", "halfline-cli"]
BUILD = [*BUILD_WHOLE, "--no-default-features"]


def build(halfline: str) -> bool:
    """Builds the command, and returns whether it is the whole one."""
    # One that has `query` asks for its arguments and ends with 2, one that lacks it ends with 1.
    whole = Path(halfline).is_file() and (
        subprocess.run([halfline, "query"], capture_output=True, check=False).returncode == 2
    )
    done = subprocess.run(BUILD_WHOLE if whole else BUILD, cwd=ROOT, check=False)
    if done.returncode != 0:
        sys.exit(done.returncode)
    return whole


def run(halfline: str, *arguments: str) -> dict[str, Any]:
    """Runs halfline, shows the command as one would type it, and returns its --json answer."""
    print("$", shlex.join(["halfline", *arguments]), flush=True)
    command = [halfline, *arguments, "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, check=False)
    if done.returncode != 0:
        sys.exit(done.returncode)
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def main() -> None:
    """Builds, generates, renders, and prints what took how long."""
    if len(sys.argv) != 2:
        sys.exit("usage: demo.py HALFLINE")
    halfline = sys.argv[1]
    whole = build(halfline)
    OUT.mkdir(exist_ok=True)
    scan, picture = OUT / "scan.ply", OUT / "scan.png"

    generated = run(halfline, "generate", "scan", "-n", str(TRIANGLES), "-o", str(scan))
    rendered = run(halfline, "render", str(scan), "-o", str(picture), "--up", "+Z")

    print(f"\n{rendered['triangles']:,} triangles")
    stages = {
        "generate the scan": generated["generate_seconds"],
        "write it": generated["write_seconds"],
        "load it": rendered["load_seconds"],
        "build the tree": rendered["build_seconds"],
        "trace": rendered["trace_seconds"],
        "write the picture": rendered["write_seconds"],
    }
    for stage, seconds in stages.items():
        print(f"{stage:<20}{seconds:8.2f} s")
    print(f"{rendered['rays']:,} rays, {rendered['rays_per_second'] / 1e6:.2f} million a second")
    print(f"The picture is {picture.resolve()}")
    if not whole:
        print("`make release` builds the rest of halfline: doctor, query, study, glTF, ...")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
