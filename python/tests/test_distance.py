"""`halfline distance`: from mesh to mesh, judged by NumPy alone."""

from __future__ import annotations

import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from children import PATIENCE_SECONDS
from conftest import Halfline
from meshes import Floats, Shape, bumpy_sphere, gridded_cube, write_obj, write_ply
from nearest_points import distances_to, winding_numbers

PNG = b"\x89PNG\r\n\x1a\n"


@dataclass(frozen=True)
class Pair:
    """Two meshes on disk, and the judge's distances of the vertices of one to the other."""

    shape: Shape
    path: Path
    other: Shape
    other_path: Path
    distances: Floats
    backward: Floats


def in_single(shape: Shape, scale: float, shift: float) -> Shape:
    """A shape of another size elsewhere, in coordinates that single precision has."""
    vertices = (shape.vertices * scale + shift).astype(np.float32).astype(np.float64)
    return Shape(vertices, shape.faces)


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Pair:
    """A bumpy sphere and a cube that it sticks out of, both closed."""
    folder = tmp_path_factory.mktemp("pair")
    ball, cube = in_single(bumpy_sphere(), 1.0, 0.03), in_single(gridded_cube(6), 0.28, -0.8)

    def signed(shape: Shape, other: Shape) -> Floats:
        inside = winding_numbers(other, shape.vertices) > 0.5
        return np.asarray(np.where(inside, -1, 1) * distances_to(other, shape.vertices).min(axis=1))

    return Pair(
        ball,
        write_ply(folder / "ball.ply", ball),
        cube,
        write_ply(folder / "cube.ply", cube),
        signed(ball, cube),
        signed(cube, ball),
    )


def measure(halfline: Halfline, pair: Pair, *arguments: str | Path) -> dict[str, Any]:
    """What the command finds, as JSON."""
    return halfline.json("distance", pair.path, "--to", pair.other_path, *arguments)


def assert_figures(found: dict[str, Any], distances: Floats) -> None:
    """The figures are NumPy's of these distances."""
    sizes = np.abs(distances)
    expected = {
        "minimum": distances.min(),
        "maximum": distances.max(),
        "mean": distances.mean(),
        "rms": np.sqrt((distances**2).mean()),
        "hausdorff": sizes.max(),
        **{f"p{p}": np.percentile(sizes, p) for p in (50, 90, 95, 99)},
    }
    told = {**found, **found["percentiles"]}
    assert {name: told[name] for name in expected} == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert found["points"] == len(distances)
    assert found["invalid_points"] == 0
    histogram = found["histogram"]
    edges = np.array(histogram["edges"])
    counts, _ = np.histogram(distances, edges)
    assert histogram["counts"] == counts.tolist()
    assert histogram["below"] == (distances < edges[0]).sum()
    assert histogram["above"] == (distances > edges[-1]).sum()


def test_plain_distances(halfline: Halfline, pair: Pair) -> None:
    found = measure(halfline, pair)
    assert (found["points"], found["signed"]) == ("vertices", False)
    assert_figures(found["forward"], np.abs(pair.distances))
    assert found["backward"] is None
    assert found["symmetric_hausdorff"] is None
    edges = found["forward"]["histogram"]["edges"]
    assert edges[0] == 0
    assert edges[-1] >= np.percentile(np.abs(pair.distances), 99)


def test_signed_distances(halfline: Halfline, pair: Pair) -> None:
    assert (pair.distances < -0.01).any()
    assert (pair.distances > 0.01).any()
    found = measure(halfline, pair, "--signed")
    assert found["signed"] is True
    assert_figures(found["forward"], pair.distances)
    edges = found["forward"]["histogram"]["edges"]
    assert edges[0] == -edges[-1]
    assert edges[5] == 0


def test_both_ways(halfline: Halfline, pair: Pair) -> None:
    found = measure(halfline, pair, "--symmetric", "--signed")
    assert_figures(found["forward"], pair.distances)
    assert_figures(found["backward"], pair.backward)
    largest = max(np.abs(pair.distances).max(), np.abs(pair.backward).max())
    assert found["symmetric_hausdorff"] == pytest.approx(largest, rel=1e-12)
    assert found["backward"]["histogram"]["edges"] == found["forward"]["histogram"]["edges"]


def test_a_mesh_is_at_no_distance_from_itself(halfline: Halfline, pair: Pair) -> None:
    found = halfline.json("distance", pair.path, "--to", pair.path, "--signed", "--symmetric")
    assert found["symmetric_hausdorff"] == 0
    assert found["forward"]["rms"] == 0
    assert found["forward"]["histogram"]["edges"][-1] == 1


