"""`halfline.trimesh` beside trimesh's own intersector in pure Python."""

from __future__ import annotations

import copy
import inspect
import pickle
from typing import Any, NamedTuple

import halfline
import numpy as np
import pytest
import trimesh
from halfline.trimesh import RayMeshIntersector
from meshes import Floats, bumpy_sphere, gridded_cube, random_rays
from numpy.typing import NDArray
from trimesh.ray.ray_triangle import RayMeshIntersector as Original


class Case(NamedTuple):
    """A mesh, and rays in general position."""

    mesh: Any
    origins: Floats
    directions: Floats

    @property
    def rays(self) -> tuple[Floats, Floats]:
        """Origins and directions."""
        return self.origins, self.directions


def trimesh_of(mesh: halfline.Mesh) -> Any:
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


def case(mesh: Any, seed: int = 1, count: int = 200) -> Case:
    """Rays from around a mesh to points within its box."""
    low, high = mesh.bounds
    center, reach = (low + high) / 2.0, np.linalg.norm(high - low) / 2.0
    rays = random_rays(count, seed)
    origins = center + reach * rays[:, :3]
    targets = np.random.default_rng(seed).uniform(low, high, size=(count, 3))
    return Case(mesh, origins, targets - origins)


def with_degenerate_faces() -> Any:
    box = trimesh.creation.box()
    nothing = [[0, 0, 1], [2, 2, 2]]
    return trimesh.Trimesh(box.vertices, np.vstack([nothing, box.faces]), process=False)


MESHES = {
    "bumpy": lambda: trimesh.Trimesh(*vars(bumpy_sphere()).values()),
    "box": trimesh.creation.box,
    "one triangle": lambda: trimesh.Trimesh(np.eye(3), [[0, 1, 2]]),
    "teapot, open": lambda: trimesh_of(halfline.generate("teapot", 2000)),
    "scan": lambda: trimesh_of(halfline.generate("scan", 2000)),
    "soup": lambda: trimesh_of(halfline.generate("soup", 300)),
    "gears": lambda: trimesh_of(halfline.generate("gears", 2000)),
    "degenerate faces": with_degenerate_faces,
    "two bodies": lambda: trimesh.util.concatenate(
        [trimesh.creation.box(), trimesh.creation.icosphere(2).apply_translation([0.7, 0.1, 3.0])]
    ),
}


@pytest.fixture(scope="module", params=MESHES)
def judged_case(request: pytest.FixtureRequest) -> Case:
    return case(MESHES[request.param]())


def by_ray(*columns: NDArray[Any]) -> list[NDArray[Any]]:
    """Hits in an order that both have: by ray, then by face."""
    face, ray = columns[:2]
    order = np.lexsort((face, ray))
    return [column[order] for column in columns]


@pytest.mark.parametrize("multiple", [True, False])
def test_the_hits_are_those_of_the_original(judged_case: Case, multiple: bool) -> None:
    mesh, rays = judged_case.mesh, judged_case.rays
    found = RayMeshIntersector(mesh).intersects_id(
        *rays, multiple_hits=multiple, return_locations=True
    )
    expected = Original(mesh).intersects_id(*rays, multiple_hits=multiple, return_locations=True)
    assert len(expected[0]) > 10
    faces, indices, locations = by_ray(*found)
    other_faces, other_indices, other_locations = by_ray(*expected)
    np.testing.assert_array_equal(indices, other_indices)
    np.testing.assert_array_equal(faces, other_faces)
    np.testing.assert_allclose(locations, other_locations, atol=1e-9 * mesh.scale)
    assert [array.dtype.name for array in found] == ["int64", "int64", "float64"]


def test_first_and_any_are_those_of_the_original(judged_case: Case) -> None:
    mesh, rays = judged_case.mesh, judged_case.rays
    ours, original = RayMeshIntersector(mesh), Original(mesh)
    first, expected = ours.intersects_first(*rays), original.intersects_first(*rays)
    np.testing.assert_array_equal(first, expected)
    assert first.dtype == expected.dtype == np.int64
    struck, expected = ours.intersects_any(*rays), original.intersects_any(*rays)
    np.testing.assert_array_equal(struck, expected)
    assert struck.dtype == expected.dtype == np.bool_


def test_locations_are_the_same_hits_as_ids(judged_case: Case) -> None:
    mesh, rays = judged_case.mesh, judged_case.rays
    ours = RayMeshIntersector(mesh)
    locations, ray, face = ours.intersects_location(*rays)
    faces, rays_hit, points = ours.intersects_id(*rays, return_locations=True)
    np.testing.assert_array_equal(face, faces)
    np.testing.assert_array_equal(ray, rays_hit)
    np.testing.assert_array_equal(locations, points)
    bare = ours.intersects_id(*rays)
    assert len(bare) == 2
    np.testing.assert_array_equal(bare[0], faces)


