"""Ctrl-C ends every long call within half a second, and everything can be used afterwards."""

from __future__ import annotations

import gzip
import signal
import subprocess
import sys
import time
from pathlib import Path

import halfline
import numpy as np
import pytest
from children import PATIENCE_SECONDS, cpu_seconds
from scripts import PREAMBLE, environment

# What is promised, and a margin for what Python does. CPU time of one thread: less than passes.
MOST_CPU_SECONDS = 0.5 + 0.5

PREPARE = {
    "load": "path = sys.argv[1]",
    "generate": "",
    "build": "mesh = halfline.generate('scan', 1_500_000)",
    "intersect": "scene = make_scene(200_000); o, d = rays(8_000_000)",
    "occluded": "scene = make_scene(200_000); o, d = rays(12_000_000)",
    "count": "scene = make_scene(200_000); o, d = rays(8_000_000)",
    "all": "scene = make_scene(200_000); o, d = rays(4_000_000)",
}

LONG_CALL = {
    "load": "halfline.load(path)",
    "generate": "halfline.generate('scan', 30_000_000)",
    "build": "halfline.Scene(mesh, preset='best')",
    "intersect": "scene.intersect(o, d)",
    "occluded": "scene.occluded(o, d)",
    "count": "scene.count_intersections(o, d)",
    "all": "scene.intersect_all(o, d)",
}

SCRIPT = """
def answer(scene):
    o, d = rays(10_000)
    return scene.intersect(o, d).t

small = make_scene()
before = answer(small)
{prepare}
try:
    print("ready", flush=True)
    {call}
    print("finished", flush=True)
except KeyboardInterrupt:
    print("interrupted", sum(os.times()[:2]), sep="\\n", flush=True)
# The scene that was asked, if there is one, goes on, and so do others.
assert (answer(small) == before).all()
if "scene" in globals():
    assert answer(scene).shape == (10_000,)
print("well", flush=True)
"""


@pytest.fixture(scope="module")
def long_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file that takes seconds to load: a gzip stream may have several members, here all alike."""
    path = tmp_path_factory.mktemp("long") / "long.obj.gz"
    lines = "v 0.123456 0.234567 0.345678\n" * 100_000 + "f -3 -2 -1\n" * 100_000
    member = gzip.compress(lines.encode(), compresslevel=1)
    path.write_bytes(member * 60)
    return path


@pytest.mark.parametrize("what", LONG_CALL)
def test_a_long_call_can_be_interrupted(what: str, long_file: Path, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    text = SCRIPT.format(prepare=PREPARE[what], call=LONG_CALL[what])
    script.write_text(PREAMBLE + text, encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, script, long_file],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(HALFLINE_THREADS="1"),
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == "ready\n", process.stderr.read()
        time.sleep(0.4)
        before = cpu_seconds(process)
        process.send_signal(signal.SIGINT)
        line = process.stdout.readline()
        after = process.stdout.readline()
        rest, errors = process.stdout.read(), process.stderr.read()
    assert line == "interrupted\n", (line, errors)
    assert float(after) - before < MOST_CPU_SECONDS
    assert rest == "well\n", errors
    assert process.returncode == 0


def test_a_handler_that_does_not_raise_lets_the_call_end(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    text = """
calls = []
signal.signal(signal.SIGUSR1, lambda *_: calls.append(time.monotonic()))
scene = make_scene()
o, d = rays(3_000_000)
begin = time.monotonic()
scene.intersect(o, d)
usual = time.monotonic() - begin

def runs_meanwhile():
    calls.clear()
    timer = threading.Timer(0.1 * usual, os.kill, (os.getpid(), signal.SIGUSR1))
    begin = time.monotonic()
    timer.start()
    hits = scene.intersect(o, d)
    end = time.monotonic()
    assert hits.t.shape == (3_000_000,)
    timer.join()
    assert len(calls) == 1, calls
    return calls[0] - begin < 0.7 * (end - begin)

# The handler runs while the call goes on, not after it; a busy machine may be late with the signal.
assert any(runs_meanwhile() for _ in range(20))
"""
    script.write_text(PREAMBLE + text, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, script],
        env=environment(HALFLINE_THREADS="1"),
        capture_output=True,
        text=True,
        timeout=PATIENCE_SECONDS,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_what_progress_raises_ends_the_call() -> None:
    scene = halfline.Scene(halfline.generate("scan", 200_000))
    directions = np.random.default_rng(0).normal(size=(2_000_000, 3)).astype(np.float32)
    seen: list[tuple[str, int, int]] = []

    def stop(stage: str, done: int, total: int) -> None:
        seen.append((stage, done, total))
        raise RuntimeError("enough")

    asks = (scene.intersect, scene.occluded, scene.count_intersections, scene.intersect_all)
    for ask in asks:
        seen.clear()
        with pytest.raises(RuntimeError, match="enough"):
            ask(np.zeros(3), directions, progress=stop)
        # It is not called again, and the rest is not cast.
        assert len(seen) == 1
        assert seen[0][0] == "trace"
        assert seen[0][1] < seen[0][2] == 2_000_000
    mesh = halfline.generate("scan", 200_000)
    with pytest.raises(RuntimeError, match="enough"):
        halfline.Scene(mesh, progress=stop)
    with pytest.raises(RuntimeError, match="enough"):
        halfline.generate("scan", 200_000, progress=stop)
    assert scene.intersect(np.zeros(3), directions[:10]).shape == (10,)
