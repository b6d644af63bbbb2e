"""The places of a motion's events told to the last digits, after the motion: only where there are any.

A limit is a fold of the circuit, a change point a crossing of its branches: both are regular solutions of equations
of their own, where the motion itself tells them to half the digits only.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimcli.analysis.singularities import interval, limits
from gimcli.errors import GimError
from gimcli.mechanism import FloatArray
from gimcli.motion.branches import first_circuit
from gimcli.motion.curve import Curve
from gimcli.motion.folds import next_crossing, next_fold
from gimcli.motion.inputs import law_inputs
from gimcli.motion.motion import Motion
from gimcli.solvers.arclength import place
from gimcli.solvers.crossing import Policy, crossing
from gimcli.status import Status

LARGEST = 60
"""Coordinates above which events stay as the motion told them: the equations are kept as full tables."""

MOST = 100
"""Change points that are told more sharply."""

CLOSE, FAR = 0.3, 2.0 * np.pi
"""Distance of rows between which a change point is looked for at once, and to which it is walked to."""

NEAR = 1e-4
"""Distance of the parameter within which what is found is the event."""


def sharpened(motion: Motion) -> Motion:
    """Return the motion with its limit and its change points told to the last digits."""
    eventful = motion.limit is not None or motion.bridged
    if not eventful or motion.first_status is not Status.OK or 2 * len(motion.mechanism.nodes) > LARGEST:
        return motion
    curve = Curve(motion.mechanism)
    bridged = tuple(_change_point(motion, curve, t) if k < MOST else t for k, t in enumerate(motion.bridged))
    limit = motion.limit if motion.limit is None else _limit(motion, curve, motion.limit)
    return replace(motion, limit=limit, bridged=bridged)


def reach(motion: Motion) -> dict[str, list[float]]:
    """Return the least and greatest value of every input on the motion's whole circuit, in the file's unit.

    Empty where the circuit is not told.
    """
    mechanism = motion.mechanism
    if motion.first_status is not Status.OK or 2 * len(mechanism.nodes) > LARGEST:
        return {}
    curve = Curve(mechanism)
    try:
        circuit = first_circuit(curve, motion.z[:, 0], curve.begin())
    except GimError:
        return {}
    ends = np.array([curve.inputs(q) for q in interval(circuit, limits(circuit))])
    return {
        a.name: sorted(float(v) for v in mechanism.value_to_file(k, ends[:, k]))
        for k, a in enumerate(mechanism.actuators)
    }


def _parameter(curve: Curve, time: float, order: int = 0) -> float:
    """Return the parameter of the curve at a time, or its derivative."""
    if curve.single:
        law = curve.mechanism.actuators[0].law
        return (
            float(law(np.array([time]), 1)[0]) if order else float(law_inputs(curve.mechanism)(np.array([time]))[0, 0])
        )
    return curve.span if order else time * curve.span


def _time(curve: Curve, near: float, q: float) -> float:
    """Return the time next to another at which the parameter has a value; the other one where none is."""
    time = near
    for _ in range(Policy().corrections):
        if abs(q - _parameter(curve, time)) <= Policy().closeness:
            break  # a time that is right stays as it is
        rate = _parameter(curve, time, 1)
        step = (q - _parameter(curve, time)) / rate if rate else np.nan
        if not abs(step) <= NEAR:
            return near
        time += step
    return float(time)


def _beside(motion: Motion, curve: Curve, time: float) -> tuple[FloatArray, FloatArray] | None:
    """Return the solved rows on both sides of a time, or the last one twice."""
    good = np.flatnonzero(motion.good)
    before, after = good[motion.time[good] <= time], good[motion.time[good] > time]
    if not len(before):
        return None
    rows = int(before[-1]), int(after[0] if len(after) else before[-1])
    low, high = (curve.point(motion.z[:, k], _parameter(curve, float(motion.time[k]))) for k in rows)
    return low, high


def _change_point(motion: Motion, curve: Curve, time: float) -> float:
    rows = _beside(motion, curve, time)
    if rows is None:
        return time
    q, (low, high) = _parameter(curve, time), rows
    if np.linalg.norm(high - low) <= CLOSE:
        guess = low + (q - low[-1]) / (high[-1] - low[-1] or 1.0) * (high - low)
        guess[-1] = q
        found = crossing(curve, guess, Policy())
    elif abs(q - low[-1]) <= FAR:
        ahead = np.append(np.zeros(len(low) - 1), np.sign(q - low[-1]))
        found = next_crossing(curve, place(curve, low, ahead), q)
    else:
        return time
    if found is None or not abs(found.p[-1] - q) <= NEAR:
        return time
    return _time(curve, time, float(found.p[-1]))


def _limit(motion: Motion, curve: Curve, time: float) -> float:
    rows = _beside(motion, curve, time)
    if rows is None:
        return time
    q, low = _parameter(curve, time), rows[0]
    ahead = np.append(np.zeros(len(low) - 1), np.sign(_parameter(curve, time, 1)) or curve.forward())
    found = next_fold(curve, place(curve, low, ahead))
    if found is None or not abs(found.p[-1] - q) <= NEAR:
        return time
    return _time(curve, time, float(found.p[-1]))
