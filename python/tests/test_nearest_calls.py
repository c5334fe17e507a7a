"""Long questions about points: they tell of their progress, and Ctrl-C ends them."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import halfline
import numpy as np
import pytest
from children import cpu_seconds
from scripts import PREAMBLE, environment
from test_interruption import MOST_CPU_SECONDS
from test_progress import listened

ALL = ("closest_points", "signed_distance", "winding_number", "contains")


@pytest.fixture(scope="module")
def scene() -> halfline.Scene:
    """Something to be near to."""
    return halfline.Scene(halfline.generate("scan", 20_000))


@pytest.mark.parametrize("name", ALL)
def test_a_callable_hears_of_progress(scene: halfline.Scene, name: str) -> None:
    points = np.random.default_rng(13).uniform(-1.0, 1.0, size=(1_000_000, 3))
    ask = getattr(scene, name)
    many = listened(partial(ask, points), "trace")
    assert len(many) > 2
    few = listened(partial(ask, points[:7]), "trace")
    assert len(few) <= 2


@pytest.mark.parametrize("name", ALL)
def test_what_progress_raises_ends_the_call(scene: halfline.Scene, name: str) -> None:
    points = np.random.default_rng(14).uniform(-1.0, 1.0, size=(1_000_000, 3))
    seen: list[tuple[str, int, int]] = []

    def stop(stage: str, done: int, total: int) -> None:
        seen.append((stage, done, total))
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        getattr(scene, name)(points, progress=stop)
    assert len(seen) == 1
    assert seen[0][1] < seen[0][2]
    assert getattr(scene, name)(points[:10]) is not None


LONG_CALLS = {
    "closest_points": "scene.closest_points(points)",
    "signed_distance": "scene.signed_distance(points)",
    "winding_number": "scene.winding_number(points)",
    "contains": "scene.contains(points)",
    # From the centre all faces are as near.
    "a tie": "ball.closest_points(np.zeros((100_000, 3)))",
}

SCRIPT = """
scene = make_scene(200_000)
ball = halfline.Scene(halfline.generate("sphere", 20_480))
points = np.random.default_rng(0).uniform(-1, 1, size=(12_000_000, 3))
before = scene.signed_distance(points[:1000])
try:
    print("ready", flush=True)
    {call}
    print("finished", flush=True)
except KeyboardInterrupt:
    print("interrupted", sum(os.times()[:2]), sep="\\n", flush=True)
assert (scene.signed_distance(points[:1000]) == before).all()
print("well", flush=True)
"""


@pytest.mark.parametrize("what", LONG_CALLS)
def test_a_long_call_can_be_interrupted(what: str, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(PREAMBLE + SCRIPT.format(call=LONG_CALLS[what]), encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, script],
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
        line, after = process.stdout.readline(), process.stdout.readline()
        rest, errors = process.stdout.read(), process.stderr.read()
    assert line == "interrupted\n", (line, errors)
    assert float(after) - before < MOST_CPU_SECONDS
    assert rest == "well\n", errors
