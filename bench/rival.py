"""What the processes that measure a rival share."""

from __future__ import annotations

import json
import sys
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np


class Clock:
    """Measures the wall time of a `with` block."""

    seconds: float

    def __enter__(self) -> Clock:
        self._begin = time.perf_counter()
        return self

    def __exit__(self, *_: object) -> None:
        self.seconds = time.perf_counter() - self._begin


def resident_bytes() -> int:
    """How much memory this process holds now; 0 where the system does not tell."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except FileNotFoundError:
        return 0
    return pages * 4096


@dataclass
class Report:
    """What one process found out."""

    tool: str
    threads: int
    triangles: int = 0
    load_seconds: float = 0.0
    build_seconds: float | None = None
    tree_bytes: int | None = None
    """By how much the process grew while it built; includes copies of the vertices."""
    trace_seconds: dict[str, float] = field(default_factory=dict)
    faces: dict[str, str] = field(default_factory=dict)
    """For each kind of rays the file that holds the faces hit."""

    def add_trace(
        self, name: str, seconds: float, faces: np.ndarray[Any, Any], rays_path: str
    ) -> None:
        """Notes how long the rays took, and keeps what they hit beside them."""
        self.trace_seconds[name] = seconds
        path = Path(rays_path).with_suffix(f".{Path(sys.argv[0]).stem}.npy")
        np.save(path, faces)
        self.faces[name] = str(path)

    def print(self) -> None:
        """Writes the report to stdout, where versus.py reads its last line."""
        print(json.dumps(asdict(self)))
