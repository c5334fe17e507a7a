"""What a library's process of `make bench-cli` reports."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np


@dataclass
class Report:
    """What one process found out."""

    key: str
    """Of the library: open3d."""
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
        path = Path(rays_path).with_suffix(f".{self.key}.npy")
        np.save(path, faces)
        self.faces[name] = str(path)

    def print(self) -> None:
        """Writes the report to stdout, where the study reads its last line."""
        print(json.dumps(asdict(self)))