def test_tolerance_and_range(halfline: Halfline, pair: Pair) -> None:
    sizes = np.sort(np.abs(pair.distances))
    place = 150 + int(np.diff(sizes[150:250]).argmax())
    tolerance = float((sizes[place] + sizes[place + 1]) / 2)
    found = measure(halfline, pair, "--tolerance", repr(tolerance), "--range", "0.75")
    assert found["tolerance"] == tolerance
    assert found["forward"]["within_tolerance"] == place + 1
    assert found["forward"]["histogram"]["edges"][-1] == 0.75
    assert_figures(found["forward"], np.abs(pair.distances))


def test_samples_lie_on_the_surface(halfline: Halfline, pair: Pair) -> None:
    """Of a mesh to itself, samples are as far away as rounding puts them."""
    found = halfline.json("distance", pair.path, "--to", pair.path, "--samples", "5k")
    assert (found["points"], found["seed"]) == ("samples", 0)
    assert found["forward"]["points"] == 5000
    assert found["forward"]["hausdorff"] < 1e-15
    seeds = [measure(halfline, pair, "--samples", "5k", "--seed", seed) for seed in "121"]
    first, other, again = (figures["forward"] for figures in seeds)
    assert first == again
    assert first != other
    # Their mean is that over the surface, within what 5,000 samples leave open.
    assert first["mean"] == pytest.approx(other["mean"], rel=0.03)


@pytest.mark.parametrize("options", [[], ["--signed"]])
def test_more_points_than_are_measured_at_a_time(
    halfline: Halfline, tmp_path: Path, options: list[str]
) -> None:
    """Points above a square, each at a height of its own."""
    heights = np.arange(300_000) / 2**20
    places = np.random.default_rng(3).uniform(0.1, 0.9, (len(heights), 2))
    cloud = Shape(np.column_stack([places, heights]), np.array([[0, 1, 2]]))
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    square = write_ply(tmp_path / "square.ply", Shape(corners, np.array([[0, 1, 2], [0, 2, 3]])))
    out = tmp_path / "deviation.ply"
    arguments: list[str | Path] = ["--to", square, "-o", out, *options]
    found = halfline.json("distance", write_ply(tmp_path / "cloud.ply", cloud), *arguments)
    np.testing.assert_array_equal(read_deviation(out)["scalar_distance"], heights)
    assert_figures(found["forward"], heights)


def test_a_cloud_of_points_can_be_measured(halfline: Halfline, pair: Pair, tmp_path: Path) -> None:
    cloud = tmp_path / "cloud.obj"
    rows = (f"v {x!r} {y!r} {z!r}\n" for x, y, z in pair.shape.vertices.tolist())
    cloud.write_text("".join(rows), encoding="utf-8")
    found = halfline.json("distance", cloud, "--to", pair.other_path, "--signed")
    assert_figures(found["forward"], pair.distances)
    for option in (["--symmetric"], ["--samples", "9"], ["--picture", str(tmp_path / "a.png")]):
        line = halfline.complains("distance", cloud, "--to", pair.other_path, *option)
        assert "cloud.obj: it has no faces" in line
    assert not (tmp_path / "a.png").exists()


def test_vertices_that_are_not_finite_count_nowhere(
    halfline: Halfline, pair: Pair, tmp_path: Path
) -> None:
    vertices = pair.shape.vertices.copy()
    vertices[3], vertices[500] = np.nan, np.inf
    path = write_ply(tmp_path / "holes.ply", Shape(vertices, pair.shape.faces))
    out = tmp_path / "deviation.ply"
    found = halfline.json("distance", path, "--to", pair.other_path, "-o", out)["forward"]
    assert found.pop("invalid_points") == 2
    rest = np.abs(np.delete(pair.distances, [3, 500]))
    assert_figures({**found, "invalid_points": 0}, rest)
    assert np.isnan(read_deviation(out)["scalar_distance"][[3, 500]]).all()


def read_deviation(path: Path) -> np.ndarray[Any, Any]:
    """The vertices of a deviation.ply."""
    content = path.read_bytes()
    end = content.index(b"end_header\n") + len(b"end_header\n")
    header = content[:end].decode("ascii")
    types = {"float": "<f4", "double": "<f8", "uchar": "u1"}
    vertex = header[header.index("element vertex") : header.index("element face")].splitlines()
    count = int(vertex[0].split()[2])
    dtype = np.dtype([(name, types[kind]) for _, kind, name in map(str.split, vertex[1:])])
    return np.frombuffer(content, dtype, count, end)


