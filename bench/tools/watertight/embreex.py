"""Casts rays with trimesh and embreex in a process of its own; run by `make bench-watertight`.

`python bench tools.watertight.embreex MESH RAYS.npy HITS.npz` writes `hit` (n,) and `crossings`
(n,), of trimesh's `intersects_first` and `intersects_id`, and `point` (n, 3), of
`intersects_location`, NaN for a miss. Embree's scene is made as trimesh makes it; embreex then sets
Embree's robust flag.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import embreex
import numpy as np
import trimesh
from common.process import Clock


def main() -> None:
    """Loads, casts, writes, and prints what did it and how long the rays took."""
    mesh_path, rays_path, hits_path = map(Path, sys.argv[1:])
    mesh: Any = trimesh.load_mesh(mesh_path, process=False)
    rays = np.load(rays_path)
    origins, directions = rays[:, :3].copy(), rays[:, 3:].copy()

    with Clock() as closest:
        hit = mesh.ray.intersects_first(origins, directions) >= 0
    with Clock() as all_hits:
        _, ray_of_hit = mesh.ray.intersects_id(origins, directions, multiple_hits=True)
    crossings = np.bincount(ray_of_hit, minlength=len(rays))
    point = np.full((len(rays), 3), np.nan)
    points, ray_of_point, _ = mesh.ray.intersects_location(origins, directions, multiple_hits=False)
    point[ray_of_point] = points

    np.savez(hits_path, hit=hit, crossings=crossings, point=point)
    tool = f"trimesh {trimesh.__version__} + embreex {embreex.__version__}, robust"
    print(json.dumps({"tool": tool, "closest": closest.seconds, "all": all_hits.seconds}))
