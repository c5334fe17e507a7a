"""Casts rays with Open3D in a process of its own; run by `make bench-watertight`.

`python bench tools.watertight.open3d MESH RAYS.npy HITS.npz` writes `hit` (n,) and `crossings`
(n,), of `cast_rays` and `count_intersections`, and `point` (n, 3), the ray at the t of `cast_rays`,
computed in double precision, NaN for a miss. Open3D takes rays and vertices in single precision
only, and makes its Embree scene with the robust flag.
"""

from __future__ import annotations

import json
import sys

import numpy as np
import open3d
from common.process import Clock


def main() -> None:
    """Loads, casts, writes, and prints what did it and how long the rays took."""
    mesh_path, rays_path, hits_path = sys.argv[1:]
    mesh = open3d.t.io.read_triangle_mesh(mesh_path)
    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        mesh.vertex.positions.to(open3d.core.float32), mesh.triangle.indices.to(open3d.core.uint32)
    )
    rays = np.load(rays_path).astype(np.float32)
    tensor = open3d.core.Tensor(rays)
    # The tree is built when the first ray asks for it.
    scene.cast_rays(tensor[:1])

    with Clock() as closest:
        t = scene.cast_rays(tensor)["t_hit"].numpy()
    with Clock() as all_hits:
        crossings = scene.count_intersections(tensor).numpy()
    hit = np.isfinite(t)
    exact = rays.astype(np.float64)
    with np.errstate(invalid="ignore"):
        point = exact[:, :3] + t[:, None].astype(np.float64) * exact[:, 3:]
    point[~hit] = np.nan

    np.savez(hits_path, hit=hit, crossings=crossings, point=point)
    tool = f"Open3D {open3d.__version__}, robust"
    print(json.dumps({"tool": tool, "closest": closest.seconds, "all": all_hits.seconds}))
