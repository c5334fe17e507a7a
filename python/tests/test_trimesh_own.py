"""trimesh's own tests of rays and proximity, with halfline in the place of trimesh's.

All of them pass but one, which asserts that what is farther by a billionth is nearest. They are
taken from the newest source distribution that has them, which that of 5.2.0 has not, and run with
the trimesh of the lock file. The distribution leaves out the module `generic` that they import and
the models that it loads: trimesh_generic.py stands in for both, and for what they use of shapely.

Left out are tests that cast rays or look for what is near by the way, but need packages or models
beyond that: test_extrude.py (shapely), test_registration.py::RegistrationTest::test_nricp, and the
walks through all models in test_mesh.py and test_mutate.py.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from conftest import ROOT

VERSION = "5.1.1"
SHA256 = "56070be44cd97ac87544c9bd3da4b7a298c6f728e83183aeb1f3524d673d5fac"

HERE = Path(__file__).resolve().parent

# Every test of these files runs, and of other files those that ask halfline.
WHOLE = ("test_proximity.py", "test_ray.py", "test_ray_upstream.py", "test_thickness.py")
PARTS = (
    "test_primitives.py::test_cyl_buffer",
    "test_primitives.py::test_sample",
    "test_registration.py::RegistrationTest::test_icp_mesh",
    "test_registration.py::RegistrationTest::test_mesh",
    "test_registration.py::RegistrationTest::test_query_from_mesh",
    "test_remesh.py::SubDivideTest::test_loop_correct",
    "test_sample.py::SampleTest::test_sample",
    "test_sample.py::SampleTest::test_sample_volume",
    "test_util.py::test_inside",
    "test_voxel.py::VoxelGridTest::test_local",
)

PROXIMITY = "test_proximity.py::NearestTest"

# Faces whose squared distances differ by less than 1e-8 are equally near for trimesh; it then takes
# that whose normal goes towards the point, and here that is the farther one.
FARTHER = f"{PROXIMITY}::test_returns_correct_point_in_ambiguous_cases"

# Those that ask trimesh's search for candidates, or that by brute force, and nothing else.
NOT_SWAPPED = (
    f"{PROXIMITY}::test_candidates",
    f"{PROXIMITY}::test_candidates_empty",
    f"{PROXIMITY}::test_candidates_rtree_versions",
    f"{PROXIMITY}::test_naive",
)

# Those that ask for trimesh's intersector in pure Python, whatever else there is.
PURE_PYTHON = ("test_ray.py::test_contain_single", "test_ray.py::test_on_vertex")


class Result(NamedTuple):
    """What became of a test."""

    outcome: str
    questions: int


@pytest.fixture(scope="module")
def suite(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with trimesh's tests, and what they import."""
    folder = tmp_path_factory.mktemp("trimesh")
    with tarfile.open(distribution()) as archive:
        for name in {test.split("::")[0] for test in (*WHOLE, *PARTS)}:
            member = archive.extractfile(f"trimesh-{VERSION}/tests/{name}")
            assert member is not None
            (folder / name).write_bytes(member.read())
    shutil.copy2(HERE / "trimesh_generic.py", folder / "generic.py")
    (folder / "pytest.ini").write_text("[pytest]\n", encoding="utf-8")
    return folder


def distribution() -> Path:
    """The source distribution, downloaded once."""
    path = ROOT / "data" / "sdist" / f"trimesh-{VERSION}.tar.gz"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as beside:
            wanted = Path(beside) / "requirement.txt"
            wanted.write_text(f"trimesh=={VERSION} --hash=sha256:{SHA256}\n", encoding="utf-8")
            pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "download"]
            options = ["--require-hashes", "--no-deps", "--no-binary", "trimesh", "--quiet"]
            subprocess.run([*pip, *options, "--dest", beside, "-r", wanted], check=True)
            (Path(beside) / path.name).replace(path)
    assert hashlib.sha256(path.read_bytes()).hexdigest() == SHA256
    return path


def run(suite: Path, swap: str, *tests: str) -> dict[str, Result]:
    """Runs tests with halfline in the place of trimesh's intersectors and queries."""
    report = suite / f"{swap}.json"
    report.unlink(missing_ok=True)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "trimesh_swap", *tests],
        cwd=suite,
        env={
            **os.environ,
            "PYTHONPATH": str(HERE),
            "HALFLINE_SWAP": swap,
            "HALFLINE_SWAP_REPORT": str(report),
        },
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert report.is_file(), done.stdout + done.stderr
    found: dict[str, dict[str, Any]] = json.loads(report.read_text(encoding="utf-8"))
    return {test: Result(**result) for test, result in found.items()}


def named_in(path: Path) -> set[str]:
    """The tests that a file has, whatever pytest makes of them."""
    found = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test"):
            found.add(f"{path.name}::{node.name}")
        if isinstance(node, ast.ClassDef):
            found |= {
                f"{path.name}::{node.name}::{method.name}"
                for method in node.body
                if isinstance(method, ast.FunctionDef) and method.name.startswith("test")
            }
    return found


def passes(results: dict[str, Result], silent: set[str]) -> None:
    """Every test passed but one, and every one asked halfline but the silent ones."""
    failed = {test for test, result in results.items() if result.outcome != "passed"}
    assert failed == {FARTHER}
    assert {test for test, result in results.items() if result.questions == 0} == silent


def test_trimesh_passes_its_tests_with_this_in_its_place(suite: Path) -> None:
    results = run(suite, "both", *WHOLE, *PARTS)
    expected = set(PARTS).union(*(named_in(suite / name) for name in WHOLE))
    assert len(expected) == 57
    assert set(results) == expected
    passes(results, set(NOT_SWAPPED))


def test_trimesh_passes_its_tests_with_both_intersectors_side_by_side(suite: Path) -> None:
    passes(run(suite, "embree", *WHOLE, *PARTS), {*NOT_SWAPPED, *PURE_PYTHON})
