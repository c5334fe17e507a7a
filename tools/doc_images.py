#!/usr/bin/env python3
"""The pictures of docs/python.md, made by the recipes that they stand beside.

Run by `make doc-images`. The functions are taken from the page itself, so a picture shows what the
page says; rays draw it. Needs the package and Pillow.
"""

from __future__ import annotations

import doctest
import io
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import halfline
import numpy as np
from doc_examples import OPTIONS, sections_of
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Floats: TypeAlias = NDArray[np.float64]

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "python.md"
IMAGES = ROOT / "docs" / "images"

WIDTH, HEIGHT = 960, 540
FINE = 3
"""Rays along each side of a pixel."""

# From where the urchin is seen.
EYE, TARGET, UP, VIEW_ANGLE = (1.3, -3.2, 1.7), (0.0, 0.0, 0.08), (0.0, 0.0, 1.0), 25

PAPER = (1.0, 1.0, 1.0)
INK = (60, 60, 60)

# Thin to thick, and weak to strong.
WALLS = ("#a50026", "#f46d43", "#fee090", "#abd9e9", "#4575b4", "#313695")
RETURNS = ("#3b0f70", "#8c2981", "#de4968", "#fe9f6d", "#fcfdbf")


def recipes() -> dict[str, Any]:
    """All functions of the page, by name."""
    found: dict[str, Any] = {}
    start = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # some examples write files
        for section in sections_of(PAGE):
            runner = doctest.DocTestRunner(optionflags=OPTIONS)
            if runner.run(section, clear_globs=False).failed:
                sys.exit(f"doc_images.py: the examples of {section.name!r} fail")
            found.update(section.globs)
        os.chdir(start)
    return {name: value for name, value in found.items() if callable(value)}


def colors_of(values: Floats, ramp: tuple[str, ...]) -> Floats:
    """Colours for values from 0 to 1, sRGB from 0 to 1."""
    stops = np.array([[int(stop[i : i + 2], 16) for i in (1, 3, 5)] for stop in ramp]) / 255
    at = np.linspace(0, 1, len(ramp))
    return np.stack([np.interp(values, at, stops[:, i]) for i in range(3)], axis=-1)


def drawing(
    scene: halfline.Scene,
    eye: tuple[float, float, float],
    rays: Floats,
    color_at: Callable[[halfline.Hits], Floats],
) -> Floats:
    """What the rays see, in colours that depend on the hit, white where there is nothing."""
    hits = scene.intersect(eye, rays)
    picture = np.empty(rays.shape)
    picture[:] = PAPER
    picture[hits.hit] = color_at(hits[hits.hit])
    return coarse(picture)


