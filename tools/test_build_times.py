"""Build times: what is edited is put back, and what cargo, compiler and nm say is counted."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import build_times
import pytest

LISTING = """\
0000000000a81230 000000000000a3f1 t <halfline::traverse::Cast<Q> as Job>::run::h0123456789abcdef
0000000000a00000 0000000000010000 T core::sort::sort
0000000000a11230 0000000000000101 t halfline_render::tile::Brush::draw::hfedcba9876543210
0000000000a21230 00000000000f0000 r halfline::tree::TABLE
                 U halfline::nothing
"""


def test_functions_are_those_of_halfline_and_the_largest_is_first() -> None:
    assert build_times.functions_of(LISTING) == [
        build_times.Function("<halfline::traverse::Cast<Q> as Job>::run", 0xA3F1),
        build_times.Function("halfline_render::tile::Brush::draw", 0x101),
    ]


def test_an_edit_changes_the_file_and_is_taken_back(tmp_path: Path) -> None:
    path = tmp_path / "leaf.rs"
    path.write_bytes(b"//! Doc.\r\nfn f() {}")
    os.utime(path, ns=(1_000_000_007, 2_000_000_011))

    def interrupted() -> None:
        with build_times.edited(path):
            assert path.read_bytes() == build_times.EDIT + b"//! Doc.\r\nfn f() {}"
            assert path.stat().st_mtime_ns != 2_000_000_011
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_bytes() == b"//! Doc.\r\nfn f() {}"
    assert path.stat().st_mtime_ns == 2_000_000_011


def test_the_leaf_test_is_there() -> None:
    assert build_times.find_leaf_test().is_file()


def test_a_leaf_test_that_went_away_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build_times, "LEAF_TESTS", ("a.rs", "b.rs"))
    with pytest.raises(build_times.BuildError, match=r"none of a\.rs, b\.rs is there"):
        build_times.find_leaf_test()


def test_as_a_wrapper_it_runs_the_compiler_and_notes_what_that_took(tmp_path: Path) -> None:
    record = tmp_path / "crates.tsv"
    script = "import sys, time\nwhile time.process_time() < 0.2: pass\nsys.exit(3)"
    for name in ("slow", "slow", "quick"):
        wrapped = [sys.executable, "-c", script if name == "slow" else "print('out')"]
        environment = {build_times.CRATES_FILE: str(record), "CARGO_PKG_NAME": name}
        done = subprocess.run(
            [sys.executable, build_times.__file__, *wrapped],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            check=False,
        )
        outcome = (3, "") if name == "slow" else (0, "out\n")
        assert (done.returncode, done.stdout) == outcome
    crates, own = build_times.read_crates(record)
    assert [crate.name for crate in crates] == ["slow", "quick"]
    assert crates[0].cpu_seconds >= 0.4
    assert own > 0


def test_the_cost_is_that_of_all_processes(tmp_path: Path) -> None:
    busy = "import time\nwhile time.process_time() < 0.2: pass"
    child = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {busy!r}])"
    cost = build_times.cost_of([[sys.executable, "-c", child]], tmp_path)
    assert cost.cpu_seconds >= 0.2
    assert cost.wall_seconds >= 0.2


def test_a_build_that_fails_is_named(tmp_path: Path) -> None:
    with pytest.raises(build_times.BuildError, match="-c raise SystemExit"):
        build_times.cost_of([[sys.executable, "-c", "raise SystemExit(1)"]], tmp_path)