def test_hits_come_by_ray_and_then_along_the_ray() -> None:
    mesh, origins, directions = case(MESHES["bumpy"]())
    locations, ray, _ = RayMeshIntersector(mesh).intersects_location(origins, directions)
    along = np.einsum("ij,ij->i", locations - origins[ray], directions[ray])
    np.testing.assert_array_equal(np.lexsort((along, ray)), np.arange(len(ray)))
    assert np.bincount(ray).max() > 3


@pytest.mark.parametrize("name", ["bumpy", "box", "scan", "degenerate faces", "two bodies"])
def test_points_inside_are_those_of_the_original(name: str) -> None:
    mesh = MESHES[name]()
    low, high = mesh.bounds
    points = np.random.default_rng(2).uniform(low - 0.1, high + 0.1, size=(300, 3))
    contains = RayMeshIntersector(mesh).contains_points(points)
    np.testing.assert_array_equal(contains, Original(mesh).contains_points(points))
    assert contains.dtype == np.bool_
    assert 10 < contains.sum() < 290


def test_the_inside_of_a_mesh_does_not_leak_through_a_hole() -> None:
    box = trimesh.creation.box().subdivide().subdivide()
    away = box.triangles_center / np.linalg.norm(box.triangles_center, axis=1, keepdims=True)
    way = np.array([0.3128, 0.5871, 0.7466])
    box.update_faces(away @ way < 0.97)
    assert not box.is_watertight
    points = np.random.default_rng(3).uniform(-0.3, 0.3, size=(200, 3))
    ours = RayMeshIntersector(box)
    # Rays tell those that look at the hole from the others.
    assert set(ours.scene.count_intersections(points, way)) == {0, 1}
    assert ours.contains_points(points).all()
    assert not ours.contains_points(points - 2.0 * way).any()


def test_what_is_inside_does_not_depend_on_orientation_or_loose_faces() -> None:
    loose = trimesh.Trimesh([[2, -1, -1], [2, 1, -1], [2, 0, 1]], [[0, 1, 2]], process=False)
    box = trimesh.creation.box()
    points = np.random.default_rng(4).uniform(-0.9, 0.9, size=(200, 3))
    expected = np.abs(points).max(axis=1) < 0.5
    assert 10 < expected.sum() < 190
    some = box.faces.copy()
    some[::2] = some[::2, ::-1]
    inconsistent = trimesh.Trimesh(box.vertices, some, process=False)
    found = RayMeshIntersector(inconsistent).contains_points(points)
    np.testing.assert_array_equal(found, expected)
    for faces in (box.faces, box.faces[:, ::-1]):
        mesh = trimesh.Trimesh(box.vertices, faces, process=False)
        for each in (mesh, trimesh.util.concatenate([mesh, loose])):
            np.testing.assert_array_equal(
                RayMeshIntersector(each).contains_points(points), expected
            )
    assert not RayMeshIntersector(box).contains_points([[np.nan, 0, 0], [0, np.inf, 0]]).any()


def test_the_original_counts_an_edge_twice_and_this_one_once() -> None:
    shape = gridded_cube(4)
    mesh = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    # From the inside of the cube through every vertex and the middle of every edge of its surface.
    targets = np.vstack([mesh.vertices, mesh.vertices[mesh.edges_unique].mean(axis=1)])
    origins = np.full_like(targets, 2.0) + np.array([0.125, 0.0625, -0.125])
    directions = targets - origins

    faces, ray = RayMeshIntersector(mesh).intersects_id(origins, directions)
    np.testing.assert_array_equal(ray, np.arange(len(targets)))
    assert all(np.isin(vertex, mesh.faces[face]) for vertex, face in enumerate(faces[:98]))

    # The known defect: `intersects_id` of the original tells each face at the edge or vertex.
    _, original = Original(mesh).intersects_id(origins, directions)
    assert (np.bincount(original, minlength=len(targets)) >= 2).all()


