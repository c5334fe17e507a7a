"""What callers may pass, as the arrays that the compiled part takes.

Nothing that is float32 or float64 and C-contiguous is copied, and no number is ever rounded:
float16 becomes float32, integers become float64 as NumPy converts them, and longdouble is refused.
"""

from __future__ import annotations

import math
import operator
import os
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray: TypeAlias = NDArray[np.float32] | NDArray[np.float64]
"""C-contiguous, aligned, in the machine's byte order."""

Vector: TypeAlias = tuple[float, float, float]
"""Of all rays."""

Numbers: TypeAlias = FloatArray | float
"""Of each ray, or of all rays."""


Columns: TypeAlias = tuple[FloatArray | Vector, FloatArray | Vector, Numbers, Numbers]
"""Origins, directions, t_min and t_max of rays: each the same for all, or an entry for each."""


def path_of(name: str, value: object) -> str:
    """A path as text.

    Raises:
        TypeError: If it is none, naming the argument.
    """
    try:
        return os.fsdecode(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name}: expected a path, found {type(value).__name__}") from None


def natural(name: str, value: object) -> int:
    """A number from 0 to 2**64 - 1.

    Raises:
        TypeError: If it is no integer, naming the argument.
        ValueError: If it is out of range.
    """
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name}: expected an integer, found {type(value).__name__}") from None
    if not 0 <= number < 2**64:
        raise ValueError(f"{name}: expected a number from 0 to 2**64 - 1, found {number}")
    return number


