"""`halfline render --cluster`: the command lets a cluster work, and tells as always."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from children import PATIENCE_SECONDS, interrupt, wait_until, without_progress
from conftest import Judged
from distributed import Client
from halfline import Scene

COMMAND: tuple[str, ...] = (sys.executable, "-m", "halfline")

SIZE = ("--resolution", "120,90", "--samples", "4", "--up", "+Z", "--ground")


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Runs the command of the package."""
    done = subprocess.run(
        [*COMMAND, *arguments],
        capture_output=True,
        text=True,
        timeout=PATIENCE_SECONDS,
        check=False,
    )
    done.stderr = without_progress(done.stderr)
    return done


@pytest.fixture
def cluster(client: Client) -> tuple[str, str]:
    """The option that names the cluster."""
    assert client.scheduler is not None
    return "--cluster", str(client.scheduler.address)


def test_a_tree_and_a_mesh_give_the_same_picture(
    cluster: tuple[str, str], scene: Scene, judged: Judged, tmp_path: Path
) -> None:
    here, tree, mesh = (tmp_path / name for name in ("here.exr", "tree.exr", "mesh.exr"))
    assert scene.path is not None
    for source, picture, options in [
        (scene.path, here, ()),
        (scene.path, tree, cluster),
        (judged.path, mesh, cluster),
    ]:
        done = run("render", source, "-o", picture, *SIZE, *options)
        assert (done.returncode, done.stderr) == (0, "")
        assert (" on tcp://127.0.0.1:" in done.stdout) == bool(options)
    assert here.read_bytes() == tree.read_bytes() == mesh.read_bytes()
    # The mesh's tree is gone.
    assert sorted(tmp_path.iterdir()) == sorted([here, tree, mesh])


def test_json_has_the_same_figures(
    cluster: tuple[str, str], judged: Judged, tmp_path: Path
) -> None:
    def figures(*options: str) -> dict[str, Any]:
        done = run("render", judged.path, "-o", tmp_path / "picture.png", *SIZE, "--json", *options)
        assert done.stderr == ""
        found: dict[str, Any] = json.loads(done.stdout)
        return found

    here, there = figures(), figures(*cluster)
    assert list(here) == list(there)
    assert (here["cluster"], there["cluster"]) == (None, cluster[1])
    for name in ("rays", "rays_by_kind", "coverage", "width", "samples", "triangles"):
        assert here[name] == there[name]
    for name in ("trace_seconds", "rays_per_second"):
        assert isinstance(there[name], float)
        assert there[name] > 0.0


def test_an_address_where_nobody_answers(judged: Judged, tmp_path: Path) -> None:
    with socket.socket() as nobody:
        nobody.bind(("127.0.0.1", 0))
        closed = f"tcp://127.0.0.1:{nobody.getsockname()[1]}"
        for address in (closed, "nonsense", "carrier-pigeon://coo:1"):
            picture = tmp_path / "picture.png"
            done = run("render", judged.path, "-o", picture, *SIZE, "--cluster", address)
            assert (done.returncode, done.stdout) == (1, "")
            assert done.stderr.count("\n") == 1
            wanted = f"halfline: error: --cluster: no scheduler of Dask answers at {address}: "
            assert done.stderr.startswith(wanted)
    assert list(tmp_path.iterdir()) == []


def test_what_else_is_wrong_comes_first(judged: Judged, tmp_path: Path) -> None:
    nobody = ("--cluster", "nonsense")
    nowhere = run("render", judged.path, "-o", tmp_path / "none" / "picture.png", *SIZE, *nobody)
    assert nowhere.returncode == 1
    assert "none/picture.png: No such file" in nowhere.stderr
    wrong = run("render", judged.path, "-o", tmp_path / "p.png", "--ground-height", "3", *nobody)
    assert wrong.returncode == 2


def test_without_dask_it_says_what_to_install(judged: Judged, tmp_path: Path) -> None:
    (tmp_path / "distributed.py").write_text("raise ImportError('No module named it')\n")
    command: list[str | Path] = [*COMMAND, "render", judged.path, "-o", tmp_path / "p.png"]
    command += ["--cluster", "tcp://a:1"]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 1
    assert done.stderr.startswith("halfline: error: --cluster: halfline.dask needs Dask, pip inst")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("is_mesh", [False, True])
def test_ctrl_c_ends_it_and_leaves_nothing(
    cluster: tuple[str, str],
    client: Client,
    scene: Scene,
    judged: Judged,
    tmp_path: Path,
    is_mesh: bool,
) -> None:
    source = judged.path if is_mesh else scene.path
    assert source is not None
    long = ("--resolution", "2000,2000", "--samples", "1024")
    command: list[str | Path] = [*COMMAND, "render", source, "-o", tmp_path / "p.png", *long]
    with subprocess.Popen(
        [*command, *cluster], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        wait_until(lambda: any(client.processing().values()))
        assert len(list(tmp_path.glob(".*.hlt"))) == is_mesh
        # Waiting costs it nothing, and the picture would take hours.
        stdout, stderr = interrupt(process)
    assert (process.returncode, stdout) == (130, "")
    assert stderr == "halfline: interrupted\n"
    assert list(tmp_path.iterdir()) == []
    # The workers do not go on.
    wait_until(lambda: not any(client.processing().values()))
