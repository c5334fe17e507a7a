"""Rays of pinhole cameras, as Open3D makes them."""

from __future__ import annotations

import operator
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfline._arrays import floats


class TensorLike(Protocol):
    """A tensor of Open3D, as far as it matters."""

    def numpy(self) -> Any:
        """What it holds."""


Given: TypeAlias = ArrayLike | TensorLike
"""Anything that is taken for an array."""


def untensored(value: Any) -> Any:
    """What a tensor of Open3D holds; anything else itself."""
    return value.numpy() if callable(getattr(value, "numpy", None)) else value


def rays_through(
    intrinsic_matrix: Given, extrinsic_matrix: Given, width_px: int, height_px: int
) -> NDArray[np.float32]:
    """Rays through the centres of pixels, (height, width, 6), of a camera given by matrices."""
    intrinsic = _matrix("intrinsic_matrix", intrinsic_matrix, (3, 3))
    extrinsic = _matrix("extrinsic_matrix", extrinsic_matrix, (4, 4))
    columns = np.arange(_size("width_px", width_px)) + 0.5
    rows = np.arange(_size("height_px", height_px)) + 0.5

    rotation, shift = extrinsic[:3, :3], extrinsic[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # The matrix is upper triangular: from below, each line has one unknown more.
        z = 1.0 / intrinsic[2, 2]
        y = (rows[:, None] - intrinsic[1, 2] * z) / intrinsic[1, 1]
        x = (columns - intrinsic[0, 2] * z - intrinsic[0, 1] * y) / intrinsic[0, 0]
        rays = np.empty((len(rows), len(columns), 6), dtype=np.float32)
        rays[..., :3] = -rotation.T @ shift
        rays[..., 3:] = np.stack(np.broadcast_arrays(x, y, z), axis=-1) @ rotation
    return rays


def towards(
    fov_deg: float,
    center: Given,
    eye: Given,
    up: Given,
    width_px: int,
    height_px: int,
) -> NDArray[np.float32]:
    """Rays through the centres of pixels, (height, width, 6), of a camera that looks at a point."""
    position = _matrix("eye", eye, (3,))
    width, height = _size("width_px", width_px), _size("height_px", height_px)
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = _unit(_matrix("center", center, (3,)) - position)
        # So rows go along `up`, not against it: the image is upside down, as in Open3D.
        right = _unit(np.cross(_matrix("up", up, (3,)), ahead))
        focal = 0.5 * width / np.tan(0.5 * np.deg2rad(float(fov_deg)))
        extrinsic = np.eye(4)
        extrinsic[:3, :3] = right, np.cross(ahead, right), ahead
        extrinsic[:3, 3] = -extrinsic[:3, :3] @ position
    intrinsic = [[focal, 0.0, 0.5 * width], [0.0, focal, 0.5 * height], [0.0, 0.0, 1.0]]
    return rays_through(intrinsic, extrinsic, width, height)


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(vector / np.linalg.norm(vector))


def _matrix(name: str, value: Given, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = floats(name, untensored(value), str(shape))
    if array.shape != shape:
        raise ValueError(f"{name}: expected shape {shape}, found {array.shape}")
    return array.astype(np.float64)


def _size(name: str, value: int) -> int:
    size = operator.index(value)
    if size < 0:
        raise ValueError(f"{name}: expected a number of pixels, found {size}")
    return size
