"""Why a ray hit what it hit, or nothing."""

from __future__ import annotations

import json
import os
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from halfline._arrays import path_of, rays_of
from halfline._native import Explanation as NativeExplanation
from halfline._native import Scene as NativeScene
from halfline._native import write_file
from halfline._progress import Progress, reporting


class Explanation:
    """Why a ray hit what it hit, or nothing: what `Scene.explain` returns.

    `print(explanation)` tells the walk step by step; in Jupyter it shows itself as a page with a
    drawing, stepped with the arrow keys. All of it is in `to_dict()`, whose form is that of
    `halfline explain --json`: docs/explain.md and docs/explain.schema.json describe it. Cells and
    faces are known by their numbers.
    """

    def __init__(self) -> None:
        raise TypeError("an explanation comes from Scene.explain")

    @classmethod
    def _of(
        cls,
        scene: NativeScene,
        origin: ArrayLike,
        direction: ArrayLike,
        t_range: tuple[float, float],
        rule: str,
        progress: Progress,
    ) -> Explanation:
        shape, (from_point, along, t_min, t_max) = rays_of(origin, direction, *t_range)
        # One vector or number comes as such, unless it was meant for many rays.
        if (
            shape != ()
            or not (isinstance(from_point, tuple) and isinstance(along, tuple))
            or not (isinstance(t_min, float) and isinstance(t_max, float))
        ):
            raise ValueError(f"expected one ray, found rays of shape {shape}")
        file = scene.file
        name = "mesh" if file is None else Path(file[0]).name
        explanation = cls.__new__(cls)
        with reporting(progress) as report:
            explanation._native = NativeExplanation(
                scene, from_point, along, t_min, t_max, rule, name, report
            )
        return explanation

    _native: NativeExplanation

    @cached_property
    def _data(self) -> dict[str, Any]:
        data: dict[str, Any] = json.loads(self._native.json())
        return data

    @property
    def hit(self) -> dict[str, Any] | None:
        """The closest hit: `t`, `face`, `uv` and `point`; None for a miss."""
        hit: dict[str, Any] | None = self._data["hit"]
        return hit

    @property
    def nearest_miss(self) -> dict[str, Any] | None:
        """The triangle that the ray passes closest; None for a hit, or without triangles.

        `face`, `distance` and `t`, the points `point_on_ray` and `point_on_face` that are nearest
        to each other, and `why` in words.
        """
        miss: dict[str, Any] | None = self._data["nearest_miss"]
        return miss

    @property
    def counts(self) -> dict[str, dict[str, int]]:
        """`nodes`, `leaves` and `triangles` for "brute_force", "textbook" and "engine"."""
        counts: dict[str, dict[str, int]] = self._data["counts"]
        return counts

    @property
    def steps(self) -> list[dict[str, Any]]:
        """The walk, in order; `kind` is "clip", "inner", "leaf", "pop" or "end"."""
        steps: list[dict[str, Any]] = self._data["steps"]
        return steps

    @property
    def cells(self) -> list[dict[str, Any]]:
        """The cells that the walk saw, by number; the root is cell 0."""
        cells: list[dict[str, Any]] = self._data["cells"]
        return cells

    def to_dict(self) -> dict[str, Any]:
        """All of it, as a new dict that `json.dump` can write."""
        data: dict[str, Any] = json.loads(self._native.json())
        return data

    def to_html(self) -> str:
        """A page to step through, which needs nothing but itself."""
        return self._native.page()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page, the JSON or the text. The file appears whole or not at all.

        Args:
            path: Ends in .html, .json or .txt.

        Raises:
            ValueError: For another extension.
            OSError: If the file cannot be written.
        """
        path = path_of("path", path)
        forms = {
            ".html": self._native.page,
            ".json": lambda: json.dumps(self._data, indent=2) + "\n",
            ".txt": self._native.text,
        }
        form = forms.get(Path(path).suffix.lower())
        if form is None:
            names = ", ".join(forms)
            raise ValueError(f"path: expected a name that ends in one of {names}, found {path!r}")
        write_file(path, form().encode())

    def __str__(self) -> str:
        return self._native.text()

    def __repr__(self) -> str:
        hit, textbook = self.hit, self.counts["textbook"]
        what = "a miss" if hit is None else f"face {hit['face']} at t = {hit['t']:.6g}"
        return (
            f"<halfline.Explanation: {what}, after {textbook['nodes']} cells and "
            f"{textbook['triangles']} triangles>"
        )

    def _repr_html_(self) -> str:
        """The page in a frame of its own, for Jupyter."""
        return (
            f'<iframe srcdoc="{escape(self.to_html())}" sandbox="allow-scripts" '
            'style="width:100%;height:760px;border:0" title="the walk of a ray"></iframe>'
        )
