"""Tree files: by the specification alone, and through everything that writes and opens them."""

from __future__ import annotations

import os
import pickle
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import halfline
import numpy as np
import pytest
import xxhash
from children import PATIENCE_SECONDS, wait_until
from numpy.typing import NDArray

PAGE = 4096
CHUNK = 1 << 20
SECTIONS = (
    "nodes",
    "leaf blocks",
    "collinear faces",
    "vertices",
    "triangles",
    "source faces",
    "vertex colours",
    "materials",
    "materials of triangles",
    "checksums",
)
# What of the header the content hash does not cover: written_at, the checksum, the hash itself,
# build_seconds and program.
PASSING = ((24, 8), (32, 8), (40, 16), (368, 8), (376, 32))


class Tree(NamedTuple):
    """A tree file, by docs/tree-file.md."""

    header: bytes
    sections: dict[str, bytes]

    def word(self, offset: int, kind: str) -> Any:
        """A number of the header."""
        return struct.unpack_from("<" + kind, self.header, offset)[0]


def read(path: Path) -> Tree:
    """Reads and checks a file by its specification."""
    content = path.read_bytes()
    header = content[:PAGE]
    assert header[:8] == b"\x89HLT\r\n\x1a\n"
    version, byte_order, file_bytes, written_at, checksum = struct.unpack_from("<IIQqQ", header, 8)
    assert (version, byte_order, file_bytes) == (2, 0x01020304, len(content))
    assert path.stat().st_mtime_ns == written_at * 10**9
    assert xxhash.xxh3_64_intdigest(header[:32] + bytes(8) + header[40:]) == checksum

    sections, end, sums = {}, PAGE, b""
    for number, name in enumerate(SECTIONS):
        offset, length = struct.unpack_from("<QQ", header, 72 + 16 * number)
        assert offset == -(-end // PAGE) * PAGE
        assert not any(content[end:offset])
        end = offset + length
        sections[name] = content[offset:end]
        if name != "checksums":
            for i in range(0, length, CHUNK):
                chunk = sections[name][i : i + CHUNK]
                sums += struct.pack("<Q", xxhash.xxh3_64_intdigest(chunk))
    assert end == len(content)
    assert sections["checksums"] == sums

    lasting = bytearray(header)
    for offset, length in PASSING:
        lasting[offset : offset + length] = bytes(length)
    low, high, mesh_low, mesh_high = struct.unpack_from("<4Q", header, 40)
    assert xxhash.xxh3_128_intdigest(bytes(lasting) + sums) == high << 64 | low
    mesh = sections["vertices"] + sections["triangles"]
    assert xxhash.xxh3_128_intdigest(mesh) == mesh_high << 64 | mesh_low
    return Tree(header, sections)


def faces_of_leaves(tree: Tree) -> list[list[int]]:
    """The faces of each leaf, by walking from the root; boxes lie in those above them."""
    blocks = np.frombuffer(tree.sections["leaf blocks"], dtype="<u4").reshape(-1, 80)[:, 72:]
    nodes = np.frombuffer(tree.sections["nodes"], dtype="<u4").reshape(-1, 64)
    sides = nodes[:, :48].view("<f4").reshape(-1, 3, 2, 8)
    low, high = np.frombuffer(tree.header[264:288], dtype="<f4").reshape(2, 3)
    seen = np.zeros(len(blocks), dtype=int)
    leaves, pending = [], [(tree.word(288, "I"), low, high)]
    while pending:
        reference, low, high = pending.pop()
        kind, index = reference >> 30, reference & (1 << 30) - 1
        if kind == 1:
            seen[index] += 1
            count = int((blocks[index] != 0xFFFFFFFF).sum())
            assert all(blocks[index][count:] == 0xFFFFFFFF)
            leaves.append(blocks[index][:count].tolist())
        elif kind == 0:
            for lane, child in enumerate(nodes[index, 48:56].tolist()):
                if child >> 30 != 2:
                    box = sides[index, :, 0, lane], sides[index, :, 1, lane]
                    assert (low <= box[0]).all()
                    assert (box[1] <= high).all()
                    pending.append((child, *box))
    assert (seen == 1).all()
    return leaves


@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_the_file_is_what_its_specification_says(tmp_path: Path, precision: type) -> None:
    generated = halfline.generate("hall", 30_000, 1)
    mesh = halfline.Mesh(generated.vertices.astype(precision), generated.faces)
    path = tmp_path / "hall.hlt"
    halfline.Scene(mesh).save(path)
    tree = read(path)
    kind = "<f8" if precision is np.float64 else "<f4"
    vertices = np.frombuffer(tree.sections["vertices"], dtype=kind).reshape(-1, 3)
    triangles = np.frombuffer(tree.sections["triangles"], dtype="<u4").reshape(-1, 3)
    assert (vertices == mesh.vertices).all()
    assert (triangles == mesh.faces).all()
    assert tree.word(300, "I") & 1 == (precision is np.float64)

    leaves = faces_of_leaves(tree)
    assert sum(map(len, leaves)) == tree.word(304, "Q")
    kept = len(triangles) - tree.word(312, "Q") - tree.word(320, "Q")
    assert len({face for faces in leaves for face in faces}) == kept

    # A leaf block's corners are the vertices in frame coordinates.
    offset, unit = np.frombuffer(tree.header[232:264]).reshape(4)[:3], tree.word(256, "d")
    block = np.frombuffer(tree.sections["leaf blocks"], dtype="<f4").reshape(-1, 80)[0]
    corners = block[:72].reshape(3, 3, 8)[:, :, 0].astype(np.float64) * unit + offset
    expected = vertices[triangles[int(block[72:73].view("<u4")[0])]]
    assert np.allclose(corners, expected, rtol=0, atol=1e-6 * unit)


def rays(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    random = np.random.default_rng(5)
    origins = random.normal(size=(count, 3))
    return origins * 3 / np.linalg.norm(origins, axis=1)[:, None], -origins + random.normal(
        size=(count, 3)
    )


@pytest.fixture(scope="module")
def scene() -> halfline.Scene:
    return halfline.Scene(halfline.generate("scan", 20_000, 0))


def test_an_opened_scene_answers_as_the_one_that_was_saved(
    tmp_path: Path, scene: halfline.Scene
) -> None:
    path = tmp_path / "scan.hlt"
    stages: list[tuple[str, int, int]] = []
    scene.save(path, progress=lambda *told: stages.append(told))
    assert stages
    assert stages[-1][0] == "write"
    assert stages[-1][1] == stages[-1][2] > 0
    assert (scene.path, scene.content_hash) == (None, None)
    opened = halfline.open(path)
    assert opened.path == path
    origins, directions = rays(5000)
    for expected, found in (
        (scene.intersect(origins, directions), opened.intersect(origins, directions)),
        (scene.intersect_all(origins, directions), opened.intersect_all(origins, directions)),
    ):
        for name in ("t", "face", "uv", "point", "normal"):
            assert np.array_equal(getattr(expected, name), getattr(found, name), equal_nan=True)
    assert (opened.occluded(origins, directions) == scene.occluded(origins, directions)).all()
    assert (opened.mesh.vertices == scene.mesh.vertices).all()
    assert not opened.mesh.vertices.flags.writeable
    assert opened.info() == scene.info()


def test_a_view_of_the_mesh_keeps_the_map(tmp_path: Path, scene: halfline.Scene) -> None:
    path = tmp_path / "scan.hlt"
    scene.save(path)
    vertices = halfline.open(path).mesh.vertices
    path.unlink()
    assert (vertices == scene.mesh.vertices).all()


def test_a_scene_from_a_file_pickles_as_path_and_hash(
    tmp_path: Path, scene: halfline.Scene
) -> None:
    path = tmp_path / "scan.hlt"
    scene.save(path)
    opened = halfline.open(path)
    pickled = pickle.dumps(opened)
    assert len(pickled) < 400
    again = pickle.loads(pickled)
    assert (again.path, again.content_hash) == (path, opened.content_hash)
    # Another tree in its place is not taken for it.
    halfline.Scene(halfline.generate("scan", 2_000, 0)).save(path)
    with pytest.raises(halfline.FormatError, match="not the tree that was pickled"):
        pickle.loads(pickled)
    path.unlink()
    with pytest.raises(FileNotFoundError):
        pickle.loads(pickled)


def resident_pages() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1])


