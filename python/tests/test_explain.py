"""`halfline explain` and `Scene.explain`: what they tell is what happens."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import halfline as package
import jsonschema
import numpy as np
import pytest
from conftest import ROOT, Halfline, Judged
from meshes import Floats, Shape, bumpy_sphere, gridded_cube, random_rays, write_ply

SCHEMA = json.loads((ROOT / "docs" / "explain.schema.json").read_text(encoding="utf-8"))
SVG = "{http://www.w3.org/2000/svg}"


def ray_text(ray: Floats) -> str:
    return ",".join(repr(float(x)) for x in ray)


def checked(explanation: dict[str, Any]) -> dict[str, Any]:
    """The explanation, which the documented schema describes."""
    jsonschema.Draft202012Validator(SCHEMA).validate(explanation)
    return explanation


@pytest.fixture(scope="module")
def cube(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cube of unit squares, whose planes are the planes of its tree."""
    return write_ply(tmp_path_factory.mktemp("cube") / "cube.ply", gridded_cube(4))


def test_the_command_explains_what_query_finds(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    rays = judged.rays[:12]
    hits = halfline.query(judged.path, rays, tmp_path)
    missed = 0
    for ray, t, face, uv in zip(rays, hits["t"], hits["face"], hits["uv"], strict=True):
        told = checked(halfline.json("explain", judged.path, f"--ray={ray_text(ray)}"))
        assert told["ray"]["origin"] == ray[:3].tolist()
        if face < 0:
            missed += 1
            assert told["hit"] is None
            assert told["nearest_miss"]["distance"] > 0
        else:
            assert told["nearest_miss"] is None
            assert (told["hit"]["t"], told["hit"]["face"]) == (t, face)
            assert told["hit"]["uv"] == uv.tolist()
    assert 0 < missed < len(rays)


@pytest.mark.parametrize("rule", ["sah", "middle", "median"])
def test_every_explanation_is_as_the_schema_says(
    rule: str, judged: Judged, scene: package.Scene
) -> None:
    cube = gridded_cube(4)
    corners = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
    apart = np.array([[0, 1, 2]])
    scenes = [
        scene,
        package.Scene(cube.vertices, cube.faces),
        package.Scene(np.array(corners), apart),
        package.Scene(np.array(corners) + 5_400_000.0, apart),
        package.Scene(np.array(corners) * 1e-30, apart),
        package.Scene(np.array(corners) * 1e30, apart),
        package.Scene(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), apart),
        package.Scene(np.array([[np.nan, 0, 0], [1, 0, 0], [0, 1, 0]]), apart),
        package.Scene(np.zeros((0, 3)), np.zeros((0, 3), dtype=int)),
    ]
    rays = [*random_rays(4, seed=3).reshape(-1, 2, 3)]
    rays += [np.array(ray) for ray in ([[2.0, 2, -9], [0, 0, 1]], [[-1.0, 2, 2], [1, 0, 0]])]
    rays += [np.array([[1.0, 1, -3], [1, 1, 1]]), np.array([[1e9, 0, 0], [-1, 1e-9, 1e-9]])]
    kinds: set[str] = set()
    for each in scenes:
        for origin, direction in rays:
            for t_range in ((0.0, np.inf), (-np.inf, np.inf), (0.5, 1.5), (-2.0, -1.0)):
                told = each.explain(
                    origin, direction, t_min=t_range[0], t_max=t_range[1], rule=rule
                )
                data = checked(told.to_dict())
                kinds |= {step.get("case", step["kind"]) for step in data["steps"]}
                hit = each.intersect(origin, direction, t_min=t_range[0], t_max=t_range[1])
                assert (data["hit"] is not None) == bool(hit.hit)
                assert str(told).splitlines()[-1]
    expected = {"clip", "leaf", "pop", "end", "near only", "far only", "both"}
    # None of the rays lies in a plane that is a median.
    assert kinds >= expected | (set() if rule == "median" else {"in plane"})


def test_counts_are_those_of_the_steps(scene: package.Scene, judged: Judged) -> None:
    for ray in judged.rays[:20]:
        told = scene.explain(ray[:3], ray[3:])
        leaves = [step for step in told.steps if step["kind"] == "leaf"]
        inner = [step for step in told.steps if step["kind"] == "inner"]
        assert told.counts["textbook"] == {
            "nodes": len(inner) + len(leaves),
            "leaves": len(leaves),
            "triangles": sum(len(leaf["tests"]) for leaf in leaves),
        }
        engine = told.to_dict()["engine"]["steps"]
        reached = [step for step in engine if step["kind"] == "leaf"]
        assert told.counts["engine"]["nodes"] == len(engine)
        assert told.counts["engine"]["triangles"] == sum(len(step["faces"]) for step in reached)


