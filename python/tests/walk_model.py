"""A small model of the textbook's walk; its explanations are as those of `halfline explain`.

It is plain floating point, for the tests of the page alone: no judge of anything. With it those
tests have walks of every kind, also of kinds that are rare on real meshes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from meshes import Floats, Shape

Json = dict[str, Any]
AXES = "xyz"
EDGES = ("b-c", "c-a", "a-b")


@dataclass
class Cell:
    """A cell of the tree, split only when the walk asks for its children."""

    low: Floats
    high: Floats
    faces: list[int]
    depth: int
    parent: int | None = None
    side: str | None = None
    axis: int | None = None
    plane: float | None = None
    children: tuple[int, int] | None = None


@dataclass
class Walk:
    """One half-line's walk through a tree with planes in the cells' middles, by turns."""

    shape: Shape
    origin: Floats
    direction: Floats
    few: int = 2
    maximum_depth: int = 12
    t_min: float = 0.0
    t_max: float | None = None
    cells: list[Cell] = field(default_factory=list)
    steps: list[Json] = field(default_factory=list)
    hit: Json | None = None
    tested: dict[int, None] = field(default_factory=dict)
    counts: Json = field(default_factory=lambda: {"nodes": 0, "leaves": 0, "triangles": 0})

    def explanation(self, name: str = "model.ply") -> Json:
        """The whole walk, as the command's --json has it, with the page's scenery."""
        corners = self.shape.corners()
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        self.cells.append(Cell(low, high, list(range(len(corners))), 0))
        entry, leave = self.clip()
        is_met = entry <= leave
        self.steps.append(
            {
                "kind": "clip",
                "cell": 0,
                "t_near": entry if is_met else None,
                "t_far": leave if is_met else None,
                "is_met": is_met,
                "why": "the half-line passes through the box around all triangles"
                if is_met
                else "the half-line passes the box around all triangles by",
            }
        )
        if is_met:
            self.loop(entry, leave)
        closest = {"face": self.hit["face"], "t": self.hit["t"]} if self.hit else None
        ending = self.ending(is_met)
        self.steps.append({"kind": "end", "hit": closest, "why": ending})
        miss = None if self.hit else self.nearest_miss()
        drawn = list(self.tested) + ([miss["face"]] if miss else [])
        return {
            "format": 1,
            "halfline": "0.1.0",
            "mesh": {
                "name": name,
                "triangles": len(corners),
                "bounds": [low.tolist(), high.tolist()],
            },
            "ray": {
                "origin": self.origin.tolist(),
                "direction": self.direction.tolist(),
                "t_min": self.t_min,
                "t_max": self.t_max,
            },
            "tree": {
                "rule": "middle",
                "maximum_depth": self.maximum_depth,
                "few_triangles": self.few,
            },
            "hit": self.hit,
            "nearest_miss": miss,
            "ending": ending,
            "counts": {
                "brute_force": {"nodes": 0, "leaves": 0, "triangles": len(corners)},
                "textbook": self.counts,
                "engine": {"nodes": 2, "leaves": 1, "triangles": 8},
            },
            "cells": [self.cell_as_json(cell) for cell in self.cells],
            "steps": self.steps,
            "triangles": {str(face): corners[face].tolist() for face in drawn},
            "engine": {
                "steps": [
                    {
                        "kind": "node",
                        "depth": 0,
                        "bounds": [low.tolist(), high.tolist()],
                        "children": 7,
                        "faces": None,
                        "t_limit": self.t_max,
                    },
                    {
                        "kind": "leaf",
                        "depth": 1,
                        "bounds": [low.tolist(), high.tolist()],
                        "children": None,
                        "faces": list(self.tested)[:8],
                        "t_limit": self.t_max,
                    },
                ]
            },
            "scenery": corners.mean(axis=1)[:3000].tolist(),
        }

    def ending(self, is_met: bool) -> str:
        """Where and why it ended, in a sentence."""
        if self.hit:
            return f"hit face {self.hit['face']} at t = {self.hit['t']:.6g}; no cell left is nearer"
        return "missed: no cell is left" if is_met else "missed: the half-line passes the box by"

    def cell_as_json(self, cell: Cell) -> Json:
        """A cell, whose plane counts only if the walk came to it."""
        return {
            "depth": cell.depth,
            "parent": cell.parent,
            "side": cell.side,
            "bounds": [cell.low.tolist(), cell.high.tolist()],
            "triangles": len(cell.faces),
            "axis": None if cell.axis is None else AXES[cell.axis],
            "plane": cell.plane,
            "children": None if cell.children is None else list(cell.children),
        }

    def clip(self) -> tuple[float, float]:
        """The part of the half-line inside the root's box; the first is greater if none is."""
        entry, leave = self.t_min, math.inf if self.t_max is None else self.t_max
        root = self.cells[0]
        for axis in range(3):
            origin, direction = float(self.origin[axis]), float(self.direction[axis])
            low, high = float(root.low[axis]), float(root.high[axis])
            if direction == 0.0:
                if not low <= origin <= high:
                    return math.inf, -math.inf
                continue
            first, last = sorted(((low - origin) / direction, (high - origin) / direction))
            entry, leave = max(entry, first), min(leave, last)
        return entry, leave

    def loop(self, t_near: float, t_far: float) -> None:
        """The walk itself, with the pushed cells on a stack."""
        stack: list[tuple[int, float, float]] = []
        current: int | None = 0
        while current is not None:
            self.counts["nodes"] += 1
            self.split(current)
            if self.cells[current].children is None:
                self.leaf(current, t_near, t_far)
                current = None
            else:
                current, t_near, t_far = self.inner(current, t_near, t_far, stack)
            while current is None and stack:
                cell, t_near, t_far = stack.pop()
                is_entered = self.hit is None or bool(self.hit["t"] >= t_near)
                why = "the next cell along the half-line"
                if not is_entered:
                    why = "dropped: the hit lies before this cell"
                self.steps.append(
                    {
                        "kind": "pop",
                        "cell": cell,
                        "t_near": t_near,
                        "t_far": t_far,
                        "is_entered": is_entered,
                        "why": why,
                    }
                )
                current = cell if is_entered else None

    def split(self, index: int) -> None:
        """Splits a cell in its middle, on the first axis by turns that separates anything."""
        cell = self.cells[index]
        if cell.depth >= self.maximum_depth or len(cell.faces) <= self.few:
            return
        parent = self.cells[cell.parent] if cell.parent is not None else None
        first = 0 if parent is None or parent.axis is None else (parent.axis + 1) % 3
        corners = self.shape.corners()[cell.faces]
        lows, highs = corners.min(axis=1), corners.max(axis=1)
        for axis in (first, (first + 1) % 3, (first + 2) % 3):
            plane = float(cell.low[axis] / 2 + cell.high[axis] / 2)
            parts = [lows[:, axis] <= plane, highs[:, axis] >= plane]
            if all(part.all() for part in parts):
                continue
            cell.axis, cell.plane = axis, plane
            cell.children = (len(self.cells), len(self.cells) + 1)
            for side, part in zip(("below", "above"), parts, strict=True):
                low, high = cell.low.copy(), cell.high.copy()
                (high if side == "below" else low)[axis] = plane
                faces = [face for face, is_in in zip(cell.faces, part, strict=True) if is_in]
                self.cells.append(Cell(low, high, faces, cell.depth + 1, index, side))
            return

    def inner(
        self, index: int, t_near: float, t_far: float, stack: list[tuple[int, float, float]]
    ) -> tuple[int, float, float]:
        """One of the lecture's cases; returns the cell to enter, with its interval."""
        cell = self.cells[index]
        assert cell.axis is not None
        assert cell.plane is not None
        assert cell.children is not None
        axis, plane = cell.axis, cell.plane
        origin, direction = float(self.origin[axis]), float(self.direction[axis])
        near, far = cell.children if direction >= 0.0 else cell.children[::-1]
        split: float | None = None
        entered, pushed = (near, [t_near, t_far]), None
        if direction == 0.0:
            if origin == plane:
                case, pushed = "in plane", (far, [t_near, t_far])
                why = "the half-line lies in the plane: both children, the whole interval"
            else:
                case = "parallel, below" if origin < plane else "parallel, above"
                entered = (cell.children[origin > plane], [t_near, t_far])
                why = "the half-line is parallel to the plane and stays on its side"
        else:
            split = (plane - origin) / direction
            if split > t_far:
                case, why = "near only", "it leaves the cell before it comes to the plane"
            elif split < t_near:
                case, why = "far only", "it enters the cell behind the plane"
                entered = (far, [t_near, t_far])
            else:
                case, why = "both", "it crosses the plane within the cell: near, then far"
                entered, pushed = (near, [t_near, split]), (far, [split, t_far])
        self.steps.append(
            {
                "kind": "inner",
                "cell": index,
                "t_near": t_near,
                "t_far": t_far,
                "axis": AXES[axis],
                "plane": plane,
                "t_split": split,
                "case": case,
                "plane_touched": split in (t_near, t_far),
                "near": near,
                "far": far,
                "enter": entered[0],
                "enter_interval": entered[1],
                "push": pushed[0] if pushed else None,
                "push_interval": pushed[1] if pushed else None,
                "why": why,
            }
        )
        if pushed:
            stack.append((pushed[0], pushed[1][0], pushed[1][1]))
        return entered[0], entered[1][0], entered[1][1]

    def leaf(self, index: int, t_near: float, t_far: float) -> None:
        """All triangles of a leaf."""
        cell = self.cells[index]
        self.counts["leaves"] += 1
        self.counts["triangles"] += len(cell.faces)
        closest: Json | None = None
        tests = []
        for face in cell.faces:
            self.tested[face] = None
            test = self.test(face, closest)
            tests.append(test)
            if test["verdict"] == "hit":
                closest = {"face": face, "t": test["t"]}
        if closest and (self.hit is None or closest["t"] < self.hit["t"]):
            a, b, c = self.shape.corners()[closest["face"]]
            point = self.origin + closest["t"] * self.direction
            weights = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), point - a, rcond=None)[0]
            self.hit = {**closest, "uv": weights.tolist(), "point": point.tolist()}
        count = f"{len(tests)} triangle{'s' if len(tests) != 1 else ''}"
        why = f"{count}: face {closest['face']} is hit" if closest else f"{count}: none is hit"
        step = {"kind": "leaf", "cell": index, "t_near": t_near, "t_far": t_far}
        self.steps.append({**step, "tests": tests, "closest": closest, "why": why})

    def test(self, face: int, closest: Json | None) -> Json:
        """One triangle's edge signs and verdict."""
        corners = self.shape.corners()[face] - self.origin
        unit = self.direction / np.linalg.norm(self.direction)
        values = [
            float(unit @ np.cross(corners[(edge + 1) % 3], corners[(edge + 2) % 3]))
            for edge in range(3)
        ]
        signs = [(value > 0) - (value < 0) for value in values]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        total = sum(values)
        answer: Json = {"face": face, "edge_signs": signs, "t": None, "edge": None, "by": None}
        if not normal.any():
            return {**answer, "verdict": "no area", "why": "its corners lie on one line"}
        if total == 0.0:
            return {**answer, "verdict": "edge-on", "why": "the half-line lies in its plane"}
        turned = [value / total for value in values]
        if min(turned) < 0.0:
            edge = int(np.argmin(turned))
            b, c = corners[(edge + 1) % 3], corners[(edge + 2) % 3]
            seen = (c - b) - unit * float(unit @ (c - b))
            by = abs(values[edge]) / float(np.linalg.norm(seen))
            why = f"passes outside edge {EDGES[edge]} by {by:.3g}"
            return {**answer, "verdict": "outside", "edge": EDGES[edge], "by": by, "why": why}
        t = float(normal @ corners[0]) / float(normal @ self.direction)
        answer["t"] = t
        if t < self.t_min:
            return {**answer, "verdict": "behind", "why": "it lies behind the origin"}
        if self.t_max is not None and t > self.t_max:
            return {**answer, "verdict": "beyond", "why": "it lies beyond t_max"}
        if closest and t >= closest["t"]:
            why = f"met at t = {t:.6g}, farther than face {closest['face']}"
            return {**answer, "verdict": "farther", "why": why}
        return {**answer, "verdict": "hit", "why": f"hit at t = {t:.6g}"}

    def nearest_miss(self) -> Json:
        """The edge that the half-line passes closest, by many samples along the edges."""
        corners = self.shape.corners()
        ends = np.roll(corners, -1, axis=1)
        weights = np.linspace(0.0, 1.0, 65)[:, None, None, None]
        points = (corners + weights * (ends - corners)).transpose(1, 0, 2, 3).reshape(-1, 195, 3)
        squared = float(self.direction @ self.direction)
        t = np.maximum((points - self.origin) @ self.direction / squared, self.t_min)
        on_ray = self.origin + t[..., None] * self.direction
        distance = np.linalg.norm(points - on_ray, axis=-1)
        face, sample = np.unravel_index(np.argmin(distance), distance.shape)
        edge = ("a-b", "b-c", "c-a")[int(sample) % 3]
        return {
            "face": int(face),
            "distance": float(distance[face, sample]),
            "t": float(t[face, sample]),
            "point_on_ray": on_ray[face, sample].tolist(),
            "point_on_face": points[face, sample].tolist(),
            "why": f"passes beside edge {edge}",
        }
