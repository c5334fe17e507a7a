"""What scenes answer, judged by NumPy."""

from __future__ import annotations

import halfline
import numpy as np
import pytest
from conftest import Judged
from meshes import Floats, bumpy_sphere
from numpy.typing import DTypeLike, NDArray

# Barycentrics and t of the judge are float64 sums of products of coordinates near one.
CLOSE = 1e-9


@pytest.fixture(scope="module", params=[np.float32, np.float64], ids=["float32", "float64"])
def scene(request: pytest.FixtureRequest, judged: Judged) -> halfline.Scene:
    """The judged mesh, in either precision: its coordinates are exact in both."""
    vertices = judged.shape.vertices.astype(request.param)
    return halfline.Scene(vertices, judged.shape.faces)


def columns(judged: Judged, dtype: DTypeLike) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    rays = judged.rays.astype(dtype)
    return rays[:, :3].copy(), rays[:, 3:].copy()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_closest_hits_are_those_of_the_judge(
    scene: halfline.Scene, judged: Judged, dtype: DTypeLike
) -> None:
    hits = scene.intersect(*columns(judged, dtype))
    face, t = judged.crossings.closest(len(judged.rays))
    sure = ~judged.crossings.unsure
    assert (face >= 0).sum() > 500
    np.testing.assert_array_equal(hits.face[sure], face[sure])
    np.testing.assert_allclose(hits.t[sure], t[sure], rtol=CLOSE)
    assert [a.dtype.name for a in (hits.t, hits.face, hits.uv)] == ["float64", "int64", "float64"]
    assert hits.t.shape == hits.face.shape == hits.hit.shape == (2000,)
    assert hits.uv.shape == (2000, 2)
    np.testing.assert_array_equal(hits.hit, hits.face >= 0)

    # A miss says so in every array.
    missed = ~hits.hit
    assert missed.any()
    assert np.all(hits.t[missed] == np.inf)
    assert np.all(hits.face[missed] == -1)
    assert np.all(hits.uv[missed] == 0.0)
    assert np.isnan(hits.point[missed]).all()
    assert np.isnan(hits.normal[missed]).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_all_hits_are_those_of_the_judge(
    scene: halfline.Scene, judged: Judged, dtype: DTypeLike
) -> None:
    hits = scene.intersect_all(*columns(judged, dtype))
    found = judged.crossings
    assert not found.unsure.any()
    np.testing.assert_array_equal(hits.ray, found.ray)
    np.testing.assert_array_equal(hits.face, found.face)
    np.testing.assert_allclose(hits.t, found.t, rtol=CLOSE)
    np.testing.assert_allclose(hits.uv, found.uv, atol=CLOSE)
    assert hits.splits.shape == (2001,)
    assert hits.splits[0] == 0
    assert hits.splits[-1] == len(hits.t) == len(found.t)
    assert [a.dtype.name for a in (hits.splits, hits.face, hits.ray)] == ["int64"] * 3
    assert [a.dtype.name for a in (hits.t, hits.uv)] == ["float64"] * 2

    counts = scene.count_intersections(*columns(judged, dtype))
    assert counts.dtype == np.int64
    np.testing.assert_array_equal(counts, np.bincount(found.ray, minlength=2000))
    np.testing.assert_array_equal(counts, hits.count)

    occluded = scene.occluded(*columns(judged, dtype))
    assert occluded.dtype == np.bool_
    np.testing.assert_array_equal(occluded, counts > 0)


