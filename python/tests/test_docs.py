"""What the pages and the docstrings show is what happens."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
import re
import shlex
from pathlib import Path
from types import ModuleType
from typing import Any

import halfline
import pytest
from conftest import ROOT, Halfline
from doc_examples import OPTIONS, blocks_without_examples, commands_of, is_shown, sections_of

# How many examples each page has: all of them are found, and none of them got lost. Whoever adds
# one writes the new number here.
PAGES = {"docs/python.md": 272}

# How many commands each page has.
COMMANDS = {"docs/lecture.md": 7}

# Where docstrings have examples, and how many.
DOCSTRINGS = {
    "halfline": 4,
    "halfline.Scene": 5,
    "halfline.Scene.closest_points": 4,
    "halfline.AllHits": 6,
}

RECIPES = {
    "Visibility",
    "Thickness map",
    "Ambient occlusion per vertex",
    "Depth image",
    "LiDAR sweep",
    "Points in a mesh",
    "Deviation of a scan from its CAD model",
    "Voxel occupancy",
    "Signed distance on a grid",
    "Clearance",
}


def failures(test: doctest.DocTest) -> str:
    """What an example shows in vain."""
    said: list[str] = []
    doctest.DocTestRunner(optionflags=OPTIONS).run(test, out=said.append)
    return "".join(said)


@pytest.mark.parametrize("name", PAGES)
def test_a_page_shows_what_happens(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    sections = [*sections_of(ROOT / name)]
    assert sum(len(section.examples) for section in sections) == PAGES[name]
    for section in sections:
        assert failures(section) == ""


@pytest.mark.parametrize("name", PAGES)
def test_every_example_of_a_page_is_found(name: str) -> None:
    page = ROOT / name
    assert blocks_without_examples(page) == []
    shown = re.findall(r"^\s*>>> ", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(shown) == PAGES[name]


def test_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (example,) = blocks_without_examples(ROOT / "README.md")
    names: dict[str, Any] = {}
    exec(compile(example, "README.md", "exec"), names)
    assert names["hits"].hit.mean() > 0.5
    assert {path.name for path in tmp_path.iterdir()} == {"scan.hlt", "scan.png"}


def test_every_recipe_has_examples_with_output() -> None:
    sections = {section.name: section for section in sections_of(ROOT / "docs/python.md")}
    assert sections.keys() >= RECIPES
    for name in RECIPES:
        assert any(example.want for example in sections[name].examples), name


def test_every_picture_of_the_guide_is_there() -> None:
    text = (ROOT / "docs/python.md").read_text(encoding="utf-8")
    for name in ("thickness", "openness", "lidar", "slice"):
        assert f"](images/{name}.png)" in text
        data = (ROOT / "docs/images" / f"{name}.png").read_bytes()
        assert data.startswith(b"\x89PNG")
        assert len(data) < 150_000


def test_a_wrong_page_is_noticed(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# One\n```python\n>>> 1 + 1\n3\n```\n## Two\n\n```python\n>>> 2\n2\n```\n")
    one, two = sections_of(page)
    assert f'File "{page}", line 3, in One' in failures(one)
    assert failures(two) == ""
    assert [two.name, two.examples[0].lineno] == ["Two", 3]


def test_sections_share_no_names(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# One\n```python\n>>> x = 1\n```\n# Two\n```python\n>>> x\n1\n```\n")
    _, two = sections_of(page)
    assert "NameError" in failures(two)


def modules() -> list[ModuleType]:
    """The package's modules in Python, those aside that start a program or need other packages."""
    names = [name for _, name, _ in pkgutil.iter_modules(halfline.__path__, "halfline.")]
    left_out = {"halfline.__main__", "halfline._native", "halfline.dask"}
    return [halfline, *(importlib.import_module(name) for name in names if name not in left_out)]


def test_docstrings_show_what_happens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    finder = doctest.DocTestFinder(exclude_empty=True)
    found: dict[str, int] = {}
    for module in modules():
        for test in finder.find(module, extraglobs={}):
            if test.examples:
                test.globs.clear()
                _, _, member = test.name.partition(module.__name__ + ".")
                found["halfline" + (f".{member}" if member else "")] = len(test.examples)
                assert failures(test) == ""
    assert found == DOCSTRINGS


@pytest.mark.parametrize("name", COMMANDS)
def test_the_commands_of_a_page_print_what_it_shows(
    name: str, halfline_command: Halfline, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    commands = commands_of(ROOT / name)
    assert len(commands) == COMMANDS[name]
    for command in commands:
        program, *arguments = shlex.split(command.line)
        assert program == "halfline", command
        output = halfline_command.ok(*arguments)
        assert is_shown(command.shown, output), f"{name}:{command.place}: {output}"


def test_dots_stand_for_lines() -> None:
    output = "a\nb\nc\nd\n"
    for shown in ("a\nb\nc\nd\n", "...\nd\n", "a\n...\n", "a\n...\nc\n...\n", "a\nb\nc\nd\n...\n"):
        assert is_shown(shown, output)
    for shown in ("a\nb\n", "...\nc\n", "b\n...\n", "a\n...\nb\nd\n", ""):
        assert not is_shown(shown, output)
