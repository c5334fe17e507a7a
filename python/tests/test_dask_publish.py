"""Workers that do not see the tree's file: it is sent to their machine once."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dask.array as da
import halfline
import halfline.dask
import numpy as np
import pytest
from children import wait_until
from clusters import cluster, elsewhere, process_ids, worker_spec
from distributed import Client
from halfline import Scene
from halfline.dask import MissingTreeError, _peers, _publish

SIZE: dict[str, Any] = {"width": 80, "height": 60, "samples": 2}


@dataclass(frozen=True)
class Machines:
    """One worker on this machine and two on another, which does not see the tree's file."""

    client: Client
    scene: Scene
    cache: Path

    @property
    def names(self) -> list[str]:
        """What lies in the cache of the other machine."""
        return sorted(path.name for path in self.cache.glob("*") if path.suffix != ".lock")


@pytest.fixture
def machines(scene: Scene, tmp_path: Path) -> Iterator[Machines]:
    """As `Machines`, with nothing in the cache."""
    path = tmp_path / "shared" / "tree.hlt"
    path.parent.mkdir()
    scene.save(path)
    there = elsewhere(path, tmp_path / "cache")
    with cluster({}, there, there, folder=tmp_path / "scratch") as client:
        yield Machines(client, halfline.open(path), tmp_path / "cache")


@pytest.fixture
def transfers(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """The workers to which files are sent."""
    seen: list[list[str]] = []
    send = _publish._send

    def counted(client: Client, tree: Any, workers: list[str], check: Any) -> None:
        seen.append(workers)
        send(client, tree, workers, check)

    monkeypatch.setattr(_publish, "_send", counted)
    monkeypatch.setattr(_publish, "CHUNK_BYTES", 10_000)
    monkeypatch.setattr("halfline.dask._peers.CHUNK_BYTES", 10_000)
    return seen


def test_the_file_travels_once_to_each_machine(
    machines: Machines, transfers: list[list[str]]
) -> None:
    client, scene = machines.client, machines.scene
    here = scene.render(**SIZE)
    for _ in range(2):
        np.testing.assert_array_equal(scene.render(**SIZE, client=client), here)
    assert [len(workers) for workers in transfers] == [1]
    copy = machines.cache / f"{scene.content_hash}.hlt"
    assert machines.names == [copy.name]
    assert scene.path is not None
    assert copy.read_bytes() == scene.path.read_bytes()
    # As old as its header says, it is not read again to be checked.
    assert copy.stat().st_mtime_ns == scene.path.stat().st_mtime_ns

    # A worker that starts again finds it there.
    client.restart()
    np.testing.assert_array_equal(scene.render(**SIZE, client=client), here)
    assert len(transfers) == 1

    halfline.dask.unpublish(client, scene)
    assert machines.names == []
    assert halfline.dask.publish(client, scene) == 1
    assert halfline.dask.publish(client, scene) == 0
    assert len(transfers) == 2


def test_a_lazy_question_without_the_file_says_what_to_do(
    scene: Scene, tmp_path: Path, transfers: list[list[str]]
) -> None:
    assert scene.path is not None
    there = elsewhere(scene.path, tmp_path / "cache")
    with cluster(there, folder=tmp_path / "scratch") as client:
        rays = da.from_array(np.random.default_rng(0).normal(size=(40, 3)), (9, 3))
        lazy = halfline.dask.intersect(scene, rays, -rays)
        with pytest.raises(MissingTreeError) as raised:
            lazy.compute()
        message = str(raised.value)
        assert message.startswith(f"{scene.path}: worker tcp://127.0.0.1:")
        assert message.endswith("send it there with halfline.dask.publish(client, scene)")
        assert "\n" not in message

        halfline.dask.publish(client, scene)
        wanted = scene.intersect(rays.compute(), -rays.compute())
        np.testing.assert_array_equal(lazy.compute().t, wanted.t)
        np.testing.assert_array_equal(lazy.normal.compute(), wanted.normal)


def test_a_machine_that_joins_later_takes_it_from_another(
    machines: Machines, transfers: list[list[str]], tmp_path: Path
) -> None:
    client, scene = machines.client, machines.scene
    assert scene.path is not None
    late = tmp_path / "late"
    rays = da.from_array(np.random.default_rng(0).normal(size=(40, 3)), (9, 3))
    spec = worker_spec(elsewhere(scene.path, late), tmp_path / "scratch")
    machines_now: Any = client.cluster
    machines_now.worker_spec["late"] = spec
    client.sync(machines_now._correct_state)
    wait_until(lambda: len(client.nthreads()) == 4)
    address = machines_now.workers["late"].worker_address
    lazy = halfline.dask.intersect(scene, rays, -rays)
    future = client.compute(lazy, workers=[address])
    np.testing.assert_array_equal(
        future.result().t, scene.intersect(rays.compute(), -rays.compute()).t
    )
    assert transfers == []
    assert [path.name for path in late.glob("*.hlt")] == [f"{scene.content_hash}.hlt"]
    assert list(late.glob("*.part")) == []


def test_another_file_at_the_path_is_not_taken_for_the_tree(
    scene: Scene, tmp_path: Path, client: Client
) -> None:
    assert scene.path is not None
    path = tmp_path / "tree.hlt"
    halfline.Scene([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).save(path)
    mine = halfline.open(path)
    lazy = halfline.dask.occluded(mine, da.zeros((4, 3), chunks=2), [0.0, 0.0, 1.0])
    scene.save(path)
    with pytest.raises(MissingTreeError, match="there is another one, of content hash"):
        lazy.compute()


def test_a_damaged_copy_is_sent_again(machines: Machines, transfers: list[list[str]]) -> None:
    client, scene = machines.client, machines.scene
    halfline.dask.publish(client, scene)
    copy = machines.cache / f"{scene.content_hash}.hlt"
    copy.write_bytes(copy.read_bytes()[:-100])
    client.restart()
    assert halfline.dask.publish(client, scene) == 1
    assert scene.path is not None
    assert copy.read_bytes() == scene.path.read_bytes()


def test_what_arrives_damaged_is_refused(
    machines: Machines, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = _peers.read_chunk

    def damage(path: str, offset: int) -> bytes:
        chunk = bytearray(read(path, offset))
        chunk[len(chunk) // 2] ^= 1
        return bytes(chunk)

    monkeypatch.setattr(_publish, "read_chunk", damage)
    with pytest.raises(halfline.FormatError):
        halfline.dask.publish(machines.client, machines.scene)
    assert machines.names == []


def test_a_file_that_is_lost_on_the_way_is_sent_again(
    scene: Scene, tmp_path: Path, transfers: list[list[str]]
) -> None:
    assert scene.path is not None
    there = elsewhere(scene.path, tmp_path / "cache")
    long: dict[str, Any] = {"width": 160, "height": 120, "samples": 32}
    with cluster(there, there, folder=tmp_path / "scratch") as client:
        killed: list[int] = []

        def kill(stage: str, done: int, total: int) -> None:
            if done and not killed:
                killed.extend(process_ids(client).values())
                # Whoever comes back finds the cache empty, and nobody to ask.
                for path in (tmp_path / "cache").glob("*.hlt"):
                    path.unlink()
                for process in killed:
                    os.kill(process, signal.SIGKILL)

        image = scene.render(**long, client=client, progress=kill)
    assert len(killed) == 2
    assert len(transfers) == 2
    np.testing.assert_array_equal(image, scene.render(**long))