def test_verdicts_are_those_of_an_independent_judge(judged: Judged, scene: package.Scene) -> None:
    corners = judged.shape.corners()
    outside = 0
    for ray in judged.rays[:40]:
        origin, direction = ray[:3], ray[3:]
        for step in scene.explain(origin, direction).steps:
            met = {test["face"]: test for test in step.get("tests", []) if test["t"] is not None}
            if step.get("closest") is not None:
                closest = min(met.values(), key=lambda test: (test["t"], test["face"]))
                assert step["closest"] == {"face": closest["face"], "t": closest["t"]}
                found = {face: test["verdict"] for face, test in met.items()}
                assert found.pop(closest["face"]) == "hit"
                assert set(found.values()) <= {"farther"}
            for test in step.get("tests", []):
                a, b, c = corners[test["face"]]
                normal = np.cross(b - a, c - a)
                t = normal @ (a - origin) / (normal @ direction)
                point = origin + t * direction
                sides = [normal @ np.cross(q - p, point - p) for p, q in ((b, c), (c, a), (a, b))]
                is_met = min(sides) > 0
                # The sign of each edge: which way round it goes, seen from the origin.
                from_origin = [corner - origin for corner in (a, b, c)]
                ends_of = [(1, 2), (2, 0), (0, 1)]
                turns = [direction @ np.cross(from_origin[i], from_origin[j]) for i, j in ends_of]
                assert test["edge_signs"] == np.sign(turns).astype(int).tolist()
                assert is_met == (test["verdict"] != "outside"), test
                if is_met:
                    assert test["t"] == pytest.approx(t, rel=1e-9)
                    continue
                outside += 1
                # By how much: the line's distance from the edge, which is a segment.
                ends = {"b-c": (b, c), "c-a": (c, a), "a-b": (a, b)}[test["edge"]]
                along = np.linspace(0, 1, 20001)[:, None]
                points = ends[0] + along * (ends[1] - ends[0])
                away = np.cross(points - origin, direction) / np.linalg.norm(direction)
                nearest = np.linalg.norm(away, axis=1).min()
                assert test["by"] == pytest.approx(nearest, rel=1e-4)
    assert outside > 50


def test_a_leaf_has_one_hit_and_the_others_are_farther() -> None:
    soup = package.Scene(package.generate("soup", 10))
    steps = soup.explain([-0.2, 0.4, 0.8], [1, 0.1, -0.1]).steps
    verdicts = [{test["face"]: test["verdict"] for test in step.get("tests", [])} for step in steps]
    assert {4: "hit"} in verdicts
    assert {0: "hit", 4: "farther", 5: "outside", 8: "outside"} in verdicts


def test_a_pixel_is_the_one_that_render_draws(
    halfline: Halfline, judged: Judged, scene: package.Scene
) -> None:
    picture = scene.render(width=60, height=40, samples=1, shading="face", up="+Z")
    assert picture.face is not None
    drawn = set()
    for column, row in [(30, 20), (22, 13), (41, 30), (0, 0), (59, 39)]:
        options = ("--pixel", f"{column},{row}", "--resolution", "60,40", "--up", "+Z")
        hit = halfline.json("explain", judged.path, *options)["hit"]
        face = -1 if hit is None else hit["face"]
        assert face == picture.face[row, column]
        drawn.add(face)
    assert len(drawn) == 4


def test_the_page_has_the_axis_up_that_the_picture_has(
    halfline: Halfline, cube: Path, tmp_path: Path
) -> None:
    for up, axis in (("+Y", 1), ("-X", 0), ("+Z", 2)):
        halfline.ok("explain", cube, "--pixel=640,360", f"--up={up}", "-o", tmp_path / "up.html")
        page = (tmp_path / "up.html").read_text(encoding="utf-8")
        assert re.search(rf'"up":{axis}[,}}]', page)


