"""`halfline study`: the report, its figures, and what stops it."""

from __future__ import annotations

import csv
import subprocess
import time
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from children import interrupt, wait_until_it_listens
from conftest import Halfline, Judged

FILES = ["study.csv", "study.html", "study.svg"]
ENGINES = ["brute", "middle", "median", "sah", "fast"]
COLUMNS = [
    "family",
    "engine",
    "n",
    "rays",
    "hit_share",
    "nodes_per_ray",
    "leaves_per_ray",
    "triangles_per_ray",
    "ns_per_ray",
    "ns_per_ray_low",
    "ns_per_ray_high",
    "build_seconds",
    "bytes_per_triangle",
    "bytes_walked",
    "extrapolated",
    "note",
]
# Small enough for a test, and six sizes, so that laws are fitted.
TINY = ["--quick", "--family", "scan,soup", "--sizes", "50,100,200,400,700,1k"]
VOID = {"meta", "br", "hr", "img", "link", "input"}


class Page(HTMLParser):
    """Checks that every element is closed where it was opened, and collects what it asks for."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.loads: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """An element begins."""
        self.tags.append(tag)
        self.loads += [
            value or "" for name, value in attrs if name in ("src", "href", "xlink:href")
        ]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        """The innermost element ends."""
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Text."""
        self.text += data


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        rows = list(reader)
        assert reader.fieldnames == COLUMNS
    return rows


