"""Who hears how far a long call is."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from tqdm.std import tqdm

Report: TypeAlias = Callable[[str, int, int], object]
"""Called with the stage ("load", "build", "trace"), what is done of it, and the total."""

Progress: TypeAlias = Report | bool | None
"""True for a bar, a callable for something else, None or False for nothing."""


@contextmanager
def reporting(progress: Progress) -> Iterator[Report | None]:
    """What to call as the work goes on; what it shows is finished when the work is."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        bar = _bar()
        try:
            yield bar.report
        finally:
            bar.close()
    elif callable(progress):
        yield progress
    else:
        raise TypeError(
            f"progress: expected True, False, None or a callable, found {type(progress).__name__}"
        )


def _bar() -> TqdmBar | TextLine:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return TextLine()
    return TqdmBar(tqdm)


# What a stage counts.
_UNITS = {"load": "B", "build": " triangles", "trace": " rays"}


class TqdmBar:
    """A bar of tqdm for each stage."""

    def __init__(self, bar_type: type[tqdm[None]]) -> None:
        self._bar_type = bar_type
        self._bar: tqdm[None] | None = None
        self._stage = ""

    def report(self, stage: str, done: int, total: int) -> None:
        """Shows it."""
        if self._bar is None or stage != self._stage:
            self.close()
            self._stage = stage
            unit = _UNITS.get(stage, "")
            self._bar = self._bar_type(total=total, desc=stage, unit=unit, unit_scale=True)
        self._bar.total = total
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Leaves the last state to be read."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


class TextLine:
    """One line of text on stderr, written over again on a terminal."""

    def __init__(self) -> None:
        self._line = ""

    def report(self, stage: str, done: int, total: int) -> None:
        """Shows it."""
        percent = 100 * done // total if total else 100
        self._line = f"halfline: {stage} {percent} %"
        if sys.stderr.isatty():
            sys.stderr.write(f"\r{self._line}\x1b[K")
            sys.stderr.flush()

    def close(self) -> None:
        """Leaves the last state to be read."""
        if self._line:
            start = "\r" if sys.stderr.isatty() else ""
            sys.stderr.write(f"{start}{self._line}\n")
            sys.stderr.flush()
