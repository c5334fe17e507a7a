#!/usr/bin/env python3
"""What compiling costs: the demo, all tests, and the engine's tests again after an edit.

Run by `make build-times`. Each part builds in a new target folder, which is removed afterwards, and
prints CPU seconds (user and system, of cargo and all that it starts) and seconds on the wall. CPU
seconds hardly depend on what else the machine does; seconds on the wall do.

- demo: the command as `make demo` builds it; and which crates took most of that, and which
  functions of halfline have the most code in it.
- tests: all programs that `make test` runs.
- edit: a line is put into the test of a leaf's triangles, the engine's tests are compiled again,
  and each is started, to list what it has. The file is put back as it was, with its time.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

from demo import BUILD as BUILD_DEMO
from demo import ROOT

CARGO = os.environ.get("CARGO", "cargo")
BUILD_TESTS = [
    [CARGO, "build", "--locked", "--workspace", "--all-targets"],
    [CARGO, "test", "--locked", "--workspace", "--no-run"],
]
# Documentation's examples are left out: rustdoc compiles each anew, whatever was edited.
ENGINE_TESTS = [CARGO, "test", "--locked", "--package", "halfline", "--lib", "--tests"]

# The test of a ray against a leaf's triangles; the first that is there.
LEAF_TESTS = ("crates/halfline/src/intersect/filter_f32.rs",)
EDIT = b"// An edit of tools/build_times.py, which takes it back.\n"

PARTS = ("demo", "tests", "edit")
LISTED = 10

# Where this script, as cargo's RUSTC_WRAPPER, writes what each crate took.
CRATES_FILE = "HALFLINE_BUILD_TIMES_CRATES"


class BuildError(Exception):
    """What cannot be measured, in one line."""


@dataclass(frozen=True)
class Cost:
    """What some commands took together."""

    cpu_seconds: float
    wall_seconds: float


@dataclass(frozen=True)
class Crate:
    """What compiling a crate took, build script and all."""

    name: str
    cpu_seconds: float


@dataclass(frozen=True)
class Function:
    """A function, and how much machine code it has."""

    name: str
    bytes: int


@dataclass
class Report:
    """Everything measured; a part that was not asked for is missing."""

    processor: str
    cores: int
    load_before: float
    """Processes that wanted a core in the minute before."""
    costs: dict[str, Cost] = field(default_factory=dict)
    crates: list[Crate] = field(default_factory=list)
    functions: list[Function] = field(default_factory=list)


def processor() -> str:
    """What the machine's processor calls itself."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except FileNotFoundError:
        asked = subprocess.run(
            ["sysctl", "-n", "machdep.cpu.brand_string"],
            capture_output=True,
            text=True,
            check=False,
        )
        return asked.stdout.strip() or "unknown processor"
    found = re.search(r"^model name\s*:\s*(.*)$", text, re.MULTILINE)
    return found[1] if found else "unknown processor"


def children_cpu_seconds() -> float:
    """What all processes took that this one has waited for, and theirs."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def cost_of(commands: Sequence[Sequence[str]], target: Path, **variables: str) -> Cost:
    """Runs commands of cargo that build into `target`, one after the other."""
    environment = {**os.environ, "CARGO_TARGET_DIR": str(target), **variables}
    cpu, wall = children_cpu_seconds(), time.monotonic()
    for command in commands:
        print("$", *command, flush=True)
        done = subprocess.run(
            command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, check=False
        )
        if done.returncode != 0:
            raise BuildError(f"{' '.join(command)} failed, see above")
    return Cost(children_cpu_seconds() - cpu, time.monotonic() - wall)


@contextmanager
def new_target() -> Iterator[Path]:
    """A folder for what is built, on the disk where that lies anyway; removed at the end."""
    parent = ROOT / "target"
    parent.mkdir(exist_ok=True)
    folder = Path(tempfile.mkdtemp(prefix="build-times-", dir=parent))
    try:
        yield folder
    finally:
        # A compiler that an interrupt left alone may still write there.
        shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def edited(path: Path) -> Iterator[None]:
    """A line more at the beginning of a file, which shifts all others; put back at the end.

    A new line makes the compiler generate the code below it again, since that says from which lines
    it comes.
    """
    before, times = path.read_bytes(), path.stat()
    try:
        path.write_bytes(EDIT + before)
        yield
    finally:
        path.write_bytes(before)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def find_leaf_test() -> Path:
    """The file that is edited."""
    for name in LEAF_TESTS:
        if (ROOT / name).is_file():
            return ROOT / name
    raise BuildError(f"none of {', '.join(LEAF_TESTS)} is there: name the leaf test in LEAF_TESTS")


def compile_crate(command: Sequence[str], record: Path) -> int:
    """As cargo's wrapper: runs the compiler, and adds a line on what it took to `record`."""
    code = subprocess.run(command, check=False).returncode
    # Cargo also asks the compiler what it is, for no package.
    name = os.environ.get("CARGO_PKG_NAME", CARGO)
    own = resource.getrusage(resource.RUSAGE_SELF)
    line = f"{name}\t{children_cpu_seconds()}\t{own.ru_utime + own.ru_stime}\n"
    # One write: other compilers append to the same file.
    with record.open("a", encoding="utf-8") as lines:
        lines.write(line)
    return code


