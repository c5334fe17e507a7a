"""halfline.dask on one and two worker processes, against one process with as many threads.

Run by `make bench-dask`. On the Stanford dragon: `intersect` over chunked rays, and a picture, on 1
and 2 worker processes of one thread each, by turns with one process without Dask that has 1 and 2
threads. The rays are made where they are cast, in either case within the time that counts; what
comes back is how many hit. A row has medians of all turns, and how many bytes a client sends for
the work.

Needs the package `halfline` and data/ (`make data`).
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import dask.array as da
import halfline
import halfline.dask
import numpy as np
from common.harness import DRAGON, OUT, ToolError, print_table, processor
from distributed import Client, LocalCluster
from distributed.protocol.core import dumps
from halfline import Scene

CHUNK_RAYS = 1_000_000
PICTURE: dict[str, Any] = {"width": 960, "height": 540, "samples": 16, "up": "+Y"}

WAYS = ("1 thread", "1 worker", "2 threads", "2 workers")


def chunk_of_rays(number: int, low: list[float], high: list[float]) -> np.ndarray[Any, Any]:
    """Rays from a sphere around a box to points in it: origins and directions, (n, 6), float32."""
    random = np.random.default_rng(number)
    middle = (np.array(low) + np.array(high)) / 2.0
    radius = float(np.linalg.norm(np.array(high) - np.array(low)))
    way = random.normal(size=(CHUNK_RAYS, 3))
    origins = middle + radius * way / np.linalg.norm(way, axis=1, keepdims=True)
    targets = random.uniform(low, high, size=(CHUNK_RAYS, 3))
    return np.hstack([origins, targets - origins]).astype(np.float32)


def block_of_rays(
    numbers: np.ndarray[Any, Any], low: list[float], high: list[float]
) -> np.ndarray[Any, Any]:
    """The rays whose chunk has the number in `numbers`."""
    return chunk_of_rays(int(numbers[0]), low, high)


def hits_here(scene: Scene, chunks: int, low: list[float], high: list[float]) -> int:
    """How many of all rays hit, in this process."""
    count = 0
    for number in range(chunks):
        rays = chunk_of_rays(number, low, high)
        count += int(np.count_nonzero(scene.intersect(rays[:, :3], rays[:, 3:]).hit))
    return count


def lazy_hits(scene: Scene, chunks: int, low: list[float], high: list[float]) -> da.Array:
    """The same as a Dask array."""
    numbers = da.arange(chunks, chunks=1)
    rays = da.map_blocks(
        block_of_rays,
        numbers,
        low=low,
        high=high,
        chunks=((CHUNK_RAYS,) * chunks, (6,)),
        new_axis=[1],
        dtype=np.float32,
        meta=np.empty((0, 0), dtype=np.float32),
    )
    hits: da.Array = halfline.dask.intersect(scene, rays[:, :3], rays[:, 3:]).hit.sum()
    return hits


@contextmanager
def threads(count: int) -> Iterator[None]:
    """This process works with so many threads."""
    halfline.set_thread_count(count)
    try:
        yield
    finally:
        halfline.set_thread_count(None)


@contextmanager
def counting(client: Client) -> Iterator[list[int]]:
    """The bytes of what a client asks for meanwhile."""
    sizes: list[int] = []
    sender: Any = client
    send = sender._send_to_scheduler

    def counted(message: dict[str, Any]) -> None:
        if message["op"] == "update-graph":
            sizes.append(sum(map(len, dumps(message))))
        send(message)

    sender._send_to_scheduler = counted
    try:
        yield sizes
    finally:
        sender._send_to_scheduler = send


def seconds_of(work: Callable[[], object]) -> tuple[float, Any]:
    """How long something takes, and what it gives."""
    begin = time.perf_counter()
    result = work()
    return time.perf_counter() - begin, result


class Race:
    """All ways to do the same work, by turns."""

    def __init__(self, scene: Scene, chunks: int, clients: dict[str, Client]) -> None:
        low, high = scene.mesh.bounds.tolist()
        self.scene = scene
        self.clients = clients
        self.here = {
            "intersect": lambda: hits_here(scene, chunks, low, high),
            "render": lambda: scene.render(**PICTURE),
        }
        self.on_cluster = {
            "intersect": lambda client: client.compute(
                lazy_hits(scene, chunks, low, high)
            ).result(),
            "render": lambda client: scene.render(**PICTURE, client=client),
        }

    def turn(self, work: str, way: str) -> tuple[float, Any]:
        """Does `work` in one way."""
        if way in self.clients:
            return seconds_of(lambda: self.on_cluster[work](self.clients[way]))
        with threads(int(way[0])):
            return seconds_of(self.here[work])

    def run(self, work: str, repetitions: int) -> dict[str, float]:
        """The median seconds of each way."""
        expected = self.turn(work, WAYS[0])[1]
        seconds: dict[str, list[float]] = {way: [] for way in WAYS}
        # The first turn opens files and starts threads.
        for repetition in range(repetitions + 1):
            for way in WAYS:
                taken, result = self.turn(work, way)
                if not np.array_equal(result, expected):
                    raise ToolError(f"{work}: {way} and {WAYS[0]} give different answers")
                if repetition > 0:
                    seconds[way].append(taken)
        return {way: statistics.median(taken) for way, taken in seconds.items()}

    def graph_bytes(self, work: str) -> int:
        """What a client sends for the work."""
        client = self.clients[WAYS[-1]]
        with counting(client) as sizes:
            self.on_cluster[work](client)
        return sum(sizes)


def measure(options: argparse.Namespace) -> None:
    """Prints the table, and keeps its figures."""
    if not DRAGON.is_file():
        raise ToolError(f"{DRAGON} is not there: make data")
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        halfline.Scene(halfline.load(DRAGON)).save(folder / "dragon.hlt")
        scene = halfline.open(folder / "dragon.hlt")
        clients = {}
        for way, count in ((WAYS[1], 1), (WAYS[3], 2)):
            cluster = LocalCluster(
                n_workers=count,
                threads_per_worker=1,
                dashboard_address=":0",
                local_directory=str(folder),
            )
            stack.enter_context(cluster)
            clients[way] = stack.enter_context(Client(cluster, set_as_default=False))
        race = Race(scene, options.chunks, clients)
        amounts = {
            "intersect": (options.chunks * CHUNK_RAYS, "Mrays/s"),
            "render": (sum((scene.render(**PICTURE).rays or {}).values()), "Mrays/s"),
        }
        rows = [["", *WAYS, "1 worker : 1 thread", "2 workers : 2 threads", "bytes sent"]]
        figures: dict[str, Any] = {"processor": processor(), "repetitions": options.repetitions}
        for work, (amount, unit) in amounts.items():
            seconds = race.run(work, options.repetitions)
            rates = {way: amount / taken / 1e6 for way, taken in seconds.items()}
            sent = race.graph_bytes(work)
            ratios = [rates[WAYS[1]] / rates[WAYS[0]], rates[WAYS[3]] / rates[WAYS[2]]]
            cells = [f"{rates[way]:.3f}" for way in WAYS] + [f"{ratio:.2f}" for ratio in ratios]
            rows.append([f"{work}, {unit}", *cells, f"{sent:,}"])
            figures[work] = {"rays": amount, "seconds": seconds, "bytes_sent": sent}
    title = f"Dragon, {processor()}, medians of {options.repetitions}"
    print_table(title, rows)
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "dask.json").write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


def main() -> int:
    """The whole comparison."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--repetitions", type=int, default=5, help="turns of each way")
    parser.add_argument("--chunks", type=int, default=8, help=f"of {CHUNK_RAYS:,} rays")
    try:
        measure(parser.parse_args())
    except (ToolError, OSError) as error:
        print(f"bench dask: {error}", file=sys.stderr)
        return 1
    return 0
