"""The change points of a motion to the last digits, and the range of its inputs: after the motion, where it has any.

A change point is a crossing of branches of the circuit: a regular solution of equations of its own, which the motion
itself, interpolated over it, determines to some digits less.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimcli.branching.singularities import interval, limits
from gimcli.continuation.bifurcation import BRANCHING, crossing
from gimcli.continuation.branches import first_circuit
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import GimError
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.follow import Meeting
from gimcli.motion.guide import LARGEST
from gimcli.motion.motion import Motion
from gimcli.status import Status

MOST = 100
"""Change points that are refined."""

NEAR = 1e-4
"""Distance of the parameter within which what is found is the event."""


def sharpened(motion: Motion) -> Motion:
    """Return the motion with its change points at the last digits; limits are there already."""
    if not motion.bridged or motion.first_status is not Status.OK or too_large(motion.mechanism):
        return motion
    curve = PositionCurve(motion.mechanism)
    pairs = zip(motion.bridged[:MOST], motion.meetings, strict=False)
    found = [_change_point(curve, time, *meeting) for time, meeting in pairs]
    return replace(
        motion, bridged=(*(time for time, _ in found), *motion.bridged[MOST:]),
        meetings=(*(meeting for _, meeting in found), *motion.meetings[MOST:]),
    )  # fmt: skip


def too_large(mechanism: Mechanism) -> bool:
    """Return whether a mechanism is too large for its curve to be followed beside a motion."""
    return 2 * len(mechanism.nodes) > LARGEST


def reach(motion: Motion) -> dict[str, list[float]]:
    """Return the least and greatest value of every input on the motion's whole circuit, in the file's unit.

    Empty where the circuit is not known.
    """
    mechanism = motion.mechanism
    if motion.first_status is not Status.OK or too_large(mechanism):
        return {}
    curve = PositionCurve(mechanism)
    good = np.flatnonzero(motion.good)
    ends = [curve.point(motion.z[:, k], curve.at_time(float(motion.time[k]))) for k in (0, good[min(1, len(good) - 1)])]
    try:
        circuit = first_circuit(curve, motion.z[:, 0], curve.begin(), ends[1] - ends[0])
    except GimError:
        return {}
    inputs = np.array([curve.inputs(q) for q in interval(circuit, limits(circuit))])
    return {
        a.name: sorted(float(v) for v in mechanism.value_to_file(k, inputs[:, k]))
        for k, a in enumerate(mechanism.actuators)
    }


def _change_point(curve: PositionCurve, time: float, z: ComplexArray, inputs: FloatArray) -> tuple[float, Meeting]:
    """Return time and place of a change point that was passed with nodes (nodes,) and inputs, all of them nearby."""
    q = curve.at_time(time) if curve.line is None else float(inputs[curve.line.main])
    found = crossing(curve, curve.point(z, q))
    if found is None or not abs(found.p[-1] - q) <= NEAR:
        return time, (z, inputs)
    exact = float(found.p[-1])
    return _time(curve, time, exact), (curve.nodes(found.p), curve.inputs(exact))


def _time(curve: PositionCurve, near: float, q: float) -> float:
    """Return the time next to another at which the parameter has a value; the other one where none is."""
    time = near
    for _ in range(BRANCHING.corrections):
        if abs(q - curve.at_time(time)) <= BRANCHING.closeness:
            break  # a time that is right stays as it is
        rate = curve.rate_at(time)
        step = (q - curve.at_time(time)) / rate if rate else np.nan
        if not abs(step) <= NEAR:
            return near
        time += step
    return float(time)
