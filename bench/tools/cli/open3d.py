"""Measures Open3D in a process of its own; run by `make bench-cli`.

`python bench tools.cli.open3d MESH THREADS NAME=RAYS.npy ...` prints one JSON object. Without rays
only the older reader, `open3d.io.read_triangle_mesh`, is measured; otherwise the newer one,
`open3d.t.io.read_triangle_mesh`, whose mesh the ray caster takes.
"""

from __future__ import annotations

import sys

import numpy as np
import open3d
from common.process import Clock, resident_bytes
from tools.cli.report import Report


def main() -> None:
    """Loads, builds, traces, reports."""
    mesh_path, threads, rays_of = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
    report = Report("open3d", f"Open3D {open3d.__version__}", threads)

    if not rays_of:
        with Clock() as load:
            legacy = open3d.io.read_triangle_mesh(mesh_path)
        report.load_seconds = load.seconds
        report.triangles = len(legacy.triangles)
        report.print()
        return

    with Clock() as load:
        mesh = open3d.t.io.read_triangle_mesh(mesh_path)
    report.load_seconds = load.seconds
    report.triangles = len(mesh.triangle.indices)

    before = resident_bytes()
    with Clock() as build:
        scene = open3d.t.geometry.RaycastingScene(nthreads=threads)
        scene.add_triangles(mesh)
        # The tree is built when the first ray asks for it.
        scene.cast_rays(open3d.core.Tensor([[0, 0, 0, 0, 0, 1]], dtype=open3d.core.float32))
    report.build_seconds = build.seconds
    report.tree_bytes = resident_bytes() - before

    for name, path in (argument.split("=", 1) for argument in rays_of):
        rays = open3d.core.Tensor(np.load(path).astype(np.float32))
        with Clock() as trace:
            answer = scene.cast_rays(rays, nthreads=threads)
        faces = answer["primitive_ids"].numpy().astype(np.int64)
        faces[faces == scene.INVALID_ID] = -1
        report.add_trace(name, trace.seconds, faces, path)
    report.print()
