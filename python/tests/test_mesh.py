"""Meshes: arrays in, views out, files."""

from __future__ import annotations

import copy
import errno
import gc
import os
import pickle
import re
import sys
import threading
from pathlib import Path
from typing import Any

import halfline
import numpy as np
import pytest
from conftest import Halfline, Judged
from meshes import bumpy_sphere


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_vertices_keep_their_precision(dtype: Any) -> None:
    shape = bumpy_sphere()
    mesh = halfline.Mesh(shape.vertices.astype(dtype), shape.faces)
    assert mesh.vertices.dtype == dtype
    assert mesh.faces.dtype == np.uint32
    np.testing.assert_array_equal(mesh.vertices, shape.vertices)
    np.testing.assert_array_equal(mesh.faces, shape.faces)
    np.testing.assert_array_equal(
        mesh.bounds, [shape.vertices.min(axis=0), shape.vertices.max(axis=0)]
    )
    assert repr(mesh) == f"<halfline.Mesh: 2,208 triangles, 1,106 vertices, {np.dtype(dtype)}>"
    assert "2,208" in mesh._repr_html_()


def test_the_arrays_are_read_only_views_that_keep_the_mesh() -> None:
    mesh = halfline.generate("sphere", 200_000)
    vertices, faces = mesh.vertices, mesh.faces
    assert mesh.vertices is vertices
    assert not vertices.flags.owndata
    assert not faces.flags.owndata
    for array in (vertices, faces):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True
    expected = vertices.copy()
    del mesh
    gc.collect()
    # Memory that was given back would be used by these.
    others = [halfline.generate("soup", 200_000) for _ in range(3)]
    np.testing.assert_array_equal(vertices, expected)
    assert faces.max() == len(vertices) - 1
    assert len(others) == 3


def test_a_scene_holds_the_mesh_and_no_copy() -> None:
    mesh = halfline.generate("sphere", 10_000)
    scene = halfline.Scene(mesh)
    native = halfline.Mesh._of(scene._native.mesh)
    assert native.vertices.__array_interface__["data"] == mesh.vertices.__array_interface__["data"]


@pytest.mark.parametrize(
    "dtype", ["i1", "u1", "<i2", ">u2", "<i4", ">i4", "u4", "<i8", ">i8", "u8"]
)
def test_faces_may_be_any_integers(dtype: str) -> None:
    faces = np.array([[0, 1, 2], [2, 1, 3]], dtype=dtype)
    vertices = np.arange(12.0).reshape(4, 3)
    for form in (faces, np.asfortranarray(faces), np.repeat(faces, 2, axis=0)[::2]):
        np.testing.assert_array_equal(halfline.Mesh(vertices, form).faces, faces)


def test_later_changes_of_the_arrays_do_not_reach_the_mesh() -> None:
    vertices, faces = np.eye(3), np.array([[0, 1, 2]])
    mesh = halfline.Mesh(vertices, faces)
    vertices[:] = 7.0
    faces[:] = 0
    np.testing.assert_array_equal(mesh.vertices, np.eye(3))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2]])


WRONG: list[tuple[Any, Any, type[Exception], str]] = [
    (np.zeros((3, 2)), [[0, 1, 2]], ValueError, "vertices: expected shape (n, 3), found (3, 2)"),
    (np.zeros(3), [[0, 1, 2]], ValueError, "vertices: expected shape (n, 3), found (3,)"),
    (np.zeros((3, 3), "U3"), [[0, 1, 2]], TypeError, "vertices: expected float32, float64 or"),
    (np.eye(3), [[0, 1, 2, 0]], ValueError, "faces: expected shape (m, 3), found (1, 4)"),
    (np.eye(3), [0, 1, 2], ValueError, "faces: expected shape (m, 3), found (3,)"),
    (np.eye(3), [[0.0, 1.0, 2.0]], TypeError, "faces: expected integers, found float64"),
    (np.eye(3), [[True, False, True]], TypeError, "faces: expected integers, found bool"),
    (
        np.eye(3),
        [[0, 1, 2], [0, 1, 3]],
        ValueError,
        "faces: row 1 is [0, 1, 3], but the 3 vertices have indices from 0 to 2",
    ),
    (np.eye(3), [[0, -1, 2]], ValueError, "faces: row 0 is [0, -1, 2], but the 3 vertices"),
    (np.eye(3), [[0, 1, 2**32]], ValueError, "faces: row 0 is [0, 1, 4294967296], but"),
    (np.eye(3), np.full((1, 3), 2**64 - 1, "u8"), ValueError, "faces: row 0 is [1844674407"),
]


@pytest.mark.parametrize(("vertices", "faces", "kind", "message"), WRONG)
def test_wrong_arrays_are_refused_by_name(
    vertices: Any, faces: Any, kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=f"^{re.escape(message)}"):
        halfline.Mesh(vertices, faces)


