"""Pictures as arrays."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfline._arrays import path_of
from halfline._native import encode_png, write_file

if TYPE_CHECKING:
    from halfline._native import Rendering

_EXTENSIONS = (".png", ".exr")


class Image(np.ndarray[tuple[Any, ...], np.dtype[np.uint8]]):
    """A picture: an array of shape (height, width, 3), or (height, width, 4) if it is transparent.

    Eight-bit sRGB, rows from top to bottom; alpha is straight. It shows itself in Jupyter, as does
    every part of it that is a picture. The layers are those of the picture as a whole, and None in
    arrays made of it: slices, sums, copies.

    Attributes:
        color: Linear red, green, blue and straight alpha, shape (height, width, 4), float32.
        depth: Distance from the camera's plane, shape (height, width), float32; infinite where
            there is nothing.
        normal: Unit normal of the surface, shape (height, width, 3), float32; zero where there is
            nothing.
        face: Index of the face, shape (height, width), int64; -1 for the ground and for nothing.
        steps: Nodes and triangles visited, shape (height, width, 2), float32, for the shading
            "steps"; else None.
        rays: How many rays were cast, by what for.
    """

    color: NDArray[np.float32] | None
    depth: NDArray[np.float32] | None
    normal: NDArray[np.float32] | None
    face: NDArray[np.int64] | None
    steps: NDArray[np.float32] | None
    rays: dict[str, int] | None
    _rendering: Rendering | None

    @classmethod
    def _of(cls, rendering: Rendering) -> Image:
        width, height = rendering.size
        pixels, channels = rendering.pixels()
        image = pixels.reshape(height, width, channels).view(cls)
        color, depth, normal, face, steps = rendering.layers()
        image.color = color.reshape(height, width, 4)
        image.depth = depth.reshape(height, width)
        image.normal = normal.reshape(height, width, 3)
        image.face = face.reshape(height, width)
        image.steps = None if steps is None else steps.reshape(height, width, 2)
        image.rays = rendering.rays()
        image._rendering = rendering
        return image

    def __array_finalize__(self, array: Any) -> None:
        self.color = self.depth = self.normal = self.face = self.steps = self.rays = None
        self._rendering = None

    def __array_wrap__(
        self, array: NDArray[Any], context: Any = None, return_scalar: bool = False
    ) -> Any:
        """What is computed from a picture is numbers."""
        plain = np.asarray(array)
        return plain[()] if return_scalar or plain.ndim == 0 else plain

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture: as PNG, or as OpenEXR with all layers.

        The file appears whole or not at all.

        Args:
            path: Ends in .png, or in .exr for a picture as a whole.

        Raises:
            ValueError: For another extension, and for an array that is no picture, or for OpenEXR
                not a whole one.
            OSError: If the file cannot be written.
        """
        path = path_of("path", path)
        extension = Path(path).suffix.lower()
        if extension not in _EXTENSIONS:
            raise ValueError(f"path: expected a name that ends in .png or .exr, found {path!r}")
        if self._rendering is not None:
            self._rendering.save(path, extension == ".exr")
            return
        png = self._repr_png_()
        if png is None or extension == ".exr":
            raise ValueError(
                "only a picture as it was rendered can be OpenEXR, and only an array of uint8 of "
                f"shape (height, width, 3) or (height, width, 4) PNG; found {self.dtype} of "
                f"shape {self.shape}"
            )
        write_file(path, png)

    def _repr_png_(self) -> bytes | None:
        """The picture as PNG, for Jupyter; None if the array is none."""
        if self.dtype != np.uint8 or self.ndim != 3 or self.size == 0:
            return None
        height, width, channels = self.shape
        if channels not in (3, 4):
            return None
        return encode_png(np.ascontiguousarray(self).view(np.ndarray), width, height, channels)
