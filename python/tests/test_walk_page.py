"""The page of a walk, in a real browser: it steps, and shows what the explanation says."""

from __future__ import annotations

import copy
import io
import json
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from children import PATIENCE_SECONDS, wait_until
from conftest import ROOT, Halfline
from meshes import Floats, Shape, bumpy_sphere, gridded_cube
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright
from walk_pages import WalkPage, explain

Json = dict[str, Any]
Open = Callable[..., "Shown"]


def soup() -> Shape:
    """Large triangles at random, one that holds a piece of the x axis, and one without area."""
    random = np.random.default_rng(5)
    centers = random.uniform(-2.0, 2.0, size=(40, 1, 3))
    corners = centers + random.uniform(-2.0, 2.0, size=(40, 3, 3))
    odd = [[[0.0, 0, 0], [1, 1, 0], [2, -1, 0]], [[0, 0, 0], [1, 1, 1], [2, 2, 2]]]
    return loose([*corners.tolist(), *odd])


def fan() -> Shape:
    """Triangles that share a corner, and so a leaf."""
    ends = np.random.default_rng(0).normal(size=(300, 2, 3))
    return loose(np.concatenate([np.zeros((300, 1, 3)), ends], axis=1).tolist())


def loose(corners: list[Any]) -> Shape:
    """Triangles with corners of their own."""
    vertices = np.array(corners, dtype=float).reshape(-1, 3)
    return Shape(vertices, np.arange(len(vertices)).reshape(-1, 3))


