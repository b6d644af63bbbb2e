"""Mean bearing loads in the pins: the constant load with the same fatigue life.

Lives are L = (C / P)^p revolutions, p = 3 for ball and 10/3 for roller bearings (ISO 281:2007), and shares of the life
are added (Palmgren 1924, Miner 1945). So a load F(t) in a pin that turns at the relative speed w(t) is equivalent to

    P = (integral of |F|^p |w| dt / integral of |w| dt)^(1/p)

This is the mean load of the catalogues (such as SKF, Rolling bearings, 2018, section B.3), with the direction of the
load left out: radial bearings without axial load, P = F.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimcli.dynamics.forces import Forces
from gimcli.dynamics.kinematic_history import turning
from gimcli.dynamics.statics import Pin, Statics
from gimcli.dynamics.work_balance import RowIntegrals
from gimcli.mechanism import FloatArray

BALL, ROLLER = 3.0, 10.0 / 3.0
"""Exponents of the life of ball and roller bearings."""

TURNING = 1e-9
"""Turns in the whole motion above which a pair turns."""


@dataclass(frozen=True)
class BearingLoad:
    """The mean load of one pin; NaN where the pair does not turn or its reaction is not determined."""

    speed: float  # rev/min, mean of the magnitude of the relative speed
    turns: float  # in both directions together
    ball: float  # N, mean load with p = 3
    roller: float  # N, with p = 10/3


class BearingLoads:
    """Computes the mean loads from the rows of a motion in pieces."""

    def __init__(self, statics: Statics) -> None:
        self.statics = statics
        self.pairs = [
            (reaction_name(statics, pin, member), pin, member) for pin in statics.pins for member in pin.members[1:]
        ]
        self._sums = RowIntegrals(3 * len(self.pairs), signed=3 * len(self.pairs))

    def add(self, forces: Forces) -> None:
        """Add the next rows; those next to singular positions are left out."""
        self._sums.add(self._integrands(forces))

    def result(self, closed: bool, step: float) -> dict[str, BearingLoad]:
        """Return the mean loads by the names of the reactions, after the last rows; `step` is the time of a step."""
        self._sums.finish(closed)
        whole = 2.0 * self._sums.positive - self._sums.net  # of the magnitudes
        found = {}
        for k, (name, _, _) in enumerate(self.pairs):
            (turned, ball, roller), steps = whole[3 * k : 3 * k + 3], self._sums.steps[3 * k]
            turns = turned * step / (2.0 * math.pi)
            speed = 60.0 * turns / (steps * step) if steps else math.nan
            if turns > TURNING:
                ball, roller = (ball / turned) ** (1.0 / BALL), (roller / turned) ** (1.0 / ROLLER)
            else:
                ball = roller = math.nan
            found[name] = BearingLoad(float(speed), float(turns), float(ball), float(roller))
        return found

    def _integrands(self, forces: Forces) -> FloatArray:
        """Return relative speed, and its products with powers of the force, of every pair (3 pairs, rows)."""
        mechanism, course = self.statics.mechanism, forces.course
        found = np.full((3 * len(self.pairs), len(course.time)), np.nan)
        for k, (_, pin, member) in enumerate(self.pairs):
            speed = turning(mechanism, course, member)[0] - turning(mechanism, course, pin.members[0])[0]
            force = np.abs(forces.pin(pin, member))
            rows = forces.bounded & np.isfinite(force)
            for j, factor in enumerate((1.0, force**BALL, force**ROLLER)):
                found[3 * k + j] = np.where(rows, speed * factor, np.nan)
        return found


def reaction_name(statics: Statics, pin: Pin, member: int) -> str:
    """Return the name of the reaction of a pin on a member, as in the columns of the table."""
    node, alone = statics.mechanism.nodes[pin.node], len(pin.members) == 2 and not pin.loaded
    return node if alone else f"{node}.{statics.mechanism.members[member].name}"
