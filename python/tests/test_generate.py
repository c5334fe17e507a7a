"""`halfline generate`: meshes to try things on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Halfline

KINDS = [
    "scan",
    "sphere",
    "soup",
    "layers",
    "sticks",
    "terrain",
    "hall",
    "balls",
    "gears",
    "mount",
    "rings",
    "teapot",
    "tetra",
    "tree",
]


@pytest.mark.parametrize("kind", KINDS)
def test_a_mesh_of_about_that_size_is_made(halfline: Halfline, tmp_path: Path, kind: str) -> None:
    mesh = tmp_path / f"{kind}.ply"
    halfline.ok("generate", kind, "-n", "20000", "-o", mesh)
    info = halfline.json("info", mesh)
    assert 2_000 <= info["triangles"] <= 200_000
    assert np.isfinite(info["bounds"]).all()


@pytest.mark.parametrize("kind", ["scan", "soup", "sticks", "terrain", "mount"])
def test_the_same_seed_makes_the_same_file(halfline: Halfline, tmp_path: Path, kind: str) -> None:
    def bytes_of(name: str, *options: str) -> bytes:
        path = tmp_path / name
        halfline.ok("generate", kind, "-n", "5000", "-o", path, *options)
        return path.read_bytes()

    first = bytes_of("first.ply", "--seed", "7", "--threads", "1")
    assert bytes_of("again.ply", "--seed", "7", "--threads", "3") == first
    assert bytes_of("other.ply", "--seed", "8") != first


def test_rays_from_outside_leave_a_scan_again(halfline: Halfline, tmp_path: Path) -> None:
    mesh = tmp_path / "scan.ply"
    halfline.ok("generate", "scan", "-n", "20000", "-o", mesh)
    info = halfline.json("info", mesh)
    low, high = np.array(info["bounds"])
    random = np.random.default_rng(3)
    targets = random.uniform(low, high, size=(500, 3))
    directions = random.normal(size=(500, 3))
    away = 3.0 * np.linalg.norm(high - low) / np.linalg.norm(directions, axis=1, keepdims=True)
    rays = np.hstack([targets - away * directions, directions])
    crossings = np.diff(halfline.query(mesh, rays, tmp_path, "--all")["splits"])
    assert crossings.max() >= 2
    assert (crossings % 2 == 0).all()
