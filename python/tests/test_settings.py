"""Settings of pictures: from Python they mean what they mean to the command, or are refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Halfline, Judged
from halfline import Scene
from halfline._native import RenderSettings
from PIL import Image

LIGHT = "point:position=1,2,3:intensity=20:radius=0.5"


@pytest.mark.parametrize(
    ("settings", "options"),
    [
        ({}, ()),
        ({"seed": 3, "samples": np.int64(2), "shading": "normal"}, "--seed 3 --shading normal"),
        (
            {"up": "-z", "camera_azimuth_angle": -20, "camera_elevation_angle": 50.5},
            "--up -z --camera-azimuth-angle -20 --camera-elevation-angle 50.5",
        ),
        (
            {
                "camera_position": np.array([3, 4, 5], dtype=np.float32),
                "camera_focal_point": (0.1, 0, 0),
                "camera_view_up": [0, 0, 1],
                "camera_view_angle": 40,
            },
            "--camera-position 3,4,5 --camera-focal-point 0.1,0,0 --camera-view-up 0,0,1 "
            "--camera-view-angle 40",
        ),
        ({"camera_orthographic": True}, "--camera-orthographic"),
        ({"camera_orthographic": False}, ()),
        ({"camera_orthographic": 1.5}, "--camera-orthographic=1.5"),
        ({"background": "studio"}, ()),
        ({"background": "none"}, "--no-background"),
        ({"background": "#336699"}, "--background-color #336699"),
        ({"background": (0.1, 0.2, 0.3)}, "--background-color 0.1,0.2,0.3"),
        ({"ground": True}, "--ground"),
        ({"ground": False}, ()),
        ({"ground": "checker", "ground_height": -2}, "--ground=checker --ground-height -2"),
        ({"ground": [0.5, 0.5, 0.25]}, "--ground=0.5,0.5,0.25"),
        (
            {"shading": "whitted", "ground": "#808080", "ground_reflectivity": 0.4},
            "--shading whitted --ground=#808080 --ground-reflectivity 0.4",
        ),
        (
            {"shading": "whitted", "material": "glass", "base_ior": 1.3, "max_depth": 3},
            "--shading whitted --material glass --base-ior 1.3 --max-depth 3",
        ),
        (
            {"shading": "whitted", "color": "#c08040", "metallic": 0.7, "roughness": 0.2},
            "--shading whitted --color #c08040 --metallic 0.7 --roughness 0.2",
        ),
        (
            {"shading": "whitted", "lights": [LIGHT, "directional:direction=0,-1,0"]},
            f"--shading whitted --light {LIGHT} --light directional:direction=0,-1,0",
        ),
        (
            {"smooth_angle": 60, "occlusion_rays": 3, "occlusion_reach": 0.1},
            "--smooth-angle 60 --occlusion-rays 3 --occlusion-reach 0.1",
        ),
    ],
)
def test_arguments_are_the_options_of_the_command(
    halfline: Halfline,
    judged: Judged,
    scene: Scene,
    tmp_path: Path,
    settings: dict[str, Any],
    options: str,
) -> None:
    picture = tmp_path / "picture.png"
    words = options.split() if options else []
    size = ("--resolution", "48,36", "--samples", "2")
    halfline.ok("render", judged.path, "-o", picture, *size, *words)
    with Image.open(picture) as image:
        expected = np.asarray(image)
    found = scene.render(**{"width": 48, "height": 36, "samples": 2, **settings})
    np.testing.assert_array_equal(np.asarray(found), expected)


def test_settings_travel_as_text() -> None:
    settings = RenderSettings(
        width=7, height=5, camera_position=(1 / 3, 1e-300, -0.1), lights=[LIGHT], color="#102030"
    )
    again = RenderSettings.from_json(settings.to_json())
    assert again.to_json() == settings.to_json()
    assert (again.size, again.samples) == ((7, 5), 16)
    with pytest.raises(ValueError, match=r"^settings: unknown field `wdith`"):
        RenderSettings.from_json('{"wdith": 7}')


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"width": "wide"}, "width: expected an integer, found str"),
        ({"width": 64.0}, "width: expected an integer, found float"),
        ({"samples": True}, "samples: expected an integer, found bool"),
        ({"shading": 3}, "shading: expected a name, found int"),
        ({"roughness": "rough"}, "roughness: expected a number, found str"),
        ({"roughness": True}, "roughness: expected a number, found bool"),
        ({"camera_position": 3}, "camera_position: expected three numbers, found int"),
        ({"camera_position": "1,2,3"}, "camera_position: expected three numbers, found str"),
        ({"camera_view_up": ("a", 1, 2)}, "camera_view_up: expected a number, found str"),
        ({"color": 3}, "color: expected #RRGGBB or three numbers, found int"),
        ({"lights": LIGHT}, "lights: expected strings, as --light of the command has them, "),
        ({"lights": [3]}, "lights: expected strings, as --light of the command has them, found"),
        ({"smaples": 4}, "render() got an unexpected keyword argument 'smaples'"),
    ],
)
def test_types_that_an_argument_cannot_have(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(TypeError) as raised:
        RenderSettings(**settings)
    assert str(raised.value).startswith(message)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"width": 0}, "width, height: 0,720 has no pixels"),
        ({"width": -1}, "width: expected a number from 0 to 4294967295, found -1"),
        ({"width": 100_000, "height": 10**5}, "width, height: 100000,100000 has more than"),
        ({"samples": 0}, "samples: 0 is not between 1 and 65536"),
        ({"seed": 2**64}, "seed: expected a number from 0 to 18446744073709551615, found 184"),
        ({"shading": "phong"}, 'shading: "phong" is none of clay, whitted, normal, depth, face, '),
        ({"up": "Q"}, 'up: "Q" is none of +X, -X, +Y, -Y, +Z, -Z'),
        (
            {"material": "wood"},
            'material: "wood" is none of plaster, plastic, metal, mirror, glass',
        ),
        ({"camera_view_up": (0, 0, 0)}, "camera_view_up: it has no length"),
        ({"camera_position": (1, 2)}, "camera_position: expected three numbers, found (1, 2)"),
        ({"camera_position": (1, 2, np.nan)}, "camera_position: expected a finite number, found"),
        ({"camera_view_angle": 180}, "camera_view_angle: 180 is not above 0 and below 180 degrees"),
        ({"camera_elevation_angle": 90}, "camera_elevation_angle: 90 is not above -90 and below"),
        (
            {"camera_position": (1, 2, 3), "camera_azimuth_angle": 4},
            "camera_azimuth_angle: expected none beside camera_position",
        ),
        (
            {"camera_position": (1, 2, 3), "camera_focal_point": (1, 2, 3)},
            "camera_position: it is the same point as the focal point",
        ),
        ({"camera_orthographic": -1}, "camera_orthographic: -1 is not a length above 0"),
        ({"background": "red"}, "background: expected studio, none, #RRGGBB or R,G,B between "),
        (
            {"background": (2, 0, 0)},
            "background: expected #RRGGBB or three numbers in 0..1, found (2,",
        ),
        ({"color": "#12"}, "color: expected R,G,B between 0 and 1, or #RRGGBB, found '#12'"),
        ({"color": (2, 0, 0)}, "color: expected #RRGGBB or three numbers in 0..1, found (2,"),
        ({"ground": "grass"}, "ground: expected shadow, checker, R,G,B in 0..1 or #RRGGBB, found"),
        ({"ground": (0, 0, -1)}, "ground: expected #RRGGBB or three numbers in 0..1, found (0"),
        ({"ground_height": 1}, "ground_height: expected none without ground"),
        ({"ground": False, "ground_reflectivity": 1}, "ground_reflectivity: expected none without"),
        ({"ground": True, "ground_reflectivity": 2}, "ground_reflectivity: 2 is not between 0 and"),
        ({"metallic": 2}, "metallic: 2 is not between 0 and 1"),
        ({"roughness": -1}, "roughness: -1 is not between 0 and 1"),
        ({"base_ior": 5}, "base_ior: 5 is not between 1 and 4"),
        ({"smooth_angle": 181}, "smooth_angle: 181 is not between 0 and 180 degrees"),
        ({"lights": ["lamp"]}, "lights: `lamp` is none of point, directional, area, found 'lamp'"),
        (
            {"lights": ["point:position=0,0,0:intensity=1:radius=-1"]},
            "lights: radius: -1 is not a length of at least 0",
        ),
        ({"max_depth": 65}, "max_depth: 65 is not between 0 and 64"),
        ({"occlusion_rays": 0}, "occlusion_rays: 0 is not between 1 and 65536"),
        ({"occlusion_reach": 0}, "occlusion_reach: 0 is not above 0"),
        ({"occlusion_reach": np.inf}, "occlusion_reach: expected a finite number, found inf"),
    ],
)
def test_values_that_make_no_sense(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError) as raised:  # noqa: PT011 - the message is compared below
        RenderSettings(**settings)
    assert str(raised.value).startswith(message)
    assert "\n" not in str(raised.value)


def test_what_only_a_scene_tells_has_the_argument_s_name(scene: Scene) -> None:
    with pytest.raises(ValueError, match=r"^camera_view_up: it is parallel to the direction"):
        scene.render(
            camera_position=(0, 9, 0), camera_focal_point=(0, 0, 0), camera_view_up=(0, 1, 0)
        )
