"""Directions of members in the motions of many designs, full turns counted as in a trace (`rates.member_angles`)."""

from __future__ import annotations

import numpy as np

from gimcli.canonical import phase
from gimcli.families.design_motions import DesignMotions
from gimcli.mechanism import FRAME, FloatArray, IntArray
from gimcli.positions.inputs import scales
from gimcli.rates.member_angles import CLEAR, COUNTED, LawAngles, full_turn

FINEST = 64
"""Largest number of parts of a step in which an angle is followed to count its turns."""

TURN = 2.0 * np.pi


def counted_angles(motions: DesignMotions, member: int) -> FloatArray:
    """Return the direction of a member (designs, rows) in the file's angle unit, full turns counted."""
    solved, mechanism = motions.solved, motions.mechanism
    if member == FRAME:
        return np.where(np.isfinite(solved.z[:, 0]), 0.0, np.nan)
    found = np.full(solved.codes.shape, np.nan)
    if motions.compiled:
        found = _together(motions, member) * (full_turn(mechanism) / TURN)
    for k in np.flatnonzero(np.any(solved.good & ~np.isfinite(found), axis=1)).tolist():
        motion = motions.motion(k)
        if motion is not None:
            own = motion.mechanism
            found[k] = LawAngles(own, len(motion.time) - 1, motions.again(own))(motion, member)
    return found


def _together(motions: DesignMotions, member: int) -> FloatArray:
    """Return the directions of a member [rad] with full turns counted, of all designs together.

    Rows between are solved where inputs move far from one row to the next, or the member turns far.
    """
    change = np.abs(np.diff(motions.solved.inputs, axis=2)) / scales(motions.mechanism)[:, None]
    parts = min(int(np.ceil(np.max(change, initial=0.0) / COUNTED * (1.0 - 1e-12))) or 1, FINEST)
    found, wide = _counted(motions, member, parts)
    while len(wide) and parts < FINEST:
        parts = min(4 * parts, FINEST)
        finer, still = _counted(motions.chosen(wide), member, parts)
        found[wide], wide = finer, wide[still]
    return found


def _counted(motions: DesignMotions, member: int, parts: int) -> tuple[FloatArray, IntArray]:
    """Return angles [rad], and the designs in which the member turns far from one row to the next.

    Each step is divided into `parts`, which are solved too if there are several. NaN for designs that miss some of
    these rows.
    """
    z = motions.solved.z
    exact = _direction(motions, member)
    angle = exact
    if parts > 1:
        inputs = _divided(motions.solved.inputs, parts)
        z = motions.family.solve(motions.solved.designs, inputs=inputs, **motions.options).z
        first, second = motions.mechanism.members[member].nodes[:2]
        angle = phase(z[:, second] - z[:, first])
        angle[:, ::parts] = np.where(np.isfinite(exact), exact, angle[:, ::parts])
    complete = filled(angle)
    change = np.diff(complete, axis=1)
    change -= TURN * np.round(change / TURN)
    wide = np.flatnonzero(np.any(np.abs(change) > CLEAR, axis=1))
    total = complete[:, :1] + np.concatenate([np.zeros((len(z), 1)), np.cumsum(change, axis=1)], axis=1)
    found = exact + TURN * np.round((total[:, ::parts] - exact) / TURN)
    found[_interrupted(angle, exact, parts)] = np.nan
    return found, wide


def _direction(motions: DesignMotions, member: int) -> FloatArray:
    first, second = motions.mechanism.members[member].nodes[:2]
    return np.asarray(phase(motions.solved.z[:, second] - motions.solved.z[:, first]))


def _interrupted(angle: FloatArray, exact: FloatArray, parts: int) -> IntArray:
    """Return the designs of which a row between two solved rows is not solved."""
    rows = np.arange(exact.shape[1]) * parts
    known = np.isfinite(exact)
    first, last = np.where(known, rows, angle.shape[1]).min(axis=1), np.where(known, rows, -1).max(axis=1)
    every = np.arange(angle.shape[1])
    inside = (every >= first[:, None]) & (every <= last[:, None])
    return np.flatnonzero(np.any(inside & ~np.isfinite(angle), axis=1))


def _divided(inputs: FloatArray, parts: int) -> FloatArray:
    """Return inputs (·, actuators, rows) with each step divided into equal parts; the given rows are kept exactly."""
    share = np.arange(parts) / parts
    steps = inputs[:, :, :-1, None] + np.diff(inputs, axis=2)[..., None] * share
    return np.concatenate([steps.reshape(*inputs.shape[:2], -1), inputs[:, :, -1:]], axis=2)


def filled(values: FloatArray) -> FloatArray:
    """Return values (designs, rows) with the last known value in rows without one, at the start the first."""
    known = np.isfinite(values)
    last = np.maximum.accumulate(np.where(known, np.arange(values.shape[1]), -1), axis=1)
    last = np.where(last >= 0, last, np.argmax(known, axis=1)[:, None])
    return np.take_along_axis(values, last, axis=1)
