"""What the black-box tests share: the built command, and a mesh with rays."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from children import PATIENCE_SECONDS, set_signals, without_progress
from meshes import Floats, Shape, bumpy_sphere, random_rays, write_ply
from moeller_trumbore import Crossings, crossings

if TYPE_CHECKING:
    from distributed import Client
    from halfline import Scene

set_signals()

ROOT = Path(__file__).resolve().parent.parent.parent


@dataclass(frozen=True)
class Halfline:
    """The command."""

    binary: Path

    def run(self, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
        """Runs it and returns whatever came of it, less what it said of its progress."""
        done = subprocess.run(
            [self.binary, *arguments],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PATIENCE_SECONDS,
            check=False,
        )
        done.stderr = without_progress(done.stderr)
        return done

    def ok(self, *arguments: str | Path) -> str:
        """Runs it, expects success, and returns what it printed on stdout."""
        done = self.run(*arguments)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def json(self, *arguments: str | Path) -> dict[str, Any]:
        """Runs it with --json, and returns the one object on stdout."""
        answer: dict[str, Any] = json.loads(self.ok(*arguments, "--json"))
        return answer

    def fails(self, code: int, *arguments: str | Path) -> str:
        """Runs it, expects the exit code `code`, and returns stderr."""
        done = self.run(*arguments)
        assert done.returncode == code, (done.returncode, done.stdout, done.stderr)
        assert done.stdout == ""
        return done.stderr

    def complains(self, *arguments: str | Path) -> str:
        """Runs it, expects exit code 1 and one line on stderr, and returns that."""
        stderr = self.fails(1, *arguments)
        assert stderr.endswith("\n")
        assert stderr.count("\n") == 1, stderr
        return stderr.rstrip("\n")

    def query(
        self, mesh: Path, rays: np.ndarray[Any, Any], folder: Path, *options: str
    ) -> dict[str, np.ndarray[Any, Any]]:
        """Casts an array of rays at a mesh, and returns the arrays of the answer."""
        np.save(folder / "rays.npy", rays)
        self.ok("query", mesh, folder / "rays.npy", "-o", folder / "hits.npz", *options)
        with np.load(folder / "hits.npz", allow_pickle=False) as hits:
            return dict(hits)


@dataclass(frozen=True)
class Judged:
    """A mesh on disk, rays, and all their crossings by the independent judge."""

    shape: Shape
    path: Path
    rays: Floats
    crossings: Crossings


@pytest.fixture(scope="session")
def halfline() -> Halfline:
    """The built command: HALFLINE_BIN, or what cargo left in target/."""
    named = os.environ.get("HALFLINE_BIN")
    candidates = (
        [Path(named)]
        if named
        else [ROOT / "target" / profile / "halfline" for profile in ("release", "debug")]
    )
    for candidate in candidates:
        if candidate.is_file():
            return Halfline(candidate.resolve())
    pytest.fail(f"no halfline at {' or '.join(map(str, candidates))}: run make test")


@pytest.fixture(scope="session")
def judged(tmp_path_factory: pytest.TempPathFactory) -> Judged:
    """The bumpy sphere as PLY and 2,000 random rays.

    The rays are exact in single precision, so that files of either precision ask the same.
    """
    shape = bumpy_sphere()
    rays = random_rays(2000, seed=1).astype(np.float32).astype(np.float64)
    path = write_ply(tmp_path_factory.mktemp("judged") / "bumpy.ply", shape)
    found = crossings(shape, rays)
    assert found.unsure.mean() < 0.001
    return Judged(shape, path, rays, found)


@pytest.fixture(scope="session")
def halfline_info(halfline: Halfline, judged: Judged) -> dict[str, Any]:
    """What the command says about the judged mesh."""
    return halfline.json("info", judged.path)


@pytest.fixture(scope="session")
def halfline_command(halfline: Halfline) -> Halfline:
    """The command, for tests that import the package of the same name."""
    return halfline


@pytest.fixture(scope="session")
def scene(judged: Judged, tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """The judged mesh from a tree file."""
    import halfline

    path = tmp_path_factory.mktemp("tree") / "bumpy.hlt"
    halfline.Scene(halfline.load(judged.path)).save(path)
    return halfline.open(path)


@pytest.fixture(scope="session")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    """A cluster of two worker processes with one thread each, which any test may kill."""
    from clusters import cluster

    with cluster({}, {}, folder=tmp_path_factory.mktemp("cluster")) as client:
        yield client
