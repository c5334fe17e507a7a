"""`halfline render`: pictures as others read them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest
from conftest import Halfline, Judged
from moeller_trumbore import crossings
from PIL import Image

SIZE = ("--resolution", "120,90")

# Straight from above, parallel rays, one pixel a fortieth of a unit wide.
ABOVE = (
    "--resolution=80,60",
    "--samples=1",
    "--camera-position=0.013,0.027,5",
    "--camera-focal-point=0.013,0.027,0",
    "--camera-view-up=0,1,0",
    "--camera-orthographic=1.5",
)


def pixels_of(path: Path) -> np.ndarray[Any, Any]:
    """The colours of a PNG, (height, width, 4), in 0 to 255."""
    with Image.open(path) as image:
        assert image.format == "PNG"
        return np.asarray(image.convert("RGBA"))


@pytest.mark.parametrize("shading", ["clay", "whitted", "normal", "depth", "face", "steps"])
def test_every_shading_gives_a_picture(
    halfline: Halfline, judged: Judged, tmp_path: Path, shading: str
) -> None:
    picture = tmp_path / "picture.png"
    halfline.ok("render", judged.path, "-o", picture, *SIZE, "--samples", "4", "--shading", shading)
    pixels = pixels_of(picture)
    assert pixels.shape == (90, 120, 4)
    assert (pixels[..., 3] == 255).all()
    # The model is in the middle, and does not look like the corner; nor is it flat.
    middle = pixels[30:60, 45:75, :3].astype(int)
    assert np.abs(middle - pixels[0, 0, :3].astype(int)).sum(axis=-1).min() > 0
    assert len(np.unique(middle.reshape(-1, 3), axis=0)) > 50


def test_the_whole_model_is_in_the_picture(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    picture = tmp_path / "picture.png"
    halfline.ok("render", judged.path, "-o", picture, *SIZE, "--no-background")
    alpha = pixels_of(picture)[..., 3]
    assert set(np.unique(alpha)) >= {0, 255}
    edge = np.concatenate([alpha[0], alpha[-1], alpha[:, 0], alpha[:, -1]])
    assert (edge == 0).all()
    rows, columns = np.nonzero(alpha)
    assert max(np.ptp(rows) / 90, np.ptp(columns) / 120) > 0.7


def test_the_background_has_the_colour_asked_for(
    halfline: Halfline, judged: Judged, tmp_path: Path
) -> None:
    picture = tmp_path / "picture.png"
    options = ("--background-color", "#336699", "--samples", "2")
    halfline.ok("render", judged.path, "-o", picture, *SIZE, *options)
    assert pixels_of(picture)[0, 0].tolist() == [0x33, 0x66, 0x99, 255]


@pytest.mark.parametrize("name", ["picture.png", "picture.exr"])
@pytest.mark.parametrize("shading", ["clay", "whitted"])
def test_the_picture_does_not_depend_on_threads(
    halfline: Halfline, judged: Judged, tmp_path: Path, name: str, shading: str
) -> None:
    def bytes_of(folder: str, *options: str) -> bytes:
        path = tmp_path / folder / name
        path.parent.mkdir()
        base = ("render", judged.path, "-o", path, *SIZE, "--samples", "4", "--shading", shading)
        halfline.ok(*base, *options)
        return path.read_bytes()

    first = bytes_of("first", "--threads", "1", "--seed", "5")
    assert bytes_of("again", "--threads", "3", "--seed", "5") == first
    assert bytes_of("other", "--seed", "6") != first


def test_the_layers_of_an_exr_are_right(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    picture = tmp_path / "picture.exr"
    halfline.ok("render", judged.path, "-o", picture, *ABOVE)
    with OpenEXR.File(str(picture), separate_channels=True) as file:
        layers = {name: channel.pixels.copy() for name, channel in file.channels().items()}
    assert {"R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z", "id"} <= set(layers)
    assert {layer.shape for layer in layers.values()} == {(60, 80)}
    assert layers["id"].dtype == np.uint32

    x = 0.013 + (np.arange(80) + 0.5 - 40) / 40
    y = 0.027 - (np.arange(60) + 0.5 - 30) / 40
    rays = np.zeros((60, 80, 6))
    rays[..., 0], rays[..., 1] = np.meshgrid(x, y)
    rays[..., 2], rays[..., 5] = 5.0, -1.0
    found = crossings(judged.shape, rays.reshape(-1, 6))
    face, t = found.closest(60 * 80)
    sure = ~found.unsure
    hit = sure & (face >= 0)
    assert 0.5 < hit.mean() < 0.99

    ours = layers["id"].astype(np.int64).ravel()
    ours[ours == 2**32 - 1] = -1
    np.testing.assert_array_equal(ours[sure], face[sure])
    np.testing.assert_allclose(layers["Z"].ravel()[hit], t[hit], rtol=1e-6)
    assert np.isinf(layers["Z"].ravel()[sure & (face < 0)]).all()

    corners = judged.shape.corners()[face[hit]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    told = np.stack([layers[f"N.{axis}"].ravel()[hit] for axis in "XYZ"], axis=-1)
    np.testing.assert_allclose(told, normals, atol=1e-5)


def test_json_tells_rays_and_seconds(halfline: Halfline, judged: Judged, tmp_path: Path) -> None:
    base = ("render", judged.path, "-o", tmp_path / "picture.png", *SIZE, "--samples", "4")
    answer = halfline.json(*base)
    assert answer["triangles"] == len(judged.shape.faces)
    assert (answer["width"], answer["height"]) == (120, 90)
    assert answer["rays"] >= 120 * 90 * 4
    assert answer["rays_per_second"] > 0
    for stage in ("load_seconds", "build_seconds", "trace_seconds", "write_seconds"):
        assert answer[stage] >= 0.0


def test_vertex_colours_are_seen(halfline: Halfline, tmp_path: Path) -> None:
    mesh = tmp_path / "colours.ply"
    corners = ["-1 -1 0 255 0 0", "1 -1 0 255 0 0", "1 1 0 255 0 0", "-1 1 0 255 0 0"]
    header = ["ply", "format ascii 1.0", "element vertex 4"]
    header += [f"property float {axis}" for axis in "xyz"]
    header += [f"property uchar {colour}" for colour in ("red", "green", "blue")]
    header += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    mesh.write_text("\n".join([*header, *corners, "4 0 1 2 3"]) + "\n", encoding="utf-8")
    picture = tmp_path / "picture.png"
    halfline.ok("render", mesh, "-o", picture, *ABOVE)
    red, green, blue, _ = pixels_of(picture)[30, 40].tolist()
    assert red > 2 * max(green, blue)
