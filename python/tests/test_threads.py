"""Threads and processes: who works, who may ask, and what children inherit."""

from __future__ import annotations

import pickle
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import halfline
import numpy as np
import pytest
from scripts import run


@pytest.fixture(scope="module")
def scene() -> halfline.Scene:
    """Something to ask."""
    return halfline.Scene(halfline.generate("scan", 20_000))


def test_other_threads_run_during_a_call(tmp_path: Path) -> None:
    # With one thread at work, this machine has a core for those that tick.
    script = """
scene = make_scene(200_000)
mesh = halfline.generate("scan", 500_000)
o, d = rays(2_000_000)
ticks, done = 0, False
def tick():
    global ticks
    while not done:
        time.sleep(0.001)
        ticks += 1
thread = threading.Thread(target=tick)
thread.start()
for call in (
    lambda: scene.intersect(o, d),
    lambda: scene.occluded(o, d),
    lambda: scene.count_intersections(o, d),
    lambda: scene.intersect_all(o, d),
    lambda: halfline.Scene(mesh),
    lambda: halfline.generate("scan", 2_000_000),
):
    before = ticks
    call()
    # Undisturbed it would be some 900 a second, and none while the call keeps the interpreter.
    assert ticks - before > 20, ticks - before
done = True
thread.join()
"""
    run(tmp_path, script, HALFLINE_THREADS="1")


