"""The compiled part of halfline; crates/halfline-python."""

from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Explanation",
    "FormatError",
    "Mesh",
    "MeshArray",
    "Picture",
    "RenderSettings",
    "Rendering",
    "Scene",
    "__version__",
    "encode_png",
    "main",
    "set_thread_count",
    "thread_count",
    "write_file",
]

__version__: str

_Report: TypeAlias = Callable[[str, int, int], object]
_Floats: TypeAlias = NDArray[np.float32] | NDArray[np.float64]
_Vectors: TypeAlias = _Floats | tuple[float, float, float]
_Numbers: TypeAlias = _Floats | float
_Material: TypeAlias = tuple[Sequence[float], float, float, float, float]
_Extras: TypeAlias = tuple[
    NDArray[np.uint32] | None, NDArray[np.uint8] | None, NDArray[np.uint32] | None, list[_Material]
]

class FormatError(ValueError): ...

@final
class Explanation:
    def __new__(
        cls,
        scene: Scene,
        origin: Sequence[float],
        direction: Sequence[float],
        t_min: float,
        t_max: float,
        rule: str,
        name: str,
        progress: _Report | None = None,
        /,
    ) -> Explanation: ...
    def json(self) -> str: ...
    def text(self) -> str: ...
    def page(self) -> str: ...

@final
class RenderSettings:
    def __new__(cls, **keywords: Any) -> RenderSettings: ...
    @staticmethod
    def from_json(json: str, /) -> RenderSettings: ...
    def to_json(self) -> str: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def samples(self) -> int: ...

@final
class Picture:
    def __new__(cls, scene: Scene, settings: RenderSettings, /) -> Picture: ...
    @property
    def size(self) -> tuple[int, int]: ...
    def trace_rows(self, first: int, end: int, progress: _Report | None = None, /) -> bytes: ...
    def trace(self, progress: _Report | None = None, /) -> Rendering: ...

@final
class Rendering:
    @staticmethod
    def assemble(settings: RenderSettings, parts: Sequence[bytes], /) -> Rendering: ...
    @property
    def size(self) -> tuple[int, int]: ...
    def pixels(self) -> tuple[NDArray[np.uint8], int]: ...
    def layers(
        self,
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float32],
        NDArray[np.float32],
        NDArray[np.int64],
        NDArray[np.float32] | None,
    ]: ...
    def rays(self) -> dict[str, int]: ...
    def save(self, path: str, is_exr: bool, /) -> None: ...

def encode_png(pixels: NDArray[np.uint8], width: int, height: int, channels: int, /) -> bytes: ...
def write_file(path: str, content: bytes, /) -> None: ...
def main(arguments: list[str], connect: Callable[[str], object] | None = None, /) -> int: ...
def thread_count() -> int: ...
def set_thread_count(count: int | None, /) -> None: ...

@final
class MeshArray:
    @property
    def __array_interface__(self) -> dict[str, Any]: ...

@final
class Mesh:
    @staticmethod
    def load(path: str, progress: _Report | None = None, /) -> Mesh: ...
    @staticmethod
    def generate(
        kind: str, triangles: int, seed: int, progress: _Report | None = None, /
    ) -> Mesh: ...
    @staticmethod
    def from_arrays(vertices: _Floats, faces: NDArray[Any], /) -> Mesh: ...
    @property
    def vertices(self) -> MeshArray: ...
    @property
    def faces(self) -> MeshArray: ...
    @property
    def vertex_count(self) -> int: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def is_single_precision(self) -> bool: ...
    def bounds(self) -> list[list[float]] | None: ...
    def surface(
        self,
        face: NDArray[np.int64],
        uv: NDArray[np.float64],
        points: NDArray[np.float64],
        normals: NDArray[np.float64],
    ) -> None: ...
    def origins_towards(
        self,
        face: NDArray[np.int64],
        uv: NDArray[np.float64],
        directions: NDArray[np.float64],
        origins: NDArray[np.float64],
    ) -> None: ...
    def save(self, path: str, progress: _Report | None = None, /) -> None: ...
    def extras(self) -> _Extras: ...
    def with_extras(self, extras: _Extras) -> Mesh: ...

@final
class Scene:
    @staticmethod
    def build(
        mesh: Mesh,
        preset: Literal["fast", "balanced", "best"] | str,
        progress: _Report | None = None,
        /,
    ) -> Scene: ...
    @staticmethod
    def open(
        path: str, verify: bool | None = None, progress: _Report | None = None, /
    ) -> Scene: ...
    def save(self, path: str, progress: _Report | None = None, /) -> None: ...
    @property
    def file(self) -> tuple[str, str, str, int] | None: ...
    @property
    def mesh(self) -> Mesh: ...
    @property
    def preset(self) -> str: ...
    def info(self) -> dict[str, Any]: ...
    def intersect(
        self,
        origins: _Vectors,
        directions: _Vectors,
        t_min: _Numbers,
        t_max: _Numbers,
        t: NDArray[np.float64],
        face: NDArray[np.int64],
        uv: NDArray[np.float64],
        progress: _Report | None = None,
        /,
    ) -> None: ...
    def occluded(
        self,
        origins: _Vectors,
        directions: _Vectors,
        t_min: _Numbers,
        t_max: _Numbers,
        flags: NDArray[np.bool_],
        progress: _Report | None = None,
        /,
    ) -> None: ...
    def count_intersections(
        self,
        origins: _Vectors,
        directions: _Vectors,
        t_min: _Numbers,
        t_max: _Numbers,
        counts: NDArray[np.int64],
        progress: _Report | None = None,
        /,
    ) -> None: ...
    def closest_points(
        self,
        points: _Vectors,
        max_distance: _Numbers,
        distance: NDArray[np.float64],
        point: NDArray[np.float64],
        face: NDArray[np.int64],
        uv: NDArray[np.float64],
        feature: NDArray[np.uint8],
        progress: _Report | None = None,
        /,
    ) -> None: ...
    def signed_distance(
        self,
        points: _Vectors,
        distance: NDArray[np.float64],
        progress: _Report | None = None,
        /,
    ) -> None: ...
    def winding_number(
        self,
        points: _Vectors,
        numbers: NDArray[np.float64],
        progress: _Report | None = None,
        /,
    ) -> None: ...
    def contains(
        self,
        points: _Vectors,
        rule: Literal["winding", "parity"] | str,
        flags: NDArray[np.bool_],
        progress: _Report | None = None,
        /,
    ) -> None: ...
    def intersect_all(
        self,
        count: int,
        origins: _Vectors,
        directions: _Vectors,
        t_min: _Numbers,
        t_max: _Numbers,
        progress: _Report | None = None,
        /,
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]: ...