def test_text_names_what_is_asked(halfline: Halfline, cube: Path) -> None:
    text = halfline.ok("explain", cube, "--ray=-1,2,0.3,1,0,0", "--rule", "middle")
    assert "cube.ply: the ray from -1, 2, 0.3 along 1, 0, 0" in text
    assert "plane y = 2: in plane" in text
    assert re.search(r"face +\d+  [0+-] [0+-] [0+-]  hit at t = 1\b", text)
    assert re.search(r"^textbook +\d+ +\d+ +\d+$", text, re.MULTILINE)
    assert "It hits face" in text.splitlines()[-1]
    assert max(map(len, text.splitlines())) <= 100

    text = halfline.ok("explain", cube, "--ray=-1,-0.25,1.5,1,0,0")
    assert "passes by the box" in text
    assert "It misses. The nearest miss: the ray passes face" in text
    assert "at a distance of 0.25" in text


def test_every_output_holds_the_whole_explanation(
    halfline: Halfline, cube: Path, tmp_path: Path
) -> None:
    asked = ("explain", cube, "--ray=-1,2,0.3,1,0,0")
    told = halfline.json(*asked)
    for name in ("walk.json", "walk.txt", "walk.html"):
        printed = halfline.ok(*asked, "-o", tmp_path / name)
        assert name in printed
        assert f"face {told['hit']['face']}" in printed
    assert json.loads((tmp_path / "walk.json").read_text(encoding="utf-8")) == told
    assert (tmp_path / "walk.txt").read_text(encoding="utf-8") == halfline.ok(*asked)
    page = (tmp_path / "walk.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    data = re.search(r'id="walk-data">(.*?)</script>', page, re.DOTALL)
    assert data is not None
    shown = json.loads(data[1])
    assert len(shown.pop("scenery")) == 192
    assert shown.pop("up") == 2
    assert shown == told
    assert halfline.ok(*asked, "-o", tmp_path / "quiet.html", "--quiet") == ""
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "quiet.html",
        "walk.html",
        "walk.json",
        "walk.txt",
    ]


def path_rectangles(path: str) -> list[tuple[float, float, float, float]]:
    """Left, top, right and bottom of the rectangles of an SVG path."""
    numbers = re.findall(r"M([\d.-]+) ([\d.-]+)H([\d.-]+)V([\d.-]+)H[\d.-]+z", path)
    rectangles = []
    for x, y, right, top in numbers:
        rectangles.append((float(x), float(top), float(right), float(y)))
    return rectangles


