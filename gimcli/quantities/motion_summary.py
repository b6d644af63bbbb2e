"""Strokes, swings, time ratios, worst transmission angles and greatest speeds of a motion along the laws.

The time ratio of an output is that of the times of its slower and faster stroke at constant speed of the input, that
is of the angles by which the input turns between the ends of the stroke. Source: Norton, Design of Machinery, sections
3.4 (quick return) and 4.10 (transmission angle).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from gimcli.canonical import TURN, first_greatest, whole_turns
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion, stream, trace
from gimcli.positions.inputs import law_inputs
from gimcli.positions.options import Options
from gimcli.quantities.extremes import Extreme, Extremes, RateRows, Sought, extremes
from gimcli.quantities.state import State
from gimcli.quantities.transmission import TransmissionJoint, output_joints
from gimcli.rates.derivatives import MotionRates, law_rates, rates_of_inputs
from gimcli.structure.joints import sliding_pairs
from gimcli.structure.kinematic_chain import kinematic_chain
from gimcli.structure.mechanism_types import driving_links
from gimcli.structure.steps import NONE


def amount(vector: Any) -> Any:
    """Return the magnitude of a vector (rows,); where it is 0, its derivative is 0."""
    size = abs(vector)
    return np.where(size > 0.0, size, 0.0 * size.value)


def speed(point: str, order: int, state: State) -> Any:
    """Return the magnitude of the velocity (order 1) or acceleration (order 2) of a point [normal length/s, /s^2]."""
    return amount(state.point(point, order))


def angular_speed(member: int, order: int, state: State) -> Any:
    """Return the magnitude of the angular velocity (order 1) or acceleration (order 2) of a member [rad/s, rad/s^2]."""
    return abs(state.turning(member, order))


def rotation(rows: RateRows, member: int) -> Sought:
    """Return the angle of a member [rad], full turns counted from rows in which it turns by less than half a turn."""
    own = rows.counted(member).value
    good = np.isfinite(own)
    return Sought(partial(_rotation, member, rows.time[good], np.unwrap(own[good])), True)


def _rotation(member: int, time: FloatArray, angle: FloatArray, state: RateRows) -> Any:
    own = state.counted(member)
    return own - TURN * whole_turns(own.value - np.interp(state.time, time, angle))


def flatness(joint: TransmissionJoint, state: State) -> Any:
    """Return the magnitude of the cosine of a transmission angle: 0 at 90 degrees, 1 at 0 and 180 degrees."""
    first, second = (state.line(line, joint.node) for line in (joint.first, joint.second))
    product = np.conj(first) * second
    return abs(product.real / abs(product))


STEPS, MOST_STEPS, FEWEST = 360, 7200, 36
"""Steps of the motion, and of each turn of an input; their number above which turns have fewer steps; the fewest."""

TOWARDS = 12
"""RateRows that approach a limit, each at half the distance of the row before."""

UNBOUNDED = 1.2
"""Ratio of a speed to that at twice the distance from a limit; a speed that grows without bound has 2**0.5 or more."""

AT_LIMIT = 1e-6
"""Difference of the inputs, in rad or relative to the size, of the same limit."""

STILL = 1e-9
"""Range, in rad or relative to the size, below which an output does not move."""

SLOW = 1e-6
"""Part of the greatest speed below which a speed is 0: a member that translates has rounding errors."""

CLOSE = 1e-12
"""Difference of times, 0..1, below which the positions are equal: a motion cannot be continued over shorter steps."""


@dataclass(frozen=True)
class Output:
    """The range of a slider along its guide, or of a member hinged to the frame."""

    name: str
    guide: str  # of a slider: the member that carries the guide; "" for a member
    found: Extremes  # normal length, or rad
    time_ratio: float | None  # None if the input makes no full turns, or there are several strokes a turn
    strokes: float  # to and fro, in one turn of the input; 0 if it makes no full turns

    @property
    def slides(self) -> bool:
        """Whether it is a slider."""
        return bool(self.guide)

    @property
    def range(self) -> float:
        """Stroke [normal length] or swing [rad]."""
        return self.found.greatest.value - self.found.least.value


@dataclass(frozen=True)
class WorstAngle:
    """The transmission angle of a joint that is farthest from 90 degrees, as an angle of at most 90 degrees."""

    joint: TransmissionJoint
    angle: float  # rad
    time: float


@dataclass(frozen=True)
class Peak:
    """The greatest speed or acceleration of a point or a member."""

    name: str
    rotary: bool
    order: int  # 1: speed, 2: acceleration
    found: Extreme  # value infinite if it grows without bound towards a limit
    constant: bool = False


@dataclass(frozen=True)
class MotionSummary:
    """The characteristics of one motion."""

    motion: Motion = field(repr=False)
    periodic: bool  # the last position is the first one
    turns: int  # full turns of the only input that moves; 0 if the motion is not such a motion
    outputs: tuple[Output, ...]
    angles: tuple[WorstAngle, ...]  # worst first
    peaks: tuple[Peak, ...]


Limit = tuple[ComplexArray, FloatArray]
"""Position (nodes,) and inputs (actuators,) of a limit."""


def motion_summary(mechanism: Mechanism, tolerance: float, limits: Sequence[Limit] = ()) -> MotionSummary | None:
    """Return the characteristics of the motion along the laws; None if its start is not assembled.

    limits: the limits of the circuit; if the motion ends at one of them, its position belongs to the motion.
    """
    options = Options(tolerance=tolerance)
    motion = trace(mechanism, _steps(mechanism), options)
    if motion.codes[0]:
        return None
    return _Summarizer(mechanism, options, motion, _end(motion, limits)).summary()


def _end(motion: Motion, limits: Sequence[Limit]) -> ComplexArray | None:
    """Return the position (nodes,) of the limit at which a motion ends; None if it is not known."""
    if motion.limit is None:
        return None
    mechanism, inputs = motion.mechanism, law_inputs(motion.mechanism)(np.array([motion.limit]))[:, 0]
    last, near = motion.z[:, motion.good][:, -1], []
    for z, u in limits:
        away = [
            math.remainder(a, TURN) if actuator.rotary else a
            for a, actuator in zip((u - inputs).tolist(), mechanism.actuators, strict=True)
        ]
        if max(map(abs, away)) <= AT_LIMIT * mechanism.size:
            near.append(z)
    return min(near, key=lambda z: float(np.max(mechanism.apart(z, last))), default=None)


def _steps(mechanism: Mechanism) -> int:
    """Return a number of steps such that each input turns by about one degree in each, or ten in very long motions."""
    times = np.linspace(0.0, 1.0, STEPS + 1)
    moved = np.abs(np.diff(law_inputs(mechanism)(times), axis=1)).sum(axis=1)
    turns = max((m / TURN for m, a in zip(moved, mechanism.actuators, strict=True) if a.rotary), default=0.0)
    whole = max(1, math.ceil(turns - STILL))
    return max(min(MOST_STEPS, STEPS * whole), FEWEST * whole)


class _Summarizer:
    def __init__(self, mechanism: Mechanism, options: Options, motion: Motion, end: ComplexArray | None) -> None:
        self.mechanism, self.options, self.motion, self.end = mechanism, options, motion, end
        good = motion.good
        first, last = motion.z[:, 0], motion.z[:, -1]
        self.periodic = bool(good.all()) and float(np.max(mechanism.apart(last, first))) <= STILL * mechanism.size
        self.turns = self._turns()
        self.rows = self._all_rows()

    def summary(self) -> MotionSummary:
        """Return everything; all quantities are refined together."""
        outputs, joints, speeds = self._outputs(), output_joints(self.mechanism, coupled=False), self._speeds()
        angles = [Sought(partial(flatness, joint)) for joint in joints]
        quantities: list[Sought] = [*(q for _, _, q in outputs), *angles, *(q for *_, q in speeds)]
        found = extremes(self.rows, quantities, self._solve, self.periodic)
        first, second = len(outputs), len(outputs) + len(joints)
        moved = [self._output(name, guide, one) for (name, guide, _), one in zip(outputs, found, strict=False) if one]
        worst = [
            WorstAngle(joint, math.acos(min(1.0, one.greatest.value)), one.greatest.time)
            for joint, one in zip(joints, found[first:second], strict=True)
            if one
        ]
        peaks = [
            self._peak(name, rotary, order, q, one)
            for (name, rotary, order, q), one in zip(speeds, found[second:], strict=True)
            if one
        ]
        return MotionSummary(
            self.motion, self.periodic, self.turns, tuple(o for o in moved if o is not None),
            tuple(sorted(worst, key=lambda w: w.angle)), tuple(peaks),
        )  # fmt: skip

    # -- rows -----------------------------------------------------------------------------------

    def _solve(self, time: FloatArray) -> RateRows:
        """Return rows at increasing times; times that are almost equal have the same position."""
        apart = np.diff(time, prepend=0.0) > CLOSE
        whole = np.append(0.0, time[apart])
        motion = next(stream(self.mechanism, 1, self.options, between=lambda _: whole))
        return self._rows(time, motion.z[:, np.cumsum(apart)])

    def _rows(self, time: FloatArray, z: ComplexArray) -> RateRows:
        rates = rates_of_inputs(self.mechanism, z, law_rates(self.mechanism, time, 3))
        rates.nodes[0] = z  # also where rates are not determined
        return RateRows(time, rates)

    def _all_rows(self) -> RateRows:
        """Return the rows of the motion; before a limit rows that approach it, and the limit itself."""
        motion, limit = self.motion, self.motion.limit
        good = motion.good
        if limit is None or limit <= motion.time[good][-1]:
            return self._rows(motion.time[good], motion.z[:, good])
        last = float(motion.time[good][-1])
        near = limit - (limit - last) * 0.5 ** np.arange(1, TOWARDS)
        rows = self._solve(np.concatenate([motion.time[good], near]))
        return rows if self.end is None else _with_end(rows, limit, self.end)

    def _turns(self) -> int:
        """Return the number of full turns of the only input that moves, in one sense; 0 for all other motions."""
        u = self.motion.inputs
        moving = np.flatnonzero(np.ptp(u, axis=1) > 0.0)
        if len(moving) != 1 or not self.mechanism.actuators[moving[0]].rotary or not self.periodic:
            return 0
        step = np.diff(u[moving[0]])
        turns = abs(float(step.sum())) / TURN
        whole = abs(turns - round(turns)) <= STILL and (np.all(step >= 0.0) or np.all(step <= 0.0))
        return round(turns) if whole else 0

    # -- outputs --------------------------------------------------------------------------------

    def _outputs(self) -> list[tuple[str, str, Sought]]:
        """Return name, guide and position of every slider and every driven member hinged to the frame."""
        mechanism, members = self.mechanism, self.mechanism.members
        found: list[tuple[str, str, Sought]] = []
        for pair in sliding_pairs(mechanism):
            if pair.actuator == NONE:
                guide = "frame" if pair.bodies[0] == FRAME else members[pair.bodies[0]].name
                found.append((pair.name, guide, Sought(partial(RateRows.travel, slide=pair.slides[0]), True)))
        hinged = {
            link
            for joint in kinematic_chain(mechanism).joints
            if joint.kind == "R" and FRAME in joint.bodies
            for link in joint.bodies
            if 0 < link < len(members)
        }
        for member in sorted(hinged - driving_links(mechanism)):
            found.append((members[member].name, "", rotation(self.rows, member)))
        return found

    def _output(self, name: str, guide: str, found: Extremes) -> Output | None:
        size = self.mechanism.size if guide else 1.0
        if found.greatest.value - found.least.value <= STILL * size:
            return None
        strokes = found.reversals / (2.0 * self.turns) if self.turns else 0.0
        ratio = self._time_ratio(found) if strokes == 1.0 else None
        return Output(name, guide, found, ratio, strokes)

    def _time_ratio(self, found: Extremes) -> float:
        u = law_inputs(self.mechanism)(np.array([found.least.time, found.greatest.time]))
        moving = first_greatest(np.ptp(self.motion.inputs, axis=1))
        away = abs(float(u[moving, 1] - u[moving, 0])) % TURN
        return max(away, TURN - away) / min(away, TURN - away)

    # -- speeds ---------------------------------------------------------------------------------

    def _speeds(self) -> list[tuple[str, bool, int, Sought]]:
        """Return name, whether it is of a member, order and quantity of all speeds that are not 0."""
        mechanism = self.mechanism
        driven = [k for k in range(1, len(mechanism.members)) if k not in driving_links(mechanism)]
        points: dict[str, Any] = {name: partial(speed, name) for name in mechanism.traced}
        members: dict[str, Any] = {mechanism.members[k].name: partial(angular_speed, k) for k in driven}
        found: list[tuple[str, bool, int, Sought]] = []
        remote = {mechanism.nodes[n] for n in mechanism.remote}
        for rotary, speeds in ((False, points), (True, members)):
            near = [formula for name, formula in speeds.items() if name not in remote] or speeds.values()
            most = max((self._most(Sought(partial(formula, 1))) for formula in near), default=0.0)
            for name, formula in speeds.items():
                for order, least in ((1, SLOW * most), (2, SLOW * most**2)):  # per s and, for sizes of about 1, per s^2
                    own = Sought(partial(formula, order))
                    if self._most(own) > least:
                        found.append((name, rotary, order, own))
        return found

    def _most(self, quantity: Sought) -> float:
        values = quantity.of(self.rows)[0]
        return float(np.max(values[np.isfinite(values)], initial=0.0))

    def _peak(self, name: str, rotary: bool, order: int, quantity: Sought, found: Extremes) -> Peak:
        if self.motion.limit is not None and self._grows(quantity):
            return Peak(name, rotary, order, Extreme(math.inf, self.motion.limit))
        constant = found.greatest.value - found.least.value <= STILL * found.greatest.value
        return Peak(name, rotary, order, found.greatest, constant)

    def _grows(self, quantity: Sought) -> bool:
        """Return whether a speed grows without bound towards the limit at which the motion ends."""
        f, _ = quantity.of(self.rows)
        f = f[np.isfinite(f)]
        return len(f) > 2 and bool(f[-1] > UNBOUNDED * f[-2] > 0.0)


def _with_end(rows: RateRows, time: float, end: ComplexArray) -> RateRows:
    """Return rows with a position at the end that has no derivatives."""
    rates = rows.rates
    z = np.concatenate([rates.nodes, np.full((*rates.nodes.shape[:2], 1), np.nan + 0j)], axis=2)
    z[0, :, -1] = end
    angles = np.concatenate([rates.angles, np.full((*rates.angles.shape[:2], 1), np.nan)], axis=2)
    return RateRows(np.append(rows.time, time), MotionRates(rates.mechanism, rates.order, z, angles))