def test_points_and_normals_lie_on_the_faces(scene: halfline.Scene, judged: Judged) -> None:
    origins, directions = columns(judged, np.float64)
    hits = scene.intersect(origins, directions)
    hit = hits.hit
    along = origins + hits.t[:, np.newaxis] * directions
    np.testing.assert_allclose(hits.point[hit], along[hit], atol=CLOSE)
    a, b, c = np.moveaxis(judged.shape.corners()[hits.face[hit]], 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(hits.normal[hit], normals, atol=CLOSE)

    all_hits = scene.intersect_all(origins, directions)
    along = origins[all_hits.ray] + all_hits.t[:, np.newaxis] * directions[all_hits.ray]
    np.testing.assert_allclose(all_hits.point, along, atol=CLOSE)
    np.testing.assert_allclose(np.linalg.norm(all_hits.normal, axis=1), 1.0)


def test_points_of_many_hits_are_those_of_few(scene: halfline.Scene, judged: Judged) -> None:
    # Beyond some ten thousand several threads find them.
    hits = scene.intersect(*columns(judged, np.float64))
    index = np.resize(np.arange(2000), (50, 1000))
    many = hits[index]
    np.testing.assert_array_equal(many.point, hits.point[index])
    np.testing.assert_array_equal(many.normal, hits.normal[index])


def test_a_range_leaves_hits_out(scene: halfline.Scene, judged: Judged) -> None:
    origins, directions = columns(judged, np.float64)
    t = judged.crossings.t
    for t_min, t_max in [(0.0, 0.8), (0.9, np.inf), (0.7, 1.1)]:
        inside = (t >= t_min) & (t <= t_max)
        expected = np.bincount(judged.crossings.ray[inside], minlength=2000)
        counts = scene.count_intersections(origins, directions, t_min=t_min, t_max=t_max)
        np.testing.assert_array_equal(counts, expected)
        occluded = scene.occluded(origins, directions, t_min=t_min, t_max=t_max)
        np.testing.assert_array_equal(occluded, expected > 0)
        hits = scene.intersect(origins, directions, t_min=t_min, t_max=t_max)
        np.testing.assert_array_equal(hits.hit, expected > 0)
        found = scene.intersect_all(origins, directions, t_min=t_min, t_max=t_max)
        np.testing.assert_array_equal(found.count, expected)


def test_each_ray_may_have_its_own_range(scene: halfline.Scene, judged: Judged) -> None:
    origins, directions = columns(judged, np.float32)
    closest = scene.intersect(origins, directions)
    # From just behind the first hit on there is one hit less.
    t_min = np.where(closest.hit, np.nextafter(closest.t, np.inf), 0.0)
    counts = scene.count_intersections(origins, directions)
    fewer = scene.count_intersections(origins, directions, t_min=t_min)
    np.testing.assert_array_equal(fewer, counts - closest.hit)
    # To the first hit, itself included, there is just that.
    t_max = closest.t
    ones = scene.count_intersections(origins, directions, t_max=t_max)
    np.testing.assert_array_equal(ones, closest.hit.astype(int))


@pytest.fixture(scope="module")
def square() -> halfline.Scene:
    """The unit square at z = 0, of two triangles."""
    return halfline.Scene([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])


def test_t_counts_in_units_of_the_direction(square: halfline.Scene) -> None:
    hits = square.intersect([0.75, 0.25, 4.0], [0.0, 0.0, -2.0])
    assert hits.shape == ()
    assert float(hits.t) == 2.0
    assert int(hits.face) == 0
    assert hits.uv.tolist() == [0.5, 0.25]
    assert hits.point.tolist() == [0.75, 0.25, 0.0]
    assert hits.normal.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_rays_that_are_not_finite_hit_nothing(square: halfline.Scene, bad: float) -> None:
    origins = np.full((6, 3), [0.75, 0.25, 4.0])
    directions = np.full((6, 3), [0.0, 0.0, -2.0])
    origins[0, 1] = bad
    directions[1, 2] = bad
    directions[2] = 0.0
    t_min = np.array([0.0, 0.0, 0.0, np.nan, 3.0, 0.0])
    t_max = np.array([9.0, 9.0, 9.0, 9.0, 1.0, 9.0])
    hits = square.intersect(origins, directions, t_min=t_min, t_max=t_max)
    assert hits.hit.tolist() == [False, False, False, False, False, True]
    assert square.count_intersections(origins, directions, t_min=t_min, t_max=t_max).tolist() == [
        0,
        0,
        0,
        0,
        0,
        1,
    ]


@pytest.mark.parametrize(
    ("origins", "directions", "shape"),
    [
        ((3,), (3,), ()),
        ((1, 3), (3,), (1,)),
        ((3,), (5, 3), (5,)),
        ((5, 3), (3,), (5,)),
        ((4, 5, 3), (3,), (4, 5)),
        ((4, 1, 3), (1, 5, 3), (4, 5)),
        ((4, 1, 3), (5, 3), (4, 5)),
        ((1, 1, 3), (4, 5, 3), (4, 5)),
        ((0, 3), (3,), (0,)),
        ((0, 3), (1, 3), (0,)),
        ((4, 0, 3), (4, 0, 3), (4, 0)),
        ((90, 1, 3), (100, 3), (90, 100)),
    ],
)
def test_leading_dimensions_are_broadcast_and_kept(
    scene: halfline.Scene,
    origins: tuple[int, ...],
    directions: tuple[int, ...],
    shape: tuple[int, ...],
) -> None:
    random = np.random.default_rng(3)
    starts = random.uniform(-0.2, 0.2, size=origins) + np.array([0.0, 0.0, 3.0])
    ways = random.uniform(-0.2, 0.2, size=directions) + np.array([0.0, 0.0, -2.0])
    flat_starts = np.broadcast_to(starts, (*shape, 3)).reshape(-1, 3)
    flat_ways = np.broadcast_to(ways, (*shape, 3)).reshape(-1, 3)

    hits = scene.intersect(starts, ways)
    flat = scene.intersect(flat_starts.copy(), flat_ways.copy())
    assert hits.shape == hits.t.shape == hits.face.shape == hits.hit.shape == shape
    assert hits.uv.shape == (*shape, 2)
    assert hits.point.shape == hits.normal.shape == (*shape, 3)
    np.testing.assert_array_equal(hits.t.ravel(), flat.t)
    np.testing.assert_array_equal(hits.uv.reshape(-1, 2), flat.uv)
    assert flat.hit.all()

    assert scene.occluded(starts, ways).shape == shape
    counts = scene.count_intersections(starts, ways)
    assert counts.shape == shape
    all_hits = scene.intersect_all(starts, ways)
    assert all_hits.shape == shape
    assert all_hits.splits.shape == (flat.t.size + 1,)
    np.testing.assert_array_equal(all_hits.count, counts)


def test_ranges_are_broadcast_too(scene: halfline.Scene) -> None:
    origin, direction = np.array([0.01, 0.02, 5.0]), np.array([0.0, 0.0, -1.0])
    t_max = np.array([1.0, 4.5, 9.0])
    assert scene.occluded(origin, direction, t_max=t_max).tolist() == [False, True, True]
    origins = np.broadcast_to(origin, (2, 1, 3))
    found = scene.occluded(origins, direction, t_max=t_max, t_min=[[0.0], [7.0]])
    assert found.tolist() == [[False, True, True], [False, False, False]]


def test_one_origin_is_not_copied_for_each_direction() -> None:
    import tracemalloc

    scene = halfline.Scene(*_bumpy())
    directions = np.random.default_rng(1).normal(size=(200_000, 3))
    scene.occluded(np.zeros(3), directions)
    tracemalloc.start()
    scene.occluded(np.zeros(3), directions)
    scene.occluded(np.zeros((1, 3), dtype=np.float32), directions)
    scene.occluded(directions, np.ones(3))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # A flag for each ray, twice.
    assert peak < 600_000


def _bumpy() -> tuple[Floats, NDArray[np.int64]]:
    shape = bumpy_sphere()
    return shape.vertices, shape.faces


def test_all_hits_are_found_by_ray(scene: halfline.Scene, judged: Judged) -> None:
    origins, directions = columns(judged, np.float64)
    all_hits = scene.intersect_all(origins.reshape(40, 50, 3), directions.reshape(40, 50, 3))
    flat = scene.intersect_all(origins, directions)
    ray = int(np.argmax(np.diff(flat.splits)))
    row = flat[ray]
    assert len(row) >= 4
    np.testing.assert_array_equal(row.t, np.sort(flat.t[flat.ray == ray]))
    i, j = divmod(ray, 50)
    np.testing.assert_array_equal(all_hits[i, j].t, row.t)
    np.testing.assert_array_equal(all_hits[i - 40, j - 50].face, row.face)
    counts = [len(hits.t) for row in all_hits for hits in row]
    assert counts == np.diff(flat.splits).tolist()
    for wrong in [(40, 0), (0, 50), (-41, 0)]:
        with pytest.raises(IndexError, match="out of bounds"):
            all_hits[wrong]


def test_hits_are_indexed_as_arrays_are(scene: halfline.Scene, judged: Judged) -> None:
    origins, directions = columns(judged, np.float64)
    hits = scene.intersect(origins.reshape(40, 50, 3), directions.reshape(40, 50, 3))
    assert len(hits) == 40
    assert len(list(hits)) == 40
    mask = hits.hit
    picked = hits[mask]
    np.testing.assert_array_equal(picked.point, hits.point[mask])
    np.testing.assert_array_equal(picked.uv, hits.uv[mask])
    np.testing.assert_array_equal(hits[..., 3].uv, hits.uv[:, 3])
    np.testing.assert_array_equal(hits[2:4, 1].normal, hits.normal[2:4, 1])
    np.testing.assert_array_equal(hits[5, 7].uv, hits.uv[5, 7])
    with pytest.raises(TypeError, match="no length"):
        len(hits[0, 0])


def test_answers_show_themselves(square: halfline.Scene) -> None:
    hit = square.intersect([0.75, 0.25, 4.0], [0.0, 0.0, -2.0])
    assert repr(hit) == ("<halfline.Hits: face 0 at t=2, uv=(0.5, 0.25), point=(0.75, 0.25, 0)>")
    assert repr(square.intersect([5, 5, 4], [0, 0, -1])) == "<halfline.Hits: a miss>"
    hits = square.intersect([[0.75, 0.25, 4.0], [5.0, 5.0, 4.0]], [0.0, 0.0, -1.0])
    assert repr(hits) == "<halfline.Hits of shape (2,): 2 rays, 1 hit, 4 to 4 as t>"
    assert "<td style='text-align:left'>4 to 4</td>" in hits._repr_html_()
    all_hits = square.intersect_all([[0.75, 0.25, 4.0], [5.0, 5.0, 4.0]], [0.0, 0.0, -1.0])
    assert repr(all_hits) == (
        "<halfline.AllHits of rays of shape (2,): 2 rays, 1 hits, 1 on one ray at most>"
    )
    assert "AllHits" in all_hits._repr_html_()
    assert repr(square) == "<halfline.Scene: 2 triangles, float64, preset 'balanced'>"
    assert "halfline.Scene" in square._repr_html_()


@pytest.mark.parametrize("preset", ["fast", "balanced", "best"])
def test_no_answer_depends_on_the_preset(judged: Judged, preset: str) -> None:
    origins, directions = columns(judged, np.float64)
    balanced = halfline.Scene(judged.shape.vertices, judged.shape.faces)
    scene = halfline.Scene(judged.shape.vertices, judged.shape.faces, preset=preset)
    assert scene.info()["preset"] == preset
    hits, expected = scene.intersect(origins, directions), balanced.intersect(origins, directions)
    np.testing.assert_array_equal(hits.t, expected.t)
    np.testing.assert_array_equal(hits.face, expected.face)


def test_figures_are_those_of_the_command(judged: Judged, halfline_info: dict[str, object]) -> None:
    info = halfline.Scene(halfline.load(judged.path)).info()
    for name in set(info) - {"build_seconds"}:
        assert info[name] == halfline_info[name], name
    assert info["build_seconds"] > 0.0


def test_an_empty_scene_answers() -> None:
    scene = halfline.Scene(np.empty((0, 3)), np.empty((0, 3), dtype=int))
    assert not scene.intersect([[0, 0, 0]], [1, 0, 0]).hit.any()
    assert len(scene.intersect_all(np.zeros((5, 3)), [1, 0, 0]).t) == 0
    assert scene.info()["bounds"] is None
    assert "nan" in scene._repr_html_()


def test_what_is_no_mesh_is_refused() -> None:
    with pytest.raises(TypeError, match=r"^mesh: expected a halfline\.Mesh, .* found int$"):
        halfline.Scene(3)
    with pytest.raises(ValueError, match=r"^preset: .*'fast', 'balanced', 'best', found 'slow'$"):
        halfline.Scene(np.eye(3), [[0, 1, 2]], preset="slow")


def test_anything_with_vertices_and_faces_is_a_mesh(judged: Judged) -> None:
    scene = halfline.Scene(judged.shape)
    assert scene.mesh.faces.shape == judged.shape.faces.shape
    assert halfline.Scene(scene.mesh).mesh is scene.mesh