def test_far_away_and_tiny_meshes_are_hit_where_the_original_fails() -> None:
    box = trimesh.creation.box()
    origins, directions = np.array([[0.1, 0.2, 5.0]]), np.array([[0.0, 0.0, -1.0]])
    tiny = box.copy().apply_scale(2.0**-40)
    ours = RayMeshIntersector(tiny)
    locations, _, _ = ours.intersects_location(origins * 2.0**-40, directions)
    np.testing.assert_allclose(locations[:, 2], [2.0**-41, -(2.0**-41)], rtol=1e-15)
    # The known defect: the original takes hits up to a millionth behind the origin for hits.
    behind = np.array([[0.1, 0.2, 0.5 + 5e-7]])
    away = -0.5 * directions
    assert not RayMeshIntersector(box).intersects_any(behind, away)[0]
    assert Original(box).intersects_any(behind, away)[0]

    far = box.copy().apply_translation([2.0**30, 0.0, 0.0])
    origins[:, 0] += 2.0**30
    locations, _, _ = RayMeshIntersector(far).intersects_location(origins, directions)
    np.testing.assert_allclose(locations[:, 2], [0.5, -0.5], rtol=1e-15)


def stack_of_squares(count: int) -> Any:
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    return trimesh.util.concatenate(
        [square.copy().apply_translation([0, 0, z]) for z in range(count)]
    )


@pytest.mark.parametrize(("limit", "expected"), [(0, 0), (1, 1), (7, 7), (100, 100), (1000, 150)])
def test_max_hits_keeps_the_first_ones(limit: int, expected: int) -> None:
    ours = RayMeshIntersector(stack_of_squares(150))
    origins, directions = [[0.75, 0.25, -1.0], [5.0, 5.0, -1.0]], [[0.0, 0.0, 1.0]] * 2
    _, ray, locations = ours.intersects_id(
        origins, directions, max_hits=limit, return_locations=True
    )
    np.testing.assert_array_equal(locations[:, 2], np.arange(expected))
    assert not ray.any()


def test_id_tells_a_hundred_hits_unless_told_otherwise_and_location_all() -> None:
    ours = RayMeshIntersector(stack_of_squares(150))
    rays = [[0.75, 0.25, -1.0]], [[0.0, 0.0, 1.0]]
    assert len(ours.intersects_id(*rays)[0]) == 100
    assert len(ours.intersects_location(*rays)[0]) == 150
    assert len(ours.intersects_id(*rays, False, max_hits=0)[0]) == 0


def test_arguments_are_those_of_the_embree_intersector() -> None:
    defaults = {
        name: {
            argument: parameter.default
            for argument, parameter in inspect.signature(method).parameters.items()
            if argument != "self"
        }
        for name, method in inspect.getmembers(RayMeshIntersector, inspect.isfunction)
        if not name.startswith("_")
    }
    none = inspect.Parameter.empty
    rays = {"ray_origins": none, "ray_directions": none}
    assert defaults == {
        "contains_points": {"points": none},
        "intersects_any": rays,
        "intersects_first": rays,
        "intersects_id": rays | {"multiple_hits": True, "max_hits": 100, "return_locations": False},
        "intersects_location": rays | {"multiple_hits": True},
    }
    ours = [name for name in dir(RayMeshIntersector) if not name.startswith("_")]
    assert set(ours) == {name for name in dir(Original) if not name.startswith("_")} | {"scene"}


def test_misses_and_no_rays_give_empty_arrays_of_the_right_shapes() -> None:
    ours = RayMeshIntersector(trimesh.creation.box())
    nothing = np.empty((0, 3))
    for rays in ((np.full((1, 3), 5.0), np.eye(3)[:1]), (nothing, nothing)):
        face, ray, location = ours.intersects_id(rays[0], rays[1], return_locations=True)
        assert (face.shape, ray.shape, location.shape) == ((0,), (0,), (0, 3))
        assert not ours.intersects_any(*rays).any()
        assert (ours.intersects_first(*rays) == -1).all()
        assert ours.intersects_first(*rays).shape == (len(rays[0]),)
    assert ours.contains_points(nothing).shape == (0,)


def test_a_mesh_without_faces_is_missed() -> None:
    empty = trimesh.Trimesh()
    ours = RayMeshIntersector(empty)
    assert not ours.intersects_any([[0, 0, 0]], [[1, 0, 0]])[0]
    assert not ours.contains_points([[0, 0, 0]])[0]


