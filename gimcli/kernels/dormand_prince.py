"""Dormand & Prince's method 8(5,3) for the equations of motion, many steps in one call.

The state is s, s', and the dissipated and supplied energies; only s and s' enter the error control. Steps, norms and
factors are those of scipy's DOP853. Source: Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 1993,
section II.10; the correction of the energy: Hairer, Lubich & Wanner 2006, algorithm IV.4.2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gimcli.kernels.influence import Chart, InfluencePosition, InfluenceScratch, copy_place
from gimcli.kernels.jit import kernel
from gimcli.kernels.reduction import DISSIPATED, KINETIC, POTENTIAL, SUPPLIED, Acting, Reduced, move
from gimcli.kernels.vector import copy
from gimcli.kernels.windows import Windows
from gimcli.mechanism import FloatArray, IntArray

STAGES = 12
SAFETY, LEAST, MOST, EXPONENT = 0.9, 0.2, 10.0, -0.125
DOUBLE, FREE_GROWTH = 2.0, 1e4
"""With one freedom a step is at most doubled, if it is longer than FREE_GROWTH times the least step (CREEP): the error
estimate is zero for a motion that is symmetric about the step."""

WANTED, FINISHED, FAILED, STOPPED = range(4)
"""Why a call ended. WANTED: the last step contains a row or an event, is very short, or ends where M is steep or near a
change point, or many positions were tried. FINISHED: the end is reached. FAILED: the least step is still too long.
STOPPED: a stage is near a change point without a window."""

NOW, BEFORE, STEP, DUE, END, RTOL, ATOL, STEEP, MOVING, GREATEST_KINETIC, START, CORRECTED, SHORTEST, NEAR, CREEP = (
    range(15)
)
"""Entries of `clock`: times of the state and of the one before, step, time of the next row, end time, tolerances,
constants of the integration, and energies."""

CLOCK = 15


class Tableau(NamedTuple):
    """Coefficients of the method."""

    a: FloatArray  # (12, 12)
    b: FloatArray  # (12,)
    e3: FloatArray  # (13,)
    e5: FloatArray  # (13,)


class States(NamedTuple):
    """State and scratch arrays; n = 2 f + 2 for f free independent variables."""

    y: FloatArray  # (n,) state: start and result
    before: FloatArray  # (n,) state before the last step
    trial: FloatArray  # (n,)
    k: FloatArray  # (13, n) slopes
    clock: FloatArray  # (CLOCK,)
    counts: IntArray  # (3,) evaluations, steps, positions tried (`weakest`) after which a call ends


class MotionModel(NamedTuple):
    """The arguments of `move` for a mechanism."""

    chart: Chart
    acting: Acting
    base: InfluencePosition
    last: InfluencePosition
    at: InfluencePosition
    windows: Windows
    room: InfluenceScratch
    out: Reduced
    gain: FloatArray
    factors: FloatArray
    none: FloatArray  # (0,)


@kernel
def slopes(m: MotionModel, y: FloatArray, to: FloatArray) -> bool:
    """Compute y'; return whether the position exists."""
    f = m.gain.shape[0]
    good = move(
        m.chart, m.acting, m.base, m.last, m.at, m.windows, y[:f], y[f : 2 * f], m.none, f, m.factors, m.room, m.out,
        m.gain,
    )  # fmt: skip
    for i in range(f):
        to[i] = y[f + i]
        to[f + i] = m.gain[i]
    to[2 * f], to[2 * f + 1] = m.out.energy[DISSIPATED], m.out.energy[SUPPLIED]
    return good


