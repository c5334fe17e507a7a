"""Pictures drawn by the workers of a cluster, in bands of rows."""

from __future__ import annotations

import asyncio
import contextlib
import os
import time
import uuid
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from queue import SimpleQueue
from typing import Any

from distributed import Client, Future, Worker
from distributed.scheduler import KilledWorker

from halfline._image import Image
from halfline._native import Rendering, RenderSettings
from halfline._progress import Progress, Report, reporting
from halfline._scene import Scene
from halfline.dask._publish import check_client, nothing, publish_tree
from halfline.dask._trees import MissingTreeError, Tree, picture_of, this_worker, tree_of

# Rows that halfline traces together.
_BLOCK = 4

# Bands for each thread of the cluster, so that none waits long for the last ones.
_BANDS_PER_THREAD = 8

# A band has no more rays from the eye than this, so that progress shows and little is lost when a
# worker dies; less would be as much work for the scheduler as for the worker.
_RAYS_PER_BAND = 1 << 19

# Nor more pixels, of some forty bytes each in the answer.
_PIXELS_PER_BAND = 1 << 17

# A band is given up after it failed so often for reasons that lie with workers. Dask itself tries
# three more workers each time (distributed.scheduler.allowed-failures).
_ATTEMPTS = 4

# How often a caller that waits looks for what has arrived.
_TICK_SECONDS = 0.01


def render(
    scene: Scene | str | os.PathLike[str],
    *,
    client: Client,
    progress: Progress = None,
    **settings: Any,
) -> Image:
    """Draws a picture on a cluster: the same to the bit as `Scene.render` gives by itself.

    Each worker opens the tree's file by itself, once; machines that do not see it get it first, as
    `publish` has it. The picture is traced in bands of rows, of which there are several for each
    thread; a band whose worker dies is traced by another one. The workers must be of the same
    system and kind of processor as each other for the last bits to be the same.

    Args:
        scene: A scene from a file, or the path of a tree file.
        client: The cluster's.
        progress: True for a bar, or a callable `progress(stage, done, total)` with the stage
            "trace" and pixels, called as bands arrive.
        **settings: As for `Scene.render`.

    Returns:
        As `Scene.render`.

    Raises:
        TypeError: As `Scene.render`, and for what is no synchronous client.
        ValueError: As `Scene.render`, and for a scene in memory: save it and open the file.
        OSError: If the file cannot be read.
        FormatError: If it is no tree, or damaged.
        RuntimeError: If workers have no halfline or another version, or die again and again.
        KeyboardInterrupt: On Ctrl-C, in less than half a second; the cluster works on no band then.
    """
    check_client(client)
    wanted = RenderSettings(**settings)
    with reporting(progress) as report:
        parts = trace(client, scene, wanted, report)
        return Image._of(Rendering.assemble(wanted, parts))


def trace(
    client: Client,
    scene: Scene | str | os.PathLike[str],
    settings: RenderSettings,
    report: Report | None,
    check: Callable[[], object] = nothing,
) -> list[bytes]:
    """All rows of a picture, for `Rendering.assemble`.

    Args:
        client: The cluster's.
        scene: From a file, or the file's path.
        settings: The picture's.
        report: Called with "trace", the pixels that have arrived, and all of them.
        check: Called every few milliseconds; what it raises ends the work.
    """
    tree, scene = tree_of(scene)
    publish_tree(client, tree, check)
    job = _Job(client, tree, settings.to_json())
    width, height = settings.size
    done = 0
    parts: list[bytes] = []
    try:
        job.submit(bands(settings.samples, width, height, _thread_count(client)))
        if report is not None:
            report("trace", done, width * height)
        while len(parts) < job.band_count:
            check()
            arrived = job.arrived()
            for (first, end), part in arrived:
                parts.append(part)
                done += (end - first) * width
            if arrived and report is not None:
                report("trace", done, width * height)
            if not arrived:
                time.sleep(_TICK_SECONDS)
    except BaseException:
        job.cancel()
        raise
    return parts