def coarse(picture: Floats) -> Floats:
    """Means over the fine pixels."""
    height, width, channels = picture.shape
    blocks = picture.reshape(height // FINE, FINE, width // FINE, FINE, channels)
    mean: Floats = blocks.mean(axis=(1, 3))
    return mean


def at_hits(hits: halfline.Hits, of_vertices: Floats) -> Floats:
    """Values of vertices, interpolated to where the hits are."""
    weights = np.column_stack([1 - hits.uv.sum(axis=1), hits.uv])
    mean: Floats = np.einsum("ij,ij...->i...", weights, of_vertices[hits.mesh.faces[hits.face]])
    return mean


def pixels_of(picture: Floats) -> Image.Image:
    """The picture with eight bits."""
    return Image.fromarray((picture.clip(0, 1) * 255).round().astype(np.uint8))


def bar(
    picture: Image.Image,
    corner: tuple[int, int],
    ramp: tuple[str, ...],
    labels: tuple[str, str, str],
    ink: tuple[int, ...],
) -> None:
    """Draws what the colours mean, to the right of and below the corner: title, least, largest."""
    font = ImageFont.load_default(size=17)
    draw = ImageDraw.Draw(picture)
    width, height, (left, top) = 260, 12, corner
    strip = colors_of(np.tile(np.linspace(0, 1, width), (height, 1)), ramp)
    picture.paste(pixels_of(strip), (left, top))
    title, least, largest = labels
    draw.text((left, top - 8), title, fill=ink, font=font, anchor="ls")
    draw.text((left, top + height + 18), least, fill=ink, font=font, anchor="ls")
    draw.text((left + width, top + height + 18), largest, fill=ink, font=font, anchor="rs")


def write(picture: Image.Image, name: str, count: int) -> None:
    """Writes a small PNG, of so many colours."""
    colors = picture.quantize(count, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    data = io.BytesIO()
    colors.save(data, "PNG", optimize=True)
    path = IMAGES / name
    path.write_bytes(data.getvalue())
    print(f"{os.path.relpath(path)}: {len(data.getvalue()) / 1000:.0f} kB")


def draw_openness(recipe: dict[str, Any], urchin: halfline.Mesh) -> None:
    """The urchin with what each vertex sees of the sky, near it."""
    scene = halfline.Scene(urchin)
    sky = recipe["openness"](scene, rays=128, reach=0.3)
    rays = recipe["pinhole"](EYE, TARGET, UP, VIEW_ANGLE, WIDTH * FINE, HEIGHT * FINE)

    def color_at(hits: halfline.Hits) -> Floats:
        grey = at_hits(hits, sky) ** 2.4
        return np.repeat(0.06 + 0.86 * grey[:, None], 3, axis=1)

    write(pixels_of(drawing(scene, EYE, rays, color_at)), "openness.png", 40)


def draw_thickness(recipe: dict[str, Any], urchin: halfline.Mesh) -> None:
    """The urchin, hollow, with how thick its shell is."""
    coarse_urchin = halfline.generate("scan", 3_000)
    middle = urchin.bounds.mean(axis=0)
    inner = (middle + 0.86 * (coarse_urchin.vertices - middle)).astype(np.float32)
    scene = halfline.Scene(recipe["hollow"](urchin, halfline.Mesh(inner, coarse_urchin.faces)))
    wall = recipe["thickness"](scene)
    normals = recipe["vertex_normals"](scene.mesh)
    thin, thick = 0.05, 0.25
    rays = recipe["pinhole"](EYE, TARGET, UP, VIEW_ANGLE, WIDTH * FINE, HEIGHT * FINE)
    sun = np.array([0.3, -0.6, 0.75]) / np.linalg.norm([0.3, -0.6, 0.75])

    def color_at(hits: halfline.Hits) -> Floats:
        color = colors_of((wall[hits.face] - thin) / (thick - thin), WALLS)
        light = 0.55 + 0.5 * (at_hits(hits, normals) @ sun).clip(0, 1)
        lit: Floats = color * light[:, None]
        return lit

    picture = pixels_of(drawing(scene, EYE, rays, color_at))
    bar(picture, (24, 36), WALLS, ("thickness", f"{thin:g} and less", f"{thick:g} and more"), INK)
    write(picture, "thickness.png", 160)


def draw_lidar(recipe: dict[str, Any]) -> None:
    """The points that a scanner in the hall finds, nearer ones before farther ones."""
    scene = halfline.Scene(halfline.generate("hall", 500_000))
    points, intensity, _ = recipe["sweep"](
        scene, (0, 0, 1.8), np.linspace(-25, 35, 96), steps=2000, far=60.0, noise=0.01
    )
    eye, target = np.array([-30.0, -17.0, 21.0]), np.array([-1.0, 1.0, 1.5])
    axis = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(axis, (0, 0, 1))
    right /= np.linalg.norm(right)
    above = np.cross(right, axis)
    depth = (points - eye) @ axis
    pixel = 2 * np.tan(np.radians(32) / 2) / (HEIGHT * FINE)
    x = WIDTH * FINE / 2 + (points - eye) @ right / depth / pixel
    y = HEIGHT * FINE / 2 - (points - eye) @ above / depth / pixel

    picture = np.empty((HEIGHT * FINE, WIDTH * FINE, 3))
    picture[:] = (0.055, 0.06, 0.09)
    colors = colors_of(intensity, RETURNS)
    order = np.argsort(-depth)
    for dx in range(-1, 2):
        for dy in range(-1, 2):
            column, row = (x[order] + dx).astype(int), (y[order] + dy).astype(int)
            inside = (column >= 0) & (column < WIDTH * FINE) & (row >= 0) & (row < HEIGHT * FINE)
            picture[row[inside], column[inside]] = colors[order][inside]
    image = pixels_of(coarse(picture))
    bar(image, (WIDTH - 284, HEIGHT - 44), RETURNS, ("intensity", "0", "1"), (220, 220, 220))
    write(image, "lidar.png", 128)


def draw_slice(recipe: dict[str, Any]) -> None:
    """A cut through the distances from an urchin."""
    scene = halfline.Scene(halfline.generate("scan", 200_000))
    bounds = np.array([[-1.6, -1.35, 0.0], [1.6, 1.35, 0.0]])
    write(Image.fromarray(recipe["slice_picture"](scene, bounds, 0.1, 0.005)), "slice.png", 64)


def main() -> None:
    """Draws all of them."""
    recipe = recipes()
    urchin = halfline.generate("scan", 500_000)
    draw_openness(recipe, urchin)
    draw_thickness(recipe, halfline.generate("scan", 200_000))
    draw_lidar(recipe)
    draw_slice(recipe)


if __name__ == "__main__":
    main()
