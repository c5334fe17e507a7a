"""The examples of a Markdown page: of Python as doctests, and commands with their output.

An example is what a fenced block of Python shows with `>>>`. The examples between one heading and
the next share their names, and see none of other sections: so a section can be copied as it is.
"""

from __future__ import annotations

import doctest
import re
from collections.abc import Iterator
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Command:
    """A command of a page, and what the page shows of its output."""

    line: str
    shown: str
    place: int


CONSOLE = re.compile(r"^```console\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def commands_of(page: Path) -> list[Command]:
    """What stands in the fenced blocks of `console`, in order: lines with `$` and their output.

    A line of three dots stands for any lines of the output.
    """
    text = page.read_text(encoding="utf-8")
    commands: list[Command] = []
    for block in CONSOLE.finditer(text):
        parts = re.split(r"^\$ (.*)\n", block[1], flags=re.MULTILINE)
        place = text.count("\n", 0, block.start()) + 1
        assert parts[0] == "", f"{page}:{place}: a block begins with a command"
        pairs = zip(parts[1::2], parts[2::2], strict=True)
        commands += [Command(line, shown, place) for line, shown in pairs]
    return commands


def is_shown(shown: str, output: str) -> bool:
    """True if the output is what is shown, where dots may stand for any lines."""
    parts = re.split(r"^\.\.\.\n", shown, flags=re.MULTILINE)
    pattern = "(?:.*\n)*".join(map(re.escape, parts))
    return re.fullmatch(pattern, output) is not None
