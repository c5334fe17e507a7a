"""What a process does that measures a library of closest points; run by `make bench-nearest`.

`python bench tools.nearest.NAME MESH.npz THREADS POINTS.npz ANSWERS.npz` prints one JSON object.
Every library does the same: it builds from arrays, and is then asked about points of several kinds,
as many of each as it answers in a second or so, but at least some hundred; the best of several
calls counts. Its answers about the first points of each kind go to ANSWERS.npz, to be compared.
Processes keep to as many cores as there are to be threads.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
from common.process import Clock, resident_bytes

Array = np.ndarray[Any, Any]

REPETITIONS = 3
CALL_SECONDS = 1.0
# What is tried first, to know how many points take so long.
FEW = 100
# Answers that are compared.
COMPARED = 20_000


class Finder(ABC):
    """A library that finds what is nearest."""

    tool: str

    @abstractmethod
    def build(self, vertices: Array, faces: Array) -> None:
        """Makes everything that the first point needs."""

    @abstractmethod
    def distances(self, points: Array) -> Array:
        """How far points are from the surface."""

    def windings(self, points: Array) -> Array:
        """Winding numbers."""
        raise NotImplementedError

    def contains(self, points: Array) -> Array:
        """Which points are inside."""
        raise NotImplementedError

    def approximate_windings(self, points: Array) -> Array:
        """Winding numbers by a method that says it is approximate."""
        raise NotImplementedError


def rate_of(ask: Callable[[Array], Array], points: Array) -> tuple[float, Array]:
    """Points a second, and the answers about as many as were asked."""
    start = time.perf_counter()
    ask(points[:FEW])
    first = (time.perf_counter() - start) / FEW
    count = min(len(points), max(FEW, int(CALL_SECONDS / first)))
    best, answers = float("inf"), np.empty(0)
    for _ in range(REPETITIONS):
        start = time.perf_counter()
        answers = ask(points[:count])
        best = min(best, time.perf_counter() - start)
    return count / best, np.asarray(answers[:COMPARED], dtype=np.float64)


def measure(finder: Finder) -> None:
    """Measures everything, and prints it."""
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[-int(sys.argv[2]) :])
    mesh, points = np.load(sys.argv[1]), np.load(sys.argv[3])
    before = resident_bytes()
    with Clock() as build:
        finder.build(mesh["vertices"], mesh["faces"])
    report: dict[str, Any] = {
        "tool": finder.tool,
        "build_seconds": build.seconds,
        "scene_bytes": resident_bytes() - before,
        "rates": {},
    }
    answers: dict[str, Any] = {}
    questions = {
        "distance": finder.distances,
        "winding": finder.windings,
        "contains": finder.contains,
        "approximate winding": finder.approximate_windings,
    }
    for question, ask in questions.items():
        kinds = [kind for kind in points.files if question == "distance" or kind == "box"]
        for kind in kinds:
            before = resident_bytes()
            try:
                rate, found = rate_of(ask, points[kind])
            except NotImplementedError:
                continue
            report["rates"][f"{question}, {kind}"] = rate
            report.setdefault("bytes_beyond", {})[question] = resident_bytes() - before
            answers[f"{question}, {kind}"] = found
    np.savez(sys.argv[4], **answers)
    report["peak_bytes"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(json.dumps(report))
