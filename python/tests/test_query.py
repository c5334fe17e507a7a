"""`halfline query`: rays from .npy, hits to .npz, judged by NumPy alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Halfline, Judged
from meshes import Shape, bumpy_sphere, gridded_cube, write_obj, write_off, write_ply, write_stl
from moeller_trumbore import crossings

ENGINES = ["fast", "textbook", "brute"]

Arrays = dict[str, np.ndarray[Any, Any]]


def assert_closest(hits: Arrays, judged: Judged) -> None:
    """The closest hits are the judge's, wherever the judge is sure."""
    face, t = judged.crossings.closest(len(judged.rays))
    sure = ~judged.crossings.unsure
    np.testing.assert_array_equal(hits["face"][sure], face[sure])
    np.testing.assert_allclose(hits["t"][sure], t[sure], rtol=1e-12)


def points_of(rays: np.ndarray[Any, Any], t: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The points at parameter t of rays (n, 6 or more)."""
    return np.asarray(rays[:, :3] + t[:, None] * rays[:, 3:6])


@pytest.mark.parametrize("engine", ENGINES)
def test_the_closest_hits_are_right(
    halfline: Halfline, judged: Judged, tmp_path: Path, engine: str
) -> None:
    hits = halfline.query(judged.path, judged.rays, tmp_path, "--engine", engine)
    assert_closest(hits, judged)


def test_the_engines_agree_to_the_bit(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    answers = [halfline.query(judged.path, judged.rays, tmp_path, "--engine", e) for e in ENGINES]
    for other in answers[1:]:
        for name, array in answers[0].items():
            np.testing.assert_array_equal(other[name], array)


def test_the_answer_has_documented_arrays(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    hits = halfline.query(judged.path, judged.rays, tmp_path)
    n = len(judged.rays)
    assert {name: (array.dtype, array.shape) for name, array in hits.items()} == {
        "t": (np.float64, (n,)),
        "face": (np.int64, (n,)),
        "uv": (np.float64, (n, 2)),
        "source_face": (np.int64, (n,)),
    }


def test_a_miss_is_infinite_and_minus_one(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    away = judged.rays.copy()
    away[:, 3:] = away[:, :3]
    hits = halfline.query(judged.path, away, tmp_path)
    assert (hits["t"] == np.inf).all()
    assert (hits["face"] == -1).all()
    assert (hits["source_face"] == -1).all()


def test_uv_weighs_the_second_and_third_vertex(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    hits = halfline.query(judged.path, judged.rays, tmp_path)
    hit = hits["face"] >= 0
    u, v = hits["uv"][hit].T
    a, b, c = np.moveaxis(judged.shape.corners()[hits["face"][hit]], 1, 0)
    on_face = (1 - u - v)[:, None] * a + u[:, None] * b + v[:, None] * c
    on_ray = points_of(judged.rays[hit], hits["t"][hit])
    np.testing.assert_allclose(on_face, on_ray, atol=1e-11)


@pytest.mark.parametrize("dtype", ["<f4", "<f8"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_rays_come_in_either_precision_and_order(
    halfline: Halfline, judged: Judged, tmp_path: Path, dtype: str, order: Any
) -> None:
    rays = np.array(judged.rays, dtype=dtype, order=order)
    assert_closest(halfline.query(judged.path, rays, tmp_path), judged)


@pytest.mark.parametrize("version", [(1, 0), (2, 0), (3, 0)])
def test_every_version_of_npy_is_read(
    halfline: Halfline, judged: Judged, tmp_path: Path, version: tuple[int, int]
) -> None:
    rays = tmp_path / "rays.npy"
    with rays.open("wb") as file:
        np.lib.format.write_array(file, judged.rays, version=version)
    halfline.ok("query", judged.path, rays, "-o", tmp_path / "hits.npz")
    with np.load(tmp_path / "hits.npz") as hits:
        assert_closest(dict(hits), judged)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_range_of_t_cuts_the_ray(
    halfline: Halfline, judged: Judged, tmp_path: Path, engine: str
) -> None:
    random = np.random.default_rng(2)
    ends = np.sort(random.uniform(0.3, 1.7, size=(len(judged.rays), 2)), axis=1)
    rays = np.hstack([judged.rays, ends])
    found = crossings(judged.shape, rays)
    hits = halfline.query(judged.path, rays, tmp_path, "--engine", engine)
    assert_closest(hits, Judged(judged.shape, judged.path, rays, found))


def test_a_range_includes_its_ends(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    t = halfline.query(judged.path, judged.rays, tmp_path)["t"]
    hit = np.isfinite(t)
    rays = np.hstack([judged.rays, t[:, None], t[:, None]])[hit]
    np.testing.assert_array_equal(halfline.query(judged.path, rays, tmp_path)["t"], t[hit])


@pytest.mark.parametrize("engine", ENGINES)
def test_any_tells_whether_there_is_a_hit(
    halfline: Halfline, judged: Judged, tmp_path: Path, engine: str
) -> None:
    answer = halfline.query(judged.path, judged.rays, tmp_path, "--any", "--engine", engine)
    assert list(answer) == ["occluded"]
    assert answer["occluded"].dtype == np.bool_
    face, _ = judged.crossings.closest(len(judged.rays))
    sure = ~judged.crossings.unsure
    np.testing.assert_array_equal(answer["occluded"][sure], face[sure] >= 0)


@pytest.mark.parametrize("engine", ENGINES)
def test_all_gives_every_crossing_in_order(
    halfline: Halfline, judged: Judged, tmp_path: Path, engine: str
) -> None:
    answer = halfline.query(judged.path, judged.rays, tmp_path, "--all", "--engine", engine)
    splits = answer["splits"]
    assert splits.dtype == np.int64
    assert splits.shape == (len(judged.rays) + 1,)
    ray = np.repeat(np.arange(len(judged.rays)), np.diff(splits))
    assert set(answer) == {"splits", "t", "face", "uv", "source_face"}
    assert {len(answer[name]) for name in ("t", "face", "uv", "source_face")} == {splits[-1]}

    expected = judged.crossings
    assert np.bincount(expected.ray).max() > 4, "the mesh should be met many times"
    ours, theirs = ~expected.unsure[ray], ~expected.unsure[expected.ray]
    np.testing.assert_array_equal(ray[ours], expected.ray[theirs])
    np.testing.assert_array_equal(answer["face"][ours], expected.face[theirs])
    np.testing.assert_allclose(answer["t"][ours], expected.t[theirs], rtol=1e-12)
    np.testing.assert_allclose(answer["uv"][ours], expected.uv[theirs], atol=1e-9)


def rays_at_vertices_and_edges(cells: int) -> np.ndarray[Any, Any]:
    """Rays from outside the gridded cube, exactly through its vertices, edges and diagonals.

    Everything is a small multiple of a half, so that no coordinate of theirs is rounded.
    """
    steps = np.arange(0.5, cells, 0.5)
    targets = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    directions = np.array([[1, 0, 0], [0, -1, 0], [0, 0, 1], [1, 1, 0], [1, -1, 1], [-2, 1, 0]])
    origins = targets[:, None, :] - 64.0 * directions[None, :, :]
    return np.hstack([origins.reshape(-1, 3), np.tile(directions, (len(targets), 1))])


@pytest.mark.parametrize("engine", ENGINES)
def test_no_ray_slips_through_an_edge_or_a_vertex(
    halfline: Halfline, tmp_path: Path, engine: str
) -> None:
    cells = 4
    mesh = write_ply(tmp_path / "cube.ply", gridded_cube(cells))
    rays = rays_at_vertices_and_edges(cells)
    closest = halfline.query(mesh, rays, tmp_path, "--engine", engine)
    with np.errstate(divide="ignore", invalid="ignore"):
        walls = (np.array([[[0.0]], [[cells]]]) - rays[:, :3]) / rays[:, 3:]
    # A ray is in the cube once it is within all three slabs.
    entry = np.where(rays[:, 3:] == 0, -np.inf, walls.min(axis=0)).max(axis=1)
    np.testing.assert_array_equal(closest["t"], entry)

    every = halfline.query(mesh, rays, tmp_path, "--engine", engine, "--all")
    np.testing.assert_array_equal(np.diff(every["splits"]), 2)


def test_no_rays_give_empty_arrays(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    none = np.empty((0, 6))
    hits = halfline.query(judged.path, none, tmp_path)
    assert {name: array.shape for name, array in hits.items()} == {
        "t": (0,),
        "face": (0,),
        "uv": (0, 2),
        "source_face": (0,),
    }
    every = halfline.query(judged.path, none, tmp_path, "--all")
    assert every["splits"].tolist() == [0]


def test_a_ray_without_meaning_hits_nothing(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    towards = [0.0, 0.0, 5.0, 0.01, 0.02, -1.0]
    rays = np.array(
        [
            [*towards, 0.0, np.inf],
            [np.nan, *towards[1:], 0.0, np.inf],
            [*towards[:3], 0.0, 0.0, 0.0, 0.0, np.inf],
            [*towards[:3], 0.0, np.inf, 0.0, 0.0, np.inf],
            [*towards, 9.0, 1.0],
            [*towards, np.nan, np.inf],
        ]
    )
    hits = halfline.query(judged.path, rays, tmp_path)
    assert (hits["face"] >= 0).tolist() == [True, False, False, False, False, False]


def test_the_result_does_not_depend_on_threads(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    one = halfline.query(judged.path, judged.rays, tmp_path, "--threads", "1")
    three = halfline.query(judged.path, judged.rays, tmp_path, "--threads", "3")
    for name, array in one.items():
        np.testing.assert_array_equal(three[name], array)


@pytest.mark.parametrize("write", [write_stl, write_obj, write_off])
def test_every_format_gives_the_same_hits(
    halfline: Halfline, judged: Judged, tmp_path: Path, write: Any
) -> None:
    path = write(tmp_path / f"bumpy.{write.__name__.removeprefix('write_')}", judged.shape)
    assert_closest(halfline.query(path, judged.rays, tmp_path), judged)


def test_double_coordinates_stay_double(halfline: Halfline, tmp_path: Path) -> None:
    # In map coordinates single precision is some 3 centimetres wrong.
    shape = bumpy_sphere()
    offset = np.array([500_000.0, 5_300_000.0, 300.0])
    vertices = shape.vertices * 1.1 + offset
    path = write_ply(tmp_path / "map.ply", Shape(vertices, shape.faces), "<f8")
    above = offset + np.array([0.1, 0.2, 9.0])
    rays = np.array([[*above, 0.0, 0.0, -1.0]])
    expected = crossings(Shape(vertices - offset, shape.faces), rays - [[*offset, 0, 0, 0]])
    hits = halfline.query(path, rays, tmp_path)
    # Coordinates of 5.3 million are given in steps of 1e-9.
    np.testing.assert_allclose(hits["t"], expected.t[:1], atol=1e-8)


def test_hits_name_the_face_of_the_file(halfline: Halfline, tmp_path: Path) -> None:
    mesh = tmp_path / "quads.obj"
    mesh.write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4\nf 2 5 6 3\n",
        encoding="utf-8",
    )
    at = np.array([[0.7, 0.2], [0.2, 0.7], [1.7, 0.2], [1.2, 0.7]])
    rays = np.hstack([at, np.ones((4, 1)), np.tile([0.0, 0.0, -1.0], (4, 1))])
    hits = halfline.query(mesh, rays, tmp_path)
    assert sorted(hits["face"].tolist()) == [0, 1, 2, 3]
    assert hits["source_face"].tolist() == [0, 0, 1, 1]


def test_json_tells_how_long_it_took(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    np.save(tmp_path / "rays.npy", judged.rays)
    arguments = ("query", judged.path, tmp_path / "rays.npy", "-o", tmp_path / "hits.npz")
    answer = halfline.json(*arguments)
    assert answer["rays"] == len(judged.rays)
    for stage in ("load_seconds", "build_seconds", "trace_seconds", "write_seconds"):
        assert answer[stage] >= 0.0
    assert answer["rays_per_second"] == pytest.approx(answer["rays"] / answer["trace_seconds"])
