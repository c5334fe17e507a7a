"""The package as such: its names, its types, its start."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import halfline
import pytest
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
