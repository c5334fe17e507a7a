"""`halfline query --nearest`: points from .npy, the nearest ones to .npz, judged by NumPy alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Halfline
from meshes import Shape, bumpy_sphere, write_ply
from nearest_points import distances_to, winding_numbers

Floats = np.ndarray[Any, np.dtype[np.float64]]


def some_points(count: int, seed: int) -> Floats:
    """Points in and around the bumpy sphere, exact in single precision."""
    points = np.random.default_rng(seed).uniform(-1.6, 1.6, (count, 3))
    return points.astype(np.float32).astype(np.float64)


@pytest.fixture(scope="module")
def shape() -> Shape:
    return bumpy_sphere()


@pytest.fixture(scope="module")
def mesh(shape: Shape, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_ply(tmp_path_factory.mktemp("near") / "bumpy.ply", shape)


def nearest(
    halfline: Halfline, mesh: Path, points: np.ndarray[Any, Any], folder: Path, *arguments: str
) -> dict[str, np.ndarray[Any, Any]]:
    """What the command says is nearest to points."""
    np.save(folder / "points.npy", points)
    out = folder / "near.npz"
    halfline.ok("query", mesh, folder / "points.npy", "--nearest", "-o", out, *arguments)
    with np.load(out) as arrays:
        return dict(arrays)


def test_the_nearest_points_are_right(
    halfline: Halfline, shape: Shape, mesh: Path, tmp_path: Path
) -> None:
    points = some_points(300, seed=1)
    near = nearest(halfline, mesh, points, tmp_path)
    everywhere = distances_to(shape, points)
    np.testing.assert_allclose(near["distance"], everywhere.min(axis=1), rtol=1e-12)
    # The face is one of the nearest, and the point on it is where the distance says.
    rows = np.arange(len(points))
    np.testing.assert_allclose(everywhere[rows, near["face"]], near["distance"], rtol=1e-12)
    gap = np.linalg.norm(points - near["point"], axis=1)
    np.testing.assert_allclose(gap, near["distance"], rtol=1e-12)
    u, v = near["uv"].T
    a, b, c = np.moveaxis(shape.corners()[near["face"]], 1, 0)
    on_face = (1 - u - v)[:, None] * a + u[:, None] * b + v[:, None] * c
    np.testing.assert_allclose(on_face, near["point"], atol=1e-12)
    zeros = (np.stack([1 - u - v, u, v]) < 1e-9).sum(axis=0)
    assert (near["feature"] == np.array(["face", "edge", "vertex"])[zeros]).all()


def test_the_answer_has_documented_arrays(halfline: Halfline, mesh: Path, tmp_path: Path) -> None:
    for count in (0, 7):
        near = nearest(halfline, mesh, some_points(count, seed=2), tmp_path, "--signed")
        shapes = {name: (array.dtype.str, array.shape) for name, array in near.items()}
        assert shapes == {
            "distance": ("<f8", (count,)),
            "point": ("<f8", (count, 3)),
            "face": ("<i8", (count,)),
            "source_face": ("<i8", (count,)),
            "uv": ("<f8", (count, 2)),
            "feature": ("<U6", (count,)),
            "signed_distance": ("<f8", (count,)),
            "winding_number": ("<f8", (count,)),
        }
    assert "winding_number" not in nearest(halfline, mesh, some_points(7, seed=2), tmp_path)


def test_distances_are_negative_inside(
    halfline: Halfline, shape: Shape, mesh: Path, tmp_path: Path
) -> None:
    points = some_points(300, seed=3)
    near = nearest(halfline, mesh, points, tmp_path, "--signed")
    winding = winding_numbers(shape, points)
    np.testing.assert_array_equal(near["winding_number"], winding.round())
    assert 30 < (winding > 0.5).sum() < 270
    sign = np.where(winding > 0.5, -1, 1)
    np.testing.assert_array_equal(near["signed_distance"], sign * near["distance"])


def test_a_point_that_is_not_finite_is_near_nothing(
    halfline: Halfline, mesh: Path, tmp_path: Path
) -> None:
    points = np.array([[np.nan, 0, 0], [0, np.inf, 0], [2.0, 0, 0]])
    near = nearest(halfline, mesh, points, tmp_path, "--signed")
    assert (near["distance"][:2] == np.inf).all()
    assert near["distance"][2] < 2
    assert (near["face"][:2] == -1).all()
    assert (near["source_face"][:2] == -1).all()
    assert (near["feature"][:2] == "").all()
    assert near["feature"][2] != ""
    for name in ("point", "uv", "signed_distance", "winding_number"):
        assert np.isnan(near[name][:2]).all(), name
        assert not np.isnan(near[name][2]).any(), name


def test_a_point_on_the_surface_is_inside_at_no_distance(
    halfline: Halfline, shape: Shape, mesh: Path, tmp_path: Path
) -> None:
    near = nearest(halfline, mesh, shape.vertices[:50], tmp_path, "--signed")
    for name in ("distance", "signed_distance"):
        assert (near[name] == 0).all()
        assert not np.signbit(near[name]).any()
    assert (near["feature"] == "vertex").all()
    np.testing.assert_array_equal(near["point"], shape.vertices[:50])


@pytest.mark.parametrize("dtype", ["<f4", ">f8"])
def test_points_may_be_of_any_float_and_order(
    halfline: Halfline, mesh: Path, tmp_path: Path, dtype: str
) -> None:
    points = some_points(64, seed=4)
    expected = nearest(halfline, mesh, points, tmp_path)
    found = nearest(halfline, mesh, np.asfortranarray(points.astype(dtype)), tmp_path)
    for name, array in expected.items():
        np.testing.assert_array_equal(found[name], array)


def test_threads_and_trees_do_not_change_a_bit(
    halfline: Halfline, mesh: Path, tmp_path: Path
) -> None:
    tree = tmp_path / "bumpy.hlt"
    halfline.ok("build", mesh, "-o", tree)
    points = some_points(500, seed=5)
    expected = nearest(halfline, mesh, points, tmp_path, "--signed")
    for source, threads in ((mesh, "1"), (tree, "2")):
        found = nearest(halfline, source, points, tmp_path, "--signed", "--threads", threads)
        for name, array in expected.items():
            np.testing.assert_array_equal(found[name], array)


def test_more_points_than_are_asked_about_at_a_time(halfline: Halfline, tmp_path: Path) -> None:
    """Points above a triangle, each at a height of its own."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    triangle = write_ply(tmp_path / "triangle.ply", Shape(corners, np.array([[0, 1, 2]])))
    heights = np.arange(300_000) / 2**20
    places = np.random.default_rng(9).uniform(0.1, 0.4, (len(heights), 2))
    points = np.column_stack([places, heights])
    near = nearest(halfline, triangle, points, tmp_path, "--signed")
    np.testing.assert_array_equal(near["distance"], heights)
    np.testing.assert_array_equal(near["signed_distance"], heights)
    np.testing.assert_array_equal(near["point"][:, :2], places)


