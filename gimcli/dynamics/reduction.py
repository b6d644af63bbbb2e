"""Equivalent one-degree-of-freedom model: inertia J(q), torque tau(q), potential V(q), and their derivatives.

    J = sum of m |B|^2 + J_i w^2,   dJ/dq = 2 sum of m B.B' + J_i w w',   tau = sum of F.B + T w

with the influence coefficients B, w and their exact derivatives by q (not finite differences). Source: Durango,
Giraldo, Calle & Mesa 2014, eqs 1-6.

The flywheel that keeps the speed of a machine within bounds over a cycle, from its reduced inertia and torque.

The driving torque is constant, the mean over the cycle. Then T(q) = T_0 + E(q) = (J(q) + J_F) w^2 / 2, E being the work
since the beginning of the cycle. The speed reaches its bounds w (1 +- delta / 2) but does not exceed them if

    J_F = (max of (w_min^2 J / 2 - E) - min of (w_max^2 J / 2 - E)) / (w^2 delta)

Source: Wittenbauer, Graphische Dynamik, 1923 (the diagram of J over E); VDI 2149-1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.dynamic_data import TIME
from gimcli.dynamics.kinematic_history import Courses, Turns
from gimcli.dynamics.loading import Loading
from gimcli.dynamics.physical import input_units
from gimcli.dynamics.statics import statics
from gimcli.errors import UsageError
from gimcli.input_laws import ConstantLaw, InputLaw, SummedLaw
from gimcli.mechanism import FloatArray, IntArray, Mechanism
from gimcli.motion.motion import stream
from gimcli.motion.summary import status_column
from gimcli.numerics.along import bisected
from gimcli.positions.options import Options
from gimcli.progress import Notify, Progress
from gimcli.status import Status
from gimcli.table import Column, Table

QUANTITIES = {
    "J": (2, "kg m^2", "kg"), "dJ_dq": (3, "kg m^2/rad", "kg/m"), "tau": (1, "N m", "N"), "V": (0, "J", "J"),
    "dtau_dq": (2, "N m/rad", "N/m"), "dV_dq": (1, "N m", "N"),
}  # fmt: skip
"""Names, powers of the unit of q by which they are divided, and units for a rotary and a linear input.

tau is the torque of weight, loads and springs, V the potential of weight and springs. dtau_dq is NaN if a load has a
table over the input or over time.
"""


@dataclass(frozen=True)
class Reduction:
    """The reduced quantities of a mechanism along one input; NaN in rows without a solution. SI units, by rad or m."""

    mechanism: Mechanism = field(repr=False)
    actuator: int
    q: FloatArray  # (rows,) rad, or length in the normal frame
    columns: dict[str, FloatArray]  # (rows,) each of QUANTITIES
    codes: IntArray  # (rows,) values of Status

    @property
    def solved(self) -> int:
        """Number of rows with a solution."""
        return int(np.sum(self.codes == Status.OK))


def reduce_to_input(
    mechanism: Mechanism, actuator: int, steps: int, jit: str = "off", notify: Notify | None = None,
    progress: Progress | None = None,
) -> Reduction:  # fmt: skip
    """Reduce a mechanism to one input along its law, in `steps` steps; the others keep the first value of their laws.

    Tables over time are evaluated at the time of each row of the law.
    """
    fixed = with_others_fixed(mechanism, actuator)
    courses, turns = Courses(fixed, steps + 1, jit, notify), Turns()
    pieces = list[tuple[FloatArray, FloatArray, IntArray]]()
    for piece in stream(fixed, steps, Options(jit=jit), notify, progress):
        good, table = np.flatnonzero(piece.good), np.full((6, len(piece.time)), np.nan)
        if len(good):
            course = courses.by_input(piece.rows(good), actuator)
            table[:, good] = _reduced(Loading(statics(fixed), course, turns))
        lost = piece.good & ~np.all(np.isfinite(table), axis=0)
        codes = np.where(lost, int(Status.SINGULAR), piece.codes)
        pieces.append((piece.inputs[actuator], np.where(lost, np.nan, table), codes))
    q, table, codes = (np.concatenate(parts, axis=-1) for parts in zip(*pieces, strict=True))
    if any(load.over in (actuator, TIME) and load.curve is not None for load in mechanism.dynamics.loads):
        table[4] = np.nan
    unit = input_units(mechanism)[actuator]
    columns = {name: own / unit**power for (name, (power, *_)), own in zip(QUANTITIES.items(), table, strict=True)}
    return Reduction(mechanism, actuator, q, columns, codes)


@np.errstate(all="ignore")
def _reduced(loads: Loading) -> FloatArray:
    """Return the quantities (6, rows) of a motion at unit speed."""
    torque = sum(loads.power[kind] for kind in ("load", "gravity", "spring"))
    still = 0.0 * loads.course.nodes[0, 0].real
    inertia, torque, v = (number + still for number in (2.0 * loads.kinetic, torque, loads.potential))
    return np.array([inertia.value, inertia.slopes[0], torque.value, v.value, torque.slopes[0], v.slopes[0]])


def with_others_fixed(mechanism: Mechanism, actuator: int) -> Mechanism:
    """Return the mechanism in which all inputs but one keep the first value of their laws."""
    start, law = mechanism.start_inputs, mechanism.actuators[actuator].law
    shares = mechanism.following[:, mechanism.drivers.index(actuator)]
    begun = start - shares * float(law(np.zeros(1))[0])
    laws: list[InputLaw] = [ConstantLaw(value) for value in start]
    for k in np.flatnonzero(shares):
        laws[k] = SummedLaw(((float(shares[k]), law),), float(begun[k]))
    laws[actuator] = law
    others = [replace(a, law=own) for a, own in zip(mechanism.actuators, laws, strict=True)]
    fixed = replace(mechanism, actuators=tuple(others))
    return fixed if mechanism.complete is None else mechanism.complete(fixed)


def chosen_input(mechanism: Mechanism, name: str) -> int:
    """Return the input of a given name, the first if the name is ""; raise UsageError if there is none."""
    names = [mechanism.actuators[k].name for k in mechanism.drivers]
    if name in names:
        return mechanism.drivers[names.index(name)]
    if name or not names:
        if name in {a.name for a in mechanism.actuators}:
            raise UsageError(f"'{name}' follows other inputs; choose one of {', '.join(names)}")
        raise UsageError(f"no actuator '{name}'; actuators: {', '.join(names) or 'none'}")
    return mechanism.drivers[0]


def reduction_table(found: Reduction) -> Table:
    """Return the table of q in the file's unit and the reduced quantities in SI units."""
    actuator = found.mechanism.actuators[found.actuator]
    columns = [
        Column(name, found.columns[name], turning if actuator.rotary else sliding)
        for name, (_, turning, sliding) in QUANTITIES.items()
    ]
    q = found.mechanism.value_to_file(found.actuator, found.q)
    return Table((Column("q", q, found.mechanism.unit_of(actuator)), *columns, status_column(found.codes)))


