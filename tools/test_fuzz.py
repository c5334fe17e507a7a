"""Fuzzing: the table tells what the logs say, and no crash is overlooked."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import fuzz

FINISHED = """\
#2\tINITED cov: 40 ft: 41 corp: 1/5b exec/s: 0 rss: 30Mb
#512\tNEW    cov: 97 ft: 120 corp: 9/80b lim: 4 exec/s: 0 rss: 31Mb L: 3/3 MS: 1 ChangeBit-
#9000\tDONE   cov: 97 ft: 130 corp: 11/90b lim: 80 exec/s: 900 rss: 35Mb
stat::number_of_executed_units: 9000
stat::average_exec_per_sec:     900
"""


def test_a_finished_target_is_summed_up() -> None:
    outcome = fuzz.outcome_of("ply", 10.0, FINISHED, exit_code=0, new_artifacts=0)
    assert outcome == fuzz.Outcome("ply", 10.0, executions=9000, coverage=97, crashes=0)
    assert fuzz.table([outcome]).splitlines()[1].split() == ["ply", "10", "9,000", "900", "97", "0"]


def test_a_target_that_was_killed_counts_as_crashed() -> None:
    killed = FINISHED.split("#9000")[0]
    outcome = fuzz.outcome_of("ply", 3.0, killed, exit_code=-9, new_artifacts=0)
    assert (outcome.executions, outcome.crashes) == (512, 1)


def test_a_target_that_never_began_has_crashed_too() -> None:
    outcome = fuzz.outcome_of("ply", 0.0, "", exit_code=127, new_artifacts=0)
    assert (outcome.executions, outcome.executions_per_second, outcome.crashes) == (0, 0, 1)


@pytest.mark.parametrize(
    ("script", "expected"),
    [
        ("exit 1", "missing: a nightly compiler (rustup toolchain install nightly)"),
        ('[ "$1" != fuzz ]', "missing: cargo-fuzz (cargo install cargo-fuzz --locked)"),
    ],
)
def test_what_is_missing_is_said_in_one_line(tmp_path: Path, script: str, expected: str) -> None:
    cargo = tmp_path / "cargo"
    cargo.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    cargo.chmod(0o755)
    done = subprocess.run(
        [sys.executable, str(Path(fuzz.__file__))],
        env=os.environ | {"PATH": f"{tmp_path}:/bin"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"{expected}\n")