def bands(samples: int, width: int, height: int, threads: int) -> list[tuple[int, int]]:
    """The rows of a picture cut into bands: first row and end of each."""
    wanted = max(
        _BANDS_PER_THREAD * threads,
        width * height * samples // _RAYS_PER_BAND,
        width * height // _PIXELS_PER_BAND,
    )
    rows = max(height // wanted // _BLOCK, 1) * _BLOCK
    return [(first, min(first + rows, height)) for first in range(0, height, rows)]


def _thread_count(client: Client) -> int:
    return sum(client.nthreads().values()) or 1


class _Job:
    """The bands of one picture on a cluster, each of which arrives once."""

    def __init__(self, client: Client, tree: Tree, settings: str) -> None:
        self.band_count = 0
        self._client = client
        self._tree = tree
        self._settings = settings
        # Not even the same picture again may meet what was cancelled of this one.
        self._name = f"halfline-render-{uuid.uuid4().hex}"
        self._pending: dict[Future[bytes], tuple[int, int]] = {}
        self._attempts: dict[tuple[int, int], int] = {}
        # What has come of a future: rows, or an exception. Not `as_completed`, which never yields a
        # future whose result was lost with its worker and cannot be had again.
        self._arrived: SimpleQueue[tuple[Future[bytes], bytes | BaseException]] = SimpleQueue()

    def submit(self, bands: Sequence[tuple[int, int]]) -> None:
        """Has bands traced."""
        for band in bands:
            self._attempts[band] = self._attempts.get(band, -1) + 1
        self.band_count = len(self._attempts)
        firsts, ends = zip(*bands, strict=True)
        # A tuple is of a group that Dask knows by its name.
        keys = [(self._name, first, self._attempts[first, end]) for first, end in bands]
        futures = self._client.map(
            _draw, firsts, ends, key=keys, pure=False, tree=self._tree, settings=self._settings
        )
        self._pending.update(zip(futures, bands, strict=True))
        loop: Any = self._client.loop
        for future in futures:
            loop.add_callback(self._follow, future)

    async def _follow(self, future: Future[bytes]) -> None:
        """Fetches what comes of a future; on the client's event loop."""
        result: bytes | BaseException
        try:
            result = await self._client.gather(future, asynchronous=True)
        except (Exception, asyncio.CancelledError) as error:
            result = error
        self._arrived.put((future, result))

    def arrived(self) -> list[tuple[tuple[int, int], bytes]]:
        """What has arrived since the last time; has what failed with a worker traced again."""
        arrived: list[tuple[tuple[int, int], bytes]] = []
        again = []
        while not self._arrived.empty():
            future, result = self._arrived.get()
            band = self._pending.pop(future)
            future.release()
            if isinstance(result, bytes) and result:
                arrived.append((band, result))
                continue
            self._check_attempts(band, result)
            again.append(band)
        if again:
            publish_tree(self._client, self._tree, nothing)
            self.submit(again)
        return arrived

    def _check_attempts(self, band: tuple[int, int], error: object) -> None:
        """Raises the error of a band, unless it lies with a worker and was not there too often."""
        is_workers = isinstance(error, (KilledWorker, CancelledError, MissingTreeError))
        if isinstance(error, BaseException) and not is_workers:
            raise error
        if self._attempts[band] + 1 < _ATTEMPTS:
            return
        if isinstance(error, MissingTreeError):
            raise error
        first, end = band
        raise RuntimeError(
            f"rows {first} to {end - 1}: workers died or were restarted again and again: {error}"
        )

    def cancel(self) -> None:
        """Ends the work on what has not arrived."""
        with contextlib.suppress(Exception):
            self._client.cancel(list(self._pending))
        self._pending.clear()


class _Unwanted(Exception):  # noqa: N818 - nobody sees it
    """Nobody waits for these rows any more."""


def _draw(first: int, end: int, *, tree: Tree, settings: str) -> bytes:
    """The task: rows of a picture; none if it was cancelled meanwhile."""
    picture = picture_of(tree, settings)
    worker = this_worker()
    if worker is None:
        return picture.trace_rows(first, end)
    try:
        return picture.trace_rows(first, end, _stop_if_unwanted(worker))
    except _Unwanted:
        return b""


def _stop_if_unwanted(worker: Worker) -> Report:
    """What ends this thread's task soon after it was cancelled; Dask would let it go on."""
    key = worker.get_current_task()

    def look(stage: str, done: int, total: int) -> None:
        task = worker.state.tasks.get(key)
        if task is None or task.state == "cancelled":
            raise _Unwanted

    return look
