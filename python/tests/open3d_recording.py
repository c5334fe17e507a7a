"""What tools/record_open3d.py wrote of Open3D's answers, and comparisons with it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from halfline.open3d import RaycastingScene
from numpy.typing import NDArray

# Embree computes in float32; t and barycentrics of the recorded hits are near one.
CLOSE = 4e-6

Array = NDArray[Any]


class Recording:
    """What tools/record_open3d.py wrote."""

    def __init__(self) -> None:
        text = Path(__file__).with_name("open3d.json").read_text(encoding="utf-8")
        self.head: dict[str, Any] = json.loads(text)
        self.cameras: dict[str, list[Any]] = self.head["cameras"]

    def __getitem__(self, name: str) -> Array:
        array = self.head["arrays"][name]
        plain = np.array(array["data"], dtype=array["dtype"])
        return np.asarray(plain.reshape(array["shape"]))

    def answer(self, name: str) -> dict[str, Array]:
        """The arrays of a dictionary."""
        names = [key for key in self.head["arrays"] if key.startswith(f"{name}.")]
        return {key.removeprefix(f"{name}."): self[key] for key in names}


RECORDING = Recording()


def filled(names: tuple[str, ...] = ("outer", "inner", "triangle")) -> RaycastingScene:
    """A scene of some of the recorded meshes."""
    scene = RaycastingScene()
    for name in names:
        scene.add_triangles(RECORDING[f"{name}_vertices"], RECORDING[f"{name}_triangles"])
    return scene


def same(found: Array, expected: Array) -> None:
    """Integers and flags are equal, floats close, and dtypes and shapes the same."""
    assert type(found) is np.ndarray
    assert found.dtype == expected.dtype
    if expected.dtype.kind == "f":
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, rtol=CLOSE, atol=CLOSE)
    else:
        np.testing.assert_array_equal(found, expected, strict=True)


def same_answers(found: dict[str, Array], expected: dict[str, Array]) -> None:
    """All arrays are the same."""
    assert set(found) == set(expected)
    for key, array in expected.items():
        same(found[key], array)


TRIANGLE = np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1]], dtype=np.float32)
FACE = np.array([[0, 1, 2]], dtype=np.uint32)