def test_a_plane_shows_the_cells_and_those_of_the_ray(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    printed = halfline.ok("explain", judged.path, "--plane", "xy", "--at", "0.1")
    path = tmp_path / "cells.svg"
    figures = halfline.json("explain", judged.path, "--plane", "xy", "--at", "0.1", "-o", path)
    assert path.read_text(encoding="utf-8") == printed
    assert figures["at"] == 0.1
    root = ElementTree.fromstring(printed)
    cells = [each for each in root.iter(f"{SVG}path") if each.get("class") == "cell"]
    depths = [int(each.get("data-depth", "")) for each in cells]
    assert depths == sorted(set(depths))
    assert depths[-1] == figures["deepest"]
    rectangles = [r for each in cells for r in path_rectangles(each.get("d", ""))]
    assert len(rectangles) == figures["cells"]
    low, high = judged.shape.vertices.min(axis=0), judged.shape.vertices.max(axis=0)
    size = (high - low)[:2] * 860 / (high - low)[:2].max()
    areas = [(right - left) * (bottom - top) for left, top, right, bottom in rectangles]
    # Written to a hundredth of a pixel.
    assert sum(areas) == pytest.approx(size[0] * size[1], rel=1e-3)

    # The ray lies in the plane, and its cells are some of the picture's.
    visited = [each for each in root.iter(f"{SVG}path") if each.get("class") == "visited"]
    assert 2 <= len(visited) < len(rectangles)
    for each in visited:
        assert path_rectangles(each.get("d", ""))[0] in rectangles
    mesh = next(each for each in root.iter(f"{SVG}path") if each.get("class") == "mesh")
    assert mesh.get("d", "").count("M") == figures["segments"] > 50


def test_a_plane_shows_the_leaves_that_a_ray_within_it_visits(
    halfline: Halfline, judged: Judged
) -> None:
    for ray in ("--ray=-3,0.2,0.1,1,0.05,0", "--ray=0.3,-3,0.1,0.02,1,0"):
        asked = ("explain", judged.path, ray)
        steps = halfline.json(*asked)["steps"]
        leaves = [step["cell"] for step in steps if step["kind"] == "leaf"]
        root = ElementTree.fromstring(halfline.ok(*asked, "--plane=xy", "--at=0.1"))
        paths = root.iter(f"{SVG}path")
        visited = [
            int(each.get("data-cell", "")) for each in paths if each.get("class") == "visited"
        ]
        assert sorted(visited) == sorted(leaves)


def test_a_plane_goes_through_the_hit_of_the_ray(
    halfline: Halfline, cube: Path, tmp_path: Path
) -> None:
    asked = ("explain", cube, "--ray=1.3,2.6,-1,0,0,1")
    assert halfline.json(*asked)["hit"]["point"] == [1.3, 2.6, 0.0]
    for plane, place in (("xy", 0.0), ("xz", 2.6), ("yz", 1.3)):
        path = tmp_path / f"{plane}.svg"
        assert halfline.json(*asked, "--plane", plane, "-o", path)["at"] == place
        ElementTree.parse(path)


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        ([], "--ray"),
        (["--ray=1,2,3"], "expected OX,OY,OZ,DX,DY,DZ"),
        (["--ray=0,0,0,0,0,0"], "its direction is zero"),
        (["--ray=0,0,nan,0,0,1"], "not finite"),
        (["--ray=0,0,0,0,0,1,2,1"], "its range from 2 to 1 is empty"),
        (["--ray=0,0,0,0,0,1", "--pixel=1,1"], "cannot be used with"),
        (["--pixel=1"], "expected COLUMN,ROW"),
        (["--pixel=-1,2"], "expected COLUMN,ROW"),
        (["--ray=0,0,0,0,0,1", "--rule=best"], "possible values"),
        (["--ray=0,0,0,0,0,1", "-o", "walk.png"], ".html"),
        (["--ray=0,0,0,0,0,1", "-o", "walk.svg"], "--plane"),
        (["--ray=0,0,0,0,0,1", "--at=1"], "--plane"),
        (["--plane=ab"], "possible values"),
        (["--plane=xy", "-o", "cells.html"], ".svg"),
        (["--plane=xy", "--json"], "--output"),
        (["--point=1,2"], "expected X,Y,Z"),
        (["--point=1,2,nan"], "expected X,Y,Z"),
        (["--point=1,2,3", "--ray=0,0,0,0,0,1"], "cannot be used with"),
        (["--point=1,2,3", "--pixel=1,1"], "cannot be used with"),
        (["--point=1,2,3", "--plane=xy"], "cannot be used with"),
        (["--point=1,2,3", "--rule=middle"], "cannot be used with"),
        (["--point=1,2,3", "-o", "walk.html"], "must end in .json or .txt"),
        (["--point=1,2,3", "-o", "walk.svg"], "--plane"),
    ],
)
def test_wrong_arguments_are_refused(
    halfline: Halfline, cube: Path, arguments: list[str], hint: str
) -> None:
    assert hint in halfline.fails(2, "explain", cube, *arguments)


def test_what_cannot_be_done_is_said_in_one_line(
    halfline: Halfline, cube: Path, tmp_path: Path
) -> None:
    ray = "--ray=0,0,-1,0,0,1"
    line = halfline.complains("explain", cube, "--pixel=1280,7")
    assert "1280,7 is outside of the picture of 1280 x 720 pixels" in line
    line = halfline.complains("explain", cube, "--plane=xy", "--at=9")
    assert "9 is outside of the mesh: z is from 0 to 4" in line
    assert "nowhere.ply" in halfline.complains("explain", tmp_path / "nowhere.ply", ray)
    broken = tmp_path / "broken.ply"
    broken.write_bytes(cube.read_bytes()[:-7])
    assert "broken.ply" in halfline.complains("explain", broken, ray)
    line = halfline.complains("explain", cube, ray, "-o", tmp_path / "no" / "walk.html")
    assert str(tmp_path / "no") in line
    # The mesh itself is never written over.
    named_html = tmp_path / "mesh.html"
    named_html.write_bytes(cube.read_bytes())
    assert "mesh.html" in halfline.fails(2, "explain", named_html, ray, "-o", named_html)
    assert named_html.read_bytes() == cube.read_bytes()


def test_a_tree_file_is_explained_as_its_mesh(
    halfline: Halfline, cube: Path, tmp_path: Path
) -> None:
    tree = tmp_path / "cube.hlt"
    halfline.ok("build", cube, "-o", tree)
    told, other = (halfline.json("explain", each, "--ray=1,1,-1,0,0,1") for each in (cube, tree))
    assert other.pop("mesh")["name"] == "cube.hlt"
    assert told.pop("mesh")["name"] == "cube.ply"
    assert told == other


