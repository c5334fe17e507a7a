"""Pages of walks by the command, and the same page with another walk in it."""

from __future__ import annotations

import html
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from conftest import Halfline
from meshes import Shape, write_ply

Json = dict[str, Any]
DATA = re.compile(
    r'(?<=<script type="application/json" id="walk-data">).*?(?=</script>)', re.DOTALL
)
TITLE = re.compile(r"(?<=<title>)(.*?)(?=</title>)|(?<=<h1>)(.*?)(?=</h1>)")


@dataclass(frozen=True)
class WalkPage:
    """A page, and the explanation that it shows."""

    text: str
    explanation: Json

    def showing(self, explanation: Json, title: str = "a walk") -> WalkPage:
        """The page as the command would write it for another explanation."""
        data = json.dumps(explanation, ensure_ascii=False, allow_nan=False)
        data = data.replace("<", "\\u003c").replace("\u2028", "\\u2028")
        text = TITLE.sub(lambda _: html.escape(title), self.text)
        return WalkPage(DATA.sub(lambda _: data, text), explanation)


def explain(
    halfline: Halfline, folder: Path, shape: Shape, ray: str, *options: str, name: str = "mesh.ply"
) -> WalkPage:
    """The command's page for a ray, as ox,oy,oz,dx,dy,dz; its data are those of its JSON."""
    mesh = write_ply(folder / name, shape, "<f8")
    halfline.ok("explain", mesh, "--ray", ray, *options, "--output", folder / "walk.html")
    text = (folder / "walk.html").read_text(encoding="utf-8")
    found = DATA.search(text)
    assert found
    explanation: Json = json.loads(found[0])
    told = halfline.json("explain", mesh, "--ray", ray, *options)
    assert {
        key: value for key, value in explanation.items() if key not in ("scenery", "up")
    } == told
    assert explanation["scenery"] or not shape.faces.size
    return WalkPage(text, explanation)