def test_opening_reads_next_to_nothing(tmp_path: Path, scene: halfline.Scene) -> None:
    path = tmp_path / "scan.hlt"
    scene.save(path)
    before = resident_pages()
    opened = [halfline.open(path) for _ in range(200)]
    grown = resident_pages() - before
    # Two hundred scenes of 2 MB share its pages; little more than the header was read.
    assert grown * os.sysconf("SC_PAGESIZE") < 100 * path.stat().st_size
    assert len({scene.content_hash for scene in opened}) == 1


def test_what_is_damaged_is_refused_in_one_line(tmp_path: Path, scene: halfline.Scene) -> None:
    path = tmp_path / "scan.hlt"
    scene.save(path)
    whole = path.read_bytes()
    random = np.random.default_rng(2)
    for at in [*random.integers(len(whole), size=50).tolist(), 0, 8, 12, 100, 4095, len(whole) - 1]:
        damaged = bytearray(whole)
        damaged[at] ^= 1
        path.write_bytes(damaged)
        with pytest.raises(halfline.FormatError) as refusal:
            halfline.open(path)
        assert str(path) in str(refusal.value)
        assert "\n" not in str(refusal.value)
    for content, reason in (
        (whole[:-1], "cut short"),
        (whole[:100], "cut short"),
        (whole + b"\0", "made longer"),
        (b"", "empty"),
        (b"ply\n", "not a tree"),
    ):
        path.write_bytes(content)
        with pytest.raises(halfline.FormatError, match=reason):
            halfline.open(path, verify=False)
    with pytest.raises(FileNotFoundError):
        halfline.open(tmp_path / "none.hlt")
    path.write_bytes(whole)
    with pytest.raises(halfline.FormatError, match="open it as a scene, from its file"):
        halfline.load(path)


