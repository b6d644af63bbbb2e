"""Refinement of the change points of a motion, and the range of its inputs, computed after the motion.

A change point is an intersection of branches. It is a regular solution of extended equations, more accurate than the
interpolated motion.
"""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from gimcli.branching.singularities import interval, limits
from gimcli.continuation.bifurcation import BRANCHING, crossing
from gimcli.continuation.branches import first_circuit
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import GimError
from gimcli.mechanism import Mechanism
from gimcli.motion.follow import PassedMeeting
from gimcli.motion.motion import Motion
from gimcli.motion.motion_curve import LARGEST
from gimcli.motion.side_by_side import side_by_side
from gimcli.status import Status

MOST = 100
"""Most change points that are refined."""

NEAR = 1e-4
"""Greatest difference of the parameter between an event and its refinement."""


def sharpened(motion: Motion) -> Motion:
    """Return a motion with refined change points; limits are accurate already."""
    if not motion.bridged:
        return motion
    if motion.parts:
        return cast("Motion", side_by_side(motion.mechanism, [sharpened(part) for part in motion.parts]))
    if too_large(motion.mechanism):
        return motion
    curve = PositionCurve(motion.mechanism)
    pairs = zip(motion.bridged[:MOST], motion.meetings, strict=False)
    found = [_change_point(curve, time, meeting) for time, meeting in pairs]
    return replace(
        motion, bridged=(*(time for time, _ in found), *motion.bridged[MOST:]),
        meetings=(*(meeting for _, meeting in found), *motion.meetings[MOST:]),
    )  # fmt: skip


def too_large(mechanism: Mechanism) -> bool:
    """Return whether a mechanism is too large for its circuit to be followed in addition to the motion."""
    return 2 * len(mechanism.nodes) > LARGEST


def reach(motion: Motion) -> dict[str, list[float]]:
    """Return the least and greatest value of every input on the whole circuit of a motion, in the file's unit.

    Empty if the circuit is not known.
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


def _change_point(curve: PositionCurve, time: float, near: PassedMeeting) -> tuple[float, PassedMeeting]:
    """Return time and position of the change point near a given one."""
    q = curve.at_time(time) if curve.line is None else float(near.inputs[curve.line.main])
    found = crossing(curve, curve.point(near.z, q))
    if found is None or not abs(found.p[-1] - q) <= NEAR:
        return time, near
    exact = float(found.p[-1])
    return _time(curve, time, exact), PassedMeeting(curve.nodes(found.p), curve.inputs(exact), found.kind)


def _time(curve: PositionCurve, near: float, q: float) -> float:
    """Return the time near `time` at which the parameter has a value; `time` itself if there is none."""
    time = near
    for _ in range(BRANCHING.corrections):
        if abs(q - curve.at_time(time)) <= BRANCHING.closeness:
            break  # the time is accurate already
        rate = curve.rate_at(time)
        step = (q - curve.at_time(time)) / rate if rate else np.nan
        if not abs(step) <= NEAR:
            return near
        time += step
    return float(time)
