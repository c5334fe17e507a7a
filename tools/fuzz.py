#!/usr/bin/env python3
"""Runs every fuzz target side by side in the background, then says what each did.

Run by `make fuzz`. Each target is one process of lowest priority; its output goes to
fuzz/logs/TARGET.log, inputs that reach something new to fuzz/corpus/TARGET, inputs that crash it
to fuzz/artifacts/TARGET. A target ends at its first crash. Exit code 1 tells of crashes, 2 of
something that is missing.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FUZZ = ROOT / "fuzz"

# Seconds within which every input has to be done with, though all targets share the processors.
TIMEOUT_SECONDS = 10
# A process holds this much at most; half of it is the sanitizer's own.
RSS_LIMIT_MB = 1024
# No single allocation for an input of kilobytes may be larger ...
MALLOC_LIMIT_MB = 64
# ... but for those that inflate: images of 2^24 pixels, gzip streams of 64 MiB, held in an array
# that doubles as it grows.
INFLATING = {"gltf": 256, "gzip": 256}
LONGEST_INPUT = 4096

# How a target ends that found nothing.
EXIT_CLEAN = 0


class MissingError(Exception):
    """What is needed and is not there, in one line."""


@dataclass(frozen=True)
class Outcome:
    """What a target did, as its log tells."""

    target: str
    seconds: float
    executions: int
    coverage: int
    crashes: int

    @property
    def executions_per_second(self) -> float:
        """By the clock, and so beside all other targets."""
        return self.executions / self.seconds if self.seconds > 0 else 0.0


def numbers(pattern: str, log: str) -> list[int]:
    """Every number that `pattern` captures."""
    return [int(number) for number in re.findall(pattern, log, re.MULTILINE)]


def outcome_of(
    target: str, seconds: float, log: str, exit_code: int, new_artifacts: int
) -> Outcome:
    """Reads a target's log. A process that fails has crashed, whether it left an input or not."""
    executed = numbers(r"stat::number_of_executed_units: +(\d+)", log) or numbers(r"^#(\d+)", log)
    coverage = numbers(r"\bcov: (\d+)", log)
    crashes = new_artifacts if exit_code == EXIT_CLEAN else max(new_artifacts, 1)
    return Outcome(
        target,
        seconds,
        executions=executed[-1] if executed else 0,
        coverage=coverage[-1] if coverage else 0,
        crashes=crashes,
    )


def table(outcomes: list[Outcome]) -> str:
    """One line for each target."""
    lines = [
        f"{'target':<16}{'seconds':>8}{'executions':>13}{'exec/s':>9}{'coverage':>10}{'crashes':>9}"
    ]
    lines += [
        f"{o.target:<16}{o.seconds:>8.0f}{o.executions:>13,}{o.executions_per_second:>9,.0f}"
        f"{o.coverage:>10,}{o.crashes:>9}"
        for o in outcomes
    ]
    return "\n".join(lines)


def check_tools() -> None:
    """Fails in one line unless cargo-fuzz and a nightly compiler are there."""
    for command, what in [
        (
            ["cargo", "+nightly", "--version"],
            "a nightly compiler (rustup toolchain install nightly)",
        ),
        (["cargo", "fuzz", "--version"], "cargo-fuzz (cargo install cargo-fuzz --locked)"),
    ]:
        try:
            done = subprocess.run(command, capture_output=True, check=False)
        except FileNotFoundError:
            raise MissingError("missing: cargo (https://rustup.rs)") from None
        if done.returncode != 0:
            raise MissingError(f"missing: {what}")


def binaries() -> dict[str, Path]:
    """Builds all targets, and says where they are."""
    command = ["cargo", "metadata", "--locked", "--no-deps", "--format-version", "1"]
    manifest = ["--manifest-path", str(FUZZ / "Cargo.toml")]
    metadata = json.loads(subprocess.run([*command, *manifest], stdout=-1, check=True).stdout)
    targets = [t["name"] for t in metadata["packages"][0]["targets"] if t["kind"] == ["bin"]]
    version = ["rustc", "+nightly", "--version", "--verbose"]
    about = subprocess.run(version, stdout=subprocess.PIPE, text=True, check=True).stdout
    host = about.split("host: ")[1].split()[0]

    # A place of their own: other flags would build everything else again as well.
    folder = Path(metadata["target_directory"]) / "fuzz"
    build = ["cargo", "+nightly", "fuzz", "build", "--target", host, "--target-dir", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True)
    return {target: folder / host / "release" / target for target in targets}


