"""Hits, all hits and pictures as objects: indexing, truth, leaving a surface."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import halfline
import numpy as np
import pytest


@pytest.fixture(scope="module")
def scene() -> halfline.Scene:
    return halfline.Scene(halfline.generate("scan", 5_000, 0))


def through(scene: halfline.Scene, shape: tuple[int, ...]) -> halfline.AllHits:
    random = np.random.default_rng(1)
    origins = random.normal(size=(*shape, 3)) * 3
    return scene.intersect_all(origins, random.normal(size=(*shape, 3)) * 0.3 - origins)


@pytest.mark.parametrize(
    "index",
    [
        slice(2, 7),
        slice(None, None, -3),
        [4, 4, -1],
        np.arange(12) % 3 == 1,
        (slice(None), None),
        Ellipsis,
        slice(3, 3),
    ],
)
def test_some_rays_of_all_hits_are_those_rays(scene: halfline.Scene, index: Any) -> None:
    found = through(scene, (12,))
    assert found.count.sum() > 5
    some = found[index]
    numbers = np.arange(12)[index]
    assert some.shape == numbers.shape
    for ray, number in enumerate(numbers.ravel().tolist()):
        row = slice(int(some.splits[ray]), int(some.splits[ray + 1]))
        for name in ("t", "face", "uv", "point", "normal"):
            assert (getattr(some, name)[row] == getattr(found[number], name)).all()


def test_all_hits_are_a_sequence_of_rays(scene: halfline.Scene) -> None:
    found = through(scene, (6,))
    assert len(found) == 6 == len(list(found))
    assert [len(hits.t) for hits in found] == found.count.tolist()
    assert (found[-1].t == found[5].t).all()
    with pytest.raises(IndexError, match="6 rays"):
        found[6]
    grid = through(scene, (3, 4))
    assert len(grid) == 3
    assert (grid[1].count == grid.count[1]).all()
    assert (grid[1, 2].t == grid[1][2].t).all()
    assert sum(len(hits.t) for row in grid for hits in row) == len(grid.t)
    with pytest.raises(IndexError):
        grid[3, 0]


def test_hits_of_many_rays_have_no_truth(scene: halfline.Scene) -> None:
    one = scene.intersect((0, 0, 9), (0, 0, -1))
    assert one
    assert not scene.intersect((0, 0, 9), (0, 0, 1))
    with pytest.raises(ValueError, match=r"\.hit\.any\(\)"):
        bool(scene.intersect([(0, 0, 9)], (0, 0, 1)))
    with pytest.raises(ValueError, match=r"\.count\.any\(\)"):
        bool(through(scene, (2,)))


def test_rays_leave_the_surface_they_start_on(scene: halfline.Scene) -> None:
    random = np.random.default_rng(2)
    away = random.normal(size=(20_000, 3))
    origins = 3 * away / np.linalg.norm(away, axis=1)[:, None]
    hits = scene.intersect(origins, random.normal(size=away.shape) * 0.4 - origins)
    ways = random.normal(size=away.shape)
    starts = hits.origins_towards(ways)
    assert (np.isnan(starts).all(axis=1) == ~hits.hit).all()
    again = scene.intersect(starts, ways)
    assert not (again.face == hits.face)[hits.hit].any()
    # From the point itself many do.
    assert (scene.intersect(hits.point, ways).face == hits.face)[hits.hit].any()
    assert np.abs(starts - hits.point)[hits.hit].max() < 1e-12
    # They are on the sides to which they go.
    side = np.einsum("ij,ij->i", starts - hits.point, hits.normal)[hits.hit]
    toward = np.einsum("ij,ij->i", ways, hits.normal)[hits.hit]
    assert (np.sign(side) == np.sign(toward)).all()

    assert hits[:5].origins_towards((1, 2, 3)).shape == (5, 3)
    assert hits[0].origins_towards((1, 2, 3)).shape == (3,)
    with pytest.raises(ValueError, match="directions: expected a shape that broadcasts"):
        hits.origins_towards(ways[:7])


def test_what_is_computed_from_a_picture_is_numbers(scene: halfline.Scene) -> None:
    image: Any = scene.render(width=40, height=30, samples=1)
    assert type(image.mean()) is np.float64
    assert type(image * 0.5) is np.ndarray
    assert type(image.max()) is np.uint8
    assert type(image[:10]) is halfline.Image
    assert image[:10].depth is None
    assert image._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"
    assert image[0]._repr_png_() is None


def test_a_mesh_is_written_and_read_back(tmp_path: Path, scene: halfline.Scene) -> None:
    path = tmp_path / "scan.ply"
    scene.mesh.save(path)
    again = halfline.load(path)
    assert (again.vertices == scene.mesh.vertices).all()
    assert (again.faces == scene.mesh.faces).all()
    with pytest.raises(ValueError, match=r"ends in \.ply"):
        scene.mesh.save(tmp_path / "scan.stl")
    with pytest.raises(ValueError, match="the name of a tree"):
        scene.save(tmp_path / "scan.ply")
    with pytest.raises(TypeError, match="path: expected a path, found int"):
        halfline.load(3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"halfline\.load reads meshes"):
        halfline.Scene(str(path))
    with pytest.raises(TypeError, match="triangles: expected an integer, found float"):
        halfline.generate("scan", 1e3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="found None"):
        scene.intersect((0, 0, 9), (0, 0, -1), t_max=None)  # type: ignore[arg-type]
    assert scene.intersect([], []).shape == (0,)
