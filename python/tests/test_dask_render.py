"""Pictures from a cluster: the same to the bit, whatever works on them and whatever dies."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import halfline
import halfline.dask
import numpy as np
import psutil
import pytest
from children import PATIENCE_SECONDS, wait_until
from clusters import cluster, process_ids, sent
from distributed import Client
from halfline import Image, Scene
from halfline.dask._render import bands

SIZE: dict[str, Any] = {"width": 120, "height": 90, "samples": 4}

# Some seconds of work, in bands that take a while each.
LONG: dict[str, Any] = {"width": 200, "height": 160, "samples": 64, "seed": 3}


def assert_same(image: Image, other: Image) -> None:
    """Compares pictures in all layers, and the rays that were cast for them: none twice."""
    np.testing.assert_array_equal(image, other)
    for name in ("color", "depth", "normal", "face", "steps"):
        np.testing.assert_array_equal(getattr(image, name), getattr(other, name), err_msg=name)
    assert image.rays == other.rays


@pytest.mark.parametrize("shading", ["clay", "whitted", "steps"])
def test_a_cluster_draws_the_same_picture(client: Client, scene: Scene, shading: str) -> None:
    settings: dict[str, Any] = {**SIZE, "shading": shading, "ground": True, "background": "none"}
    here = scene.render(**settings)
    assert_same(scene.render(**settings, client=client), here)
    assert scene.path is not None
    assert_same(halfline.dask.render(scene.path, client=client, **settings), here)


def test_one_worker_draws_the_same_picture(scene: Scene, tmp_path: Path) -> None:
    with cluster({}, folder=tmp_path) as client:
        assert_same(scene.render(**SIZE, client=client), scene.render(**SIZE))


def test_defaults_are_those_of_the_scene(client: Client, scene: Scene) -> None:
    image = halfline.dask.render(scene, client=client, height=40, samples=1)
    assert_same(image, scene.render(height=40, samples=1))
    assert image.shape == (40, 1280, 3)


def test_progress_comes_as_bands_arrive(client: Client, scene: Scene) -> None:
    told: list[tuple[str, int, int]] = []
    scene.render(**SIZE, client=client, progress=lambda *now: told.append(now))
    stages, done, totals = zip(*told, strict=True)
    assert set(stages) == {"trace"}
    assert set(totals) == {120 * 90}
    assert (done[0], done[-1]) == (0, 120 * 90)
    assert list(done) == sorted(set(done))
    assert len(done) > 2
    assert all(pixels % (120 * 2) == 0 for pixels in done)


def test_bands_are_all_rows_and_not_too_many() -> None:
    for samples, width, height, threads in [
        (16, 1280, 720, 2),
        (1, 1, 1, 64),
        (4096, 2000, 2000, 4),
        (1, 20_000, 20_000, 1000),
        (16, 640, 481, 7),
    ]:
        cut = bands(samples, width, height, threads)
        assert cut[0][0] == 0
        assert cut[-1][1] == height
        assert all(end == first for (_, end), (first, _) in itertools.pairwise(cut))
        assert all(first % 4 == 0 for first, _ in cut)
        assert len(cut) <= -(-height // 4)
        assert len(cut) >= min(8 * threads, -(-height // 4))
        assert len(cut) <= 5000


def test_the_graph_is_small_and_results_do_not_stay(client: Client, scene: Scene) -> None:
    with sent(client) as sizes:
        scene.render(**SIZE, client=client)
    assert 0 < sum(sizes) < 12_000
    wait_until(lambda: not any(client.has_what().values()))
    assert not client.futures


def test_a_worker_that_is_killed_loses_nothing(client: Client, scene: Scene) -> None:
    here = scene.render(**LONG)
    before = process_ids(client)
    victims: list[int] = []
    told: list[int] = []

    def kill(stage: str, done: int, total: int) -> None:
        told.append(done)
        if done == 0 or victims:
            return
        worker, process = next(iter(before.items()))
        # From here on it finishes nothing, and so dies with all that it has begun.
        os.kill(process, signal.SIGSTOP)
        wait_until(lambda: client.processing()[worker])
        victims.append(process)
        os.kill(process, signal.SIGKILL)

    image = scene.render(**LONG, client=client, progress=kill)
    assert len(victims) == 1
    assert_same(image, here)
    assert told == sorted(set(told))
    assert told[-1] == 160 * 200
    wait_until(lambda: len(client.nthreads()) == 2)
    assert victims[0] not in process_ids(client).values()


def test_workers_that_all_die_again_and_again_lose_nothing(client: Client, scene: Scene) -> None:
    killed: set[int] = set()
    done_then = 0

    def kill(stage: str, done: int, total: int) -> None:
        nonlocal done_then
        if done > done_then and len(killed) < 6:
            done_then = done
            wait_until(lambda: len(set(process_ids(client).values()) - killed) == 2)
            for process in set(process_ids(client).values()) - killed:
                killed.add(process)
                os.kill(process, signal.SIGKILL)

    image = scene.render(**LONG, client=client, progress=kill)
    assert len(killed) >= 4
    assert_same(image, scene.render(**LONG))


def test_a_restarted_cluster_goes_on(client: Client, scene: Scene) -> None:
    first = scene.render(**SIZE, client=client)
    before = set(process_ids(client).values())
    client.restart()
    assert before.isdisjoint(process_ids(client).values())
    assert_same(scene.render(**SIZE, client=client), first)


def test_a_restart_on_the_way_loses_nothing(scene: Scene, tmp_path: Path) -> None:
    restarted: list[int] = []
    # Of its own: nannies that had replaced killed workers once did not heed a restart.
    with cluster({}, {}, folder=tmp_path) as client:

        def restart(stage: str, done: int, total: int) -> None:
            if done and not restarted:
                restarted.append(done)
                client.restart(timeout=PATIENCE_SECONDS)

        image = scene.render(**LONG, client=client, progress=restart)
    assert restarted
    assert_same(image, scene.render(**LONG))


def test_ctrl_c_ends_the_work(client: Client, scene: Scene) -> None:
    workers = [psutil.Process(process) for process in process_ids(client).values()]
    cpu_then: list[float] = []

    def cpu_seconds() -> float:
        return sum(sum(worker.cpu_times()[:2]) for worker in workers)

    def press() -> None:
        cpu_then.append(cpu_seconds())
        os.kill(os.getpid(), signal.SIGINT)

    timer: list[threading.Timer] = []

    def start(stage: str, done: int, total: int) -> None:
        if done and not timer:
            timer.append(threading.Timer(0.1, press))
            timer[0].start()

    with pytest.raises(KeyboardInterrupt):
        scene.render(width=2000, height=2000, samples=1024, client=client, progress=start)
    # Nor do the workers go on, though a band alone would take them long.
    wait_until(lambda: not any(client.processing().values()))
    wait_until(lambda: not any(client.run(executing).values()))
    assert cpu_seconds() - cpu_then[0] < 5.0
    assert_same(scene.render(**SIZE, client=client), scene.render(**SIZE))


def executing(dask_worker: Any) -> int:
    """How many tasks a worker works on."""
    return len(dask_worker.state.executing) + len(dask_worker.state.tasks)


def test_an_error_of_the_caller_ends_the_work(client: Client, scene: Scene) -> None:
    def refuse(stage: str, done: int, total: int) -> None:
        if done:
            raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        scene.render(**LONG, client=client, progress=refuse)
    wait_until(lambda: not any(client.processing().values()))


def test_what_makes_no_sense_is_refused(client: Client, scene: Scene) -> None:
    with pytest.raises(ValueError, match=r"in memory: scene.save\(path\), then halfline.open"):
        halfline.Scene(scene.mesh).render(client=client)
    with pytest.raises(TypeError, match=r"client: expected a distributed.Client, found str"):
        scene.render(client="tcp://127.0.0.1:8786")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="unexpected keyword argument 'wdith'"):
        halfline.dask.render(scene, client=client, wdith=3)
    with pytest.raises(ValueError, match="samples"):
        scene.render(samples=0, client=client)
    with pytest.raises(FileNotFoundError):
        halfline.dask.render("none.hlt", client=client)


def test_threads_are_those_that_dask_gave(client: Client, scene: Scene) -> None:
    scene.render(**SIZE, client=client)
    assert set(client.run(halfline.thread_count).values()) == {1}


def test_without_dask_it_says_what_to_install() -> None:
    for name in ("dask", "dask.array", "distributed"):
        script = f"import sys; sys.modules[{name!r}] = None; import halfline.dask"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        last = done.stderr.splitlines()[-1]
        assert last.startswith("ImportError: halfline.dask needs Dask, pip install 'halfline[")
