"""Trees sent to the machines of a cluster that do not see their files."""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

from distributed import Client

import halfline
from halfline._scene import Scene
from halfline.dask._peers import Place, abandon, finish, forget, probe, read_chunk, receive
from halfline.dask._trees import CHUNK_BYTES, Tree, tree_of


def publish(client: Client, scene: Scene | str | os.PathLike[str]) -> int:
    """Sends a tree's file to those machines of a cluster that see neither its path nor a copy.

    Nothing is sent where it is there. The bytes go once to each machine, a few megabytes at a time
    and not as part of any graph, and lie in its cache from then on, for workers that restart as
    well. Those on machines that join later take it from another worker when they need it.

    `Scene.render` calls this itself; before the lazy functions it is for the caller to do, where
    the workers do not see the scene's path.

    Args:
        client: The cluster's.
        scene: A scene from a file, or the path of a tree file.

    Returns:
        To how many machines it was sent.

    Raises:
        TypeError: For arguments of other types, and for an asynchronous client.
        ValueError: For a scene in memory.
        OSError: If the file cannot be read, or a worker cannot write it.
        FormatError: If what arrives is not the tree.
        RuntimeError: If workers have no halfline, or another version.
        KeyboardInterrupt: On Ctrl-C.
    """
    check_client(client)
    tree, _ = tree_of(scene)
    return publish_tree(client, tree, nothing)


def nothing() -> None:
    """Nobody wants the end."""


def publish_tree(client: Client, tree: Tree, check: Callable[[], object]) -> int:
    """`publish`; `check` is called now and then, and may raise."""
    sent = 0
    while True:
        lacking: dict[tuple[Any, ...], str] = {}
        for address, place in _places(client, tree).items():
            if place.machine is not None:
                lacking.setdefault(place.machine, address)
        if not lacking:
            return sent
        # What seemed one machine and is not shows when the others are asked again.
        _send(client, tree, sorted(lacking.values()), check)
        sent += len(lacking)


def unpublish(client: Client, scene: Scene | str | os.PathLike[str]) -> None:
    """Removes a tree's file from the caches of a cluster's machines; the file itself stays.

    Args:
        client: The cluster's.
        scene: As for `publish`.

    Raises:
        TypeError: As `publish`.
        ValueError: As `publish`.
        OSError: If the file cannot be read, or a copy cannot be removed.
    """
    check_client(client)
    tree, _ = tree_of(scene)
    client.run(forget, tree)


def check_client(client: object) -> None:
    """Refuses what is no client of Dask, or one for coroutines."""
    if not isinstance(client, Client):
        raise TypeError(f"client: expected a distributed.Client, found {type(client).__name__}")
    if client.asynchronous:
        raise TypeError("client: expected a synchronous one, found one for coroutines")


def _places(client: Client, tree: Tree) -> dict[str, Place]:
    """What each worker has."""
    places: dict[str, Place] = {}
    for address, answer in client.run(probe, tree, on_error="return").items():
        if isinstance(answer, ImportError):
            raise RuntimeError(
                f"worker {address} has no halfline to work with, pip install 'halfline[dask]' "
                f"there: {answer}"
            )
        if isinstance(answer, OSError):
            # It has gone.
            continue
        if isinstance(answer, BaseException):
            raise answer
        if answer.version != halfline.__version__:
            raise RuntimeError(
                f"worker {address} has halfline {answer.version}, this process "
                f"{halfline.__version__}: their pictures may differ"
            )
        places[address] = answer
    return places


def _send(client: Client, tree: Tree, workers: list[str], check: Callable[[], object]) -> None:
    transfer = uuid.uuid4().hex
    file = Path(tree.path).stat()
    try:
        for offset in range(0, file.st_size, CHUNK_BYTES):
            check()
            chunk = read_chunk(tree.path, offset)
            client.run(receive, tree, transfer, offset, chunk, workers=workers)
        client.run(finish, tree, transfer, file.st_mtime_ns, workers=workers)
    except BaseException:
        client.run(abandon, tree, transfer, workers=workers, on_error="ignore")
        raise