FLAT = loose([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
POINT = loose([[[1.0, 1, 1]] * 3])
# For each walk a mesh, a ray and options of the command.
WALKS: dict[str, tuple[Callable[[], Shape], str, list[str]]] = {
    # Near only, far only and both; several leaves, a hit, and cells that are dropped.
    "hitting": (bumpy_sphere, "-2,-0.9,0.4,1,0.5,-0.25", ["--rule", "middle"]),
    "hitting, sah": (bumpy_sphere, "-2,-0.9,0.4,1,0.5,-0.25", ["--rule", "sah"]),
    # Within planes and beside them, on either side.
    "along a plane": (lambda: gridded_cube(8), "-3,4,4.5,1,0,0", ["--rule", "middle"]),
    "missing": (bumpy_sphere, "-2,-1,-0.9,1,0.05,0.03", []),
    "passing by": (bumpy_sphere, "-2,1.4,0.4,1,0.05,0", []),
    "every verdict": (soup, "-5,0,0,1,0,0,4,6.2", []),
    "many triangles": (fan, "-3,0.01,0.02,1,0,0", []),
    "afar": (bumpy_sphere, "-2e6,-0.9,0.4,1,0,0", ["--rule", "middle"]),
    # It would cross planes of y where t is beyond all doubles.
    "nearly parallel": (bumpy_sphere, "-2,0.1,0.2,1,1e-320,0", ["--rule", "middle"]),
    "no triangle": (lambda: loose([]), "0,0,0,1,0,0", []),
    "flat, from above": (lambda: FLAT, "0.2,0.2,1000,0,0,-1", []),
    "flat, within": (lambda: FLAT, "-1,0.2,0,1,0,0", []),
    "flat, beside": (lambda: FLAT, "5,5,5,1,0,0", []),
    "a point": (lambda: POINT, "1,1,0,0,0,1", []),
    "from a point": (lambda: POINT, "1,1,1,0,0,1", []),
}


class Walks:
    """The command's pages of walks, each made once."""

    def __init__(self, halfline: Halfline, folder: Path) -> None:
        self.halfline = halfline
        self.folder = folder
        self.pages: dict[str, WalkPage] = {}

    def __getitem__(self, name: str) -> WalkPage:
        if name not in self.pages:
            shape, ray, options = WALKS[name]
            self.pages[name] = explain(self.halfline, self.folder, shape(), ray, *options)
        return self.pages[name]


@pytest.fixture(scope="module")
def walks(halfline: Halfline, tmp_path_factory: pytest.TempPathFactory) -> Walks:
    return Walks(halfline, tmp_path_factory.mktemp("walks"))


def moved(page: WalkPage, factor: float, offset: float) -> WalkPage:
    """The same walk with its mesh elsewhere, in other units."""
    places = {"origin", "bounds", "point", "point_on_ray", "point_on_face", "triangles", "scenery"}
    lengths = {"direction", "by", "distance"}

    def move(value: Any, shift: float) -> Any:
        if isinstance(value, dict):
            return {key: move(part, shift) for key, part in value.items()}
        if isinstance(value, list):
            return [move(part, shift) for part in value]
        return None if value is None else value * factor + shift

    def visit(value: Any) -> Any:
        if isinstance(value, list):
            return [visit(part) for part in value]
        if not isinstance(value, dict):
            return value
        return {
            key: move(part, offset)
            if (key in places and not isinstance(part, int)) or key == "plane"
            else move(part, 0.0)
            if key in lengths
            else visit(part)
            for key, part in value.items()
        }

    return page.showing(visit(page.explanation))


def long(page: WalkPage, count: int) -> WalkPage:
    """A walk of many steps, from a push, a leaf and a pop over and over."""
    explanation = copy.deepcopy(page.explanation)
    first, *steps, last = explanation["steps"]
    inner = next(step for step in steps if step["kind"] == "inner" and step["push"] is not None)
    leaf = next(step for step in steps if step["kind"] == "leaf")
    pop = {
        "kind": "pop",
        "cell": inner["push"],
        "t_near": inner["push_interval"][0],
        "t_far": inner["push_interval"][1],
        "is_entered": True,
        "why": "the next cell along the half-line",
    }
    explanation["steps"] = [first, *[inner, leaf, pop] * ((count - 2) // 3), last]
    return page.showing(explanation)


@dataclass
class Shown:
    """A page in the browser, and all that it complained of or asked for."""

    page: Page
    explanation: Json
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def state(self, name: str) -> str:
        """What the page says of itself."""
        value: str = self.page.evaluate("name => document.body.dataset[name]", name)
        return value

    def step(self) -> int:
        """The step that is shown; the first is 0."""
        return int(self.state("step"))

    def go(self, step: int) -> Json:
        """Shows a step by a click in the list, and returns what the explanation says of it."""
        self.page.locator("#list button").nth(step).click()
        self.settle()
        assert self.step() == step
        found: Json = self.explanation["steps"][step]
        return found

    def first(self, **wanted: Any) -> int:
        """The first step of which this is so."""
        steps = self.explanation["steps"]
        return next(
            index
            for index, step in enumerate(steps)
            if all(step.get(key) == value for key, value in wanted.items())
        )

    def settle(self) -> None:
        """Waits until the drawing is at rest."""
        self.until("document.body.dataset.drawn === document.body.dataset.step")

    def until(self, condition: str) -> None:
        """Waits until this is so. The page's policy forbids Playwright's own way, by `eval`."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not self.page.evaluate(condition):
            assert time.monotonic() < deadline, condition
            time.sleep(0.01)

    def changed(self, *pictures: bytes) -> bytes:
        """Waits until the drawing is none of these, and returns it."""
        wait_until(lambda: self.picture() not in pictures)
        return self.picture()

    def text(self, selector: str) -> str:
        """The text of an element as it is seen, with plain minus signs."""
        return self.page.locator(selector).inner_text().replace("\N{MINUS SIGN}", "-")

    def picture_text(self) -> str:
        """All words of the lecture's picture."""
        return " | ".join(self.page.locator("#picture text").all_text_contents())

    def numbers(self) -> dict[str, str]:
        """The table of a step's numbers, each with all its digits where it has them."""
        rows: list[list[str]] = self.page.evaluate(
            """() => [...document.querySelectorAll("#numbers tr")].map((row) => [
              row.cells[0].textContent,
              row.querySelector("data")?.value ?? row.cells[1].textContent])"""
        )
        return dict(rows)

    def color(self, name: str) -> tuple[int, ...]:
        """A colour of the style sheet."""
        value: str = self.page.evaluate(
            "name => getComputedStyle(document.documentElement).getPropertyValue(name).trim()",
            f"--{name}",
        )
        return tuple(int(value[start : start + 2], 16) for start in (1, 3, 5))

    def pixels(self, positions: list[list[float]], reach: int = 1) -> list[Any]:
        """The drawing's colours around positions of the mesh; empty where they are not seen."""
        image = np.asarray(Image.open(io.BytesIO(self.picture())).convert("RGB"), dtype=float)
        height, width, _ = image.shape
        found = []
        for x, y in self.where(positions).astype(int):
            is_seen = reach < x < width - reach and reach < y < height - reach
            rows, columns = slice(y - reach, y + reach + 1), slice(x - reach, x + reach + 1)
            found.append(image[rows, columns].reshape(-1, 3) if is_seen else np.empty((0, 3)))
        return found

    def where(self, positions: list[list[float]]) -> Floats:
        """Where positions of the mesh are in the drawing."""
        return np.array(self.page.evaluate("positions => positions.map(whereIs)", positions))

    def along_the_ray(self, start: float, end: float) -> list[list[float]]:
        """Positions on the ray between two t."""
        ray = self.explanation["ray"]
        # In quarters, for huge meshes.
        origin, direction = np.array(ray["origin"]) / 4, np.array(ray["direction"]) / 4
        shares = np.linspace(0.1, 0.9, 17)
        along = [origin + (start + share * (end - start)) * direction for share in shares]
        return [(4 * position).tolist() for position in along]

    def is_mostly(self, name: str, positions: list[list[float]]) -> bool:
        """True if most of the positions that can be seen have this colour."""
        wanted = self.color(name)
        seen = [colors for colors in self.pixels(positions) if len(colors)]
        assert seen
        near = [np.abs(colors - wanted).max(axis=1).min() < 40 for colors in seen]
        return bool(np.mean(near) > 0.5)

    def picture(self) -> bytes:
        """The drawing in space, as it is on the screen."""
        return self.page.locator("#drawing").screenshot()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """A Chromium without a window."""
    found = subprocess.run(
        [ROOT / "tools" / "find_browser.sh"], capture_output=True, text=True, check=False
    )
    if found.returncode != 0:
        pytest.fail(found.stderr.strip(), pytrace=False)
    with sync_playwright() as playwright:
        # As root Chromium starts only without its sandbox.
        browser = playwright.chromium.launch(
            executable_path=found.stdout.strip(),
            args=["--no-sandbox"],
            timeout=1000 * PATIENCE_SECONDS,
        )
        yield browser
        browser.close()


@pytest.fixture
def show(browser: Browser, tmp_path: Path) -> Iterator[Open]:
    """Opens pages without a network; complaints and requests fail the test that made them."""
    opened: list[Shown] = []

    def show(walk: WalkPage, fragment: str = "", **options: Any) -> Shown:
        path = tmp_path / f"walk-{len(opened)}.html"
        path.write_text(walk.text, encoding="utf-8")
        context = browser.new_context(
            offline=True,
            **{"viewport": {"width": 1280, "height": 800}, "reduced_motion": "reduce", **options},
        )
        context.set_default_timeout(1000 * PATIENCE_SECONDS)
        shown = Shown(context.new_page(), walk.explanation)
        shown.page.on("console", lambda said: shown.complaints.append(said.text))
        shown.page.on("pageerror", lambda error: shown.complaints.append(str(error)))
        shown.page.on("request", lambda request: shown.requests.append(request.url))
        shown.page.goto(path.as_uri() + fragment)
        opened.append(shown)
        shown.settle()
        return shown

    yield show
    for shown in opened:
        address = shown.page.url
        shown.page.context.close()
        assert shown.complaints == []
        asked = [url for url in shown.requests if not url.startswith("data:")]
        assert [url.partition("#")[0] for url in asked] == [address.partition("#")[0]]


@pytest.mark.parametrize("name", WALKS)
def test_what_the_command_tells_follows_the_schema(walks: Walks, name: str) -> None:
    schema = json.loads((ROOT / "docs" / "explain.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    judge = jsonschema.Draft202012Validator(schema)
    told = dict(walks[name].explanation)
    # The scenery is for the page alone.
    assert not judge.is_valid(told)
    del told["scenery"], told["up"]
    judge.validate(told)


def test_the_walks_are_of_many_kinds(walks: Walks) -> None:
    def of(name: str, key: str) -> set[Any]:
        return {step[key] for step in walks[name].explanation["steps"] if key in step}

    assert {"near only", "far only", "both"} <= of("hitting", "case") & of("hitting, sah", "case")
    assert of("hitting", "is_entered") == {True, False}
    assert {"in plane", "parallel, below", "parallel, above"} <= of("along a plane", "case")
    assert of("missing", "case")
    assert walks["missing"].explanation["nearest_miss"]
    assert of("passing by", "is_met") == {False}


def test_keys_step_forward_and_back(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    last = len(shown.explanation["steps"]) - 1
    keys = shown.page.keyboard
    seen = [shown.step()]
    for key in ["ArrowRight", "ArrowRight", "ArrowLeft", "End", "ArrowRight", "Home", "ArrowLeft"]:
        keys.press(key)
        seen.append(shown.step())
    assert seen == [0, 1, 2, 1, last, last, 0, 0]


def test_buttons_step(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    last = len(shown.explanation["steps"]) - 1
    seen = []
    for name in ["forward", "forward", "back", "last", "first"]:
        shown.page.click(f"#{name}")
        seen.append(shown.step())
    assert seen == [1, 2, 1, last, 0]


def test_the_slider_steps(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    slider = shown.page.locator("#slider")
    assert slider.get_attribute("max") == str(len(shown.explanation["steps"]) - 1)
    slider.fill("7")
    assert shown.step() == 7
    slider.press("ArrowRight")
    assert shown.step() == 8
    shown.page.keyboard.press("Home")
    assert shown.step() == 0
    assert slider.input_value() == "0"


def test_the_space_bar_plays_and_pauses(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    shown.page.keyboard.press(" ")
    assert shown.state("playing") == "true"
    shown.until("Number(document.body.dataset.step) >= 1")
    shown.page.keyboard.press(" ")
    assert shown.state("playing") == "false"
    # On a button, the space bar presses the button.
    shown.page.locator("#forward").press(" ")
    assert shown.state("playing") == "false"


def test_the_address_names_the_step(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"], fragment="#step=6")
    assert shown.step() == 6
    shown.page.keyboard.press("ArrowRight")
    shown.until("location.hash === '#step=7'")
    shown.page.evaluate("location.hash = '#step=3'")
    shown.until("document.body.dataset.step === '3'")


@pytest.mark.parametrize(("fragment", "step"), [("#step=99999", -1), ("#step=x", 0), ("#", 0)])
def test_an_address_with_no_such_step_shows_one_that_there_is(
    show: Open, walks: Walks, fragment: str, step: int
) -> None:
    shown = show(walks["hitting"], fragment=fragment)
    assert shown.step() == step % len(shown.explanation["steps"])


@pytest.mark.parametrize("name", ["hitting, sah", "along a plane", "missing"])
def test_every_step_shows_its_cell_and_case(show: Open, walks: Walks, name: str) -> None:
    shown = show(walks[name])
    cells = shown.explanation["cells"]
    stack: list[int] = []
    for number, step in enumerate(shown.explanation["steps"]):
        assert shown.step() == number
        cell = step.get("cell", 0)
        assert shown.state("kind") == step["kind"]
        assert shown.state("cell") == str(cell)
        assert shown.state("case") == step.get("case", "")
        assert shown.text("#why") == step["why"].replace("\N{MINUS SIGN}", "-")
        assert shown.text("#heading").startswith(f"Step {number}: ")
        assert shown.text("#list [aria-current=step] .count") == str(number)
        if step["kind"] == "inner":
            assert f"cell {cell}, depth {cells[cell]['depth']}" in shown.text("#heading")
            assert shown.text("#case strong").startswith(step["case"])
            assert ("plane touched" in shown.text("#case")) == step["plane_touched"]
            numbers = shown.numbers()
            assert numbers["axis"] == step["axis"]
            for name, key in [("plane", "plane"), ("t_near", "t_near"), ("t_far", "t_far")]:
                assert float(numbers[name]) == step[key]
            if step["t_split"] is None:
                assert numbers["t_split"].startswith("none")
            else:
                assert float(numbers["t_split"]) == step["t_split"]
            assert f"cell {step['enter']} " in numbers["enter"]
            role = "near" if step["enter"] == step["near"] else "far"
            assert numbers["enter"].startswith(role)
            if step["push"] is None:
                assert numbers["push"] == "nothing"
            else:
                assert f"cell {step['push']} " in numbers["push"]
                stack.append(step["push"])
        elif step["kind"] == "pop":
            assert stack.pop() == cell
            verdict = "entered" if step["is_entered"] else "dropped"
            assert verdict in shown.text("#case")
            assert f"cell {cell}" in shown.text("#stack li.popped")
        boxes = shown.page.locator("#stack li[data-cell]:not(.popped)")
        listed = boxes.evaluate_all("boxes => boxes.map((box) => Number(box.dataset.cell))")
        assert listed == stack[::-1]
        shown.page.keyboard.press("ArrowRight")


def test_the_lecture_picture_has_the_plane_on_its_side_of_the_interval(
    show: Open, walks: Walks
) -> None:
    shown = show(walks["hitting"])
    for case in ["near only", "far only", "both"]:
        shown.go(shown.first(case=case, plane_touched=False))
        plane = shown.page.locator("#picture line.plane").bounding_box()
        bars = shown.page.locator("#picture .bar").evaluate_all(
            "bars => bars.map((bar) => [bar.getBoundingClientRect().left, "
            "bar.getBoundingClientRect().right, bar.getAttribute('class')])"
        )
        assert plane
        x = plane["x"] + plane["width"] / 2
        left, right = min(bar[0] for bar in bars), max(bar[1] for bar in bars)
        assert (x > right) == (case == "near only")
        assert (x < left) == (case == "far only")
        # What lies before the plane is near, what lies behind it is far; what is pushed is hatched.
        for start, end, style in bars:
            assert ("near" in style) == ((start + end) / 2 < x)
        styles = [style.split()[1] for _, _, style in bars]
        assert (
            styles
            == {
                "near only": ["fill-near"],
                "far only": ["fill-far"],
                "both": ["fill-near", "hatched-far"],
            }[case]
        )


def test_parallel_rays_have_pictures_of_their_own(show: Open, walks: Walks) -> None:
    shown = show(walks["along a plane"])
    shown.go(shown.first(case="in plane"))
    picture = shown.picture_text()
    assert "above: push" in picture
    assert "below: enter" in picture
    assert "lies on the plane" in shown.text("#case")
    plane = shown.page.locator("#picture line.plane").bounding_box()
    bars = shown.page.locator("#picture .bar")
    assert plane
    # The ray runs on the plane, half on either side.
    middles = [bars.nth(k).bounding_box() for k in range(2)]
    assert middles[0]
    assert middles[1]
    assert middles[0]["y"] < plane["y"] + plane["height"] / 2 < middles[1]["y"] + 2

    step = shown.go(shown.first(case="parallel, above"))
    assert step["t_split"] is None
    assert "above: enter" in shown.picture_text()
    assert "below: not met" in shown.picture_text()
    bar, plane = bars.nth(0).bounding_box(), shown.page.locator("line.plane").bounding_box()
    assert bar
    assert plane
    assert bar["y"] + bar["height"] < plane["y"] + plane["height"] / 2


def test_a_leaf_lists_its_triangles_as_they_were_tested(show: Open, walks: Walks) -> None:
    shown = show(walks["every verdict"])
    verdicts = set()
    for number, step in enumerate(shown.explanation["steps"]):
        if step["kind"] != "leaf":
            continue
        shown.go(number)
        rows = shown.page.evaluate(
            """() => [...document.querySelectorAll("#tests tbody tr")].map((row) =>
              [...row.cells].map((cell) => cell.textContent.trim()).concat(
                [...row.querySelectorAll("data")].map((data) => Number(data.value))))"""
        )
        assert len(rows) == len(step["tests"])
        for row, test in zip(rows, step["tests"], strict=True):
            verdicts.add(test["verdict"])
            assert row[0] == str(test["face"])
            assert row[1:4] == ["\N{MINUS SIGN}0+"[sign + 1] for sign in test["edge_signs"]]
            assert row[4].endswith(" " + test["verdict"])
            assert row[7:] == [value for value in (test["t"], test["by"]) if value is not None]
            assert row[6].endswith(f"outside {test['edge']}" if test["edge"] else "")
    assert verdicts == {"hit", "farther", "beyond", "behind", "outside", "edge-on", "no area"}


def test_another_triangle_can_be_looked_at(show: Open, walks: Walks) -> None:
    shown = show(walks["every verdict"])
    step = shown.go(shown.first(kind="leaf"))
    outside = next(test for test in step["tests"] if test["verdict"] == "outside")
    before = shown.picture()
    shown.page.click(f"#tests tr[data-face='{outside['face']}']")
    assert outside["why"] in shown.text("#test-why")
    shown.changed(before)
    assert shown.page.locator("#picture line.crossed-edge").count() == 1


def test_the_interval_is_drawn_in_the_colours_of_near_and_far(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    for case in ["near only", "far only", "both"]:
        step = shown.go(shown.first(case=case))
        split = min(max(step["t_split"], step["t_near"]), step["t_far"])
        if case != "far only":
            assert shown.is_mostly("near", shown.along_the_ray(step["t_near"], split))
        if case != "near only":
            assert shown.is_mostly("far", shown.along_the_ray(split, step["t_far"]))


def test_the_children_are_tinted_blue_and_orange(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    step = shown.go(shown.first(case="both"))
    near, far = (
        np.array(shown.explanation["cells"][step[role]]["bounds"]) for role in ("near", "far")
    )
    for box, other, sign in [(near, far, 1), (far, near, -1)]:
        shares = np.stack(np.meshgrid(*[np.linspace(0.05, 0.95, 9)] * 3), axis=-1).reshape(-1, 3)
        inside = box[0] + shares * (box[1] - box[0])
        # Of the box's picture, what the other box does not cover.
        corners = np.array(
            [[other[k, axis] for axis, k in enumerate(c)] for c in np.ndindex(2, 2, 2)]
        )
        angles = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
        ways = np.stack([np.cos(angles), np.sin(angles)])
        reach = (shown.where(corners.tolist()) @ ways).max(axis=0)
        is_alone = (shown.where(inside.tolist()) @ ways > reach).any(axis=1)
        assert is_alone.sum() > 50
        found = np.concatenate(shown.pixels(inside[is_alone].tolist()))
        red, _, blue = found.mean(axis=0)
        assert sign * (blue - red) > 15


@pytest.mark.parametrize("kind", ["clip", "inner", "leaf", "pop"])
def test_the_drawing_has_the_cell_of_the_step(show: Open, walks: Walks, kind: str) -> None:
    shown = show(walks["hitting"])
    # Not the root, where there is a choice: its edges are drawn at every step.
    deep: Json = {"inner": {"case": "far only"}, "pop": {"is_entered": False}}
    step = shown.go(shown.first(kind=kind, **deep.get(kind, {})))

    def edges_in_bold(cell: int) -> int:
        bounds = np.array(shown.explanation["cells"][cell]["bounds"])
        lines = []
        for axis in range(3):
            for one, other in np.ndindex(2, 2):
                ends = bounds.copy()
                ends[:, (axis + 1) % 3] = bounds[one, (axis + 1) % 3]
                ends[:, (axis + 2) % 3] = bounds[other, (axis + 2) % 3]
                lines += [ends[0] + share * (ends[1] - ends[0]) for share in (0.3, 0.5, 0.7)]
        current = shown.color("current")
        is_bold = [
            bool((np.abs(colors - current).max(axis=1) < 40).sum() >= 6)
            for colors in shown.pixels([line.tolist() for line in lines])
        ]
        return int(np.reshape(is_bold, (12, 3)).any(axis=1).sum())

    # Nine edges are seen; the other three are dotted.
    assert edges_in_bold(step["cell"]) >= 8
    others = [index for index, cell in enumerate(shown.explanation["cells"]) if cell["depth"] == 3]
    strangers = [cell for cell in others if cell != step["cell"]]
    assert all(edges_in_bold(cell) < 8 for cell in strangers)


def test_the_drawing_changes_from_step_to_step(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    pictures = []
    for number in range(20):
        shown.go(number)
        pictures.append(shown.picture())
    assert len(set(pictures)) == len(pictures)


def test_the_view_flies_to_where_it_would_be_at_once(show: Open, walks: Walks) -> None:
    flying = show(walks["hitting"], reduced_motion="no-preference")
    sudden = show(walks["hitting"])
    for shown in (flying, sudden):
        shown.go(shown.first(kind="leaf"))
    assert flying.picture() == sudden.picture()


def test_the_drawing_can_be_turned_moved_zoomed_and_reset(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    start = shown.picture()
    mouse = shown.page.mouse

    def drag(dx: float, dy: float) -> None:
        mouse.move(400, 300)
        mouse.down()
        mouse.move(400 + dx, 300 + dy, steps=4)
        mouse.up()

    pictures = [start]
    drag(90, 30)
    pictures.append(shown.changed(*pictures))
    shown.page.keyboard.down("Shift")
    drag(40, -60)
    shown.page.keyboard.up("Shift")
    pictures.append(shown.changed(*pictures))
    mouse.wheel(0, -300)
    shown.changed(*pictures)
    shown.page.keyboard.press("0")
    shown.page.evaluate("document.activeElement.blur()")
    wait_until(lambda: shown.picture() == start)


def test_a_miss_shows_the_nearest_miss(show: Open, walks: Walks) -> None:
    shown = show(walks["missing"])
    shown.page.keyboard.press("End")
    shown.settle()
    miss = shown.explanation["nearest_miss"]
    assert shown.text("#case strong") == "missed"
    result = shown.text("#result")
    assert f"face\t{miss['face']}" in result
    assert f"by\t{miss['distance']:.6g}" in result
    assert miss["why"] in result
    # The gap is drawn, and large enough to be seen.
    ends = [np.array(miss[name]) for name in ("point_on_ray", "point_on_face")]
    line = [(ends[0] + share * (ends[1] - ends[0])).tolist() for share in np.linspace(0.1, 0.9, 9)]
    reds = [
        np.abs(colors - shown.color("far")).max(axis=1).min() < 40 for colors in shown.pixels(line)
    ]
    assert np.mean(reds) > 0.4
    where = shown.where([end.tolist() for end in ends])
    assert np.linalg.norm(where[0] - where[1]) > 15
    assert shown.page.locator("#picture line.gap").count() == 1


def test_a_hit_is_told_at_the_end(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    hit, counts = shown.explanation["hit"], shown.explanation["counts"]
    shown.page.keyboard.press("End")
    shown.settle()
    assert f"face {hit['face']}" in shown.text("#case")
    assert f"{hit['t']:.6g}" in shown.text("#result")
    (colors,) = shown.pixels([hit["point"]])
    assert np.abs(colors - shown.color("hit")).max() < 40
    rows = shown.page.locator("#counts tbody tr")
    for index, who in enumerate(["brute_force", "textbook", "engine"]):
        wanted = [counts[who][what] for what in ("nodes", "leaves", "triangles")]
        cells = [cell.replace(",", "") for cell in rows.nth(index).locator("td").all_inner_texts()]
        assert [int(cell) for cell in cells] == wanted
    assert rows.nth(0).is_visible()


def test_a_ray_that_passes_the_box_by(show: Open, walks: Walks) -> None:
    shown = show(walks["passing by"])
    assert len(shown.explanation["steps"]) == 2
    assert shown.text("#case strong") == "the box is missed"
    assert "nowhere: it leaves “in y”" in shown.picture_text()
    shown.page.keyboard.press("ArrowRight")
    shown.settle()
    assert str(shown.explanation["nearest_miss"]["face"]) in shown.text("#result")


@pytest.mark.parametrize(
    ("factor", "offset"), [(1.0, 5.4e6), (1e-30, 0.0), (1e30, 0.0), (8e307, 0.0), (1e-200, 0.0)]
)
def test_scale_and_place_of_the_mesh_do_not_matter(
    show: Open, walks: Walks, factor: float, offset: float
) -> None:
    shown = show(moved(walks["hitting"], factor, offset))
    step = shown.go(shown.first(case="both"))
    assert shown.is_mostly("near", shown.along_the_ray(step["t_near"], step["t_split"]))
    assert shown.is_mostly("far", shown.along_the_ray(step["t_split"], step["t_far"]))
    beyond = shown.along_the_ray(step["t_far"], 1.3 * step["t_far"] - 0.3 * step["t_split"])
    assert not shown.is_mostly("far", beyond)
    shown.go(shown.first(kind="leaf"))
    shown.page.keyboard.press("End")
    shown.settle()
    (colors,) = shown.pixels([shown.explanation["hit"]["point"]], reach=3)
    assert np.abs(colors - shown.color("hit")).max(axis=1).min() < 40


def test_numbers_that_differ_look_different(show: Open, walks: Walks) -> None:
    shown = show(walks["afar"])
    for number, step in enumerate(shown.explanation["steps"]):
        if step["kind"] == "inner" and step["t_split"] is not None:
            shown.go(number)
            values = {step["t_near"], step["t_split"], step["t_far"]}
            cells = shown.page.locator("#numbers data").all_inner_texts()
            rows = dict(
                zip(
                    shown.numbers(),
                    shown.page.locator("#numbers td").all_inner_texts(),
                    strict=True,
                )
            )
            assert cells
            assert len({rows[name] for name in ("t_near", "t_split", "t_far")}) == len(values)


ODD = ["flat, from above", "flat, within", "flat, beside", "a point", "from a point", "afar"]


@pytest.mark.parametrize("name", ODD)
def test_flat_and_single_triangles_and_far_origins_are_drawn(
    show: Open, walks: Walks, name: str
) -> None:
    shown = show(walks[name])
    last = len(shown.explanation["steps"]) - 1
    for number in {0, 1, last // 2, last}:
        shown.go(number)
        image = Image.open(io.BytesIO(shown.picture())).convert("RGB")
        # The middle, without the buttons, the legend and the axes.
        middle = np.asarray(image)[100:-100, 150:-150]
        assert (middle != shown.color("canvas")).any(axis=2).sum() > 500


def test_planes_that_are_infinitely_far_along_the_ray(show: Open, walks: Walks) -> None:
    shown = show(walks["nearly parallel"])
    step = shown.go(shown.first(case="near only", t_split=None))
    assert float(shown.numbers()["t_split"]) == np.inf
    assert "t_split = ∞" in shown.picture_text()
    assert shown.is_mostly("near", shown.along_the_ray(step["t_near"], step["t_far"]))


def test_an_empty_mesh_has_a_page(show: Open, walks: Walks) -> None:
    shown = show(walks["no triangle"])
    assert "there are no triangles" in shown.picture_text()
    shown.page.keyboard.press("End")
    assert shown.text("#case strong") == "missed"


def test_the_camera_says_what_is_up(show: Open, walks: Walks) -> None:
    walk = walks["hitting"]
    pictures = set()
    for up, name in enumerate("xyz"):
        shown = show(walk.showing({**walk.explanation, "up": up}))
        assert shown.text("#up") == f"up: {name}"
        pictures.add(shown.picture())
    assert len(pictures) == 3


def test_two_thousand_steps(show: Open, walks: Walks) -> None:
    shown = show(long(walks["hitting"], 2000), fragment="#step=1000")
    assert shown.step() == 1000
    for _ in range(20):
        shown.page.keyboard.press("ArrowRight")
    shown.settle()
    assert shown.step() == 1020
    shown.page.keyboard.press("End")
    shown.settle()
    assert shown.step() == len(shown.explanation["steps"]) - 1
    marked = shown.page.locator("#list [aria-current=step]")
    assert marked.count() == 1
    box, around = marked.bounding_box(), shown.page.locator("#list").bounding_box()
    assert box
    assert around
    assert around["y"] <= box["y"] <= around["y"] + around["height"]


def test_a_leaf_of_many_triangles(show: Open, walks: Walks) -> None:
    shown = show(walks["many triangles"])
    step = max(shown.explanation["steps"], key=lambda step: len(step.get("tests", [])))
    shown.go(shown.explanation["steps"].index(step))
    assert shown.page.locator("#tests tbody tr").count() == len(step["tests"]) > 200


def test_the_name_of_a_file_is_text(show: Open, halfline: Halfline, tmp_path: Path) -> None:
    name = "<img src=x onerror=alert(1)>&'\".ply"
    shown = show(explain(halfline, tmp_path, FLAT, "0.2,0.2,1,0,0,-1", name=name))
    assert name in shown.page.title()
    assert name in shown.text("h1")


def test_titles_and_names_are_text(show: Open, walks: Walks) -> None:
    explanation = copy.deepcopy(walks["hitting"].explanation)
    evil = "<script>document.title = 'gone'</script></script><!-- & {{data}}"
    explanation["mesh"]["name"] = evil
    explanation["ending"] = evil
    explanation["steps"][0]["why"] = evil
    shown = show(walks["hitting"].showing(explanation, evil))
    assert shown.page.title() == evil
    assert shown.text("h1") == evil
    assert shown.text("#ending") == evil
    assert shown.text("#why") == evil


@pytest.mark.parametrize("size", [(1280, 800), (1920, 1080), (390, 844)])
def test_it_fits_the_screen(show: Open, walks: Walks, size: tuple[int, int]) -> None:
    shown = show(walks["hitting"], viewport={"width": size[0], "height": size[1]})
    for number in (0, 1, shown.first(kind="leaf"), len(shown.explanation["steps"]) - 1):
        shown.go(number)
        assert shown.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        for element in ["#forward", "#slider", "#drawing"]:
            shown.page.locator(element).scroll_into_view_if_needed()
            box = shown.page.locator(element).bounding_box()
            assert box
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= size[0]
            assert box["width"] > 30
            assert element != "#drawing" or box["width"] > size[0] / 2
        texts = shown.page.locator("#picture text").evaluate_all(
            """texts => texts.map((text) => text.getBoundingClientRect())
              .map(({ left, right }) => [left, right])"""
        )
        assert all(left >= -1 and right <= size[0] + 1 for left, right in texts)


def test_dark_and_light(show: Open, walks: Walks) -> None:
    grounds = []
    for scheme in ("light", "dark"):
        shown = show(walks["hitting"], color_scheme=scheme)
        shown.go(shown.first(case="both"))
        canvas = shown.color("canvas")
        grounds.append(sum(canvas))
        step = shown.explanation["steps"][shown.step()]
        assert shown.is_mostly("near", shown.along_the_ray(step["t_near"], step["t_split"]))
    assert grounds[0] > 600
    assert grounds[1] < 150


def test_sharp_on_screens_with_small_pixels(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"], device_scale_factor=2)
    widths = shown.page.evaluate("[drawing.width, drawing.clientWidth].map(Number)")
    assert widths[0] == 2 * widths[1]


def test_a_finger_turns_the_drawing(show: Open, walks: Walks) -> None:
    shown = show(
        walks["hitting"], viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True
    )
    before = shown.picture()
    touch = shown.page.context.new_cdp_session(shown.page)
    # Upwards, as if to scroll the page.
    for kind, y in [
        ("touchStart", 350),
        ("touchMove", 300),
        ("touchMove", 200),
        ("touchMove", 150),
    ]:
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": 150, "y": y}]})
        shown.page.wait_for_timeout(50)
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    shown.changed(before)
    assert shown.page.evaluate("scrollY") == 0


def test_the_fast_tree_is_told_beside(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    shown.page.click("#engine summary")
    rows = shown.page.locator("#engine-steps tbody tr")
    assert rows.count() == len(shown.explanation["engine"]["steps"])
    before = shown.picture()
    rows.nth(0).click()
    shown.changed(before)


def test_screen_readers_are_told_the_step(show: Open, walks: Walks) -> None:
    shown = show(walks["hitting"])
    step = shown.go(3)
    live = shown.page.locator("[aria-live=polite]")
    assert step["why"] in live.inner_text()
    slider = shown.page.locator("#slider")
    assert str(slider.get_attribute("aria-valuetext")).startswith("step 3: ")
    assert step["why"] in str(shown.page.locator("#drawing").get_attribute("aria-label"))
    # The list is one stop of the Tab key.
    assert shown.page.locator("#list button[tabindex='0']").count() == 1
