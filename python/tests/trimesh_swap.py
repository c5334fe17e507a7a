"""A plugin of pytest that puts halfline's intersector in the place of trimesh's.

It writes what became of each test, and how many questions the test asked halfline, to the file that
HALFLINE_SWAP_REPORT names. Where HALFLINE_SWAP is "embree", trimesh's intersector in pure Python
stays, and trimesh takes halfline's for the one by Embree only.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from types import ModuleType

import pytest
import trimesh
from halfline import Scene
from halfline.trimesh import RayMeshIntersector

_questions = 0
_report: dict[str, dict[str, object]] = {}


class Counted(RayMeshIntersector):
    """Counts what it is asked."""

    @property
    def scene(self) -> Scene:
        """Every question begins here."""
        global _questions
        _questions += 1
        return super().scene


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
