"""`halfline doctor`: what is wrong with a mesh, and whether rays slip through it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Halfline, Judged
from meshes import Floats, Ints, Shape, bumpy_sphere, gridded_cube, write_off, write_ply, write_stl

DEFECTS = [
    "open_edges",
    "non_manifold_edges",
    "inconsistent_edges",
    "degenerate_faces",
    "non_finite_faces",
    "duplicate_faces",
]


def defects(report: dict[str, Any]) -> dict[str, int]:
    """The defects that there are, with their counts."""
    counts = {name: report[name]["count"] for name in DEFECTS}
    return {name: count for name, count in counts.items() if count}


def assert_clean(report: dict[str, Any]) -> None:
    """No ray did what it must not do."""
    assert report["rays"] > 0
    assert (report["leaks"], report["wrong_parities"], report["late_hits"]) == (0, 0, 0)
    assert report["examples"] == []


def cube(low: float, high: float) -> Shape:
    """A cube of twelve triangles, fronts outside."""
    grid = gridded_cube(1)
    corners = grid.corners()
    middle = np.full(3, 0.5)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normals, corners[:, 0] - middle) < 0
    faces = np.where(inward[:, None], grid.faces[:, ::-1], grid.faces)
    return Shape(low + (high - low) * grid.vertices, faces)


def joined(*shapes: Shape) -> Shape:
    """All of them in one."""
    starts = np.cumsum([0, *(len(shape.vertices) for shape in shapes)])
    faces = [shape.faces + start for shape, start in zip(shapes, starts, strict=False)]
    return Shape(np.vstack([shape.vertices for shape in shapes]), np.vstack(faces))


def ply(path: Path, vertices: list[list[float]] | Floats, faces: list[list[int]] | Ints) -> Path:
    """A PLY of a few triangles."""
    shape = Shape(
        np.array(vertices, dtype=float).reshape(-1, 3), np.array(faces, dtype=int).reshape(-1, 3)
    )
    return write_ply(path, shape)


def test_a_closed_mesh_is_watertight(halfline: Halfline, judged: Judged) -> None:
    report = halfline.json("doctor", judged.path)
    vertices, faces = len(judged.shape.vertices), len(judged.shape.faces)
    assert (report["vertices"], report["triangles"]) == (vertices, faces)
    assert report["edges"] == faces * 3 // 2
    assert report["euler_characteristic"] == 2
    assert (report["components"], report["closed"], report["consistent"]) == (1, True, True)
    assert defects(report) == {}
    assert report["facing"] == "outward"
    a, b, c = np.moveaxis(judged.shape.corners(), 1, 0)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    np.testing.assert_allclose(report["volume"], volume, rtol=1e-12)
    assert report["verdict"] == "closed, consistently oriented, outward: watertight"
    assert_clean(report)
    targets = vertices + report["edges"]
    assert (report["targets"], report["rays"]) == (targets, 4 * targets)
    assert report["from_inside"] is True
    assert len(report["origins"]) == 4
    for name in ["examine_seconds", "build_seconds", "closest_rays_per_second"]:
        assert report[name] > 0, name


def test_the_origins_are_inside(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    for seed in ["0", "1"]:
        report = halfline.json("doctor", judged.path, "--seed", seed, "--rays", "1000")
        origins = np.array(report["origins"])
        direction = np.random.default_rng(5).normal(size=origins.shape)
        hits = halfline.query(
            judged.path, np.hstack([origins, direction]), tmp_path, "--all", "--engine", "brute"
        )
        assert (np.diff(hits["splits"]) % 2 == 1).all()


def test_the_sample_is_as_large_as_wanted(halfline: Halfline, judged: Judged) -> None:
    for rays in [1, 5, 1000, 5000]:
        report = halfline.json("doctor", judged.path, "--rays", str(rays))
        assert report["rays"] == rays
        assert_clean(report)


def test_a_seed_gives_the_same_report_on_any_number_of_threads(
    halfline: Halfline, judged: Judged
) -> None:
    reports = [
        halfline.json("doctor", judged.path, "--rays", "3000", "--seed", "7", "--threads", threads)
        for threads in ["1", "3"]
    ]
    for report in reports:
        for name in [name for name in report if name.endswith(("_seconds", "_second", "_bytes"))]:
            del report[name]
    assert reports[0] == reports[1]


def test_an_stl_soup_is_judged_by_its_surface(halfline: Halfline, tmp_path: Path) -> None:
    shape = cube(0.0, 1.0)
    soup = Shape(shape.corners().reshape(-1, 3), np.arange(36).reshape(-1, 3))
    for path in [
        write_stl(tmp_path / "cube.stl", shape),
        write_ply(tmp_path / "soup.ply", soup),
        write_ply(tmp_path / "double.ply", soup, dtype="<f8"),
    ]:
        report = halfline.json("doctor", path)
        assert (report["edges"], defects(report), report["facing"]) == (18, {}, "outward")
        assert_clean(report)
    assert report["duplicate_vertices"] == 36 - 8


def test_a_hole_is_named_by_its_faces(halfline: Halfline, tmp_path: Path) -> None:
    shape = cube(0.0, 1.0)
    path = write_ply(tmp_path / "open.ply", Shape(shape.vertices, shape.faces[:-1]))
    report = halfline.json("doctor", path)
    assert report["open_edges"]["count"] == 3
    edges = {frozenset(edge) for a, b, c in [shape.faces[-1]] for edge in [(a, b), (b, c), (c, a)]}
    for face in report["open_edges"]["first_faces"]:
        a, b, c = shape.faces[face]
        assert edges & {frozenset((a, b)), frozenset((b, c)), frozenset((c, a))}
    assert (report["closed"], report["facing"], report["volume"]) == (False, None, None)
    assert report["from_inside"] is False
    assert report["verdict"] == "open: 3 border edges"
    assert_clean(report)


def test_faces_are_those_of_the_file(halfline: Halfline, tmp_path: Path) -> None:
    # A cube of six squares, the fifth of them left out; triangles are numbered otherwise.
    square = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [1, 5, 7, 3]]
    lines = ["OFF", f"8 {len(square)} 0"]
    lines += [f"{i >> 2 & 1} {i >> 1 & 1} {i & 1}" for i in range(8)]
    lines += ["4 " + " ".join(map(str, face)) for face in square]
    path = tmp_path / "box.off"
    path.write_text("\n".join(lines) + "\n")
    report = halfline.json("doctor", path)
    assert report["triangles"] == 10
    assert report["open_edges"] == {"count": 4, "first_faces": [0, 1, 2, 3]}


def test_orientation_is_told(halfline: Halfline, tmp_path: Path) -> None:
    shape = cube(-1.0, 1.0)
    inside_out = write_ply(tmp_path / "in.ply", Shape(shape.vertices, shape.faces[:, ::-1]))
    report = halfline.json("doctor", inside_out)
    assert (report["facing"], report["volume"]) == ("inward", -8.0)
    assert report["verdict"] == "closed, consistently oriented, inward: watertight"
    faces = shape.faces.copy()
    faces[4] = faces[4, ::-1]
    report = halfline.json(
        "doctor", write_ply(tmp_path / "turned.ply", Shape(shape.vertices, faces))
    )
    assert defects(report) == {"inconsistent_edges": 3}
    assert report["verdict"] == "closed, inconsistently oriented: watertight"
    assert_clean(report)


def test_cubes_that_share_an_edge(halfline: Halfline, tmp_path: Path) -> None:
    first, second = cube(0.0, 1.0), cube(0.0, 1.0)
    second.vertices[:, :2] += 1.0
    report = halfline.json("doctor", write_off(tmp_path / "two.off", joined(first, second)))
    assert defects(report) == {"non_manifold_edges": 1}
    assert (report["components"], report["duplicate_vertices"]) == (1, 2)
    expected = "closed, consistently oriented, outward, 1 non-manifold edge: watertight"
    assert report["verdict"] == expected
    assert_clean(report)


def test_bad_faces_are_counted(halfline: Halfline, tmp_path: Path) -> None:
    shape = cube(0.0, 1.0)
    more = np.array([[np.nan, 0.0, 0.0], [0.5, 0.5, 0.5], [9.0, 9.0, 9.0]])
    vertices = np.vstack([shape.vertices, more])
    bad = [shape.faces[3][[1, 2, 0]], [0, 1, 8], [9, 9, 1]]
    faces = np.vstack([shape.faces, np.array(bad)])
    report = halfline.json("doctor", ply(tmp_path / "bad.ply", vertices, faces))
    found = defects(report)
    assert {name: found[name] for name in DEFECTS[3:]} == dict.fromkeys(DEFECTS[3:], 1)
    assert report["duplicate_faces"]["first_faces"] == [12]
    assert report["non_finite_faces"]["first_faces"] == [13]
    assert report["degenerate_faces"]["first_faces"] == [14]
    # The face that is there twice leaves three faces at each of its edges.
    assert found["non_manifold_edges"] == 3
    assert report["unreferenced_vertices"] == 1
    assert report["verdict"] == "open: 3 edges of 3, 5 or more triangles, inconsistently oriented"


@pytest.mark.parametrize(
    ("vertices", "faces", "verdict"),
    [
        ([], [], "empty: there are no triangles"),
        ([[0, 0, 0]] * 3, [], "empty: there are no triangles"),
        ([[1, 1, 1]] * 3, [[0, 1, 2], [1, 1, 0]], "no surface: no triangle has three finite"),
        ([[np.nan, 0, 0]] * 3, [[0, 1, 2]], "no surface: no triangle has three finite"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], "open: 3 border edges"),
        ([[0, 0, 0], [1, 1, 1], [3, 3, 3]], [[0, 1, 2]], "open: 3 border edges"),
        (
            [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
            [[0, 1, 2], [2, 1, 0]],
            "closed, consistently oriented, no volume: no point inside was found",
        ),
    ],
)
def test_meshes_of_little_or_nothing(
    halfline: Halfline,
    tmp_path: Path,
    vertices: list[list[float]],
    faces: list[list[int]],
    verdict: str,
) -> None:
    path = ply(tmp_path / "mesh.ply", vertices, faces)
    report = halfline.json("doctor", path)
    assert report["verdict"].startswith(verdict)
    assert (report["leaks"], report["wrong_parities"], report["late_hits"]) == (0, 0, 0)
    assert halfline.ok("doctor", path).splitlines()[-1] == report["verdict"]


def test_far_from_the_origin(halfline: Halfline, tmp_path: Path) -> None:
    shape = bumpy_sphere()
    far = Shape(shape.vertices + np.array([5e5, 5.4e6, 100.0]), shape.faces)
    report = halfline.json("doctor", write_ply(tmp_path / "far.ply", far, dtype="<f8"))
    assert report["from_inside"] is True
    assert report["verdict"].endswith("outward: watertight")
    assert_clean(report)


def test_a_person_reads_the_same(halfline: Halfline, judged: Judged) -> None:
    for options in [[], ["--quiet"]]:
        lines = halfline.ok("doctor", judged.path, *options).splitlines()
        rows = {line.split("  ")[1]: line for line in lines[1:-1] if line.startswith("  ")}
        assert re.search(r" 0 +of one triangle$", rows["open edges"])
        assert f" {len(judged.shape.faces):,}" in rows["triangles"]
        assert lines[-1] == "closed, consistently oriented, outward: watertight"


def test_wrong_arguments_are_refused(halfline: Halfline, judged: Judged) -> None:
    for options in [["--rays", "0"], ["--rays", "many"], ["--seed", "-1"]]:
        halfline.fails(2, "doctor", judged.path, *options)