def test_bounds_are_those_of_what_is_used() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [9, 9, 9], [np.nan, 1, 1]])
    bounds = halfline.Mesh(vertices, [[0, 1, 2], [0, 1, 4]]).bounds
    np.testing.assert_array_equal(bounds, [[0, 0, 0], [1, 2, 0]])
    assert not bounds.flags.writeable
    assert np.isnan(halfline.Mesh(vertices, []).bounds).all()


def test_a_loaded_mesh_is_that_of_the_file(judged: Judged) -> None:
    for path in (judged.path, str(judged.path), os.fsencode(judged.path)):
        mesh = halfline.load(path)
        np.testing.assert_array_equal(mesh.vertices, judged.shape.vertices)
        np.testing.assert_array_equal(mesh.faces, judged.shape.faces)


def test_a_generated_mesh_is_that_of_the_command(
    halfline_command: Halfline, tmp_path: Path
) -> None:
    path = tmp_path / "soup.ply"
    halfline_command.ok("generate", "soup", "-n", "1000", "--seed", "7", "-o", path)
    mesh, loaded = halfline.generate("soup", 1000, seed=7), halfline.load(path)
    np.testing.assert_array_equal(mesh.vertices, loaded.vertices)
    np.testing.assert_array_equal(mesh.faces, loaded.faces)


def test_generation_checks_its_arguments() -> None:
    with pytest.raises(ValueError, match='kind: "cube" is none of scan, sphere'):
        halfline.generate("cube", 12)
    with pytest.raises(ValueError, match=r"triangles: expected a number from 0 to .* found -1"):
        halfline.generate("soup", -1)
    with pytest.raises(ValueError, match="number of triangles: zero"):
        halfline.generate("soup", 0)
    with pytest.raises(ValueError, match="seed: expected a number from 0"):
        halfline.generate("soup", 5, seed=2**64)
    assert len(halfline.generate("soup", 5, seed=2**64 - 1).faces) == 5


def test_a_file_that_is_not_there_is_an_os_error(tmp_path: Path) -> None:
    path = tmp_path / "nowhere.ply"
    with pytest.raises(FileNotFoundError) as raised:
        halfline.load(path)
    assert raised.value.errno == errno.ENOENT
    assert raised.value.filename == str(path)
    with pytest.raises(IsADirectoryError, match="Is a directory") as directory:
        halfline.load(tmp_path)
    assert directory.value.filename == str(tmp_path)


def test_a_damaged_file_is_a_format_error(tmp_path: Path) -> None:
    path = tmp_path / "damaged.ply"
    path.write_text("ply\nformat ascii 1.0\nelement vertex x\n", encoding="utf-8")
    with pytest.raises(halfline.FormatError, match=r"damaged\.ply: line 3: ") as raised:
        halfline.load(path)
    assert isinstance(raised.value, ValueError)
    assert "\n" not in str(raised.value)
    again = pickle.loads(pickle.dumps(raised.value))
    assert isinstance(again, halfline.FormatError)
    assert str(again) == str(raised.value)


def test_a_mesh_pickles_with_all_that_its_file_said(tmp_path: Path) -> None:
    colored = halfline.generate("rings", 1000)
    assert colored._native.extras()[3] != []
    path = tmp_path / "quads.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\nf 1 2 3 4\nf 3 4 5\n")
    quads = halfline.load(path)
    np.testing.assert_array_equal(quads._native.extras()[0], [0, 0, 1])
    for mesh in (colored, quads, halfline.Mesh(np.eye(3), [[0, 1, 2]])):
        for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
            again = pickle.loads(pickle.dumps(mesh, protocol))
            np.testing.assert_array_equal(again.vertices, mesh.vertices)
            assert again.vertices.dtype == mesh.vertices.dtype
            np.testing.assert_array_equal(again.faces, mesh.faces)
            *arrays, materials = again._native.extras()
            *expected, expected_materials = mesh._native.extras()
            assert materials == expected_materials
            for array, other in zip(arrays, expected, strict=True):
                np.testing.assert_array_equal(array, other)


def test_copies_of_what_never_changes_are_itself() -> None:
    scene = halfline.Scene(np.eye(3), [[0, 1, 2]])
    assert copy.copy(scene) is scene
    assert copy.deepcopy([scene])[0] is scene
    assert copy.copy(scene.mesh) is scene.mesh
    assert copy.deepcopy(scene.mesh) is scene.mesh


@pytest.mark.skipif(sys.platform == "win32", reason="there are no named pipes")
def test_pipes_and_devices_are_no_files(tmp_path: Path) -> None:
    pipes = [tmp_path / "pipe.ply", tmp_path / "pipe.hlt"]
    for pipe in pipes:
        os.mkfifo(pipe)
        # Whoever opens it all the same finds its end, and no reason to wait.
        threading.Thread(target=pipe.write_bytes, args=(b"",), daemon=True).start()
    for read in (halfline.load, halfline.open):
        for path, kind in [*((pipe, "pipe") for pipe in pipes), (Path(os.devnull), "device")]:
            with pytest.raises(OSError, match=f"^{path}: not a regular file but a {kind}$"):
                read(path)