def outcome(question: Callable[[], object]) -> str:
    try:
        question()
    except halfline.FormatError as error:
        return str(error)
    return "answer"


def test_verify_skips_the_checksums_and_nothing_else(tmp_path: Path, scene: halfline.Scene) -> None:
    path = tmp_path / "scan.hlt"
    scene.save(path)
    origins, directions = rays(2000)
    whole = path.read_bytes()
    random = np.random.default_rng(3)
    outcomes = set()
    for turn in range(100):
        damaged = bytearray(whole)
        for _ in range(1 + turn % 20):
            at = int(random.integers(PAGE, len(whole) - 4000))
            damaged[at : at + int(random.integers(1, 4000))] = random.bytes(
                int(random.integers(1, 4000))
            )
        path.write_bytes(damaged[: len(whole)].ljust(len(whole), b"\0"))
        opened = halfline.open(path, verify=False)
        for ask in (opened.intersect, opened.occluded, opened.count_intersections):
            outcomes.add(outcome(partial(ask, origins, directions)))
    assert "answer" in outcomes
    assert all(told == "answer" or "damaged" in told for told in outcomes)


HOLD = """
import sys, halfline, numpy as np
scene = halfline.open(sys.argv[1])
origins = np.random.default_rng(0).normal(size=(200_000, 3)) * 2
print("open", flush=True)
sys.stdin.readline()
try:
    scene.intersect(origins, -origins)
except halfline.FormatError as error:
    print(error, flush=True)
else:
    print("answered", flush=True)
"""


def test_a_file_cut_short_under_the_map_is_an_error_with_a_word(
    tmp_path: Path, scene: halfline.Scene
) -> None:
    path = tmp_path / "scan.hlt"
    scene.save(path)
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, path],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "open\n"
        os.truncate(path, 8192)
        out, err = holder.communicate("go\n", timeout=PATIENCE_SECONDS)
    assert holder.returncode == 0
    assert str(path) in out
    assert "cut short" in out
    assert err == ""


SAVE = """
import sys, halfline
scenes = [halfline.Scene(halfline.generate("scan", n, 0)) for n in (60_000, 80_000)]
print("ready", flush=True)
while True:
    for scene in scenes:
        scene.save(sys.argv[1])
"""


def changed(path: Path, before: int) -> bool:
    """True once another file lies there."""
    return path.stat().st_ino != before


def test_killed_at_any_moment_it_leaves_a_whole_file(tmp_path: Path) -> None:
    path = tmp_path / "scan.hlt"
    halfline.Scene(halfline.generate("scan", 1000, 0)).save(path)
    sizes = set()
    random = np.random.default_rng(4)
    for turn in range(8):
        is_another = partial(changed, path, path.stat().st_ino)
        with subprocess.Popen(
            [sys.executable, "-c", SAVE, path], stdout=subprocess.PIPE, text=True
        ) as saver:
            assert saver.stdout is not None
            assert saver.stdout.readline() == "ready\n"
            # Half of them may finish a file first, however long that takes.
            if turn % 2:
                wait_until(is_another)
            time.sleep(float(random.uniform(0, 0.15)))
            saver.send_signal(signal.SIGKILL)
        opened = halfline.open(path, verify=True)
        sizes.add(len(opened.mesh.faces))
    assert sizes <= {1000, 60_000, 80_000}
    assert sizes & {60_000, 80_000}, "some were written"
