"""`halfline.dask`: lazy questions over chunked points, whose answers are those of `Scene`."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import dask
import dask.array as da
import halfline
import halfline.dask
import numpy as np
import pytest
from clusters import sent
from dask.array.utils import assert_eq
from distributed import Client
from halfline import Scene
from halfline.dask import LazyNearest

PARTS = ("distance", "point", "face", "uv", "feature", "normal", "found")
NUMBERS = ("signed_distance", "winding_number", "contains")

SHAPE = (6, 5)

CHUNKS = [
    pytest.param((6, 5, 3), id="one"),
    pytest.param((2, 3, 3), id="equal"),
    pytest.param((4, 2, 1), id="parts of points"),
    pytest.param(((1, 0, 5), 5, 3), id="with an empty one"),
]

Array = np.ndarray[Any, Any]


@pytest.fixture(scope="module")
def points() -> Array:
    """Points in and around the scene, one of them nowhere, (6, 5, 3)."""
    points = np.random.default_rng(3).uniform(-1.5, 1.5, size=(*SHAPE, 3))
    points[2, 3, 1] = np.nan
    return points


@pytest.mark.parametrize("chunks", CHUNKS)
def test_the_nearest_points_are_those_of_the_scene(
    scene: Scene, points: Array, chunks: Any
) -> None:
    lazy = halfline.dask.closest_points(scene, da.from_array(points, chunks), max_distance=0.75)
    eager = scene.closest_points(points, max_distance=0.75)
    assert 0 < np.count_nonzero(eager.found) < eager.found.size - 1
    assert lazy.shape == SHAPE
    for name in PARTS:
        part = getattr(lazy, name)
        assert part.chunks[:2] == lazy.chunks
        assert part.numblocks[2:] in ((), (1,))
        assert_eq(part, getattr(eager, name))
        np.testing.assert_array_equal(part.compute(), getattr(eager, name))
    together = lazy.compute()
    assert isinstance(together, halfline.Nearest)
    for name in PARTS:
        np.testing.assert_array_equal(getattr(together, name), getattr(eager, name))


@pytest.mark.parametrize("chunks", CHUNKS)
@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_are_those_of_the_scene(
    scene: Scene, points: Array, chunks: Any, name: str
) -> None:
    lazy = getattr(halfline.dask, name)(scene, da.from_array(points, chunks))
    eager = getattr(scene, name)(points)
    assert lazy.dtype == eager.dtype
    assert lazy.shape == SHAPE
    assert_eq(lazy, eager)
    np.testing.assert_array_equal(lazy.compute(), eager)


def test_the_rule_goes_along(tmp_path: Path) -> None:
    sphere = halfline.generate("sphere", 320)
    halfline.Scene(sphere.vertices, sphere.faces[:, ::-1]).save(tmp_path / "inverted.hlt")
    middle = da.zeros((4, 3), chunks=(2, 3))
    for rule, expected in (("winding", False), ("parity", True)):
        inside = halfline.dask.contains(tmp_path / "inverted.hlt", middle, rule=rule)
        assert inside.compute().tolist() == [expected] * 4
    with pytest.raises(ValueError, match="found 'odd'"):
        halfline.dask.contains(tmp_path / "inverted.hlt", middle, rule="odd").compute()


def test_leading_dimensions_are_broadcast(scene: Scene, points: Array) -> None:
    most = np.linspace(0.1, 1.0, SHAPE[1])
    cases: list[tuple[Any, Any]] = [
        (da.from_array(points, (6, 2, 3)), da.from_array(most, 3)),
        (da.from_array(points[:, :1], (3, 1, 3)), most),
        (points, np.float32(0.5)),
        ([0.5, 0.5, 0.5], da.from_array(most, 2)),
        (da.from_array(points[:0], (2, 2, 3)), 2),
    ]
    for given, limit in cases:
        lazy = halfline.dask.closest_points(scene, given, max_distance=limit)
        plain = [each.compute() if isinstance(each, da.Array) else each for each in (given, limit)]
        eager = scene.closest_points(plain[0], max_distance=plain[1])
        assert lazy.shape == eager.shape
        np.testing.assert_array_equal(lazy.distance.compute(), eager.distance)


def test_chunks_of_unknown_sizes_are_taken(scene: Scene, points: Array) -> None:
    flat = da.from_array(points.reshape(-1, 3), (8, 3))
    some = flat[flat[:, 0] > 0.0]
    expected = points.reshape(-1, 3)[points.reshape(-1, 3)[:, 0] > 0.0]
    near = halfline.dask.closest_points(scene, some)
    assert np.isnan(near.shape[0])
    eager = scene.closest_points(expected)
    np.testing.assert_array_equal(near.point.compute(), eager.point)
    signed = halfline.dask.signed_distance(scene, some).compute()
    np.testing.assert_array_equal(signed, scene.signed_distance(expected))


def test_each_point_is_asked_once(
    scene: Scene, points: Array, monkeypatch: pytest.MonkeyPatch
) -> None:
    ask = Scene.closest_points
    counts: list[int] = []

    def counted(self: Scene, points: Any, **more: Any) -> halfline.Nearest:
        near = ask(self, points, **more)
        counts.append(near.distance.size)
        return near

    monkeypatch.setattr(Scene, "closest_points", counted)
    lazy = halfline.dask.closest_points(scene, da.from_array(points, (2, 3, 3)))
    for asked in [
        [getattr(lazy, name) for name in PARTS],
        [lazy.distance.max(), lazy.face, lazy.found.sum(axis=0)],
        [lazy],
        [lazy, lazy.distance],
    ]:
        counts.clear()
        dask.compute(*asked, scheduler="synchronous")
        assert sum(counts) == 30, asked


def test_the_same_input_has_the_same_names(scene: Scene, points: Array, tmp_path: Path) -> None:
    chunked = da.from_array(points, (2, 3, 3))
    ask = halfline.dask.closest_points
    scene.save(tmp_path / "copy.hlt")
    first, second = ask(scene, chunked), ask(scene, chunked)
    third = ask(tmp_path / "copy.hlt", chunked)
    for name in PARTS:
        assert getattr(first, name).name == getattr(second, name).name == getattr(third, name).name
    assert len({getattr(first, name).name for name in PARTS}) == len(PARTS)
    assert dask.base.tokenize(first) == dask.base.tokenize(third)
    assert ask(scene, chunked, max_distance=2.0).distance.name != first.distance.name
    numbers = {getattr(halfline.dask, name)(scene, chunked).name for name in NUMBERS}
    inside = halfline.dask.contains(scene, chunked)
    other = halfline.dask.contains(scene, chunked, rule="parity")
    assert len({*numbers, inside.name, other.name}) == 4
    with dask.config.set({"tokenize.ensure-deterministic": True}):
        assert ask(scene, chunked).normal.name == first.normal.name
        assert halfline.dask.contains(scene, chunked).name == inside.name


def test_workers_answer_as_the_scene_does(client: Client, scene: Scene, points: Array) -> None:
    chunked = da.from_array(points, (2, 3, 3))
    lazy, eager = halfline.dask.closest_points(scene, chunked), scene.closest_points(points)
    kept = lazy.persist()
    assert isinstance(kept, LazyNearest)
    for near in (lazy.compute(), kept.compute(), client.compute(lazy).result()):
        assert isinstance(near, halfline.Nearest)
        for name in PARTS:
            np.testing.assert_array_equal(getattr(near, name), getattr(eager, name))
    np.testing.assert_array_equal(kept.normal.compute(), eager.normal)
    for name in NUMBERS:
        found = getattr(halfline.dask, name)(scene, chunked).compute()
        np.testing.assert_array_equal(found, getattr(scene, name)(points))
    # The mesh stays where it is.
    assert len(pickle.dumps(lazy.compute())) < len(pickle.dumps(eager)) / 10
    again = pickle.loads(pickle.dumps(lazy.compute()))
    np.testing.assert_array_equal(again.normal, eager.normal)


def test_the_graph_is_small(client: Client, scene: Scene) -> None:
    points = da.random.default_rng(0).random((100_000, 3), chunks=(1_000, 3))
    near = halfline.dask.closest_points(scene, points)
    assert len(pickle.dumps(near.distance.__dask_graph__())) < 40_000
    with sent(client) as sizes:
        assert halfline.dask.signed_distance(scene, points).min().compute() < 0
    assert 0 < sum(sizes) < 60_000


def test_what_they_are_is_said(scene: Scene, points: Array) -> None:
    lazy = halfline.dask.closest_points(scene, da.from_array(points, (3, 5, 3)))
    assert repr(lazy) == "<halfline.dask.LazyNearest of shape (6, 5), chunks ((3, 3), (5,))>"


def test_what_makes_no_sense_is_refused_at_once(scene: Scene, tmp_path: Path) -> None:
    points = da.zeros((4, 3), chunks=2)
    ask = halfline.dask.closest_points
    in_memory = halfline.Scene(scene.mesh)
    for name in ("closest_points", *NUMBERS):
        each = getattr(halfline.dask, name)
        with pytest.raises(ValueError, match=r"points: expected shape .*, 3\), found \(4, 2\)"):
            each(scene, points[:, :2])
        with pytest.raises(TypeError, match=r"points: .* found complex128"):
            each(scene, points * 1j)
        with pytest.raises(ValueError, match=r"memory: scene.save\(path\), then halfline.open"):
            each(in_memory, points)
        with pytest.raises(TypeError, match=r"scene: expected a halfline.Scene or .* found int"):
            each(3, points)
        with pytest.raises(FileNotFoundError):
            each(tmp_path / "none.hlt", points)
    with pytest.raises(ValueError, match=r"^points, max_distance: .* found points \(4,\), max"):
        ask(scene, points, max_distance=da.ones(3))
    with pytest.raises(TypeError, match=r"max_distance: expected float32, .* found bool"):
        ask(scene, points, max_distance=da.zeros(4, dtype=bool))
