"""What the charts share: colours, text, logarithmic axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

HALFLINE, RIVAL, INK, FAINT = "#c8501e", "#4a7ba6", "#333333", "#d8d8d8"


@dataclass(frozen=True)
class LogAxis:
    """A logarithmic axis: values from `lowest` to `highest` lie between two coordinates."""

    lowest: float
    highest: float
    start: float
    end: float

    def place(self, value: float) -> float:
        """Where a value is; one beyond an end is at that end."""
        share = math.log(value / self.lowest) / math.log(self.highest / self.lowest)
        return self.start + (self.end - self.start) * min(max(share, 0.0), 1.0)


def text(x: float, y: float, words: str, extra: str = "") -> str:
    """A piece of text."""
    return f'<text x="{x:.1f}" y="{y:.1f}" {extra}>{words}</text>'


def dot(x: float, y: float, color: str, radius: float, words: str) -> str:
    """A mark that tells its value when one points at it."""
    circle = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{color}">'
    return f"{circle}<title>{words}</title></circle>"


def line(x: Sequence[float], y: Sequence[float], color: str, width: float, extra: str = "") -> str:
    """A line through points."""
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    stroke = f'stroke="{color}" stroke-width="{width}" fill="none"'
    return f'<polyline points="{points}" {stroke} {extra}/>'


def page(width: float, height: float, title: str, parts: list[str]) -> str:
    """A chart of some parts on white."""
    begin = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" '
        f'font-family="Helvetica, Arial, sans-serif" font-size="12" fill="{INK}">',
        f"<title>{title}</title>",
        f'<rect width="100%" height="{height:.0f}" fill="#ffffff"/>',
    ]
    return "\n".join([*begin, *parts, "</svg>"]) + "\n"