@pytest.fixture(scope="module")
def studied(halfline: Halfline, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    """A folder with a study in it, and its figures."""
    folder = tmp_path_factory.mktemp("study") / "made" / "anew"
    return folder, halfline.json("study", *TINY, "--output", folder)


def test_there_are_three_files(studied: tuple[Path, Any]) -> None:
    folder, figures = studied
    assert sorted(path.name for path in folder.iterdir()) == FILES
    assert figures["output"] == str(folder)


def test_the_csv_has_a_row_for_each_family_engine_and_size(studied: tuple[Path, Any]) -> None:
    rows = rows_of(studied[0] / "study.csv")
    keys = [(row["family"], row["engine"], int(row["n"])) for row in rows]
    sizes = {"scan": [48, 96, 192, 396, 700, 1000], "soup": [50, 100, 200, 400, 700, 1000]}
    near = [(family, engine, n) for family in sizes for n in sizes[family] for engine in ENGINES]
    assert [key[:2] for key in keys] == [key[:2] for key in near]
    for (_, _, n), (_, _, wanted) in zip(keys, near, strict=True):
        assert abs(n - wanted) <= 0.05 * wanted
    for row in rows:
        assert float(row["ns_per_ray"]) > 0
        assert row["extrapolated"] == "false"
        steps = float(row["nodes_per_ray"]) + float(row["leaves_per_ray"])
        if row["engine"] == "brute":
            assert steps == 0
            assert float(row["triangles_per_ray"]) == int(row["n"])
            assert row["build_seconds"] == row["bytes_per_triangle"] == ""
        else:
            assert steps >= 1
            assert float(row["build_seconds"]) > 0


def test_json_and_csv_say_the_same(studied: tuple[Path, Any]) -> None:
    folder, figures = studied
    of_csv = [
        (row["family"], row["engine"], int(row["n"]), float(row["ns_per_ray"]))
        for row in rows_of(folder / "study.csv")
    ]
    of_json = [
        (family["family"], row["engine"], row["n"], row["ns_per_ray"])
        for family in figures["families"]
        for row in family["rows"]
    ]
    assert of_json == of_csv


def test_brute_force_grows_like_n_and_all_laws_are_told(studied: tuple[Path, Any]) -> None:
    _, figures = studied
    for family in figures["families"]:
        laws = {(g["engine"], g["quantity"]): g for g in family["growth"]}
        assert ("fast", "steps") in laws
        assert ("sah", "time") in laws
        brute = laws["brute", "triangles"]
        assert brute["verdict"].startswith("n holds (±0 %)")
        assert brute["points"] == 6
        names = {law["law"] for law in brute["laws"]}
        assert names == {"constant", "log n", "n^(1/3)", "n^(1/2)", "n"}
        assert all(law["b"] >= 0 for law in brute["laws"])


def test_speed_ups_that_were_not_measured_are_marked(studied: tuple[Path, Any]) -> None:
    _, figures = studied
    for family in figures["families"]:
        sizes = {speed_up["n"] for speed_up in family["speed_up"]}
        assert sizes == {16_843, 5_500_000}
        assert all(s["extrapolated"] and s["brute_extrapolated"] for s in family["speed_up"])


def test_shares_of_a_picture_add_up(studied: tuple[Path, Any]) -> None:
    shares = studied[1]["shares"]
    assert [share["engine"] for share in shares] == ["brute", "sah", "fast"]
    for share in shares:
        parts = [share[name] for name in ("ray_generation", "intersection", "shading")]
        assert abs(sum(parts) - 1) < 1e-9
        assert min(parts) >= 0


def test_the_page_is_well_formed_and_needs_nothing_else(studied: tuple[Path, Any]) -> None:
    folder, figures = studied
    text = (folder / "study.html").read_text(encoding="utf-8")
    page = Page()
    page.feed(text)
    page.close()
    assert page.open == []
    assert page.loads == []
    assert {"script", "link", "img", "iframe"}.isdisjoint(page.tags)
    for outside in ("http://", "https://", "url(", "@import"):
        assert outside not in text
    # Six figures of two panels each, and the bars.
    assert page.tags.count("svg") == 6 * 2 + 1
    for finding in figures["findings"]:
        assert finding["topic"] in page.text


def test_the_plot_alone_is_a_picture_on_white(studied: tuple[Path, Any]) -> None:
    root = ET.parse(studied[0] / "study.svg").getroot()
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    first = root[0]
    assert first.tag.endswith("rect")
    assert (first.get("width"), first.get("height")) == (root.get("width"), root.get("height"))
    assert first.get("fill") == "#fff"
    drawn = "".join(root.itertext())
    for name in ("brute force", "middle", "median", "SAH", "halfline", "nanoseconds per ray"):
        assert name in drawn


def test_people_get_tables_and_findings(halfline: Halfline, tmp_path: Path) -> None:
    done = halfline.run("study", *TINY, "--quiet", "--output", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    for part in ("scan: ", "soup: how it grows with n", "textbook SAH", "Findings", "study.html"):
        assert part in done.stdout
    lines = done.stdout.splitlines()
    assert all(len(line) <= 80 for line in lines if str(tmp_path) not in line)


def test_ones_own_mesh_is_studied(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    out = tmp_path / "out"
    figures = halfline.json("study", judged.path, "--quick", "--sizes", "200,9k", "--output", out)
    own = len(judged.shape.faces)
    [family] = figures["families"]
    assert family["family"] == judged.path.name
    sizes = sorted({row["n"] for row in family["rows"]})
    assert sizes == [200, own, 4 * own]


def test_a_tree_file_is_a_mesh_too(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    tree = tmp_path / "bumpy.hlt"
    halfline.ok("build", judged.path, "-o", tree)
    figures = halfline.json(
        "study", tree, "--quick", "--sizes", "200", "--output", tmp_path / "out"
    )
    assert [row["n"] for row in figures["families"][0]["rows"]][-1] == len(judged.shape.faces)


def test_trees_beyond_the_budget_are_named(halfline: Halfline, tmp_path: Path) -> None:
    options = ["--family", "soup", "--sizes", "2k,4k", "--budget", "0.0001", "--quick"]
    halfline.ok("study", *options, "--output", tmp_path)
    rows = rows_of(tmp_path / "study.csv")
    textbook = [row for row in rows if row["engine"] in ("middle", "median", "sah")]
    assert len(textbook) == 6
    for row in textbook:
        assert row["note"].startswith("not built: ")
        assert row["ns_per_ray"] == row["build_seconds"] == ""


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--sizes", "0"], "at least 1"),
        (["--sizes", "many"], "whole number"),
        (["--family", "dragon"], "dragon"),
        (["--family", "scan", "mesh.ply"], "cannot be used with"),
        (["--budget", "0"], "above 0"),
        (["--budget", "nan"], "above 0"),
        (["one.ply", "two.ply"], "two.ply"),
    ],
)
def test_wrong_arguments_are_refused(
    halfline: Halfline, tmp_path: Path, options: list[str], said: str
) -> None:
    out = tmp_path / "out"
    assert said in halfline.fails(2, "study", *options, "--output", out)
    assert not out.exists()


def test_a_broken_mesh_is_named_and_nothing_is_left(halfline: Halfline, tmp_path: Path) -> None:
    broken = tmp_path / "broken.ply"
    broken.write_text("ply\nformat ascii 1.0\nelement vertex many\nend_header\n")
    said = halfline.complains("study", broken, "--output", tmp_path / "deep" / "out")
    assert said.startswith(f"halfline: error: {broken}: line 3: ")
    assert [path.name for path in tmp_path.iterdir()] == ["broken.ply"]


def test_a_mesh_with_nothing_to_hit_is_named(halfline: Halfline, tmp_path: Path) -> None:
    empty = tmp_path / "empty.off"
    empty.write_text("OFF\n0 0 0\n")
    said = halfline.complains("study", empty, "--output", tmp_path / "out")
    assert "empty.off: " in said
    assert [path.name for path in tmp_path.iterdir()] == ["empty.off"]


def test_a_folder_that_cannot_be_is_refused_at_once(halfline: Halfline, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    said = halfline.complains("study", "--output", tmp_path / "file")
    assert str(tmp_path / "file") in said
    said = halfline.complains("study", "--output", tmp_path / "file" / "inside")
    assert str(tmp_path / "file") in said
    (tmp_path / "study.csv").mkdir()
    assert "study.csv" in halfline.complains("study", "--output", tmp_path)


@pytest.mark.parametrize("seconds", [0.2, 1.5])
def test_ctrl_c_leaves_nothing(halfline: Halfline, tmp_path: Path, seconds: float) -> None:
    out = tmp_path / "out"
    options = ["--sizes", "1k,100k,3M", "--budget", "1000", "--output", str(out)]
    child = subprocess.Popen(
        [str(halfline.binary), "study", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until_it_listens(child)
    time.sleep(seconds)
    stdout, stderr = interrupt(child)
    assert (child.returncode, stdout, stderr) == (130, "", "halfline: interrupted\n")
    assert list(tmp_path.iterdir()) == []
