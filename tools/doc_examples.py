"""The examples of a Markdown page, as doctests.

An example is what a fenced block of Python shows with `>>>`. The examples between one heading and
the next share their names, and see none of other sections: so a section can be copied as it is.
"""

from __future__ import annotations

import doctest
import re
from collections.abc import Iterator
from pathlib import Path

FENCE = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
ANY_FENCE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)

OPTIONS = doctest.REPORT_NDIFF
"""No ellipsis, no lenient white space: what a page shows is what one sees."""


def sections_of(page: Path) -> Iterator[doctest.DocTest]:
    """The sections of a page that have examples; failures name the lines of the page."""
    text = page.read_text(encoding="utf-8")
    code = _only_code(text)
    prose = ANY_FENCE.sub(lambda block: _blank(block[0]), text)  # comments are no headings
    headings = [*HEADING.finditer(prose)]
    ends = [heading.start() for heading in headings[1:]] + [len(text)]
    for heading, end in zip(headings, ends, strict=True):
        line = text.count("\n", 0, heading.start())
        test = doctest.DocTestParser().get_doctest(
            code[heading.start() : end], {}, heading[1], str(page), line
        )
        if test.examples:
            yield test


def blocks_without_examples(page: Path) -> list[str]:
    """Blocks of Python that would not be run."""
    text = page.read_text(encoding="utf-8")
    return [block[1] for block in FENCE.finditer(text) if ">>> " not in block[1]]


def _only_code(text: str) -> str:
    """The text with everything but its code made blank, so that lines stay where they are."""
    parts: list[str] = []
    at = 0
    for block in FENCE.finditer(text):
        parts += [_blank(text[at : block.start(1)]), block[1]]
        at = block.end(1)
    return "".join(parts) + _blank(text[at:])


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)