def vectors_of(name: str, value: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Vectors of a given leading shape in double precision, broadcast to it."""
    array = _vectors(name, value)
    try:
        spread = np.broadcast_to(array, (*shape, 3))
    except ValueError:
        raise ValueError(
            f"{name}: expected a shape that broadcasts to {(*shape, 3)}, found {array.shape}"
        ) from None
    return np.ascontiguousarray(spread, dtype=np.float64)


def rays_of(
    origins: ArrayLike,
    directions: ArrayLike,
    t_min: ArrayLike,
    t_max: ArrayLike,
) -> tuple[tuple[int, ...], Columns]:
    """Checks rays, and broadcasts what they have against each other.

    Returns:
        The leading dimensions of the answer, and the rays.
    """
    origin_array = _vectors("origins", origins)
    direction_array = _vectors("directions", directions)
    lowest, highest = _numbers("t_min", t_min), _numbers("t_max", t_max)
    shape = origin_array.shape[:-1]
    is_even = shape == direction_array.shape[:-1]
    if not (is_even and isinstance(lowest, float) and isinstance(highest, float)):
        shape = _broadcast(shape, direction_array.shape[:-1], np.shape(lowest), np.shape(highest))
    columns = (
        _vector_column(origin_array, shape),
        _vector_column(direction_array, shape),
        _number_column(lowest, shape),
        _number_column(highest, shape),
    )
    return shape, columns


def points_of(
    points: ArrayLike, max_distance: ArrayLike = math.inf
) -> tuple[tuple[int, ...], FloatArray | Vector, Numbers]:
    """Checks points, and how far from each anything counts.

    Returns:
        The leading dimensions of the answer, the points, and the distances.
    """
    array = _vectors("points", points)
    most = _numbers("max_distance", max_distance)
    shape = array.shape[:-1]
    if not isinstance(most, float):
        try:
            shape = np.broadcast_shapes(shape, most.shape)
        except ValueError:
            raise ValueError(
                "points, max_distance: expected leading dimensions that broadcast together, found "
                f"points {shape}, max_distance {most.shape}"
            ) from None
    return shape, _vector_column(array, shape), _number_column(most, shape)


def _broadcast(*shapes: tuple[int, ...]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        names = ("origins", "directions", "t_min", "t_max")
        found = ", ".join(
            f"{name} {shape}" for name, shape in zip(names, shapes, strict=True) if shape
        )
        raise ValueError(
            "origins, directions, t_min, t_max: expected leading dimensions that broadcast "
            f"together, found {found}"
        ) from None


def _vector_column(array: FloatArray, shape: tuple[int, ...]) -> FloatArray | Vector:
    if array.size == 3:
        x, y, z = array.reshape(3).tolist()
        return x, y, z
    return plain(array if array.shape[:-1] == shape else _spread(array, (*shape, 3)))


def _number_column(value: Numbers, shape: tuple[int, ...]) -> Numbers:
    if isinstance(value, float):
        return value
    if value.size == 1:
        return float(value.reshape(()))
    return plain(value if value.shape == shape else _spread(value, shape))


def _spread(array: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    spread: NDArray[Any] = np.broadcast_to(array, shape)
    return spread


def _vectors(name: str, value: ArrayLike) -> FloatArray:
    array = floats(name, value, "(..., 3)")
    if array.shape == (0,):
        # An empty list of rays.
        return np.empty((0, 3))
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name}: expected shape (..., 3), found {array.shape}")
    return array


def _numbers(name: str, value: ArrayLike) -> Numbers:
    if isinstance(value, float):
        return float(value)
    if value is None:
        raise TypeError(f"{name}: expected float32, float64 or integers, found None")
    array = floats(name, value, "of the rays, or a number")
    return float(array) if array.ndim == 0 else array


def plain(array: FloatArray) -> FloatArray:
    """The array itself if it is C-contiguous and aligned, else a copy that is."""
    if array.flags.c_contiguous and array.flags.aligned:
        return array
    copy: NDArray[Any] = array.copy(order="C")
    return copy


def floats(name: str, value: ArrayLike, shape: str) -> FloatArray:
    """The array of float32 or float64 in which `value` loses nothing, in any layout."""
    array: NDArray[Any] = value if type(value) is np.ndarray else array_of(name, value, shape)
    dtype = array.dtype
    if dtype.char in "fd" and dtype.isnative:
        return array
    converted: NDArray[Any] = array.astype(float_type(name, dtype))
    return converted


def float_type(name: str, dtype: np.dtype[Any]) -> type[np.float32] | type[np.float64]:
    """The type in which numbers of `dtype` lose nothing."""
    if dtype.kind == "f" and dtype.itemsize <= 4:
        return np.float32
    if dtype.kind in "iu" or (dtype.kind == "f" and dtype.itemsize == 8):
        return np.float64
    if dtype.kind == "f":
        raise TypeError(
            f"{name}: expected float32, float64 or integers, found {dtype.name}, which would "
            "have to be rounded: convert it with .astype(numpy.float64)"
        )
    raise TypeError(f"{name}: expected float32, float64 or integers, found {dtype.name}")


def array_of(name: str, value: ArrayLike, shape: str) -> NDArray[Any]:
    """What NumPy makes of a list, or of anything with `__array__`."""
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(f"{name}: expected an array, found a masked one: call its .filled() first")
    try:
        return np.asarray(value)
    except ValueError as error:
        raise ValueError(
            f"{name}: expected an array of shape {shape}, found what NumPy cannot make an array "
            f"of: {error}"
        ) from None


def vertices_of(value: ArrayLike) -> FloatArray:
    """Checks vertices of a mesh."""
    array = floats("vertices", value, "(n, 3)")
    if array.ndim != 2 or array.shape[1] != 3:
        if array.size == 0:
            array = array.reshape(0, 3)
        else:
            raise ValueError(f"vertices: expected shape (n, 3), found {array.shape}")
    return plain(array)


def faces_of(value: ArrayLike) -> NDArray[Any]:
    """Checks faces of a mesh: they come as 32-bit or 64-bit integers, whichever are quickest."""
    array = value if type(value) is np.ndarray else array_of("faces", value, "(m, 3)")
    if array.size == 0 and array.ndim <= 2:
        # An empty list is of floats, as far as NumPy knows.
        return np.empty((0, 3), dtype=np.int64)
    if array.dtype.kind not in "iu":
        raise TypeError(f"faces: expected integers, found {array.dtype.name}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces: expected shape (m, 3), found {array.shape}")
    if array.itemsize < 4:
        array = array.astype(np.int32)
    else:
        array = array.astype(array.dtype.newbyteorder("="), copy=False)
    return np.require(array, requirements=["C", "ALIGNED"])


def count_of(shape: tuple[int, ...]) -> int:
    """How many rays have these leading dimensions."""
    return math.prod(shape)
