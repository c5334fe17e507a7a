"""What is told of long calls, and to whom."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import halfline
import numpy as np
import pytest
from conftest import Judged
from scripts import run


class Listener:
    """Remembers what it was told."""

    def __init__(self) -> None:
        self.told: list[tuple[str, int, int]] = []

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Hears of progress."""
        self.told.append((stage, done, total))


def listened(call: Callable[..., object], stage: str) -> list[tuple[str, int, int]]:
    """What a call told; each must go on from the last, to the end."""
    listener = Listener()
    call(progress=listener)
    told = listener.told
    assert told
    assert {known for known, _, _ in told} == {stage}
    amounts = [done for _, done, _ in told]
    assert amounts == sorted(amounts)
    assert told[-1][1] == told[-1][2] > 0
    return told


def test_a_callable_hears_of_every_stage(judged: Judged) -> None:
    listened(partial(halfline.load, judged.path), "load")
    listened(partial(halfline.generate, "scan", 1000), "load")
    mesh = halfline.generate("scan", 300_000)
    told = listened(partial(halfline.Scene, mesh), "build")
    assert len(told) > 2
    scene = halfline.Scene(mesh)
    directions = np.random.default_rng(0).normal(size=(1_000_000, 3))
    asks = (scene.intersect, scene.occluded, scene.count_intersections, scene.intersect_all)
    for ask in asks:
        many = listened(partial(ask, np.zeros(3), directions), "trace")
        assert len(many) > 2
        assert many[-1] == ("trace", 1_000_000, 1_000_000)
        few = listened(partial(ask, np.zeros(3), directions[:7]), "trace")
        assert few == [("trace", 7, 7)]


def test_nobody_else_is_told(capfd: pytest.CaptureFixture[str]) -> None:
    scene = halfline.Scene(np.eye(3), [[0, 1, 2]], progress=False)
    scene.intersect(np.zeros((10_000, 3)), np.ones(3), progress=None)
    assert capfd.readouterr() == ("", "")


def test_what_cannot_be_told_is_refused() -> None:
    with pytest.raises(
        TypeError, match="progress: expected True, False, None or a callable, found int"
    ):
        halfline.Scene(np.eye(3), [[0, 1, 2]], progress=1)  # type: ignore[arg-type]


SHOW = """
scene = halfline.Scene(halfline.generate("scan", 20_000), progress=True)
o, d = rays(500_000)
scene.intersect(o, d, progress=True)
"""


def test_true_shows_bars_of_tqdm(tmp_path: Path) -> None:
    stdout, stderr = run(tmp_path, SHOW)
    assert stdout == ""
    assert "build: 100%" in stderr
    assert "trace: 100%" in stderr
    assert "500k/500k" in stderr


def test_true_shows_text_without_tqdm(tmp_path: Path) -> None:
    stdout, stderr = run(tmp_path, "sys.modules['tqdm'] = sys.modules['tqdm.auto'] = None\n" + SHOW)
    assert stdout == ""
    assert stderr == "halfline: build 100 %\nhalfline: trace 100 %\n"
