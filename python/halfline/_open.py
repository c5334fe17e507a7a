"""Scenes from files of trees."""

from __future__ import annotations

import os

from halfline._arrays import path_of
from halfline._native import Scene as NativeScene
from halfline._progress import Progress, reporting
from halfline._scene import Scene


def open_tree(
    path: str | os.PathLike[str], *, verify: bool | None = None, progress: Progress = None
) -> Scene:
    """Opens a scene that was saved: maps the file, in well under a millisecond whatever its size.

    All processes on a machine share its memory. A file that was touched since it was written, as
    its time of modification tells, is read once and tested against its checksums, at the speed of
    memory.

    What is damaged after that can give wrong answers or a `FormatError`, but never harms the
    process; nor does a file that is cut short while it is open.

    Args:
        path: The file.
        verify: True to test it against its checksums in any case, False to never do so.
        progress: As for `Scene`, with the stage "load".

    Returns:
        The scene. It pickles as the file's path and content hash.

    Raises:
        OSError: If the file cannot be opened.
        FormatError: If it is no tree, or one of another version, cut short or damaged.
        KeyboardInterrupt: On Ctrl-C.
    """
    with reporting(progress) as report:
        return Scene._of(NativeScene.open(path_of("path", path), verify, report))