def test_wrong_arrays_are_refused() -> None:
    ours = RayMeshIntersector(trimesh.creation.box())
    ask: list[Any] = [
        ours.intersects_id,
        ours.intersects_location,
        ours.intersects_first,
        ours.intersects_any,
    ]
    two, three = np.zeros((2, 3)), np.zeros((3, 3))
    for method in ask:
        with pytest.raises(ValueError, match=r"ray_origins, ray_directions.*\(2, 3\) and \(3, 3\)"):
            method(two, three)
        with pytest.raises(ValueError, match=r"same shape \(n, 3\), found \(3,\) and \(3,\)"):
            method(two[0], two[0])
        with pytest.raises(TypeError, match=r"ray_directions.*complex128"):
            method(two, two * 1j)
    for points in (np.zeros(3), np.zeros((2, 2)), np.zeros((1, 2, 3))):
        with pytest.raises(ValueError, match=r"points: expected shape \(n, 3\)"):
            ours.contains_points(points)
    unfit: Any = RayMeshIntersector
    with pytest.raises(TypeError, match="geometry: expected one mesh"):
        unfit()


def test_the_mesh_may_be_given_by_either_name_or_be_a_halfline_mesh() -> None:
    box = trimesh.creation.box()
    ray = [[0.1, 0.2, 5.0]], [[0.0, 0.0, -1.0]]
    for ours in (
        RayMeshIntersector(geometry=box, scale_to_box=False),
        RayMeshIntersector(mesh=box),
        RayMeshIntersector(halfline.Mesh(box.vertices, box.faces)),
    ):
        found = ours.intersects_location(*ray)[0]
        np.testing.assert_allclose(found[:, 2], [0.5, -0.5], rtol=1e-15)


def height(mesh: Any) -> list[float]:
    """Where a ray from above meets the mesh, by the mesh's own `ray`."""
    assert type(mesh.ray) is RayMeshIntersector
    locations = mesh.ray.intersects_location([[0.1, 0.2, 50.0]], [[0.0, 0.0, -1.0]])[0]
    found: list[float] = locations[:, 2].round(12).tolist()
    return found


@pytest.fixture
def box() -> Any:
    mesh = trimesh.creation.box()
    mesh.ray = RayMeshIntersector(mesh)
    assert height(mesh) == [0.5, -0.5]
    return mesh


def test_the_tree_follows_the_mesh(box: Any) -> None:
    scene = box.ray.scene
    assert box.ray.scene is scene
    box.apply_translation([0.0, 0.0, 3.0])
    assert height(box) == [3.5, 2.5]
    box.vertices[:, 2] += 1.0
    assert height(box) == [4.5, 3.5]
    box.vertices = box.vertices * [1.0, 1.0, 2.0]
    assert height(box) == [9.0, 7.0]
    box.update_faces(box.face_normals[:, 2] < 0.5)
    assert height(box) == [7.0]
    box.faces = box.faces[:0]
    assert height(box) == []


def test_a_copied_mesh_leaves_the_intersector_to_the_first(box: Any) -> None:
    copies = [box.copy(), copy.copy(box), copy.deepcopy(box)]
    for each in copies:
        # As with any intersector that was assigned: trimesh's copies begin with its default.
        assert type(each.ray) is Original
        each.apply_translation([0.0, 0.0, 3.0])
        each.ray = RayMeshIntersector(each)
        assert height(each) == [3.5, 2.5]
    assert height(box) == [0.5, -0.5]


def test_a_copied_intersector_is_of_the_same_mesh(box: Any) -> None:
    for duplicate in (copy.copy(box.ray), copy.deepcopy(box.ray)):
        assert type(duplicate) is RayMeshIntersector
        assert duplicate is not box.ray
        assert duplicate.mesh is box


def test_meshes_and_intersectors_are_pickled_without_the_tree(box: Any) -> None:
    box.ray.intersects_any([[0, 0, 0]], [[1, 0, 0]])
    again = pickle.loads(pickle.dumps(box))
    assert again.ray.mesh is again
    assert height(again) == [0.5, -0.5]
    again.apply_translation([0.0, 0.0, 3.0])
    assert height(again) == [3.5, 2.5]
    assert height(box) == [0.5, -0.5]

    alone = pickle.loads(pickle.dumps(box.ray))
    assert alone.mesh.ray is alone
    assert len(pickle.dumps(box)) < len(pickle.dumps(trimesh.creation.box())) + 300


def test_what_trimesh_asks_its_ray_for_is_asked_here(box: Any) -> None:
    assert box.contains([[0, 0, 0], [2, 0, 0]]).tolist() == [True, False]
    thickness = trimesh.proximity.thickness(
        box, np.array([[0.5, 0.0, 0.0]]), exterior=False, method="ray"
    )
    np.testing.assert_allclose(thickness, 1.0)


def test_it_says_what_it_is_of(box: Any) -> None:
    assert repr(box.ray).startswith("<halfline.trimesh.RayMeshIntersector of <trimesh.Trimesh(")
