"""Ctrl-C ends the work within a second, with exit code 130 and nothing half written."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path

import numpy as np
from children import interrupt, wait_until_it_listens
from conftest import Halfline, Judged


def interrupt_after(seconds: float, command: list[str | Path]) -> tuple[int, str]:
    """Starts a command and sends it SIGINT while it works; gives its exit code and stderr."""
    with subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        wait_until_it_listens(process)
        time.sleep(seconds)
        _, stderr = interrupt(process)
        return process.returncode, stderr


def test_a_render_can_be_interrupted(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    picture = tmp_path / "picture.png"
    size = ["--resolution", "2000,2000", "--samples", "4096"]
    command: list[str | Path] = [halfline.binary, "render", judged.path, "-o", picture, *size]
    code, stderr = interrupt_after(1.0, command)
    assert code == 130
    assert stderr == "halfline: interrupted\n"
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_render_leaves_the_old_picture(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    picture = tmp_path / "picture.png"
    picture.write_bytes(b"old")
    size = ["--resolution", "2000,2000", "--samples", "4096"]
    command: list[str | Path] = [halfline.binary, "render", judged.path, "-o", picture, *size]
    code, _ = interrupt_after(0.5, command)
    assert code == 130
    assert picture.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [picture]


def test_a_query_can_be_interrupted(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    rays = tmp_path / "rays.npy"
    np.save(rays, np.tile(judged.rays, (500, 1)))
    command: list[str | Path] = [halfline.binary, "query", judged.path, rays]
    command += ["-o", tmp_path / "hits.npz", "--engine", "brute"]
    code, _ = interrupt_after(1.0, command)
    assert code == 130
    assert list(tmp_path.iterdir()) == [rays]


def test_a_doctor_can_be_interrupted(halfline: Halfline, tmp_path: Path) -> None:
    mesh = tmp_path / "sphere.ply"
    halfline.ok("generate", "sphere", "-n", "400k", "-o", mesh)
    command: list[str | Path] = [halfline.binary, "doctor", mesh, "--rays", "100M"]
    code, stderr = interrupt_after(1.5, command)
    assert code == 130
    assert stderr == "halfline: interrupted\n"
