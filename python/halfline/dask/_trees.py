"""Trees by content hash, as the processes of a cluster find, open and keep them."""

from __future__ import annotations

import contextlib
import ctypes
import os
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import dask
from distributed import Worker, get_worker

import halfline
from halfline._native import Picture, RenderSettings
from halfline._open import open_tree
from halfline._scene import Scene
from halfline.dask._recent import Recent

CHUNK_BYTES = 4 << 20
"""So much of a file travels at a time."""

# What <malloc.h> calls the size from which on blocks come from the system, and what it is to be.
_M_MMAP_THRESHOLD = -3
_BUFFER_BYTES = 4 << 20

_MOST_OPEN = 4
_MOST_PICTURES = 4

_scenes: Recent[str, Scene] = Recent(_MOST_OPEN)
_pictures: Recent[tuple[str, str], Picture] = Recent(_MOST_PICTURES)


class MissingTreeError(RuntimeError):
    """A worker has no tree file, and no other worker has it."""


@dataclass(frozen=True)
class Tree:
    """What tasks know of a tree: where it lies for some, and what it is.

    Attributes:
        path: The file, absolute.
        content_hash: 32 hexadecimal digits.
    """

    path: str
    content_hash: str

    def __dask_tokenize__(self) -> tuple[str, str, str]:
        # Where it lies makes no difference to the answers.
        return "halfline.dask.Tree", halfline.__version__, self.content_hash


def tree_of(scene: Scene | str | os.PathLike[str]) -> tuple[Tree, Scene]:
    """What tasks know of a scene from a file, or of the file at a path.

    Raises:
        TypeError: For anything else.
        ValueError: For a scene in memory.
        OSError: If the file cannot be opened.
        FormatError: If it is no tree.
    """
    if isinstance(scene, (str, os.PathLike)):
        scene = open_tree(scene)
    if not isinstance(scene, Scene):
        kind = type(scene).__name__
        raise TypeError(f"scene: expected a halfline.Scene or the path of a tree, found {kind}")
    path, content_hash = scene.path, scene.content_hash
    if path is None or content_hash is None:
        raise ValueError(
            "scene: expected one from a file, which workers can open, found one in memory: "
            "scene.save(path), then halfline.open(path)"
        )
    return Tree(str(path), content_hash), scene


def scene_of(tree: Tree) -> Scene:
    """The scene of a tree, in this process: opened once, and kept while it is among the last few.

    Raises:
        MissingTreeError: If it is nowhere to be found, naming path, worker and `publish`.
    """
    return _scenes.get(tree.content_hash, lambda: _open(tree))


def picture_of(tree: Tree, settings: str) -> Picture:
    """A picture of a tree, in this process: planned once. Its settings are given as JSON."""

    def plan() -> Picture:
        return Picture(scene_of(tree)._native, RenderSettings.from_json(settings))

    return _pictures.get((tree.content_hash, settings), plan)


def _open(tree: Tree) -> Scene:
    worker = this_worker()
    if worker is not None and worker.nanny:
        _share_cores(worker)
        _keep_buffers()
    scene, reason = find(tree, worker)
    if scene is None and worker is not None:
        scene, reason = _fetch(tree, worker)
    if scene is None:
        where = f"worker {worker.address}" if worker is not None else "this process"
        raise MissingTreeError(
            f"{tree.path}: {where} on {socket.gethostname()} has no such tree ({reason}): send it "
            "there with halfline.dask.publish(client, scene)"
        )
    return scene


def _fetch(tree: Tree, worker: Worker) -> tuple[Scene | None, str]:
    from halfline.dask._peers import fetch

    with _locked(cached(tree, worker)):
        # Another process of this machine may have fetched it meanwhile.
        scene, reason = find(tree, worker)
        if scene is None and fetch(worker, tree):
            scene, reason = find(tree, worker)
        return scene, reason


def find(tree: Tree, worker: Worker | None) -> tuple[Scene | None, str]:
    """The tree's scene from its path or from the machine's cache; else None and why."""
    reason = ""
    for path in (Path(tree.path), cached(tree, worker)):
        try:
            scene = open_tree(path)
        except (OSError, ValueError) as error:
            reason = reason or str(error)
            continue
        if scene.content_hash == tree.content_hash:
            return scene, ""
        reason = reason or f"there is another one, of content hash {scene.content_hash}"
    return None, reason


def cached(tree: Tree, worker: Worker | None) -> Path:
    """Where the tree's file is in the machine's cache, if it is there."""
    return cache_folder(worker) / f"{tree.content_hash}.hlt"


def cache_folder(worker: Worker | None) -> Path:
    """The machine's cache of trees; it need not exist."""
    named = os.environ.get("HALFLINE_CACHE")
    if named:
        return Path(named)
    if worker is not None:
        return Path(worker.local_directory).parent / "halfline-trees"
    scratch = dask.config.get("temporary-directory") or tempfile.gettempdir()
    return Path(scratch) / "dask-scratch-space" / "halfline-trees"


def this_worker() -> Worker | None:
    """The worker whose task this is."""
    try:
        return get_worker()
    except ValueError:
        return None


def _share_cores(worker: Worker) -> None:
    """Gives halfline as many threads as Dask gave the worker's process, which is no other's."""
    if not os.environ.get("HALFLINE_THREADS"):
        halfline.set_thread_count(worker.state.nthreads)


def _keep_buffers() -> None:
    """Lets glibc take buffers of some hundred kilobytes from the heap, as it does by itself.

    The nanny sets MALLOC_TRIM_THRESHOLD_, upon which glibc fetches and clears every block of more
    than 128 KiB anew: pictures would take half as long again.
    """
    set_by_hand = os.environ.get("MALLOC_MMAP_THRESHOLD_")
    if os.environ.get("MALLOC_TRIM_THRESHOLD_") and not set_by_hand:
        # Other systems and C libraries have no such thing, nor the need.
        with contextlib.suppress(AttributeError, OSError, TypeError):
            ctypes.CDLL(None).mallopt(_M_MMAP_THRESHOLD, _BUFFER_BYTES)


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """One process of the machine at a time, where the system has such locks."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.with_suffix(".lock").open("a") as file:
        try:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        except (ImportError, OSError):
            # Then two may write the same file, each beside it and renamed.
            pass
        yield
