"""The chart of `make bench-growth`: time and counts per ray over triangles.

Both axes are logarithmic, so that a power of n is a straight line and log n bends towards flat.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from common.harness import OUT

from charts.svg import FAINT, HALFLINE, INK, RIVAL, LogAxis, dot, line, page, text

LEFT, TOP, WIDTH, HEIGHT = 62, 64, 270, 210
ACROSS, DOWN = WIDTH + 178, HEIGHT + 76
LABEL_HEIGHT = 13
DASHED = 'stroke-dasharray="5 3"'
POWERS = {3: "10³", 4: "10⁴", 5: "10⁵", 6: "10⁶", 7: "10⁷", 8: "10⁸"}


@dataclass(frozen=True)
class Series:
    """What one line shows: a column of the figures, for one kind of rays."""

    key: str
    rays: str
    name: str
    color: str


@dataclass(frozen=True)
class Row:
    """What the panels of a row show."""

    title: str
    series: Sequence[Series]
    digits: str


ROWS = (
    Row(
        "nanoseconds per ray",
        [
            Series("halfline_nanoseconds", "random", "halfline, chords", HALFLINE),
            Series("halfline_nanoseconds", "primary", "halfline, primary", HALFLINE),
            Series("embree_nanoseconds", "random", "Embree, chords", RIVAL),
            Series("embree_nanoseconds", "primary", "Embree, primary", RIVAL),
        ],
        "{:.0f} ns",
    ),
    Row(
        "counts per ray of halfline",
        [
            Series("cache_lines_per_ray", "random", "cache lines, chords", "#7a5195"),
            Series("cache_lines_per_ray", "primary", "cache lines, primary", "#7a5195"),
            Series("nodes_per_ray", "random", "nodes, chords", INK),
            Series("nodes_per_ray", "primary", "nodes, primary", INK),
            Series("leaves_per_ray", "random", "leaves, chords", "#4f8a5b"),
            Series("leaves_per_ray", "primary", "leaves, primary", "#4f8a5b"),
        ],
        "{:.2f}",
    ),
)


def ticks(values: Sequence[float]) -> list[float]:
    """1, 2 and 5 times powers of ten, from below the least value to above the largest."""
    steps = [step * 10.0**power for power in range(-3, 7) for step in (1, 2, 5)]
    inside = [i for i, step in enumerate(steps) if min(values) < step < max(values)]
    if not inside:
        return [0.1, 1.0, 10.0]
    return steps[inside[0] - 1 : inside[-1] + 2]


def spread_labels(wanted: Sequence[float]) -> list[float]:
    """Heights near the wanted ones, in their order, that leave room for a line of text each."""
    heights = list(wanted)
    order = sorted(range(len(heights)), key=lambda i: heights[i])
    for _ in range(50):
        for above, below in itertools.pairwise(order):
            overlap = LABEL_HEIGHT - (heights[below] - heights[above])
            if overlap > 0:
                heights[above] -= overlap / 2
                heights[below] += overlap / 2
    return heights


def panel(
    figures: list[dict[str, Any]], row: Row, x_axis: LogAxis, y_axis: LogAxis, marks: list[float]
) -> list[str]:
    """The lines of one kind of mesh, within axes."""
    left, right, top, bottom = x_axis.start, x_axis.end, y_axis.end, y_axis.start
    parts = []
    for power, words in POWERS.items():
        if x_axis.lowest <= 10**power <= x_axis.highest:
            x = x_axis.place(10**power)
            parts.append(line([x, x], [top, bottom], FAINT, 0.7))
            parts.append(text(x, bottom + 15, words, 'text-anchor="middle" font-size="11"'))
    for mark in marks:
        y = y_axis.place(mark)
        parts.append(line([left, right], [y, y], FAINT, 0.7))
        parts.append(text(left - 6, y + 4, f"{mark:g}", 'text-anchor="end" font-size="11"'))
    parts.append(line([left, left, right], [top, bottom, bottom], INK, 1.0))
    parts.append(text((left + right) / 2, bottom + 31, "triangles", 'text-anchor="middle"'))

    ends: list[tuple[Series, float]] = []
    for series in row.series:
        points = [
            (entry["triangles"], entry[series.key])
            for entry in figures
            if entry["rays"] == series.rays and entry[series.key] > 0
        ]
        if not points:
            continue
        across = [x_axis.place(triangles) for triangles, _ in points]
        heights = [y_axis.place(value) for _, value in points]
        dashes = DASHED if series.rays == "primary" else ""
        parts.append(line(across, heights, series.color, 1.8, dashes))
        for at, height, (triangles, value) in zip(across, heights, points, strict=True):
            words = f"{series.name}, {triangles:,} triangles: {row.digits.format(value)}"
            parts.append(dot(at, height, series.color, 2.5, words))
        ends.append((series, heights[-1]))
    heights = spread_labels([height for _, height in ends])
    for (series, _), height in zip(ends, heights, strict=True):
        color = f'fill="{series.color}" font-size="11"'
        parts.append(text(right + 8, height + 4, series.name, color))
    return parts


def chart(figures: list[dict[str, Any]]) -> str:
    """A column of panels for each kind of mesh."""
    families = list(dict.fromkeys(row["family"] for row in figures))
    sizes = [row["triangles"] for row in figures]
    title = "A ray's cost as meshes grow, on one thread"
    parts = [text(12, 20, title, 'font-size="14"')]
    for number, row in enumerate(ROWS):
        keys = {series.key for series in row.series}
        values = [entry[key] for entry in figures for key in keys if entry[key] > 0]
        marks = ticks(values or [1.0])
        top = TOP + number * DOWN
        for column, family in enumerate(families):
            left = LEFT + column * ACROSS
            x_axis = LogAxis(min(sizes) / 1.2, max(sizes) * 1.2, left, left + WIDTH)
            y_axis = LogAxis(marks[0], marks[-1], top + HEIGHT, top)
            parts.append(text(left, top - 12, f"{family}: {row.title}", 'font-weight="bold"'))
            wanted = [entry for entry in figures if entry["family"] == family]
            parts += panel(wanted, row, x_axis, y_axis, marks)
    width = LEFT + len(families) * ACROSS - 40
    return page(width, TOP + len(ROWS) * DOWN - 20, title, parts)


def main() -> None:
    """Reads the figures, and draws them as bench/out/growth.svg."""
    figures = json.loads((OUT / "growth.json").read_text(encoding="utf-8"))
    (OUT / "growth.svg").write_text(chart(figures), encoding="utf-8")
