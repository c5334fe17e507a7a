#!/usr/bin/env python3
"""The chart of README: ratios to Embree's best, cell by cell, from bench/out/peers.json.

`make peers` runs it last. Rates are a logarithmic axis: twice as fast is as far from 1 as half.
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent

LEFT, TOP, ROW, GAP, WIDTH = 150, 58, 17, 26, 470
LOWEST, HIGHEST = 0.1, 10.0
HALFLINE, RIVAL, INK, FAINT = "#c8501e", "#4a7ba6", "#333333", "#d8d8d8"


def place(ratio: float) -> float:
    """Where a ratio is across the chart."""
    share = math.log(ratio / LOWEST) / math.log(HIGHEST / LOWEST)
    return LEFT + WIDTH * min(max(share, 0.0), 1.0)


def text(x: float, y: float, words: str, extra: str = "") -> str:
    """A piece of text."""
    return f'<text x="{x:.1f}" y="{y:.1f}" {extra}>{words}</text>'


def dot(ratio: float, y: float, color: str, radius: float, words: str) -> str:
    """A mark that tells its value when one points at it."""
    circle = f'<circle cx="{place(ratio):.1f}" cy="{y:.1f}" r="{radius}" fill="{color}">'
    return f"{circle}<title>{words}</title></circle>"


def chart(cells: list[dict[str, Any]]) -> str:
    """The chart of some cells, mesh after mesh."""
    meshes = list(dict.fromkeys(cell["mesh"] for cell in cells))
    height = TOP + len(cells) * ROW + len(meshes) * GAP + 10
    bottom = height - 10
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {LEFT + WIDTH + 30} {height}" '
        f'font-family="Helvetica, Arial, sans-serif" font-size="12" fill="{INK}">',
        "<title>Rays a second, divided by those of Embree's best configuration</title>",
        f'<rect width="100%" height="{height}" fill="#ffffff"/>',
        text(12, 20, "Rays a second, divided by those of Embree 4.4 at its best", 'font-size="14"'),
        f'<circle cx="16" cy="36" r="5" fill="{HALFLINE}"/>',
        text(26, 40, "halfline, exact"),
        f'<circle cx="136" cy="36" r="3.5" fill="{RIVAL}"/>',
        text(146, 40, "obvhs"),
    ]
    for tick in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0):
        x, width = place(tick), 1.6 if tick == 1.0 else 0.7
        color = INK if tick == 1.0 else FAINT
        line = f'x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{bottom}"'
        parts.append(f'<line {line} stroke="{color}" stroke-width="{width}"/>')
        parts.append(text(x, TOP - 5, f"{tick:g}", 'text-anchor="middle" font-size="11"'))
    y = float(TOP)
    for mesh in meshes:
        y += GAP
        parts.append(text(12, y - 6, mesh, 'font-weight="bold"'))
        for cell in (cell for cell in cells if cell["mesh"] == mesh):
            middle = y + ROW / 2
            parts.append(text(LEFT - 10, middle + 4, cell["rays"], 'text-anchor="end"'))
            if cell["obvhs"] is not None:
                ratio = cell["obvhs"] / cell["embree"]
                parts.append(dot(ratio, middle, RIVAL, 3.5, f"obvhs {ratio:.2f}"))
            words = f"halfline {cell['ratio']:.2f}, {cell['halfline']:.1f} M rays/s"
            parts.append(dot(cell["ratio"], middle, HALFLINE, 5, words))
            y += ROW
    return "\n".join([*parts, "</svg>"]) + "\n"


def main() -> None:
    """Draws what was measured on one thread."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--cells", type=Path, default=ROOT / "bench" / "out" / "peers.json")
    parser.add_argument("--output", type=Path, default=ROOT / "bench" / "out" / "peers.svg")
    options = parser.parse_args()
    cells = json.loads(options.cells.read_text(encoding="utf-8"))
    picture = chart([cell for cell in cells if cell["threads"] == 1])
    options.output.write_text(picture, encoding="utf-8")


if __name__ == "__main__":
    main()
