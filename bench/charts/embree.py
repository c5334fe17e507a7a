"""The chart of README: ratios to Embree's best, cell by cell, from bench/out/embree.json.

`make bench-embree` makes it last. Rates are a logarithmic axis: twice as fast is as far from 1 as
half.
"""

from __future__ import annotations

import json
from typing import Any

from common.harness import OUT

from charts.svg import FAINT, HALFLINE, INK, RIVAL, LogAxis, dot, line, page, text

LEFT, TOP, ROW, GAP, WIDTH = 150, 58, 17, 26, 470
AXIS = LogAxis(lowest=0.1, highest=10.0, start=LEFT, end=LEFT + WIDTH)
TICKS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)


def chart(cells: list[dict[str, Any]]) -> str:
    """The chart of some cells, mesh after mesh."""
    meshes = list(dict.fromkeys(cell["mesh"] for cell in cells))
    height = TOP + len(cells) * ROW + len(meshes) * GAP + 10
    bottom = height - 10
    threads = cells[0]["threads"]
    title = "Rays a second, divided by those of Embree 4.4 at its best"
    title += f" ({threads} thread{'' if threads == 1 else 's'})"
    parts = [
        text(12, 20, title, 'font-size="14"'),
        dot(16, 36, HALFLINE, 5, "halfline"),
        text(26, 40, "halfline, exact"),
        dot(136, 36, RIVAL, 3.5, "obvhs"),
        text(146, 40, "obvhs"),
    ]
    for tick in TICKS:
        x, width = AXIS.place(tick), 1.6 if tick == 1.0 else 0.7
        parts.append(line([x, x], [TOP, bottom], INK if tick == 1.0 else FAINT, width))
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
                parts.append(dot(AXIS.place(ratio), middle, RIVAL, 3.5, f"obvhs {ratio:.2f}"))
            words = f"halfline {cell['ratio']:.2f}, {cell['halfline']:.1f} M rays/s"
            parts.append(dot(AXIS.place(cell["ratio"]), middle, HALFLINE, 5, words))
            y += ROW
    return page(LEFT + WIDTH + 30, height, title, parts)


def main() -> None:
    """Reads the cells, and draws those of the fewest threads as bench/out/embree.svg."""
    cells = json.loads((OUT / "embree.json").read_text(encoding="utf-8"))
    fewest = min(cell["threads"] for cell in cells)
    drawn = chart([cell for cell in cells if cell["threads"] == fewest])
    (OUT / "embree.svg").write_text(drawn, encoding="utf-8")