def read_crates(record: Path) -> tuple[list[Crate], float]:
    """The crates of a build, the slowest first, and what this script's own processes took."""
    seconds: dict[str, float] = {}
    own = 0.0
    for line in record.read_text(encoding="utf-8").splitlines():
        name, compiler, wrapper = line.split("\t")
        seconds[name] = seconds.get(name, 0.0) + float(compiler)
        own += float(wrapper)
    crates = [Crate(name, taken) for name, taken in seconds.items()]
    return sorted(crates, key=lambda crate: -crate.cpu_seconds), own


def read_functions(program: Path) -> list[Function]:
    """The functions of halfline's crates in a program, those with the most code first."""
    if shutil.which("nm") is None:
        print("sizes of functions are left out: no nm (on Debian: apt install binutils)")
        return []
    command = ["nm", "--print-size", "--size-sort", "--reverse-sort", "--demangle", str(program)]
    listed = subprocess.run(command, capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        print(f"sizes of functions are left out: {listed.stderr.strip().splitlines()[-1]}")
        return []
    return functions_of(listed.stdout)


def functions_of(listing: str) -> list[Function]:
    """The functions of halfline's crates in what nm prints: address, size, kind, name."""
    functions = []
    for line in listing.splitlines():
        match = re.fullmatch(r"[0-9a-f]+ ([0-9a-f]+) [tTwW] (.*)", line)
        if match and re.search(r"\bhalfline(_\w+)?(\[[0-9a-f]+\])?::", match[2]):
            # The compiler's hash at the end tells nothing.
            name = re.sub(r"::h[0-9a-f]{16}$", "", match[2])
            functions.append(Function(name, int(match[1], 16)))
    return sorted(functions, key=lambda function: -function.bytes)


def measure_demo(report: Report) -> None:
    """The demo's build, its crates, its functions."""
    with new_target() as target:
        record = target / "crates.tsv"
        wrapper = {"RUSTC_WRAPPER": str(Path(__file__).resolve()), CRATES_FILE: str(record)}
        cost = cost_of([BUILD_DEMO], target, **wrapper)
        report.crates, own = read_crates(record)
        report.costs["demo"] = replace(cost, cpu_seconds=cost.cpu_seconds - own)
        report.functions = read_functions(target / "release" / "halfline")


def measure_tests(report: Report) -> None:
    """The build of all tests."""
    with new_target() as target:
        report.costs["tests"] = cost_of(BUILD_TESTS, target)


def measure_edit(report: Report) -> None:
    """The engine's tests, after an edit."""
    leaf_test = find_leaf_test()
    with new_target() as target:
        report.costs["engine's tests"] = cost_of([[*ENGINE_TESTS, "--no-run"]], target)
        with edited(leaf_test):
            cost = cost_of([[*ENGINE_TESTS, "--", "--list"]], target)
        report.costs["engine's tests after an edit"] = cost


def print_report(report: Report) -> None:
    """One small table, and what is below it."""
    print(f"\n{report.processor}, {report.cores} cores, load {report.load_before:.1f} before")
    print("| build | CPU s | wall s |\n| --- | --: | --: |")
    for name, cost in report.costs.items():
        print(f"| {name} | {cost.cpu_seconds:.0f} | {cost.wall_seconds:.0f} |")
    if report.crates:
        print("\nthe demo's slowest crates, CPU s")
        for crate in report.crates[:LISTED]:
            print(f"{crate.cpu_seconds:8.1f}  {crate.name}")
    if report.functions:
        print("\nhalfline's functions with the most code, kB")
        for function in report.functions[:LISTED]:
            print(f"{function.bytes / 1e3:8.1f}  {function.name}")


def measure(options: argparse.Namespace) -> None:
    """Measures, prints, writes."""
    if "edit" in options.parts:
        find_leaf_test()
    # What is downloaded first is not compiled, and so does not count.
    subprocess.run([CARGO, "fetch", "--locked", "--quiet"], cwd=ROOT, check=True)
    report = Report(processor(), os.cpu_count() or 1, os.getloadavg()[0])
    steps = {"demo": measure_demo, "tests": measure_tests, "edit": measure_edit}
    for part in PARTS:
        if part in options.parts:
            steps[part](report)
    print_report(report)
    if options.json:
        options.json.write_text(json.dumps(asdict(report), indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """The whole measurement; or one crate's compiler, if cargo calls."""
    if record := os.environ.get(CRATES_FILE):
        return compile_crate(sys.argv[1:], Path(record))
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS, help="[default: all]")
    parser.add_argument("--json", type=Path, metavar="FILE", help="everything measured")
    # What is edited is put back, and what is built removed, however this ends.
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)
    try:
        measure(parser.parse_args())
    except (BuildError, OSError) as error:
        print(f"build_times.py: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