def test_many_threads_may_ask_one_scene(scene: halfline.Scene) -> None:
    random = np.random.default_rng(2)
    batches = [random.normal(size=(size, 3)) for size in (1, 10, 4096, 5000, 30_000) * 8]
    expected = [scene.intersect_all(np.zeros(3), batch) for batch in batches]

    def ask(batch: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> halfline.AllHits:
        return scene.intersect_all(np.zeros(3), batch)

    with ThreadPoolExecutor(8) as pool:
        for found, hits in zip(pool.map(ask, batches), expected, strict=True):
            np.testing.assert_array_equal(found.splits, hits.splits)
            np.testing.assert_array_equal(found.t, hits.t)
            np.testing.assert_array_equal(found.face, hits.face)


def test_the_number_of_threads_can_be_set(scene: halfline.Scene) -> None:
    directions = np.random.default_rng(2).normal(size=(20_000, 3))
    expected = scene.intersect(np.zeros(3), directions)
    default = halfline.thread_count()
    try:
        for count in (1, 5, 2):
            halfline.set_thread_count(count)
            assert halfline.thread_count() == count
            hits = scene.intersect(np.zeros(3), directions)
            np.testing.assert_array_equal(hits.t, expected.t)
    finally:
        halfline.set_thread_count(None)
    assert halfline.thread_count() == default
    for wrong in (0, -1, 2**16):
        with pytest.raises(ValueError, match=f"count: expected a number of threads .* {wrong}$"):
            halfline.set_thread_count(wrong)


def test_only_the_own_threads_work(tmp_path: Path) -> None:
    script = """
def thread_names():
    tasks = os.listdir("/proc/self/task")
    return sorted(open(f"/proc/self/task/{task}/comm").read().strip() for task in tasks)

if not sys.platform.startswith("linux"):
    sys.exit()
before = thread_names()
scene = make_scene()
o, d = rays(100_000)
hits = scene.intersect(o, d)
hits.point, scene.info(), scene.mesh.bounds, scene.mesh.vertices
halfline.Scene(np.array(scene.mesh.vertices), np.array(scene.mesh.faces))
for count in (1, 100, 100_000):
    scene.intersect_all(o, d[:count]), scene.occluded(o, d[:count])
    scene.count_intersections(o, d[:count])
# Not one of rayon's global threads.
assert thread_names() == sorted([*before, "halfline-0", "halfline-1", "halfline-2"]), thread_names()
assert halfline.thread_count() == 3
"""
    run(tmp_path, script, HALFLINE_THREADS="3")


def test_few_rays_need_no_threads(tmp_path: Path) -> None:
    script = """
import pickle
scene = make_scene()
halfline.set_thread_count(7)
o, d = rays(4096)
scene.intersect(o, d), scene.intersect_all(o, d), scene.occluded(o, d)
scene.intersect(o, d).point
if sys.platform.startswith("linux"):
    tasks = os.listdir("/proc/self/task")
    names = [open(f"/proc/self/task/{task}/comm").read().strip() for task in tasks]
    assert sum(name.startswith("halfline-") for name in names) == 2, names
"""
    run(tmp_path, script, HALFLINE_THREADS="2")


def test_a_wrong_number_in_the_environment_is_named(tmp_path: Path) -> None:
    script = """
try:
    make_scene()
except ValueError as error:
    print(error)
"""
    stdout, _ = run(tmp_path, script, HALFLINE_THREADS="many")
    assert stdout == (
        'HALFLINE_THREADS: expected a number of threads from 1 to 65535, found "many"\n'
    )


FORK = """
import warnings
# Python warns of forks where there are threads: that they work is what is shown here.
warnings.simplefilter("ignore", DeprecationWarning)
scene = make_scene()
o, d = rays(300_000)
expected = scene.intersect(o, d)

def check():
    hits = scene.intersect(o, d)
    assert (hits.t == expected.t).all() and (hits.face == expected.face).all()
    assert len(scene.intersect_all(o, d)) > 0
    # Everything else works too.
    assert make_scene(1000).intersect(o, d).hit.any()
    return True
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there is no fork")
def test_a_scene_works_after_fork(tmp_path: Path) -> None:
    script = """
def child_is_well():
    child = os.fork()
    if child == 0:
        signal.alarm(600)
        try:
            check()
            # And in its own children.
            if os.getppid() == parent and not child_is_well():
                os._exit(1)
            os._exit(0)
        except BaseException as error:
            print(repr(error), file=sys.stderr, flush=True)
            os._exit(1)
    return os.waitpid(child, 0)[1] == 0

parent = os.getpid()
assert child_is_well()
# While other threads are in the middle of calls.
stop = False
def work():
    while not stop:
        check()
threads = [threading.Thread(target=work) for _ in range(2)]
for thread in threads:
    thread.start()
for _ in range(10):
    time.sleep(0.02)
    assert child_is_well()
stop = True
for thread in threads:
    thread.join()
assert check()
"""
    run(tmp_path, FORK + script)


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
@pytest.mark.skipif(sys.platform == "win32", reason="there is no fork")
def test_processes_may_share_work(tmp_path: Path, method: str) -> None:
    script = """
import multiprocessing

def ask(scene_and_rays):
    scene, o, d = scene_and_rays
    return scene.intersect(o, d).t

if __name__ == "__main__":
    expected = scene.intersect(o, d).t
    context = multiprocessing.get_context(METHOD)
    with context.Pool(2) as pool:
        parts = [(scene, o, d[first : first + 100_000]) for first in range(0, 300_000, 100_000)]
        found = np.concatenate(pool.map(ask, parts))
    assert (found == expected).all()
"""
    run(tmp_path, FORK + script.replace("METHOD", repr(method)))


def test_a_scene_pickles(scene: halfline.Scene) -> None:
    directions = np.random.default_rng(2).normal(size=(1000, 3))
    best = halfline.Scene(scene.mesh, preset="best")
    again = pickle.loads(pickle.dumps(best))
    assert again.info()["preset"] == "best"
    assert again.mesh.vertices.dtype == np.float32
    hits, expected = (s.intersect_all(np.zeros(3), directions) for s in (again, scene))
    np.testing.assert_array_equal(hits.t, expected.t)

    # So do answers, and those of one scene still share its mesh.
    one, other = pickle.loads(pickle.dumps((hits, again.intersect(np.zeros(3), directions))))
    np.testing.assert_array_equal(one.point, hits.point)
    assert one.mesh is other.mesh


def test_a_daemon_in_a_call_lets_the_process_end(tmp_path: Path) -> None:
    script = """
scene = make_scene(200_000)
o, d = rays(8_000_000)
threading.Thread(target=scene.intersect, args=(o, d), daemon=True).start()
time.sleep(0.3)
"""
    _, stderr = run(tmp_path, script, HALFLINE_THREADS="1")
    assert stderr == ""