POINT_SCHEMA = {"$ref": "#/$defs/point_explanation", "$defs": SCHEMA["$defs"]}


def about_point(halfline: Halfline, mesh: Path, point: Floats) -> dict[str, Any]:
    """What is told about a point, which the documented schema describes."""
    told = halfline.json("explain", mesh, f"--point={ray_text(point)}")
    jsonschema.Draft202012Validator(POINT_SCHEMA).validate(told)
    return told


def test_a_point_is_explained_as_query_finds_it(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    points = judged.rays[:12, :3].copy()
    points[6:] *= 0.3
    np.save(tmp_path / "points.npy", points)
    arguments: list[str | Path] = [judged.path, tmp_path / "points.npy", "--nearest", "--signed"]
    halfline.ok("query", *arguments, "-o", tmp_path / "near.npz")
    with np.load(tmp_path / "near.npz") as arrays:
        near = dict(arrays)
    assert 0 < (near["signed_distance"] < 0).sum() < len(points)
    for i, point in enumerate(points):
        told = about_point(halfline, judged.path, point)
        assert told["point"] == point.tolist()
        assert told["signed_distance"] == near["signed_distance"][i]
        assert told["closest"] == {
            "distance": near["distance"][i],
            "point": near["point"][i].tolist(),
            "face": near["face"][i],
            "uv": near["uv"][i].tolist(),
            "feature": near["feature"][i],
        }
        winding = told["winding"]
        assert winding["number"] == near["winding_number"][i]
        assert winding["boundary_edges"] == 0
        assert sum(crossing["sign"] for crossing in winding["crossings"]) == winding["number"]


def test_crossings_of_a_point_are_hits_of_its_ray(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    told = about_point(halfline, judged.path, judged.rays[0, :3] * 0.3)
    ray = np.array([told["point"] + told["winding"]["direction"]])
    hits = halfline.query(judged.path, ray, tmp_path, "--all")
    assert sorted(c["face"] for c in told["winding"]["crossings"]) == sorted(hits["face"].tolist())


def test_the_walk_to_what_is_nearest_opens_boxes_as_near(
    halfline: Halfline, judged: Judged
) -> None:
    point = judged.rays[3, :3]
    told = about_point(halfline, judged.path, point)
    steps = told["engine"]["steps"]
    counts = told["counts"]["engine"]
    leaves = [step for step in steps if step["kind"] == "leaf"]
    assert (counts["nodes"], counts["leaves"]) == (len(steps), len(leaves))
    assert counts["triangles"] == sum(len(leaf["faces"]) for leaf in leaves)
    assert counts["triangles"] < told["counts"]["brute_force"]["triangles"] / 4
    for step in steps:
        low, high = np.array(step["bounds"])
        gap = np.linalg.norm(np.maximum(0, np.maximum(low - point, point - high)))
        assert step["distance"] == pytest.approx(gap)
        if step["limit"] is not None:
            assert step["distance"] <= step["limit"] * (1 + 1e-5) + 1e-6
    limits = [np.inf if step["limit"] is None else step["limit"] for step in steps]
    assert limits[0] == np.inf
    assert limits == sorted(limits, reverse=True)
    assert any(told["closest"]["face"] in leaf["faces"] for leaf in leaves)


def test_faces_that_tie_are_told(halfline: Halfline, cube: Path) -> None:
    """Above a corner of the grid on the cube, the faces around it are equally near."""
    told = about_point(halfline, cube, np.array([2.0, 2.0, 5.0]))
    distances = [near["distance"] for near in told["nearest"]]
    assert distances == sorted(distances)
    ties = [near["face"] for near in told["nearest"] if near["distance"] == 1]
    assert ties == sorted(ties)
    assert len(ties) >= 4
    assert told["closest"] == told["nearest"][0]
    assert told["closest"]["feature"] == "vertex"
    text = halfline.ok("explain", cube, "--point=2,2,5")
    for word in (
        "It is outside, 1 from the surface",
        "which has the lower index",
        "depth 0",
        "engine",
    ):
        assert word in text, word
    on_it = about_point(halfline, cube, np.array([2.5, 2.25, 4.0]))
    assert on_it["is_on_surface"]
    assert on_it["signed_distance"] == 0
    assert "It lies on the surface" in halfline.ok("explain", cube, "--point=2.5,2.25,4")


def test_an_open_surface_has_a_share_of_its_boundary(halfline: Halfline, tmp_path: Path) -> None:
    whole = bumpy_sphere()
    path = write_ply(tmp_path / "open.ply", Shape(whole.vertices, whole.faces[:-1]))
    told = about_point(halfline, path, np.array([0.1, 0.2, 0.3]))
    winding = told["winding"]
    assert winding["boundary_edges"] == 3
    signs = sum(crossing["sign"] for crossing in winding["crossings"])
    assert winding["number"] == pytest.approx(signs + winding["boundary"], abs=1e-15)
    assert 0.9 < winding["number"] < 1
    assert told["is_inside"]
    assert 0 < winding["boundary_error"] <= 1e-9
    text = halfline.ok("explain", path, "--point=0.1,0.2,0.3")
    assert "edges of the boundary" in text


def test_every_form_tells_of_the_point(halfline: Halfline, cube: Path, tmp_path: Path) -> None:
    for name in ("point.json", "point.txt"):
        halfline.ok("explain", cube, "--point=1,1,1", "-o", tmp_path / name)
    told = json.loads((tmp_path / "point.json").read_text(encoding="utf-8"))
    assert told == about_point(halfline, cube, np.array([1.0, 1.0, 1.0]))
    text = (tmp_path / "point.txt").read_text(encoding="utf-8")
    assert text == halfline.ok("explain", cube, "--point=1,1,1")
    empty = tmp_path / "empty.obj"
    empty.write_text("# nothing\n", encoding="utf-8")
    assert about_point(halfline, empty, np.zeros(3))["closest"] is None
    assert "Nothing is near it" in halfline.ok("explain", empty, "--point=0,0,0")


def test_an_explanation_in_python(scene: package.Scene, tmp_path: Path) -> None:
    hit = scene.explain([0, 0, 3], np.array([0, 0.01, -1], dtype=np.float32))
    found = scene.intersect([0, 0, 3], np.array([0, 0.01, -1], dtype=np.float32))
    assert hit.hit is not None
    assert (hit.hit["t"], hit.hit["face"]) == (float(found.t), int(found.face))
    assert hit.nearest_miss is None
    assert repr(hit).startswith(f"<halfline.Explanation: face {hit.hit['face']} at t = ")
    assert str(hit).startswith("bumpy.hlt: the ray from 0, 0, 3")
    miss = scene.explain([0, 0, 3], [0, 0, 1])
    assert miss.hit is None
    assert miss.nearest_miss is not None
    assert repr(miss) == "<halfline.Explanation: a miss, after 0 cells and 0 triangles>"

    for name, content in (("a.html", hit.to_html()), ("a.txt", str(hit))):
        hit.save(tmp_path / name)
        assert (tmp_path / name).read_text(encoding="utf-8") == content
    hit.save(str(tmp_path / "a.json"))
    assert json.loads((tmp_path / "a.json").read_text(encoding="utf-8")) == hit.to_dict()
    frame = hit._repr_html_()
    assert frame.startswith("<iframe srcdoc=")
    assert frame.count("<") == 2


def test_python_refuses_what_is_no_ray(scene: package.Scene, tmp_path: Path) -> None:
    one = [0.0, 0, 1]
    with pytest.raises(ValueError, match=r"expected one ray, found rays of shape \(1,\)"):
        scene.explain([one], one)
    with pytest.raises(ValueError, match=r"expected one ray, found rays of shape \(2,\)"):
        scene.explain(one, one, t_max=np.array([1.0, 2.0]))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="its direction is zero"):
        scene.explain(one, [0, 0, 0])
    with pytest.raises(ValueError, match='"best" is none of middle, median, sah'):
        scene.explain(one, one, rule="best")
    with pytest.raises(ValueError, match=r"a name that ends in one of \.html, \.json, \.txt"):
        scene.explain(one, one).save(tmp_path / "walk.png")
    with pytest.raises(FileNotFoundError):
        scene.explain(one, one).save(tmp_path / "no" / "walk.html")
    with pytest.raises(TypeError, match=r"comes from Scene\.explain"):
        package.Explanation()


def test_the_sphere_is_explained_by_name() -> None:
    shape: Shape = bumpy_sphere()
    told = package.Scene(shape.vertices, shape.faces).explain([0, 0, 3], [0, 0, -1])
    assert told.to_dict()["mesh"] == {
        "name": "mesh",
        "triangles": len(shape.faces),
        "bounds": [shape.vertices.min(axis=0).tolist(), shape.vertices.max(axis=0).tolist()],
    }
