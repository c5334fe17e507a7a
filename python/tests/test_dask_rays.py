"""`halfline.dask`: lazy questions over chunked rays, whose answers are those of `Scene`."""

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
from halfline.dask import LazyHits
from meshes import random_rays

PARTS = ("t", "face", "uv", "point", "normal", "hit")

SHAPE = (6, 5)

Rays = tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]


@pytest.fixture(scope="module")
def rays() -> Rays:
    """Origins in double, directions in single precision, (6, 5, 3)."""
    both = random_rays(30, seed=2).reshape(*SHAPE, 6)
    return both[..., :3].copy(), both[..., 3:].astype(np.float32)


CHUNKS = [
    pytest.param((6, 5, 3), (6, 5, 3), id="one"),
    pytest.param((2, 3, 3), (2, 3, 3), id="equal"),
    pytest.param((2, 5, 1), (4, 2, 2), id="different"),
    pytest.param(((1, 0, 5), 5, 3), ((1, 0, 5), 5, 3), id="with an empty one"),
]


@pytest.mark.parametrize(("of_origins", "of_directions"), CHUNKS)
def test_the_closest_hits_are_those_of_the_scene(
    scene: Scene, rays: Rays, of_origins: Any, of_directions: Any
) -> None:
    origins, directions = rays
    lazy = halfline.dask.intersect(
        scene, da.from_array(origins, of_origins), da.from_array(directions, of_directions)
    )
    eager = scene.intersect(origins, directions)
    assert 0 < np.count_nonzero(eager.hit) < eager.hit.size
    assert lazy.shape == SHAPE
    for name in PARTS:
        part = getattr(lazy, name)
        assert part.chunks[:2] == lazy.chunks
        assert part.numblocks[2:] in ((), (1,))
        assert_eq(part, getattr(eager, name))
        np.testing.assert_array_equal(part.compute(), getattr(eager, name))
    together = lazy.compute()
    assert isinstance(together, halfline.Hits)
    for name in PARTS:
        np.testing.assert_array_equal(getattr(together, name), getattr(eager, name))


@pytest.mark.parametrize(("of_origins", "of_directions"), CHUNKS)
def test_flags_and_counts_are_those_of_the_scene(
    scene: Scene, rays: Rays, of_origins: Any, of_directions: Any
) -> None:
    origins, directions = rays
    chunked = da.from_array(origins, of_origins), da.from_array(directions, of_directions)
    for name in ("occluded", "count_intersections"):
        lazy = getattr(halfline.dask, name)(scene, *chunked, t_min=0.25, t_max=1.5)
        eager = getattr(scene, name)(*rays, t_min=0.25, t_max=1.5)
        assert lazy.dtype == eager.dtype
        assert_eq(lazy, eager)
        np.testing.assert_array_equal(lazy.compute(), eager)


def test_leading_dimensions_are_broadcast(scene: Scene, rays: Rays) -> None:
    origins, directions = rays
    ends = np.linspace(0.5, 3.0, SHAPE[1])
    cases: list[tuple[Any, Any, Any]] = [
        ([0.0, 0.0, 3.0], da.from_array(directions, (4, 2, 3)), np.inf),
        (da.from_array(origins[:, :1], (3, 1, 3)), da.from_array(directions[0], (2, 3)), 2),
        (da.from_array(origins, (6, 2, 3)), directions, da.from_array(ends, 3)),
        (origins, directions, np.float32(1.5)),
        (da.from_array(origins, (2, 2, 3)), [0, 0, -1], da.from_array(np.array(2.5))),
        (da.from_array(origins[:0], (2, 2, 3)), directions[:0], np.inf),
        ([0, 0, 3], da.from_array(np.array([0.0, 0.0, -1.0])), da.from_array(np.array(9.0))),
    ]
    for start, way, end in cases:
        lazy = halfline.dask.intersect(scene, start, way, t_max=end)
        eager = scene.intersect(*dask.compute(start, way), t_max=dask.compute(end)[0])
        assert lazy.shape == eager.shape
        assert_eq(lazy.t, eager.t)
        assert_eq(lazy.normal, eager.normal)


def test_chunks_of_unknown_sizes(scene: Scene, rays: Rays) -> None:
    origins, directions = (array.reshape(-1, 3) for array in rays)
    wanted = origins[:, 0] > 0.0
    mask = da.from_array(wanted, 7)
    some = [da.from_array(array, (7, 3))[mask] for array in (origins, directions)]
    lazy = halfline.dask.intersect(scene, *some)
    eager = scene.intersect(origins[wanted], directions[wanted])
    assert np.isnan(lazy.shape[0])
    for name in PARTS:
        assert_eq(getattr(lazy, name), getattr(eager, name))
    assert lazy.compute().shape == eager.shape
    flags = halfline.dask.occluded(scene, [0, 0, 3], some[1])
    assert_eq(flags, scene.occluded([0, 0, 3], directions[wanted]))


def never(*_: object, **__: object) -> None:
    raise AssertionError("computed")