def test_the_mesh_with_its_distances(halfline: Halfline, pair: Pair, tmp_path: Path) -> None:
    out = tmp_path / "deviation.ply"
    measure(halfline, pair, "--signed", "--tolerance", "0.05", "--range", "0.2", "-o", out)
    vertices = read_deviation(out)
    np.testing.assert_allclose(vertices["scalar_distance"], pair.distances, rtol=1e-12)
    np.testing.assert_array_equal(vertices["quality"], vertices["scalar_distance"].astype("<f4"))
    for axis, name in enumerate("xyz"):
        np.testing.assert_array_equal(vertices[name], pair.shape.vertices[:, axis])
    red, green, blue = (vertices[name].astype(int) for name in ("red", "green", "blue"))
    within = np.abs(pair.distances) <= 0.05
    assert within.any()
    assert len(set(zip(red[within], green[within], blue[within], strict=True))) == 1
    assert (green[within] > red[within]).all()
    assert (green[within] > blue[within]).all()
    assert (blue > red)[pair.distances < -0.06].all()
    assert (red > blue)[pair.distances > 0.06].all()
    # It is a mesh like any other.
    assert halfline.json("info", out)["triangles"] == len(pair.shape.faces)
    again = halfline.json("distance", out, "--to", pair.other_path, "--signed")
    assert_figures(again["forward"], pair.distances)


def test_files_show_vertices_whatever_is_sampled(
    halfline: Halfline, pair: Pair, tmp_path: Path
) -> None:
    out = tmp_path / "deviation.ply"
    measure(halfline, pair, "--samples", "100", "-o", out)
    expected = np.abs(pair.distances)
    np.testing.assert_allclose(read_deviation(out)["scalar_distance"], expected, rtol=1e-12)


def test_the_picture_has_a_scale(halfline: Halfline, pair: Pair, tmp_path: Path) -> None:
    picture = tmp_path / "deviation.png"
    options: list[str | Path] = ["--signed", "--picture", picture, "--resolution", "320,240"]
    measure(halfline, pair, *options)
    first = picture.read_bytes()
    assert first.startswith(PNG)
    measure(halfline, pair, *options, "--threads", "1")
    assert picture.read_bytes() == first
    measure(halfline, pair, *options, "--tolerance", "0.1")
    assert picture.read_bytes() != first


def test_threads_and_trees_do_not_change_a_bit(
    halfline: Halfline, pair: Pair, tmp_path: Path
) -> None:
    trees = {}
    for name, path in (("ball", pair.path), ("cube", pair.other_path)):
        trees[name] = tmp_path / f"{name}.hlt"
        halfline.ok("build", path, "-o", trees[name])
    out = [tmp_path / "a.ply", tmp_path / "b.ply"]
    options = ["--signed", "--symmetric"]
    a = measure(halfline, pair, *options, "-o", out[0], "--threads", "1")
    b = halfline.json("distance", trees["ball"], "--to", trees["cube"], *options, "-o", out[1])
    assert (a["forward"], a["backward"]) == (b["forward"], b["backward"])
    assert out[0].read_bytes() == out[1].read_bytes()


def test_a_mesh_may_come_through_a_pipe(halfline: Halfline, pair: Pair) -> None:
    for arguments, path in (
        (["-", "--to", str(pair.other_path)], pair.path),
        ([str(pair.path), "--to", "-"], pair.other_path),
    ):
        with path.open("rb") as stdin:
            done = subprocess.run(
                [halfline.binary, "distance", *arguments, "--quiet"],
                stdin=stdin,
                capture_output=True,
                text=True,
                timeout=PATIENCE_SECONDS,
                check=True,
            )
        assert "standard input" in done.stdout.splitlines()[0]


