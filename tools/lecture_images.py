#!/usr/bin/env python3
"""The pictures of docs/lecture.md and of the README's part about it, by the command itself.

Run by `make lecture-images`: cells of the teapot's tree, cut by a plane, and the page of a walk as
a browser shows it. With --study FOLDER also the main plot of a study that was made before, by
`make study`.
"""

from __future__ import annotations

import argparse
import io
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"

RULES = ("middle", "median", "sah")

# The walk of section 3, and a step in which both parts of a cell are passed.
WALK = ("soup.ply", "--ray=-0.2,0.4,0.8,1,0.1,-0.1")
STEP = 3
WIDTH, HEIGHT = 1280, 800


def browser() -> str:
    """The path of the browser that the tests use."""
    found = subprocess.run(
        [ROOT / "tools" / "find_browser.sh"], stdout=subprocess.PIPE, text=True, check=True
    )
    return found.stdout.strip()


def screenshot(page: Path, step: int, to: Path) -> None:
    """What a browser shows of a page at a step."""
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=browser(), args=["--no-sandbox"])
        tab = chromium.new_page(viewport={"width": WIDTH, "height": HEIGHT})
        tab.goto(f"{page.as_uri()}#step={step}")
        tab.wait_for_selector(f"body[data-step='{step}']")
        png = tab.screenshot()
        chromium.close()
    # Few colours are there, so a palette loses nothing that shows.
    Image.open(io.BytesIO(png)).convert("RGB").quantize(128).save(to, optimize=True)


def main() -> None:
    """Draws all of them into docs/images."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("halfline", type=Path, help="the command")
    parser.add_argument("--study", type=Path, metavar="FOLDER", help="where a study was written")
    arguments = parser.parse_args()
    command = arguments.halfline.resolve()

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def run(*words: str | Path) -> None:
            subprocess.run([command, *words, "--quiet"], cwd=folder, check=True)

        run("generate", "teapot", "-n", "16843", "-o", "teapot.ply")
        for rule in RULES:
            output = IMAGES / f"lecture-{rule}.svg"
            run("explain", "teapot.ply", "--plane", "xz", "--rule", rule, "-o", output)
        run("generate", "soup", "-n", "10", "-o", "soup.ply")
        run("explain", *WALK, "-o", "walk.html")
        screenshot(folder / "walk.html", STEP, IMAGES / "walk.png")
    if arguments.study is not None:
        shutil.copyfile(arguments.study / "study.svg", IMAGES / "study.svg")


if __name__ == "__main__":
    main()
