"""Wrong input ends in one clear line and exit code 1, wrong arguments in exit code 2."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Halfline, Judged
from meshes import write_ply

PLY_HEADER = (
    b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n"
    b"property float x\nproperty float y\nproperty float z\n"
    b"element face %d\nproperty list uchar int vertex_indices\nend_header\n"
)
TRIANGLE = np.eye(3, dtype="<f4").tobytes()
FACE = b"\x03" + np.array([0, 1, 2], dtype="<i4").tobytes()


@pytest.mark.parametrize(
    ("name", "content", "hint"),
    [
        ("empty.ply", b"", ""),
        ("noise.ply", bytes(range(256)) * 4, ""),
        ("noise.obj", b"v 1 2 three\n", "line 1"),
        ("noise.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n", ""),
        ("noise.glb", b"glTF" + b"\xff" * 60, ""),
        ("cut.ply", PLY_HEADER % (3, 1) + TRIANGLE, "face"),
        ("cut.stl", b"\0" * 80 + np.uint32(9).tobytes() + b"\0" * 60, ""),
        ("bomb.ply", PLY_HEADER % (3, 4_000_000_000) + TRIANGLE + FACE, "face"),
        ("bomb.off", b"OFF\n4000000000 4000000000 0\n0 0 0\n", ""),
        ("index.ply", PLY_HEADER % (2, 1) + TRIANGLE[:24] + FACE, "face"),
        ("index.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4"),
        ("zero.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4"),
        ("version.ply", b"ply\nformat ascii 7.0\nend_header\n", "7.0"),
        ("uri.gltf", b'{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"../a"}]}', ""),
        ("v1.gltf", b'{"asset":{"version":"1.0"}}', ""),
        ("mesh.docx", b"PK", ""),
    ],
)
def test_a_bad_mesh_is_named_in_one_line(
    halfline: Halfline, tmp_path: Path, name: str, content: bytes, hint: str
) -> None:
    mesh = tmp_path / name
    mesh.write_bytes(content)
    line = halfline.complains("info", mesh)
    assert name in line
    assert hint in line
    assert "panic" not in line


def test_a_missing_file_is_named(halfline: Halfline, tmp_path: Path) -> None:
    assert "nowhere.ply" in halfline.complains("info", tmp_path / "nowhere.ply")
    assert str(tmp_path) in halfline.complains("info", tmp_path)


@pytest.mark.parametrize(
    "rays",
    [
        np.zeros((4, 5)),
        np.zeros((4, 7)),
        np.zeros(6),
        np.zeros((2, 2, 6)),
        np.zeros((4, 6), dtype=np.int64),
        np.zeros((4, 6), dtype=np.complex128),
        np.zeros((4, 6), dtype=[("a", "f8")]),
    ],
    ids=lambda rays: f"{rays.shape}-{rays.dtype}",
)
def test_rays_of_the_wrong_kind_are_refused(
    halfline: Halfline, judged: Judged, tmp_path: Path, rays: np.ndarray
) -> None:
    np.save(tmp_path / "rays.npy", rays)
    line = halfline.complains("query", judged.path, tmp_path / "rays.npy", "-o", tmp_path / "h.npz")
    assert "rays.npy" in line
    assert not (tmp_path / "h.npz").exists()


@pytest.mark.parametrize("length", [0, 5, 9, 60, 127, 128, 200])
def test_rays_cut_short_are_refused(
    halfline: Halfline, judged: Judged, tmp_path: Path, length: int
) -> None:
    path = tmp_path / "rays.npy"
    np.save(path, np.ones((4, 6)))
    path.write_bytes(path.read_bytes()[:length])
    assert "rays.npy" in halfline.complains("query", judged.path, path, "-o", tmp_path / "h.npz")
    assert list(tmp_path.iterdir()) == [path]


def test_a_pickle_is_not_opened(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    path = tmp_path / "rays.npy"
    np.save(path, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    assert "rays.npy" in halfline.complains("query", judged.path, path, "-o", tmp_path / "h.npz")


def test_an_output_that_cannot_be_written_is_named(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    np.save(tmp_path / "rays.npy", judged.rays)
    missing = tmp_path / "missing" / "hits.npz"
    line = halfline.complains("query", judged.path, tmp_path / "rays.npy", "-o", missing)
    assert "missing" in line


def test_a_failure_leaves_the_old_output_alone(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    hits = tmp_path / "hits.npz"
    hits.write_bytes(b"old")
    np.save(tmp_path / "rays.npy", np.zeros((4, 5)))
    halfline.complains("query", judged.path, tmp_path / "rays.npy", "-o", hits)
    assert hits.read_bytes() == b"old"


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["sing"],
        ["info"],
        ["info", "a.ply", "b.ply"],
        ["info", "a.ply", "--loud"],
        ["query", "a.ply", "rays.npy"],
        ["query", "a.ply", "rays.npy", "-o", "h.npz", "--engine", "magic"],
        ["query", "a.ply", "rays.npy", "-o", "h.npz", "--any", "--all"],
        ["query", "a.ply", "rays.npy", "-o", "h.npz", "--threads", "-1"],
        ["query", "a.ply", "rays.npy", "-o", "h.npz", "--threads", "many"],
        ["generate", "unicorn", "-n", "10", "-o", "u.ply"],
        ["generate", "sphere", "-n", "-3", "-o", "s.ply"],
        ["render", "a.ply", "-o", "a.png", "--resolution", "0,10"],
        ["render", "a.ply", "-o", "a.png", "--resolution", "wide"],
    ],
    ids=" ".join,
)
def test_wrong_arguments_exit_with_two(halfline: Halfline, arguments: list[str]) -> None:
    stderr = halfline.fails(2, *arguments)
    assert "--help" in stderr


def test_help_and_version_are_no_errors(halfline: Halfline) -> None:
    assert "render" in halfline.ok("--help")
    assert "--engine" in halfline.ok("query", "--help")
    assert halfline.ok("--version").startswith("halfline ")


def test_quiet_says_nothing(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    np.save(tmp_path / "rays.npy", judged.rays)
    done = halfline.run(
        "query", judged.path, tmp_path / "rays.npy", "-o", tmp_path / "hits.npz", "--quiet"
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_bytes_after_the_end_are_accepted(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    mesh = write_ply(tmp_path / "longer.ply", judged.shape)
    mesh.write_bytes(mesh.read_bytes() + b"more")
    assert halfline.json("info", mesh)["triangles"] == len(judged.shape.faces)
