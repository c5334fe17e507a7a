"""How objects show themselves in Jupyter."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


def table(title: str, rows: Iterable[tuple[str, str]]) -> str:
    """A small table of names and figures, as HTML."""
    cells = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th>"
        f"<td style='text-align:left'>{escape(figure)}</td></tr>"
        for name, figure in rows
    )
    return f"<table><caption>halfline.{escape(title)}</caption>{cells}</table>"