def test_people_read_a_table_and_a_histogram(
    halfline: Halfline, pair: Pair, tmp_path: Path
) -> None:
    out = tmp_path / "deviation.ply"
    arguments: list[str | Path] = ["--to", pair.other_path, "--signed", "--symmetric"]
    arguments += ["--tolerance", "0.1"]
    text = halfline.ok("distance", pair.path, *arguments, "-o", out)
    titles = [line for line in text.splitlines() if not line.startswith(" ")]
    there, back = (
        f"{a} to {b}" for a, b in ((pair.path, pair.other_path), (pair.other_path, pair.path))
    )
    assert titles == [there, back, "in all"]
    for word in ("minimum", "RMS", "99 %", "Hausdorff", "symmetric", "within", "█", str(out)):
        assert word in text, word
    # The figures are the result, which --quiet does not silence.
    assert "RMS" in halfline.ok("distance", pair.path, *arguments, "--quiet")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ([], "--to"),
        (["--to", "{other}", "--tolerance", "-1"], "expected a number of at least 0"),
        (["--to", "{other}", "--tolerance", "nan"], "expected a number of at least 0"),
        (["--to", "{other}", "--range", "0"], "expected a number above 0"),
        (["--to", "{other}", "--tolerance", "2", "--range", "2"], "--range must be above"),
        (["--to", "{other}", "--samples", "0"], "expected a whole number"),
        (["--to", "{other}", "--seed", "3"], "--samples"),
        (["--to", "{other}", "-o", "deviation.obj"], "must end in .ply"),
        (["--to", "{other}", "--picture", "deviation.jpg"], "must end in .png"),
        (["--to", "{other}", "-o", "{mesh}"], "--output {mesh} would overwrite the input"),
        (["--to", "{other}", "-o", "{other}"], "--output {other} would overwrite the input"),
        (["--to", "{other}", "--preset", "none"], "--preset"),
    ],
)
def test_wrong_arguments(halfline: Halfline, pair: Pair, arguments: list[str], reason: str) -> None:
    names = {"mesh": str(pair.path), "other": str(pair.other_path)}
    before = pair.path.read_bytes(), pair.other_path.read_bytes()
    filled = [argument.format(**names) for argument in arguments]
    assert reason.format(**names) in halfline.fails(2, "distance", pair.path, *filled)
    assert (pair.path.read_bytes(), pair.other_path.read_bytes()) == before


def test_two_pipes_are_one_too_many(halfline: Halfline) -> None:
    assert "only one of MESH and OTHER" in halfline.fails(2, "distance", "-", "--to", "-")


def test_what_has_no_surface_is_named(halfline: Halfline, pair: Pair, tmp_path: Path) -> None:
    empty = tmp_path / "empty.obj"
    cloud = tmp_path / "cloud.obj"
    nowhere = tmp_path / "nowhere.obj"
    empty.write_text("# nothing\n", encoding="utf-8")
    cloud.write_text("v 0 0 0\nv 1 0 0\n", encoding="utf-8")
    nowhere.write_text("v nan 0 0\nv nan 1 0\nv nan 0 1\nf 1 2 3\n", encoding="utf-8")
    for path in (empty, cloud):
        line = halfline.complains("distance", pair.path, "--to", path)
        assert f"{path.name}: it has no faces, and so no surface" in line
    assert "nowhere.obj" in halfline.complains("distance", pair.path, "--to", nowhere)
    line = halfline.complains("distance", nowhere, "--to", pair.path)
    assert "nowhere.obj: none of its vertices is finite" in line
    assert "empty.obj: it has no vertices" in halfline.complains(
        "distance", empty, "--to", pair.path
    )


def test_broken_files_are_named(halfline: Halfline, pair: Pair, tmp_path: Path) -> None:
    cut = tmp_path / "cut.ply"
    cut.write_bytes(pair.path.read_bytes()[:-5])
    tree = tmp_path / "tree.hlt"
    halfline.ok("build", pair.path, "-o", tree)
    content = bytearray(tree.read_bytes())
    content[len(content) // 2] ^= 255
    tree.write_bytes(content)
    out = tmp_path / "out.ply"
    for broken in (cut, tree, tmp_path / "missing.ply"):
        for mesh, other in ((broken, pair.path), (pair.path, broken)):
            line = halfline.complains("distance", mesh, "--to", other, "-o", out)
            assert broken.name in line
            assert "panic" not in line
    assert not out.exists()


def test_degenerate_faces_have_distances_too(halfline: Halfline, tmp_path: Path) -> None:
    """A face without area is the segment that it is."""
    line = Shape(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]]))
    point = Shape(np.array([[1.5, 2.0, 0], [3, 0, 0], [-1, 0, 0]]), np.array([[0, 1, 2]]))
    paths = write_obj(tmp_path / "point.obj", point), write_obj(tmp_path / "line.obj", line)
    found = halfline.json("distance", paths[0], "--to", paths[1])["forward"]
    assert (found["minimum"], found["maximum"]) == (1, 2)


@pytest.mark.parametrize("when", [0.15, 0.6, 1.5])
def test_an_interruption_leaves_nothing_behind(
    halfline: Halfline, tmp_path: Path, when: float
) -> None:
    scan, out = tmp_path / "scan.ply", tmp_path / "out"
    out.mkdir()
    halfline.ok("generate", "scan", "-n", "400k", "-o", scan)
    arguments = ["--samples", "40M", "--signed", "--threads", "1", "-o", str(out / "a.ply")]
    with subprocess.Popen(
        [halfline.binary, "distance", scan, "--to", scan, *arguments, "--picture", out / "a.png"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        time.sleep(when)
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        stdout, _ = process.communicate(timeout=PATIENCE_SECONDS)
        assert time.monotonic() - began < 3
    assert (process.returncode, stdout) == (130, "")
    assert list(out.iterdir()) == []
