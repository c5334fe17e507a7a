"""The package as such: its names, its types, its start."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import halfline
import pytest
from children import PATIENCE_SECONDS, interrupt, wait_until_it_listens
from conftest import Halfline, Judged
from halfline import _command


def test_every_name_is_there() -> None:
    for name in halfline.__all__:
        assert getattr(halfline, name) is not None
        assert name in dir(halfline)
    with pytest.raises(AttributeError, match="module 'halfline' has no attribute 'Sceen'"):
        getattr(halfline, "Sceen")  # noqa: B009
    assert halfline.__version__ == "0.1.0"
    assert (Path(halfline.__file__).parent / "py.typed").is_file()


def test_every_public_name_is_explained() -> None:
    for owner in (halfline.Mesh, halfline.Scene, halfline.Hits, halfline.AllHits):
        for name, member in vars(owner).items():
            if not name.startswith("_") and (callable(member) or isinstance(member, property)):
                assert member.__doc__, (owner, name)
    for name in halfline.__all__:
        assert name == "__version__" or getattr(halfline, name).__doc__


def test_the_command_starts_without_numpy() -> None:
    code = "import halfline._command, sys; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
    assert callable(_command.main)


def command(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Runs the command that comes with the package."""
    return subprocess.run(
        [sys.executable, "-m", "halfline", *arguments],
        capture_output=True,
        text=True,
        timeout=PATIENCE_SECONDS,
        check=False,
    )


@pytest.mark.parametrize(
    "arguments", [["--version"], ["--help"], ["info", "--help"], ["info"], ["info", "nowhere.ply"]]
)
def test_the_command_is_the_same_program(halfline_command: Halfline, arguments: list[str]) -> None:
    expected, found = halfline_command.run(*arguments), command(*arguments)
    assert (found.returncode, found.stdout, found.stderr) == (
        expected.returncode,
        expected.stdout,
        expected.stderr,
    )


def test_the_command_does_its_work(judged: Judged, tmp_path: Path) -> None:
    picture = tmp_path / "picture.png"
    done = command("render", judged.path, "-o", picture, "--resolution", "40,30")
    assert done.returncode == 0, done.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_the_command_can_be_interrupted(judged: Judged, tmp_path: Path) -> None:
    size = ["--resolution", "2000,2000", "--samples", "4096"]
    arguments: list[str | Path] = ["render", judged.path, "-o", tmp_path / "picture.png", *size]
    with subprocess.Popen(
        [sys.executable, "-m", "halfline", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        wait_until_it_listens(process)
        time.sleep(0.5)
        _, stderr = interrupt(process)
    assert process.returncode == 130
    assert stderr == "halfline: interrupted\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["dask", "open3d", "trimesh"])
def test_a_submodule_is_there_when_it_is_asked_for(name: str) -> None:
    code = f"import halfline; print(halfline.{name}.__name__, {name!r} in dir(halfline))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == f"halfline.{name} True\n"
