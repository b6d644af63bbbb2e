"""A mechanism reduced to one input: inertia J(q), torque tau(q), potential V(q), and their derivatives.

    J = sum of m |B|^2 + J_i w^2,   dJ/dq = 2 sum of m B.B' + J_i w w',   tau = sum of F.B + T w

with the influence coefficients B, w and their exact derivatives by q: no differences. Source: Durango, Giraldo, Calle
& Mesa 2014, eqs 1-6.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.dynamic_data import TIME, DrivingEffort
from gimcli.dynamics.reducer import Reducer, holding, release_of
from gimcli.errors import UsageError
from gimcli.kernels.reduction import POTENTIAL
from gimcli.mechanism import ConstantLaw, FloatArray, IntArray, Mechanism
from gimcli.motion.motion import trace
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run
from gimcli.positions.options import Options
from gimcli.progress import Progress, no_progress
from gimcli.rates.motion_table import status_column
from gimcli.status import Status
from gimcli.table import Column, Table


@dataclass(frozen=True)
class Reduction:
    """What is left of a mechanism in one input; NaN where it cannot be. SI units, per rad or per m."""

    mechanism: Mechanism = field(repr=False)
    actuator: int
    q: FloatArray  # (rows,) rad, or length in the normal frame
    inertia: FloatArray  # (rows,) kg m2, or kg
    inertia_slope: FloatArray  # (rows,)
    torque: FloatArray  # (rows,) N m, or N: of weight, loads and springs
    torque_slope: FloatArray  # (rows,) NaN where a load follows a table over the input or over time
    potential: FloatArray  # (rows,) J: of weight and springs
    potential_slope: FloatArray  # (rows,)
    codes: IntArray  # (rows,) of Status

    @property
    def solved(self) -> int:
        """Number of rows that could be reduced."""
        return int(np.sum(self.codes == Status.OK))


def reduce_to_input(
    mechanism: Mechanism, actuator: int, steps: int, run: Run = plain, progress: Progress = no_progress
) -> Reduction:
    """Reduce a mechanism to one input along its law, in `steps` steps; the other inputs stand where theirs begin.

    Tables over time are taken at the times at which the law has the positions.
    """
    bare = undamped(holding(mechanism, actuator))
    reducer = Reducer(bare, (actuator,), run)
    weights = Reducer(without_loads(bare), (actuator,), run)
    motion = trace(held(mechanism, actuator), steps, Options(jit="off" if run is plain else "auto"))
    table, codes = np.full((6, steps + 1), np.nan), motion.codes.copy()
    speeds, rest = np.zeros(len(motion.inputs)), np.zeros(len(motion.inputs))
    speeds[0] = 1.0
    for row in np.flatnonzero(motion.good).tolist():
        inputs, clock = motion.inputs[:, row], float(motion.time[row]) * mechanism.duration
        target = inputs[[actuator, *reducer.given]]
        both = (reducer, weights)
        if not all(each.come(motion.z[:, row], inputs) and each.move(target, speeds, rest, clock) for each in both):
            codes[row] = int(Status.SINGULAR)
            continue
        state = reducer.state()
        table[:, row] = (
            state.m[0, 0], 2.0 * state.h[0], state.q[0], state.rate, state.energy[POTENTIAL], -weights.out.q[0],
        )  # fmt: skip
        progress(row, steps)
    if any(load.over in (actuator, TIME) and load.curve is not None for load in mechanism.dynamics.loads):
        table[3] = np.nan
    return _reduction(mechanism, actuator, motion.inputs[actuator], table, codes)


def held(mechanism: Mechanism, actuator: int) -> Mechanism:
    """Return the mechanism whose inputs but one stand where their laws begin."""
    start = mechanism.start_inputs
    others = [a if k == actuator else replace(a, law=ConstantLaw(start[k])) for k, a in enumerate(mechanism.actuators)]
    return replace(mechanism, actuators=tuple(others))


def _reduction(mechanism: Mechanism, actuator: int, q: FloatArray, table: FloatArray, codes: IntArray) -> Reduction:
    """Return a reduction in SI units."""
    unit = 1.0
    if not mechanism.actuators[actuator].rotary:
        unit = mechanism.dynamics.metre or 1.0
    powers = unit ** np.array([2, 3, 1, 2, 0, 1])
    inertia, slope, torque, torque_slope, potential, potential_slope = table / powers[:, None]
    return Reduction(
        mechanism, actuator, q, inertia, slope, torque, torque_slope, potential, potential_slope, codes
    )  # fmt: skip


def undamped(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism without what depends on speeds, and without efforts."""
    dynamics = mechanism.dynamics
    releases = tuple(replace(release_of(mechanism, k), effort=DrivingEffort()) for k in range(len(mechanism.actuators)))
    return replace(mechanism, dynamics=replace(dynamics, dampers=(), frictions=(), releases=releases))


def without_loads(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with weight and springs alone."""
    return replace(mechanism, dynamics=replace(mechanism.dynamics, loads=()))


def chosen_input(mechanism: Mechanism, name: str) -> int:
    """Return an input by name, or the only one; raise UsageError where that is not clear."""
    names = [a.name for a in mechanism.actuators]
    if name in names:
        return names.index(name)
    if name or not names:
        raise UsageError(f"no actuator '{name}'; actuators: {', '.join(names) or 'none'}")
    return 0


def reduction_table(found: Reduction) -> Table:
    """Return q in the file's unit and what is reduced to it, in SI units."""
    actuator = found.mechanism.actuators[found.actuator]
    quantities = (
        ("J", found.inertia, "kg m2", "kg"), ("dJ_dq", found.inertia_slope, "kg m2/rad", "kg/m"),
        ("tau", found.torque, "N m", "N"), ("V", found.potential, "J", "J"),
        ("dtau_dq", found.torque_slope, "N m/rad", "N/m"), ("dV_dq", found.potential_slope, "N m", "N"),
    )  # fmt: skip
    columns = [
        Column(name, values, turning if actuator.rotary else sliding) for name, values, turning, sliding in quantities
    ]
    q = found.mechanism.value_to_file(found.actuator, found.q)
    return Table((Column("q", q, found.mechanism.unit_of(actuator)), *columns, status_column(found.codes)))