def test_figures_as_json(halfline: Halfline, mesh: Path, tmp_path: Path) -> None:
    points = some_points(100, seed=6)
    points[3] = np.nan
    np.save(tmp_path / "points.npy", points)
    near = tmp_path / "near.npz"
    figures = halfline.json(
        "query", mesh, tmp_path / "points.npy", "--nearest", "--signed", "-o", near
    )
    assert figures["question"] == "nearest"
    assert figures["points"] == 100
    assert figures["invalid_points"] == 1
    with np.load(near) as arrays:
        assert figures["inside_points"] == (arrays["signed_distance"] <= 0).sum()


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--nearest", "--any"], "cannot be used with"),
        (["--nearest", "--all"], "cannot be used with"),
        (["--nearest", "--engine", "brute"], "cannot be used with"),
        (["--signed"], "--nearest"),
    ],
)
def test_wrong_arguments(
    halfline: Halfline, mesh: Path, tmp_path: Path, arguments: list[str], reason: str
) -> None:
    np.save(tmp_path / "points.npy", some_points(3, seed=7))
    near = tmp_path / "near.npz"
    done = halfline.fails(2, "query", mesh, tmp_path / "points.npy", "-o", near, *arguments)
    assert reason in done
    assert not near.exists()


def test_rays_are_no_points(halfline: Halfline, mesh: Path, tmp_path: Path) -> None:
    np.save(tmp_path / "rays.npy", np.zeros((4, 6)))
    near = tmp_path / "near.npz"
    done = halfline.fails(1, "query", mesh, tmp_path / "rays.npy", "--nearest", "-o", near)
    assert "shape is (4, 6), expected (n, 3) for points" in done
    assert not near.exists()


def test_a_file_cut_short_is_refused(halfline: Halfline, mesh: Path, tmp_path: Path) -> None:
    path = tmp_path / "points.npy"
    np.save(path, some_points(10, seed=8))
    path.write_bytes(path.read_bytes()[:-8])
    near = tmp_path / "near.npz"
    assert "the file ends before" in halfline.fails(1, "query", mesh, path, "--nearest", "-o", near)
    assert not near.exists()
