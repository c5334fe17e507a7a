"""Casts rays at triangle meshes of any size, exactly.

    >>> import halfline
    >>> scene = halfline.Scene(halfline.generate("sphere", 1280))   # or of halfline.load(path)
    >>> hits = scene.intersect([[0, 0, 3], [0, 9, 3]], [0, 0, -1])
    >>> hits.t                               # also .face .uv .point .normal; misses inf and -1
    array([ 2., inf])

See `Scene` for what can be asked, and docs/python.md for a guide. `set_thread_count` and the
environment variable HALFLINE_THREADS say how many threads work; by default it is as many as there
are cores that the process may use.
"""

from __future__ import annotations

from halfline._native import FormatError, __version__, set_thread_count, thread_count

# What type checkers take for true. To import it from typing would be half of the command's start.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from halfline._explanation import Explanation
    from halfline._hits import AllHits, Hits
    from halfline._image import Image
    from halfline._mesh import Mesh, generate, load
    from halfline._nearest import Nearest
    from halfline._open import open_tree as open  # noqa: A004
    from halfline._scene import Scene

__all__ = [
    "AllHits",
    "Explanation",
    "FormatError",
    "Hits",
    "Image",
    "Mesh",
    "Nearest",
    "Scene",
    "__version__",
    "generate",
    "load",
    "open",
    "set_thread_count",
    "thread_count",
]

# The command must start without NumPy, so what needs it is imported when it is asked for.
_LAZY = {
    "AllHits": "halfline._hits",
    "Explanation": "halfline._explanation",
    "Hits": "halfline._hits",
    "Image": "halfline._image",
    "Mesh": "halfline._mesh",
    "Nearest": "halfline._nearest",
    "Scene": "halfline._scene",
    "generate": "halfline._mesh",
    "load": "halfline._mesh",
    "open": "halfline._open",
}

# What `import halfline` finds when it is asked for.
_SUBMODULES = ("dask", "open3d", "trimesh")

# In its module it has another name, to leave the built-in one alone there.
_NAMES = {"open": "open_tree"}

if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        from importlib import import_module

        if name in _SUBMODULES:
            return import_module(f"halfline.{name}")
        if name in _LAZY:
            value = getattr(import_module(_LAZY[name]), _NAMES.get(name, name))
            globals()[name] = value
            return value
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted({*globals(), *_LAZY, *_SUBMODULES})