TURN = 1e-9
"""Greatest difference of a cycle from whole turns, in turns."""


@dataclass(frozen=True)
class Flywheel:
    """A flywheel and the data that it was computed from."""

    inertia: float  # kg m^2, on the input's shaft; 0: no flywheel is needed
    speed: float  # rad/s, mean of the greatest and the least speed
    fluctuation: float  # coefficient of speed fluctuation, (greatest - least) / mean speed
    torque: float  # N m, constant driving torque
    work: float  # J, greatest minus least E over the cycle
    without: float  # coefficient of speed fluctuation without a flywheel; NaN if the machine would stop


def flywheel(found: Reduction, speed: float, fluctuation: float) -> Flywheel:
    """Return the flywheel for a mean speed [rad/s] and a coefficient of speed fluctuation.

    Raises UsageError unless the reduction covers whole turns and all its rows are solved.
    """
    _refuse(found, speed, fluctuation)
    drive, work = cycle_work(found)
    inertia = _needed(found.columns["J"], work, speed, fluctuation)
    return Flywheel(
        max(0.0, inertia), speed, fluctuation, drive, float(np.ptp(work)), _without(found.columns["J"], work, speed)
    )


def cycle_work(found: Reduction) -> tuple[float, FloatArray]:
    """Return the constant driving torque [N m] of a cycle, and the work [J] of all forces since its beginning (rows,).

    The integral is the trapezoidal rule with the end correction of Euler and Maclaurin.
    """
    step, tau, slope = np.diff(found.q), found.columns["tau"], found.columns["dtau_dq"]
    parts = 0.5 * step * (tau[:-1] + tau[1:])
    if np.all(np.isfinite(slope)):
        parts += step**2 / 12.0 * (slope[:-1] - slope[1:])
    work = np.concatenate(([0.0], np.cumsum(parts)))
    drive = -float(work[-1] / (found.q[-1] - found.q[0]))
    return drive, np.asarray(work + drive * (found.q - found.q[0]))


def _needed(inertia: FloatArray, work: FloatArray, speed: float, fluctuation: float) -> float:
    least, greatest = (0.5 * (speed * (1.0 + s * fluctuation / 2.0)) ** 2 for s in (-1.0, 1.0))
    return float(np.max(least * inertia - work) - np.min(greatest * inertia - work)) / (speed**2 * fluctuation)


def _without(inertia: FloatArray, work: FloatArray, speed: float) -> float:
    """Return the fluctuation without a flywheel: the required inertia decreases with the fluctuation to 0 there."""
    most = 2.0 - TURN
    if _needed(inertia, work, speed, most) > 0.0:
        return math.nan
    if not _needed(inertia, work, speed, TURN) > 0.0:
        return 0.0
    return bisected(lambda delta: not _needed(inertia, work, speed, delta) > 0.0, TURN, most)[1]


def _refuse(found: Reduction, speed: float, fluctuation: float) -> None:
    actuator = found.mechanism.actuators[found.actuator]
    turns = abs(float(found.q[-1] - found.q[0])) / (2.0 * math.pi)
    whole = actuator.rotary and turns > 0.5 and abs(turns - round(turns)) < TURN
    if not whole or found.solved < len(found.q):
        raise UsageError(
            f"a flywheel needs a rotary input that makes whole turns: the law of '{actuator.name}' must cover whole"
            " turns, and all positions must be assembled"
        )
    if not speed > 0.0 or not 0.0 < fluctuation < 2.0:
        raise UsageError(
            f"expected a speed above 0 and a fluctuation above 0 and below 2, got {30.0 * speed / math.pi:g} rev/min"
            f" and {fluctuation:g}"
        )
