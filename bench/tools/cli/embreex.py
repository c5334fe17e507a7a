"""Measures trimesh with embreex in a process of its own; run by `make bench-cli`.

`python bench tools.cli.embreex MESH THREADS NAME=RAYS.npy ...` prints one JSON object. Embree is
called through trimesh's own `intersects_first`, which works on one thread whatever THREADS is.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import embreex
import numpy as np
import trimesh
from common.process import Clock, resident_bytes
from tools.cli.report import Report


def main() -> None:
    """Loads, builds, traces, reports."""
    mesh_path, _, rays_of = Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
    report = Report(
        "embreex", f"trimesh {trimesh.__version__} + embreex {embreex.__version__}", threads=1
    )

    with Clock() as load:
        # Without processing: trimesh would merge equal vertices, which nobody else does.
        mesh: Any = trimesh.load_mesh(mesh_path, process=False)
    report.load_seconds = load.seconds
    report.triangles = len(mesh.faces)

    before = resident_bytes()
    with Clock() as build:
        # Embree builds its tree when the first ray asks for it.
        mesh.ray.intersects_first(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    report.build_seconds = build.seconds
    report.tree_bytes = resident_bytes() - before

    for name, path in (argument.split("=", 1) for argument in rays_of):
        rays = np.load(path)
        origins, directions = rays[:, :3].copy(), rays[:, 3:].copy()
        with Clock() as trace:
            faces = mesh.ray.intersects_first(origins, directions)
        report.add_trace(name, trace.seconds, np.asarray(faces, dtype=np.int64), path)
    report.print()
