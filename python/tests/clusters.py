"""Clusters of Dask on this machine: real processes, as the tests want them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from children import PATIENCE_SECONDS
from distributed import Client, Nanny, Scheduler, SpecCluster
from distributed.protocol.core import dumps

# A worker with this in its environment sees no file in the folder that it names.
HIDDEN = "HALFLINE_TEST_HIDDEN"


@contextmanager
def cluster(*workers: dict[str, str], folder: Path) -> Iterator[Client]:
    """A client of a cluster of one process of one thread for each of the environments `workers`."""
    spec = {name: worker_spec(environment, folder) for name, environment in enumerate(workers)}
    options = {"host": "127.0.0.1", "port": 0, "dashboard": False, "dashboard_address": ":0"}
    scheduler = {"cls": Scheduler, "options": options}
    with SpecCluster(scheduler=scheduler, workers=spec) as made, Client(made) as client:
        client.wait_for_workers(len(workers), timeout=PATIENCE_SECONDS)
        yield client


def worker_spec(environment: dict[str, str], folder: Path) -> dict[str, object]:
    """What SpecCluster makes a worker of."""
    options = {
        "nthreads": 1,
        "host": "127.0.0.1",
        "local_directory": str(folder),
        "env": environment,
        "preload": [__file__],
        # Each has a machine to itself, as far as it knows.
        "memory_limit": 0,
    }
    return {"cls": Nanny, "options": options}


def elsewhere(path: Path, folder: Path) -> dict[str, str]:
    """The environment of a worker on another machine, which does not see the folder of `path`."""
    return {HIDDEN: str(path.parent), "HALFLINE_CACHE": str(folder)}


def dask_setup(worker: object) -> None:
    """Called by Dask in each worker, before its work."""
    hidden = os.environ.get(HIDDEN)
    if not hidden:
        return
    trees: Any = import_module("halfline.dask._trees")
    seen = trees.open_tree

    def open_tree(path, **options):  # type: ignore[no-untyped-def]
        if Path(path).is_relative_to(hidden):
            raise FileNotFoundError(2, "No such file or directory", str(path))
        return seen(path, **options)

    trees.open_tree = open_tree


@contextmanager
def sent(client: Client) -> Iterator[list[int]]:
    """The bytes of each message with work that the client sends to the scheduler meanwhile."""
    sizes: list[int] = []
    send = client._send_to_scheduler

    def counted(message: dict[str, Any]) -> None:
        if message["op"] == "update-graph":
            sizes.append(sum(map(len, dumps(message))))
        send(message)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(client, "_send_to_scheduler", counted)
        yield sizes


def process_ids(client: Client) -> dict[str, int]:
    """The process of each worker that is alive."""
    ids: dict[str, int] = client.run(os.getpid, on_error="ignore")
    return ids
