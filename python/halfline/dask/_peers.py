"""Files of trees on their way between machines.

Messages run on the event loops of workers, so whatever takes long goes to a thread.
"""

from __future__ import annotations

import asyncio
import os
import socket
import time
import uuid
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from distributed import Worker
from distributed.protocol.pickle import dumps
from distributed.utils import sync

import halfline
from halfline._native import FormatError
from halfline._open import open_tree
from halfline.dask._trees import CHUNK_BYTES, Tree, cache_folder, cached, find

# What was left by a sender that died is removed after so many seconds.
_STALE_SECONDS = 24 * 3600.0


@dataclass(frozen=True)
class Place:
    """What a worker has.

    Attributes:
        machine: What tells its machine's cache apart from others; None if it has the file.
        file: Where it has the tree's file; None if it has not.
        size: The file's bytes.
        modified: When the file was modified, in nanoseconds; its header tells the same.
        version: halfline's.
    """

    machine: tuple[str, str, int, int] | None
    file: str | None
    size: int
    modified: int
    version: str


async def probe(tree: Tree, dask_worker: Worker | None = None) -> Place:
    """What this worker has of a tree."""
    return await asyncio.to_thread(_probe, tree, dask_worker)


def _probe(tree: Tree, worker: Worker | None) -> Place:
    scene, _ = find(tree, worker)
    if scene is not None and scene.path is not None:
        file = scene.path.stat()
        return Place(None, str(scene.path), file.st_size, file.st_mtime_ns, halfline.__version__)
    folder = cache_folder(worker)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        place = folder.stat()
    except OSError as error:
        host = socket.gethostname()
        raise RuntimeError(f"the cache of trees cannot be on {host}: {error}") from None
    machine = (socket.gethostname(), str(folder), place.st_dev, place.st_ino)
    return Place(machine, None, 0, 0, halfline.__version__)


async def read(path: str, offset: int) -> bytes:
    """A chunk of a file of this worker."""
    return await asyncio.to_thread(read_chunk, path, offset)


def read_chunk(path: str | os.PathLike[str], offset: int) -> bytes:
    """The chunk of a file that begins at `offset`."""
    with Path(path).open("rb") as file:
        file.seek(offset)
        return file.read(CHUNK_BYTES)


async def receive(
    tree: Tree, transfer: str, offset: int, chunk: bytes, dask_worker: Worker | None = None
) -> None:
    """Puts a chunk of a tree's file in its place, in a file beside the one that it will be."""
    await asyncio.to_thread(_receive, _part(tree, transfer, dask_worker), offset, chunk)


def _receive(part: Path, offset: int, chunk: bytes) -> None:
    if offset == 0:
        part.parent.mkdir(parents=True, exist_ok=True)
        for left in part.parent.glob("*.part"):
            if time.time() - left.stat().st_mtime > _STALE_SECONDS:
                left.unlink(missing_ok=True)
    with part.open("wb" if offset == 0 else "r+b") as file:
        file.seek(offset)
        file.write(chunk)


async def finish(
    tree: Tree, transfer: str, modified: int, dask_worker: Worker | None = None
) -> None:
    """Tests a file that has arrived against its checksums, and gives it its name.

    Raises:
        FormatError: If it is not the tree.
    """
    part, path = _part(tree, transfer, dask_worker), cached(tree, dask_worker)
    await asyncio.to_thread(_finish, tree, part, path, modified)


def _finish(tree: Tree, part: Path, path: Path, modified: int) -> None:
    try:
        found = open_tree(part, verify=True).content_hash
        if found != tree.content_hash:
            raise FormatError(f"{path}: arrived as another tree, of content hash {found}")
        # The header tells when the file was modified: as it was, it need not be read again.
        os.utime(part, ns=(modified, modified))
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


async def abandon(tree: Tree, transfer: str, dask_worker: Worker | None = None) -> None:
    """Removes what has arrived of a file."""
    _part(tree, transfer, dask_worker).unlink(missing_ok=True)


async def forget(tree: Tree, dask_worker: Worker | None = None) -> None:
    """Removes a tree's file from the machine's cache."""
    cached(tree, dask_worker).unlink(missing_ok=True)


def _part(tree: Tree, transfer: str, worker: Worker | None) -> Path:
    return cache_folder(worker) / f"{tree.content_hash}-{transfer}.part"


def fetch(worker: Worker, tree: Tree) -> bool:
    """Takes a tree's file from another worker into the machine's cache; False if none has it.

    To be called from a task.
    """
    return bool(sync(worker.loop, _fetch, worker, tree))


async def _fetch(worker: Worker, tree: Tree) -> bool:
    answers = await worker.scheduler.broadcast(
        msg={"op": "run", **_call(probe, tree)}, on_error="ignore"
    )
    for address, answer in answers.items():
        place = answer.get("result") if isinstance(answer, dict) else None
        if not isinstance(place, Place) or place.file is None:
            continue
        try:
            await _fetch_from(worker, address, place, tree)
        except (OSError, ValueError):
            # It is gone, or what it has is damaged: another one may have it too.
            continue
        return True
    return False


async def _fetch_from(worker: Worker, address: str, place: Place, tree: Tree) -> None:
    peer = worker.rpc(address)
    transfer = uuid.uuid4().hex
    try:
        for offset in range(0, place.size, CHUNK_BYTES):
            answer: Any = await peer.run(**_call(read, place.file, offset))
            if answer["status"] != "OK":
                raise OSError(f"{address} cannot read {place.file}")
            await receive(tree, transfer, offset, answer["result"], dask_worker=worker)
        await finish(tree, transfer, place.modified, dask_worker=worker)
    finally:
        await abandon(tree, transfer, dask_worker=worker)


def _call(function: Callable[..., Awaitable[Any]], *args: object) -> dict[str, Any]:
    """The message that has a worker run a function."""
    return {"function": dumps(function), "args": dumps(args), "kwargs": dumps({}), "wait": True}
