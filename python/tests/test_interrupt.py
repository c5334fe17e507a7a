"""Ctrl-C ends the work within a second, with exit code 130 and nothing half written."""

from __future__ import annotations

import signal
import subprocess
import time
from pathlib import Path

import numpy as np
from conftest import Halfline, Judged

# What is promised, and a margin for a machine that does much else.
PATIENCE_SECONDS = 1.0 + 2.0


def interrupt_after(seconds: float, command: list[str | Path]) -> tuple[int, str, float]:
    """Starts a command and sends it SIGINT; gives its exit code, stderr, and how long it took."""
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        time.sleep(seconds)
        assert process.poll() is None, "it ended before it could be interrupted"
        process.send_signal(signal.SIGINT)
        begin = time.monotonic()
        _, stderr = process.communicate(timeout=60)
        return process.returncode, stderr.decode(), time.monotonic() - begin


def test_a_render_can_be_interrupted(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    picture = tmp_path / "picture.png"
    size = ["--resolution", "2000,2000", "--samples", "4096"]
    command: list[str | Path] = [halfline.binary, "render", judged.path, "-o", picture, *size]
    code, stderr, seconds = interrupt_after(1.0, command)
    assert code == 130
    assert seconds < PATIENCE_SECONDS
    assert stderr.splitlines()[-1].endswith("interrupted")
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_render_leaves_the_old_picture(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    picture = tmp_path / "picture.png"
    picture.write_bytes(b"old")
    size = ["--resolution", "2000,2000", "--samples", "4096"]
    command: list[str | Path] = [halfline.binary, "render", judged.path, "-o", picture, *size]
    code, _, _ = interrupt_after(0.5, command)
    assert code == 130
    assert picture.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [picture]


def test_a_query_can_be_interrupted(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    rays = tmp_path / "rays.npy"
    np.save(rays, np.tile(judged.rays, (500, 1)))
    command: list[str | Path] = [halfline.binary, "query", judged.path, rays]
    command += ["-o", tmp_path / "hits.npz", "--engine", "brute"]
    code, _, seconds = interrupt_after(1.0, command)
    assert code == 130
    assert seconds < PATIENCE_SECONDS
    assert list(tmp_path.iterdir()) == [rays]


def test_a_doctor_can_be_interrupted(halfline: Halfline, tmp_path: Path) -> None:
    mesh = tmp_path / "sphere.ply"
    halfline.ok("generate", "sphere", "-n", "400k", "-o", mesh)
    command: list[str | Path] = [halfline.binary, "doctor", mesh, "--rays", "100M"]
    code, stderr, seconds = interrupt_after(1.5, command)
    assert code == 130
    assert seconds < PATIENCE_SECONDS
    assert stderr.splitlines()[-1].endswith("interrupted")