def test_nothing_is_computed_before_it_is_asked_for(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Scene, "intersect", never)
    monkeypatch.setattr(Scene, "occluded", never)
    origins = da.zeros((10**9, 3), dtype=np.float32, chunks=(10**6, 3))
    lazy = halfline.dask.intersect(scene, origins, [0, 0, 1])
    assert repr(lazy).startswith("<halfline.dask.LazyHits of shape (1000000000,)")
    for name, dtype in zip(PARTS, ("f8", "i8", "f8", "f8", "f8", "?"), strict=True):
        part = getattr(lazy, name)
        assert (part.dtype, part._meta.dtype, part.npartitions) == (dtype, dtype, 1000)
        assert part._meta.ndim == part.ndim
    assert halfline.dask.occluded(scene, origins, [0, 0, 1])._meta.shape == (0,)


def test_each_ray_is_cast_once(scene: Scene, rays: Rays, monkeypatch: pytest.MonkeyPatch) -> None:
    cast = Scene.intersect
    counts: list[int] = []

    def counted(self: Scene, origins: Any, *rest: Any, **more: Any) -> halfline.Hits:
        hits = cast(self, origins, *rest, **more)
        counts.append(hits.t.size)
        return hits

    monkeypatch.setattr(Scene, "intersect", counted)
    lazy = halfline.dask.intersect(scene, *(da.from_array(array, (2, 3, 3)) for array in rays))
    for asked in [
        [getattr(lazy, name) for name in PARTS],
        [lazy.t.min(), lazy.face, lazy.hit.sum(axis=0)],
        [lazy],
        [lazy, lazy.t],
    ]:
        counts.clear()
        dask.compute(*asked, scheduler="synchronous")
        assert sum(counts) == 30, asked


def test_the_same_input_has_the_same_names(scene: Scene, rays: Rays, tmp_path: Path) -> None:
    chunked = [da.from_array(array, (2, 3, 3)) for array in rays]
    first, second = (halfline.dask.intersect(scene, *chunked) for _ in range(2))
    scene.save(tmp_path / "copy.hlt")
    third = halfline.dask.intersect(tmp_path / "copy.hlt", *chunked)
    for name in PARTS:
        assert getattr(first, name).name == getattr(second, name).name == getattr(third, name).name
    assert dask.base.tokenize(first) == dask.base.tokenize(third)
    assert len({getattr(first, name).name for name in PARTS}) == len(PARTS)
    other = halfline.dask.intersect(scene, *chunked, t_max=2.0)
    assert other.t.name != first.t.name
    halfline.Scene([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).save(tmp_path / "other.hlt")
    assert halfline.dask.intersect(tmp_path / "other.hlt", *chunked).t.name != first.t.name
    with dask.config.set({"tokenize.ensure-deterministic": True}):
        assert halfline.dask.occluded(scene, *chunked).name
        assert halfline.dask.intersect(scene, *chunked).point.name == first.point.name


def test_workers_answer_as_the_scene_does(client: Client, scene: Scene, rays: Rays) -> None:
    lazy = halfline.dask.intersect(scene, *(da.from_array(array, (2, 3, 3)) for array in rays))
    eager = scene.intersect(*rays)
    kept = lazy.persist()
    assert isinstance(kept, LazyHits)
    for hits in (lazy.compute(), kept.compute(), client.compute(lazy).result()):
        assert isinstance(hits, halfline.Hits)
        for name in PARTS:
            np.testing.assert_array_equal(getattr(hits, name), getattr(eager, name))
    np.testing.assert_array_equal(kept.point.compute(), eager.point)
    # The mesh stays where it is.
    assert len(pickle.dumps(lazy.compute())) < len(pickle.dumps(eager)) / 20


def test_the_graph_is_small(client: Client, scene: Scene) -> None:
    origins = da.random.default_rng(0).random((1_000_000, 3), chunks=(10_000, 3))
    lazy = halfline.dask.intersect(scene, origins, [0.0, 0.0, 1.0])
    assert len(pickle.dumps(lazy.t.__dask_graph__())) < 40_000
    with sent(client) as sizes:
        assert lazy.hit.sum().compute() > 0
    assert 0 < sum(sizes) < 60_000


def test_what_makes_no_sense_is_refused_at_once(scene: Scene, tmp_path: Path) -> None:
    rays = da.zeros((4, 3), chunks=2)
    ask = halfline.dask.intersect
    with pytest.raises(ValueError, match=r"origins: expected shape \(\.\.\., 3\), found \(4, 2\)"):
        ask(scene, rays[:, :2], rays)
    with pytest.raises(ValueError, match=r"directions: expected shape \(\.\.\., 3\), found \(\)"):
        ask(scene, rays, 1.0)
    with pytest.raises(ValueError, match=r"that broadcast together, found origins \(4,\), dir"):
        ask(scene, rays, rays[:3])
    with pytest.raises(TypeError, match="t_max: expected float32, float64 or integers, found bool"):
        ask(scene, rays, rays, t_max=da.zeros(4, dtype=bool))
    with pytest.raises(TypeError, match=r"origins: .* found complex128"):
        halfline.dask.occluded(scene, rays * 1j, rays)
    with pytest.raises(ValueError, match=r"in memory: scene.save\(path\), then halfline.open"):
        ask(halfline.Scene(scene.mesh), rays, rays)
    with pytest.raises(TypeError, match=r"scene: expected a halfline.Scene or .* found int"):
        ask(3, rays, rays)  # type: ignore[arg-type]
    with pytest.raises(FileNotFoundError):
        ask(tmp_path / "none.hlt", rays, rays)
