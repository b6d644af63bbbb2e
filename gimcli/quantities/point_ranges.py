"""Ranges of the traced points of a motion, and whether their curves are closed; the motion may come in pieces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gimcli.mechanism import FRAME, BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.structure.carried import carried_point
from gimcli.structure.rotation import members_of
from gimcli.table import Table

SAME = 1e-7
"""Distance, relative to the size, of two positions that are the same."""

COUNTED = 2.0
"""Rotation [rad] between two rows up to which turns can be counted."""

CLOSED, OPEN, RETRACED, FIXED = "closed", "open", "there and back", "fixed"


class PointRanges:
    """Least and greatest coordinates of the traced points in the solved rows so far, and their first and last ones."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        shape = len(mechanism.traced), 2
        self.least, self.greatest = np.full(shape, math.inf), np.full(shape, -math.inf)
        self.first, self.last = np.full(shape, math.nan), np.full(shape, math.nan)
        self.rows, self.solved = 0, np.zeros(len(mechanism.traced), dtype=int)

    def add(self, table: Table, good: BoolArray) -> None:
        """Add the next rows of a motion, of which those in `good` (rows,) are solved."""
        places = np.array([[table[f"{name}.{letter}"] for letter in "xy"] for name in self.mechanism.traced])
        values, every = places.reshape(*self.least.shape, len(table)), bool(good.all())
        least, greatest = (np.min, np.max) if every else (np.fmin.reduce, np.fmax.reduce)  # NaN: skipped
        self.least = np.minimum(self.least, least(values, axis=2, initial=math.inf))
        self.greatest = np.maximum(self.greatest, greatest(values, axis=2, initial=-math.inf))
        self.first, self.last = self.first if self.rows else values[..., 0], values[..., -1]
        self.solved += len(table) if every else np.count_nonzero(np.isfinite(values[:, 1]), axis=1)
        self.rows += len(table)

    def report(self, motion: Motion) -> dict[str, dict[str, Any]]:
        """Return ranges and kind of curve by the names of the points; `motion` has enough rows to count turns."""
        if not self.solved.any():
            return {}
        return {
            name: {
                "x": [float(self.least[k, 0]), float(self.greatest[k, 0])],
                "y": [float(self.least[k, 1]), float(self.greatest[k, 1])],
                "curve": self._curve(k, name, _own(motion, name)),
            }
            for k, name in enumerate(self.mechanism.traced)
        }  # fmt: skip

    def _curve(self, number: int, name: str, motion: Motion) -> str:
        """Return whether a curve is closed; the path on a circle or a line of the frame may go there and back."""
        near = SAME * motion.mechanism.size * motion.mechanism.scale
        if float(np.max(self.greatest[number] - self.least[number])) <= near:
            return FIXED
        apart = float(np.hypot(*(self.last[number] - self.first[number])))
        if self.solved[number] < self.rows or not apart <= near:
            return OPEN
        return RETRACED if _returns(motion) or _retraced(motion, name) else CLOSED


def _own(motion: Motion, name: str) -> Motion:
    """Return the motion of the machine that has a node or a point; that of the whole file if none has it."""
    owners = (m for m in motion.machines if name in (*m.mechanism.nodes, *(p.name for p in m.mechanism.points)))
    return next(owners, motion)


def _returns(motion: Motion) -> bool:
    """Return whether the only input that moves returns to its first value along the same branch."""
    moving = np.flatnonzero(np.ptp(motion.inputs, axis=1) > 0.0)
    if len(moving) != 1 or motion.parameter is not None or motion.bridged or motion.touched:
        return False
    u = motion.inputs[moving[0]]
    return bool(abs(u[-1] - u[0]) <= SAME * float(np.ptp(u)))


def _retraced(motion: Motion, name: str) -> bool:
    """Return whether a closed path is on a line of the frame, or on an arc around a fixed node without a full turn."""
    mechanism = motion.mechanism
    if name in mechanism.nodes:
        node = mechanism.nodes.index(name)
        if any(slide.node == node and slide.guide == FRAME for slide in mechanism.slides):
            return True
        members = members_of(mechanism)[node]
    else:
        members = (next(point.member for point in mechanism.points if point.name == name),)
    fixed = set(mechanism.members[FRAME].nodes)
    pivots = [n for m in members if m != FRAME for n in mechanism.members[m].nodes if n in fixed]
    return bool(pivots) and _net_turn(carried_point(mechanism, name, motion.z) - motion.z[pivots[0]]) == 0


def _net_turn(arm: ComplexArray) -> int | None:
    """Return the number of turns of a vector (rows,); None if the rows are too far apart to count them."""
    step: FloatArray = np.angle(arm[1:] / arm[:-1])
    if not float(np.max(np.abs(step), initial=0.0)) <= COUNTED:
        return None
    return round(float(step.sum()) / (2.0 * math.pi))
