"""`halfline info`: what a mesh and its tree are like."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Halfline, Judged
from meshes import Shape, write_ply


def test_json_describes_mesh_and_tree(halfline: Halfline, judged: Judged) -> None:
    info = halfline.json("info", judged.path)
    assert info["triangles"] == len(judged.shape.faces)
    assert info["skipped"] == 0
    low, high = info["bounds"]
    np.testing.assert_array_equal(low, judged.shape.vertices.min(axis=0))
    np.testing.assert_array_equal(high, judged.shape.vertices.max(axis=0))
    tree = info["tree"]
    assert tree["references"] >= info["triangles"]
    assert tree["references_per_triangle"] == tree["references"] / info["triangles"]
    assert tree["bytes_per_triangle"] == tree["bytes"] / info["triangles"]
    assert sum(tree["leaves_by_size"]) == tree["leaves"]
    assert 1 < tree["children_per_node"] <= 8
    sizes = enumerate(tree["leaves_by_size"])
    assert sum(size * leaves for size, leaves in sizes) == tree["references"]
    assert tree["depth"] > 0
    assert tree["sah_cost"] > 0
    assert info["build_seconds"] > 0


def test_a_person_reads_the_same(halfline: Halfline, judged: Judged) -> None:
    text = halfline.ok("info", judged.path)
    assert "triangles" in text.lower()
    assert str(len(judged.shape.faces)) in text.replace(",", "").replace("\u202f", "")


def test_polygons_count_as_triangles(halfline: Halfline, tmp_path: Path) -> None:
    mesh = tmp_path / "pentagon.off"
    mesh.write_text("OFF\n5 1 0\n0 0 0\n2 0 0\n3 1 0\n1 2 0\n-1 1 0\n5 0 1 2 3 4\n")
    assert halfline.json("info", mesh)["triangles"] == 3


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_degenerate_triangles_are_counted_and_left_out(
    halfline: Halfline, tmp_path: Path, bad: float
) -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [bad, 0, 0]], dtype=float)
    faces = np.array([[0, 1, 2], [0, 1, 3], [1, 1, 2], [0, 2, 4]])
    mesh = write_ply(tmp_path / "bad.ply", Shape(vertices, faces))
    info = halfline.json("info", mesh)
    assert info["triangles"] == 4
    assert info["skipped"] == 3
    assert info["bounds"][1] == [2.0, 1.0, 0.0]
    ray = np.array([[0.2, 0.2, 1.0, 0.0, 0.0, -1.0]])
    assert halfline.query(mesh, ray, tmp_path)["face"].tolist() == [0]


def test_an_empty_mesh_is_a_mesh(halfline: Halfline, tmp_path: Path) -> None:
    mesh = write_ply(tmp_path / "empty.ply", Shape(np.empty((0, 3)), np.empty((0, 3), dtype=int)))
    assert halfline.json("info", mesh)["triangles"] == 0
    ray = np.array([[0.2, 0.2, 1.0, 0.0, 0.0, -1.0]])
    assert halfline.query(mesh, ray, tmp_path)["face"].tolist() == [-1]
