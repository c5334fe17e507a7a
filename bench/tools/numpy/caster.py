"""What a process does that measures a Python library which casts rays; run by `make bench-numpy`.

`python bench tools.numpy.NAME MESH.npz THREADS RAYS.npz` prints one JSON object. Every library
does the same: it builds from arrays, casts the same single-precision rays, and is then interrupted
by Ctrl-C in a long call, while another thread counts how often it gets its turn.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import threading
import time
from abc import ABC, abstractmethod
from statistics import median
from typing import Any

import numpy as np
from common.process import Clock, resident_bytes

Array = np.ndarray[Any, Any]

REPETITIONS = 3
# A call to be interrupted takes about so long, and gets its SIGINT after so long.
CALL_SECONDS = 3.0
INTERRUPTED_AFTER = 0.5
TICK_SECONDS = 0.001


# Its clock is that of all processes.
SENDER = """
import os, signal, sys, time
print("ready", flush=True)
time.sleep(float(sys.argv[2]))
print(time.perf_counter(), flush=True)
os.kill(int(sys.argv[1]), signal.SIGINT)
"""


class Caster(ABC):
    """A library that casts rays at one mesh."""

    tool: str
    threads: int

    @abstractmethod
    def build(self, vertices: Array, faces: Array) -> None:
        """Makes everything that the first ray needs."""

    @abstractmethod
    def closest(self, origins: Array, directions: Array) -> Array:
        """The faces that rays hit first, -1 for none."""

    @abstractmethod
    def all_hits(self, origins: Array, directions: Array) -> int:
        """How many hits all rays have together, each of which was found."""

    @abstractmethod
    def counts(self, origins: Array, directions: Array) -> Array:
        """How many hits each ray has."""


class Ticker(threading.Thread):
    """Counts how often a thread that sleeps a millisecond at a time wakes up."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.ticks = 0
        self.start()

    def run(self) -> None:
        """Counts for ever."""
        while True:
            time.sleep(TICK_SECONDS)
            self.ticks += 1

    def rate_of(self, seconds: float, ticks_before: int) -> float:
        """Wake-ups a second since then."""
        return (self.ticks - ticks_before) / seconds


def seconds_of(cast: Any, rays: tuple[Array, Array]) -> tuple[float, Any]:
    """The median time of some calls, and what the last of them said."""
    times, answer = [], None
    for _ in range(REPETITIONS):
        with Clock() as clock:
            answer = cast(*rays)
        times.append(clock.seconds)
    return median(times), answer


def long_call(caster: Caster, rays: tuple[Array, Array], seconds: float) -> dict[str, float]:
    """Interrupts a call of some seconds, and tells how soon it ended."""
    times = max(1, round(CALL_SECONDS / seconds))
    rays = (np.tile(rays[0], (times, 1)), np.tile(rays[1], (times, 1)))
    ticker = Ticker()
    time.sleep(0.2)
    before = ticker.ticks
    time.sleep(0.5)
    idle = ticker.rate_of(0.5, before)
    with Clock() as whole:
        before = ticker.ticks
        caster.closest(*rays)
    busy = ticker.rate_of(whole.seconds, before)

    # From outside, as the terminal does it: in this process a thread may have to wait for its turn.
    sender = subprocess.Popen(
        [sys.executable, "-c", SENDER, str(os.getpid()), str(INTERRUPTED_AFTER)],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert sender.stdout is not None
    sender.stdout.readline()
    try:
        caster.closest(*rays)
        time.sleep(INTERRUPTED_AFTER + CALL_SECONDS)
    except KeyboardInterrupt:
        ended = time.perf_counter()
    else:
        raise SystemExit("the call was not interrupted")
    latency = ended - float(sender.communicate()[0])
    caster.closest(rays[0][:10], rays[1][:10])
    return {
        "call_seconds": whole.seconds,
        "interrupt_seconds": latency,
        "ticks_idle": idle,
        "ticks_busy": busy,
    }


def measure(caster: Caster) -> None:
    """Measures everything, and prints it."""
    mesh, rays = np.load(sys.argv[1]), np.load(sys.argv[3])
    vertices, faces = mesh["vertices"], mesh["faces"]
    before = resident_bytes()
    with Clock() as build:
        caster.build(vertices, faces)
    report: dict[str, Any] = {
        "tool": caster.tool,
        "threads": caster.threads,
        "build_seconds": build.seconds,
        "scene_bytes": resident_bytes() - before,
    }
    for kind in ("coherent", "incoherent"):
        cast = (rays[f"{kind}_origins"], rays[f"{kind}_directions"])
        report[f"{kind}_seconds"], found = seconds_of(caster.closest, cast)
        report[f"{kind}_rays"] = len(cast[0])
        report[f"{kind}_hits"] = int(np.count_nonzero(found >= 0))
    many = (rays["many_origins"], rays["many_directions"])
    report["many_rays"] = len(many[0])
    report["all_seconds"], report["all_hits"] = seconds_of(caster.all_hits, many)
    report["counts_seconds"], counts = seconds_of(caster.counts, many)
    report["counted"] = int(counts.sum())
    report["peak_bytes"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    cast = (rays["incoherent_origins"], rays["incoherent_directions"])
    report |= long_call(caster, cast, report["incoherent_seconds"])
    print(json.dumps(report))