@kernel
def try_step(m: MotionModel, t: Tableau, s: States, h: float) -> float:
    """Compute a step, in `trial`; return its error relative to the tolerance, infinite if a position does not exist."""
    n = s.y.shape[0]
    for stage_number in range(1, STAGES + 1):
        row = t.b if stage_number == STAGES else t.a[stage_number]
        for i in range(n):
            total = 0.0
            for j in range(stage_number):
                total += row[j] * s.k[j, i]
            s.trial[i] = s.y[i] + h * total
        s.counts[0] += 1
        if not slopes(m, s.trial, s.k[stage_number]):
            return math.inf
    five, three = 0.0, 0.0
    for i in range(n - 2):
        scale = s.clock[ATOL] + s.clock[RTOL] * max(abs(s.y[i]), abs(s.trial[i]))
        p, q = 0.0, 0.0
        for j in range(STAGES + 1):
            p += t.e5[j] * s.k[j, i]
            q += t.e3[j] * s.k[j, i]
        five += (p / scale) ** 2
        three += (q / scale) ** 2
    if five == 0.0 and three == 0.0:
        return 0.0
    return h * five / math.sqrt((five + 0.01 * three) * (n - 2))


@kernel
def correct_energy(m: MotionModel, s: States) -> None:
    """Scale the speeds so that the energy is that of the start."""
    clock, f = s.clock, m.gain.shape[0]
    kinetic, potential = m.out.energy[KINETIC], m.out.energy[POTENTIAL]
    clock[GREATEST_KINETIC] = max(clock[GREATEST_KINETIC], kinetic)
    if not kinetic > clock[MOVING] * max(clock[GREATEST_KINETIC], abs(potential)):
        return
    excess = kinetic + potential - clock[START]
    clock[CORRECTED] += abs(excess)
    for i in range(f, 2 * f):
        s.y[i] *= 1.0 - 0.5 * excess / kinetic
    s.counts[0] += 1
    slopes(m, s.y, s.k[0])


@kernel
def is_wanted(m: MotionModel, s: States) -> bool:
    """Return whether the last step contains a row or an event, or ends where M is steep or near a change point."""
    f = m.gain.shape[0]
    if s.clock[NOW] >= s.clock[DUE] or s.clock[NOW] >= s.clock[END]:
        return True
    for i in range(f, 2 * f):
        if s.before[i] * s.y[i] < 0.0:
            return True
    for g in range(m.at.sign.shape[0]):
        if abs(m.at.sign[g]) < s.clock[NEAR]:
            return True
    steepest = 0.0
    for k in range(f):
        for i in range(m.at.v.shape[0]):
            steepest = max(steepest, abs(m.at.b[k, i]))
    return steepest > s.clock[STEEP]


@kernel
def take_steps(m: MotionModel, t: Tableau, s: States, conservative: bool) -> int:
    """Take steps until `is_wanted`; `base` is the position before the last step, `y` the state after it."""
    clock = s.clock
    while True:
        rejected = False
        while True:
            h = min(clock[STEP], clock[END] - clock[NOW])
            if not clock[STEP] >= clock[SHORTEST]:  # also NaN
                return FAILED
            error = try_step(m, t, s, h)
            if error < 1.0:
                break
            if m.room.weak[2] != 0.0:
                return STOPPED
            clock[STEP] = h * (max(LEAST, SAFETY * error**EXPONENT) if error < math.inf else LEAST)
            rejected = True
        factor = MOST if error == 0.0 else min(MOST, SAFETY * error**EXPONENT)
        clock[STEP] = h * (min(1.0, factor) if rejected else factor)
        if m.gain.shape[0] == 1:
            clock[STEP] = min(clock[STEP], max(DOUBLE * h, FREE_GROWTH * clock[CREEP]))
        clock[BEFORE], clock[NOW] = clock[NOW], clock[NOW] + h
        s.counts[1] += 1
        copy(s.before, s.y)
        copy(s.y, s.trial)
        if h < clock[CREEP] or m.room.weakest[1] >= s.counts[2] or is_wanted(m, s):
            return FINISHED if clock[NOW] >= clock[END] else WANTED
        copy_place(m.base, m.at)
        copy(s.k[0], s.k[STAGES])
        if conservative:
            correct_energy(m, s)
            copy_place(m.base, m.at)
