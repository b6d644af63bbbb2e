"""Quantities of a motion whose extremes are sought: speeds, angles, travels, quality of transmission."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from gimcli.canonical import whole_turns
from gimcli.mechanism import FRAME, FloatArray
from gimcli.quantities.extremes import RateRows, Sought
from gimcli.quantities.state import State
from gimcli.quantities.transmission import TransmissionJoint

TURN = 2.0 * np.pi


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


def travel(slide: int, state: State) -> Any:
    """Return the position of a slider along its guide [normal length]."""
    row = state.mechanism.slides[slide]
    place, along = state.node(row.node), -1j * state.normal(slide)
    if row.guide != FRAME:
        place = place - state.node(state.mechanism.members[row.guide].nodes[0])
    return (np.conj(along) * place).real


def flatness(joint: TransmissionJoint, state: State) -> Any:
    """Return the magnitude of the cosine of a transmission angle: 0 at 90 degrees, 1 at 0 and 180 degrees."""
    first, second = (state.line(line, joint.node) for line in (joint.first, joint.second))
    product = np.conj(first) * second
    return abs(product.real / abs(product))
