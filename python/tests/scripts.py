"""Scripts that tests run in processes of their own: what they do must not reach the other tests."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from children import PATIENCE_SECONDS

# A scene of some size and many rays, the same in every script.
PREAMBLE = """
import os, signal, sys, threading, time
import numpy as np
import halfline

def rays(count):
    random = np.random.default_rng(0)
    directions = random.normal(size=(count, 3)).astype(np.float32)
    return np.float32([0.0, 0.0, 0.1]), directions

def make_scene(triangles=20_000):
    return halfline.Scene(halfline.generate("scan", triangles))
"""


def environment(**variables: str) -> dict[str, str]:
    """The environment of a script."""
    return {**os.environ, "OPENBLAS_NUM_THREADS": "1", **variables}


def run(folder: Path, script: str, **variables: str) -> tuple[str, str]:
    """Runs a script to its end, and returns what it wrote on stdout and stderr."""
    path = folder / "script.py"
    path.write_text(PREAMBLE + script, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, path],
        capture_output=True,
        text=True,
        timeout=PATIENCE_SECONDS,
        check=False,
        env=environment(**variables),
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout, done.stderr