def command_of(target: str, binary: Path, seconds: int, longest: int) -> list[str]:
    """How to run a target; what it finds goes to the first of the folders at the end."""
    dictionary = FUZZ / "dictionaries" / f"{target}.dict"
    return [
        str(binary),
        f"-max_total_time={seconds}",
        f"-timeout={TIMEOUT_SECONDS}",
        f"-rss_limit_mb={RSS_LIMIT_MB}",
        f"-malloc_limit_mb={INFLATING.get(target, MALLOC_LIMIT_MB)}",
        f"-max_len={longest}",
        "-print_final_stats=1",
        f"-artifact_prefix={FUZZ / 'artifacts' / target}/",
        *([f"-dict={dictionary}"] if dictionary.is_file() else []),
        str(FUZZ / "corpus" / target),
        str(FUZZ / "seeds" / target),
    ]


def run(wanted: dict[str, Path], seconds: int, scratch: str) -> list[Outcome]:
    """Runs the targets side by side until the last has ended; their own files go to `scratch`."""
    # The sanitizer remembers freed memory and where it came from; half of the limit is enough.
    sanitizer = "quarantine_size_mb=64:malloc_context_size=8:detect_odr_violation=0"
    environment = os.environ | {"ASAN_OPTIONS": sanitizer, "TMPDIR": scratch}
    symbolizer = shutil.which("llvm-symbolizer")
    if symbolizer is not None:
        environment |= {"ASAN_SYMBOLIZER_PATH": symbolizer}
    (FUZZ / "logs").mkdir(exist_ok=True)

    processes: dict[str, subprocess.Popen[bytes]] = {}
    before: dict[str, set[Path]] = {}
    start = time.monotonic()
    for target, binary in wanted.items():
        for kind in ("corpus", "artifacts"):
            (FUZZ / kind / target).mkdir(parents=True, exist_ok=True)
        before[target] = set((FUZZ / "artifacts" / target).iterdir())
        command = command_of(target, binary, seconds, LONGEST_INPUT)
        with (FUZZ / "logs" / f"{target}.log").open("wb") as log:
            processes[target] = subprocess.Popen(
                ["nice", "-n", "19", *command], stdout=log, stderr=log, env=environment
            )

    # Wait, and note when each ends.
    ended: dict[str, float] = {}
    try:
        while len(ended) < len(processes):
            for target, process in processes.items():
                if target not in ended and process.poll() is not None:
                    ended[target] = time.monotonic() - start
                    verdict = "done" if process.returncode == EXIT_CLEAN else "CRASHED"
                    print(f"{target}: {verdict} after {ended[target]:.0f} s", flush=True)
            time.sleep(0.2)
    finally:
        for process in processes.values():
            if process.poll() is None:
                process.terminate()
                process.wait()

    outcomes = []
    for target, process in processes.items():
        text = (FUZZ / "logs" / f"{target}.log").read_text(encoding="utf-8", errors="replace")
        new = set((FUZZ / "artifacts" / target).iterdir()) - before[target]
        # An input that was slow beside all other work is no crash; one that hangs is a timeout.
        new = {path for path in new if not path.name.startswith("slow-unit")}
        outcomes.append(outcome_of(target, ended[target], text, process.returncode, len(new)))
    return outcomes


def main() -> int:
    """Runs the wanted targets, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=int, default=1800, help="for each target")
    parser.add_argument("target", nargs="*", help="which to run; all, if none is named")
    arguments = parser.parse_args()
    try:
        check_tools()
    except MissingError as error:
        print(error, file=sys.stderr)
        return 2
    built = binaries()
    unknown = [target for target in arguments.target if target not in built]
    if unknown:
        print(f"no target {unknown[0]}: there are {', '.join(built)}", file=sys.stderr)
        return 2
    wanted = {target: built[target] for target in arguments.target or built}
    print(f"{len(wanted)} targets, {arguments.seconds} s each, side by side", flush=True)
    in_memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(dir=in_memory if in_memory.is_dir() else None) as scratch:
        outcomes = run(wanted, arguments.seconds, scratch)
    print(table(outcomes))
    return 1 if any(outcome.crashes for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
