"""Ranges of the traced points of a motion, and whether their curves are closed; the motion may come in pieces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.quantities.quantity import ColumnRange
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
        self.ranges = {name: (ColumnRange(), ColumnRange()) for name in mechanism.traced}
        self.first: dict[str, FloatArray] = {}
        self.last: dict[str, FloatArray] = {}

    def add(self, table: Table) -> None:
        """Add the next rows of a motion."""
        for name, own in self.ranges.items():
            places = np.stack([table.floats(f"{name}.{axis}") for axis in "xy"])
            for one, values in zip(own, places, strict=True):
                one.add(values)
            self.first.setdefault(name, places[:, 0])
            self.last[name] = places[:, -1]

    def report(self, motion: Motion) -> dict[str, dict[str, Any]]:
        """Return ranges and kind of curve by the names of the points; `motion` has enough rows to count turns."""
        if not any(math.isfinite(x.least) for x, _ in self.ranges.values()):
            return {}
        return {
            name: {
                "x": [x.least, x.greatest], "y": [y.least, y.greatest], "curve": self._curve(name, _own(motion, name)),
            }
            for name, (x, y) in self.ranges.items()
        }  # fmt: skip

    def _curve(self, name: str, motion: Motion) -> str:
        """Return whether a curve is closed; the path on a circle or a line of the frame may go there and back."""
        near = SAME * motion.mechanism.size * motion.mechanism.scale
        if not max(own.greatest - own.least for own in self.ranges[name]) > near:
            return FIXED
        if self.ranges[name][1].empty or not math.dist(self.last[name], self.first[name]) <= near:
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
