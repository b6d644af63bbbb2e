"""Mechanical advantage: output force or torque divided by that of an input, without losses, the other inputs fixed.

Without losses F_out v_out = F_in v_in, so that the advantage is the ratio of rates d(in) / d(out), angles in rad.
Source: Norton, Design of Machinery, section 6.6; Uicker, Pennock & Shigley, Theory of Machines and Mechanisms.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.mechanism import FRAME, FloatArray, Mechanism
from gimcli.quantities.extremes import RateRows
from gimcli.quantities.quantity import Head, Kind, Quantity, place_of, point_names, unit_of
from gimcli.quantities.state import State
from gimcli.rates.derivatives import MotionRates

STILL = 1e-12
"""Rate of the output for a unit rate of the input (normal frame) below which the output is at rest."""


class Advantage(Quantity):
    """The mechanical advantage and its inverse."""

    def __init__(self, mechanism: Mechanism, spec: str, actuator: int, output: str) -> None:
        self.mechanism, self.spec, self.actuator = mechanism, spec, actuator
        self.member, self.slide, self.point = _output(mechanism, spec, output)
        turning = mechanism.actuators[actuator].rotary
        linear = self.member is None
        units = ("", "") if turning != linear else ("1/{}", "{}") if turning else ("{}", "1/{}")
        own, ratio = (unit_of(mechanism, unit) if unit else "" for unit in units)
        self.heads = (Head(spec, own, "mechanical advantage"), Head(f"{spec}.ratio", ratio))
        # from the normal frame to the file's units
        self.scale = (mechanism.scale if linear else 1.0) / (1.0 if turning else mechanism.scale)

    def values(self, state: State) -> Sequence[Any]:
        """Return d(in) / d(out) (inf if the output is at rest) and d(out) / d(in), each (rows,)."""
        ratio = self._rate(state.path.of_input(self.actuator))
        ratio = np.where(np.abs(ratio) <= STILL, 0.0, ratio)
        with np.errstate(all="ignore"):
            return [np.where(ratio == 0.0, np.inf, 1.0 / (ratio * self.scale)), ratio * self.scale]

    def _rate(self, rates: MotionRates) -> FloatArray:
        """Return the rate of the output (rows,): of a member's angle, along a guide, or along a point's path."""
        if self.member is not None:
            return np.asarray(rates.angular(self.member)[0])
        if self.slide is not None:
            return np.asarray(RateRows(np.empty(0), rates).travel(self.slide).slopes[0])
        assert self.point is not None
        return np.asarray(np.abs(rates.point(self.point)[1]))


def _output(mechanism: Mechanism, spec: str, name: str) -> tuple[int | None, int | None, str | None]:
    """Return the moving member, slide, or point or node of a name; the two others are None."""
    members = [m.name for m in mechanism.members]
    if name in members[FRAME + 1 :]:
        return members.index(name, FRAME + 1), None, None
    pairs = [s.pair for s in mechanism.slides]
    if name in pairs:
        return None, pairs.index(name), None
    known = [*members[FRAME + 1 :], *pairs, *point_names(mechanism)]
    place_of(spec, "member, sliding pair, point or node", name, known)
    return None, None, name


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> Sequence[Quantity]:
    actuator = place_of(spec, "actuator", names[0], [a.name for a in mechanism.actuators])
    return [Advantage(mechanism, spec, actuator, names[1])]


KIND = Kind(
    "advantage",
    "ACTUATOR/OUTPUT",
    "force or torque of an output (member, sliding pair, point) over an input's; angles in rad, inf at rest",
    (2,),
    _make,
)
