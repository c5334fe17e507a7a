"""A plugin of pytest that puts halfline's intersector and proximity in the place of trimesh's.

It writes what became of each test, and how many questions the test asked halfline, to the file that
HALFLINE_SWAP_REPORT names. Where HALFLINE_SWAP is "embree", trimesh's intersector in pure Python
stays, and trimesh takes halfline's for the one by Embree only.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import trimesh
from halfline import Scene
from halfline.trimesh import ProximityQuery, RayMeshIntersector, closest_point, signed_distance
from numpy.typing import ArrayLike

_questions = 0
_report: dict[str, dict[str, object]] = {}


def _count() -> None:
    global _questions
    _questions += 1


class Counted(RayMeshIntersector):
    """Counts what it is asked."""

    @property
    def scene(self) -> Scene:
        """Every question begins here."""
        _count()
        return super().scene


class CountedQuery(ProximityQuery):
    """Counts what it is asked."""

    def on_surface(self, points: ArrayLike) -> Any:
        """One of three questions."""
        _count()
        return super().on_surface(points)

    def vertex(self, points: ArrayLike) -> Any:
        """One of three questions."""
        _count()
        return super().vertex(points)

    def signed_distance(self, points: ArrayLike) -> Any:
        """One of three questions."""
        _count()
        return super().signed_distance(points)


def counted(ask: Callable[..., Any]) -> Callable[..., Any]:
    """A function that counts how often it is called."""

    def asked(*arguments: Any, **options: Any) -> Any:
        _count()
        return ask(*arguments, **options)

    return asked


def pytest_configure() -> None:
    """Swaps before any test is imported."""
    # Tests that are for Embree alone ask for the version of its bindings.
    bindings = ModuleType("embreex")
    vars(bindings)["__version__"] = "4.4.0"
    embree = ModuleType("trimesh.ray.ray_pyembree")
    vars(embree)["RayMeshIntersector"] = Counted
    sys.modules.update({bindings.__name__: bindings, embree.__name__: embree})
    trimesh.ray.ray_pyembree = embree
    trimesh.ray.has_embree = True
    trimesh.proximity.ProximityQuery = CountedQuery
    trimesh.proximity.closest_point = counted(closest_point)
    trimesh.proximity.signed_distance = counted(signed_distance)
    if os.environ["HALFLINE_SWAP"] != "embree":
        trimesh.ray.ray_triangle.RayMeshIntersector = Counted


def pytest_runtest_setup() -> None:
    """Counts anew for each test."""
    global _questions
    _questions = 0


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Keeps what became of a test; what is skipped never gets to be called."""
    if report.when == "call" or report.outcome != "passed":
        _report[report.nodeid] = {"outcome": report.outcome, "questions": _questions}


def pytest_sessionfinish() -> None:
    """Writes the report."""
    Path(os.environ["HALFLINE_SWAP_REPORT"]).write_text(json.dumps(_report), encoding="utf-8")
