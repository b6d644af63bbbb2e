"""Inputs over time, a little beyond the ends of the motion too."""

from __future__ import annotations

import math

import numpy as np

from gimcli.mechanism import Drive, FloatArray, Mechanism
from gimcli.motion.follow import Inputs


def law_inputs(mechanism: Mechanism) -> Inputs:
    """Return the actuators' laws as inputs; beyond the ends they go on straight."""

    def inputs(time: FloatArray) -> FloatArray:
        values = np.empty((len(mechanism.actuators), len(time)))
        if len(time) and np.min(time) >= 0.0 and np.max(time) <= 1.0:
            for k, actuator in enumerate(mechanism.actuators):
                values[k] = actuator.law(time)
            return values
        inside = np.clip(time, 0.0, 1.0)
        for k, actuator in enumerate(mechanism.actuators):
            values[k] = actuator.law(inside) + (time - inside) * actuator.law(inside, 1)
        return values

    return inputs


def straight_inputs(start: FloatArray, end: FloatArray) -> Inputs:
    """Return inputs that run evenly from one set of values to another."""

    def inputs(time: FloatArray) -> FloatArray:
        return np.asarray(start[:, None] + time * (end - start)[:, None])

    return inputs


def nearest_turns(mechanism: Mechanism, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return `start` with rotary values moved by whole turns next to those of `end`."""
    moved = start.copy()
    for k, actuator in enumerate(mechanism.actuators):
        if actuator.drive is Drive.ROTARY:
            moved[k] += 2.0 * math.pi * round((end[k] - start[k]) / (2.0 * math.pi))
    return moved


def pace(mechanism: Mechanism, values: FloatArray) -> float:
    """Return the fastest change of an input over a stretch, in turns (or 2 pi sizes)."""
    change = np.abs(np.diff(values, axis=1)).sum(axis=1)
    scale = [1.0 if a.drive is Drive.ROTARY else mechanism.size for a in mechanism.actuators]
    return float(np.max(change / np.array(scale), initial=0.0) / (2.0 * math.pi))
