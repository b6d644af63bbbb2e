"""Coordinates and directions by name, in the file's units."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gimcli.library.result import ByName
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.motion.coupler_points import carried_point


def places(mechanism: Mechanism, z: ComplexArray, shape: Callable[[ComplexArray], Any]) -> ByName:
    """Return the coordinates of nodes and points; `shape` converts complex numbers (rows,) to the value."""
    names = (*mechanism.nodes, *(p.name for p in mechanism.points))
    return ByName(names, lambda name: shape(np.asarray(mechanism.to_file(carried_point(mechanism, name, z)))))


def pairs(z: ComplexArray) -> FloatArray:
    """Return complex numbers (rows,) as x and y (rows, 2)."""
    return np.stack([z.real, z.imag], axis=-1)


def coordinates(found: Mapping[str, complex]) -> dict[str, list[float]]:
    """Return complex numbers by name as x and y, for a report."""
    return {name: [float(z.real), float(z.imag)] for name, z in found.items()}


def angles(mechanism: Mechanism, z: ComplexArray, shape: Callable[[FloatArray], Any]) -> ByName:
    """Return the directions of the moving members from their first node to their second, in the file's angle unit.

    `shape` converts angles (rows,) to the value.
    """
    members = {m.name: m for m in mechanism.members[FRAME + 1 :]}

    def direction(name: str) -> Any:
        first, second = members[name].nodes[:2]
        found = np.angle(z[second] - z[first])
        return shape(np.degrees(found) if mechanism.angle_unit == "deg" else found)

    return ByName(tuple(members), direction)


def counted(mechanism: Mechanism, angle: FloatArray, ahead: FloatArray | float = 0.0) -> FloatArray:
    """Return angles (rows,) with full turns counted; rows without a position stay NaN.

    `ahead` (rows - 1,) is the approximate change from each row to the next. By default it is 0: the change is then
    taken to be less than half a turn.
    """
    found, good, turn = angle.copy(), np.isfinite(angle), _turn(mechanism)
    change = np.diff(angle[good])
    found[good] = (
        angle[good] + turn * np.cumsum(np.concatenate([[0.0], np.round((ahead - change) / turn)]))[: good.sum()]
    )
    return found


def widest(mechanism: Mechanism, angle: FloatArray) -> float:
    """Return the largest change [rad] of an angle (rows,) from one row to the next, at most half a turn."""
    turn = _turn(mechanism)
    change = np.abs((np.diff(angle) + 0.5 * turn) % turn - 0.5 * turn) / turn
    return 2.0 * np.pi * float(np.max(change[np.isfinite(change)], initial=0.0))


def _turn(mechanism: Mechanism) -> float:
    return 360.0 if mechanism.angle_unit == "deg" else 2.0 * np.pi
