"""Images against tiles, and rays from a surface against rays from beside it, from NumPy.

Run by `make bench-shapes`. The same camera rays come as one row, as an image of shape (height,
width, 3), and tile by tile of 8 by 8: an image should cost no more than tiles. The same hemisphere
rays start where `Hits.origins_towards` puts them, a few roundings above the surface, and 2e-5 of
the scene above it: the first should cost little more. One thread; the least of several turns, in
which all forms take turns; writes bench/out/shapes.json.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Mapping
from functools import partial

import halfline
import numpy as np
from common.harness import DRAGON, OUT, ROOT, print_table, processor
from numpy.typing import NDArray

Array = NDArray[np.float64]

FILES = {"bunny": ROOT / "data" / "stl-models" / "objects" / "bunny.bin.stl", "dragon": DRAGON}
GENERATED = {"hall": 200_000}

# How far above the surface the other rays start, in terms of the scene's size.
ABOVE = 2e-5


def camera(scene: halfline.Scene, side: int) -> tuple[Array, Array]:
    """An eye outside of the scene, and directions through a square picture."""
    low, high = (np.asarray(corner) for corner in scene.mesh.bounds)
    size = float(np.linalg.norm(high - low))
    away = np.array([0.4, 0.3, 1.0]) / np.linalg.norm([0.4, 0.3, 1.0])
    right = np.cross(-away, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, -away)
    at = ((np.arange(side) + 0.5) / side * 2 - 1) * 0.42
    directions = -away + right * at[None, :, None] - up * at[:, None, None]
    return (low + high) / 2 + away * (1.2 * size), np.ascontiguousarray(directions)


def nanoseconds(
    calls: Mapping[str, Callable[[], object]], count: int, turns: int
) -> dict[str, float]:
    """What a ray takes by each of some calls: the least of several turns."""
    least = dict.fromkeys(calls, float("inf"))
    for _ in range(turns):
        for name, call in calls.items():
            start = time.perf_counter()
            call()
            least[name] = min(least[name], (time.perf_counter() - start) / count * 1e9)
    return least


def images(scene: halfline.Scene, side: int, turns: int) -> dict[str, float]:
    """Camera rays in three shapes."""
    eye, image = camera(scene, side)
    tiled = image.reshape(side // 8, 8, side // 8, 8, 3).transpose(0, 2, 1, 3, 4)
    forms = {
        "row": image.reshape(-1, 3),
        "image": image,
        "tiles": np.ascontiguousarray(tiled).reshape(-1, 3),
    }
    calls = {name: partial(scene.intersect, eye, rays) for name, rays in forms.items()}
    return nanoseconds(calls, side * side, turns)


def starts(scene: halfline.Scene, side: int, turns: int) -> dict[str, float]:
    """Hemisphere rays from the surface, and from above it."""
    eye, image = camera(scene, side)
    hits = scene.intersect(eye, image)
    is_hit = hits.face >= 0
    hits, along = hits[is_hit], image[is_hit]
    facing = np.where((hits.normal * along).sum(-1, keepdims=True) > 0, -hits.normal, hits.normal)
    sphere = np.random.default_rng(1).normal(size=facing.shape)
    directions = facing + 0.999 * sphere / np.linalg.norm(sphere, axis=-1, keepdims=True)
    low, high = (np.asarray(corner) for corner in scene.mesh.bounds)
    origins = {
        "surface": hits.origins_towards(directions),
        "above": hits.point + facing * (ABOVE * np.linalg.norm(high - low)),
    }
    calls: dict[str, Callable[[], object]] = {}
    for name, origin in origins.items():
        calls[f"{name}, any"] = partial(scene.occluded, origin, directions)
        calls[f"{name}, closest"] = partial(scene.intersect, origin, directions)
    return nanoseconds(calls, len(along), turns)


def main() -> int:
    """Measures, prints, writes."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--side", type=int, default=1000, help="pixels of a side, by eights")
    parser.add_argument("--turns", type=int, default=9)
    options = parser.parse_args()
    if options.side < 8 or options.side % 8:
        parser.error("--side: not a multiple of 8")
    halfline.set_thread_count(1)

    figures, rows = [], [["ns a ray", "row", "image", "tiles", "tiles / image"]]
    starting = [["ns a ray", "surface", "above", "surface / above"]]
    for name in (*FILES, *GENERATED):
        file = FILES.get(name)
        mesh = halfline.load(file) if file else halfline.generate(name, GENERATED[name])
        scene = halfline.Scene(mesh)
        shapes = images(scene, options.side, options.turns)
        where = starts(scene, options.side, options.turns)
        figures.append({"mesh": name, "images": shapes, "starts": where})
        told = [f"{shapes[form]:.1f}" for form in ("row", "image", "tiles")]
        rows.append([name, *told, f"{shapes['tiles'] / shapes['image']:.2f}"])
        for question in ("any", "closest"):
            surface, above = where[f"surface, {question}"], where[f"above, {question}"]
            told = [f"{surface:.1f}", f"{above:.1f}", f"{surface / above:.2f}"]
            starting.append([f"{name}, {question} hit", *told])
    print(f"{processor()}, one thread, {options.side} x {options.side} rays in double precision")
    print_table("Camera rays in three shapes", rows)
    print_table("Hemisphere rays from a surface, and from above it", starting)
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "shapes.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
