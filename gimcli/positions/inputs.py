"""Inputs over time, a little beyond the ends of the motion too, and the line that they run along."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import FloatArray, Mechanism

Inputs = Callable[[FloatArray], FloatArray]
"""Inputs (actuators, rows) at times (rows,); also a little beyond the ends of the motion."""

SAMPLES = 65
"""Times at which laws are looked at."""

STRAIGHT = 1e-13
"""Distance from a line, over its length, below which inputs run along it: some roundings."""


@dataclass(frozen=True)
class InputLine:
    """A straight line in the space of the inputs; its parameter q is the value of the input that moves most."""

    base: FloatArray  # (actuators,) inputs at q = 0
    along: FloatArray  # (actuators,) change of the inputs with q
    main: int  # the input that moves most: base 0, along 1

    def at(self, q: FloatArray) -> FloatArray:
        """Return the inputs (actuators, rows) at parameters (rows,)."""
        return np.asarray(self.base[:, None] + self.along[:, None] * q)


def line_through(mechanism: Mechanism, values: FloatArray) -> InputLine | None:
    """Return the line that inputs (actuators, times) run along; None where they do not, or all stand still.

    A single input always runs along one.
    """
    if len(values) == 1:
        return InputLine(np.zeros(1), np.ones(1), 0)
    change = values - values[:, :1]
    reach = np.max(np.abs(change), axis=1, initial=0.0) / scales(mechanism)
    if not len(reach):
        return None
    main = int(np.argmax(reach))
    far = int(np.argmax(np.abs(change[main])))
    if not reach[main] > 0.0:
        return None
    along = change[:, far] / change[main, far]
    beside = np.abs(change - along[:, None] * change[main])
    if np.any(beside > STRAIGHT * np.max(np.abs(values), axis=1, keepdims=True) + STRAIGHT * np.abs(change[main, far])):
        return None
    base = values[:, 0] - along * values[main, 0]
    base[main], along[main] = 0.0, 1.0
    return InputLine(base, along, main)


def input_line(mechanism: Mechanism) -> InputLine | None:
    """Return the line that the laws run along together; None where each goes its own way, or all stand still."""
    few = len(mechanism.actuators) < 2
    return line_through(mechanism, law_inputs(mechanism)(np.zeros(1) if few else law_times(mechanism)))


def law_times(mechanism: Mechanism) -> FloatArray:
    """Return times that tell the course of the laws: evenly spaced ones, and all at which one may turn back."""
    stops = [actuator.law.stops() for actuator in mechanism.actuators]
    return np.unique(np.concatenate([np.linspace(0.0, 1.0, SAMPLES), *stops]))


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
        if actuator.rotary:
            moved[k] += 2.0 * math.pi * round((end[k] - start[k]) / (2.0 * math.pi))
    return moved


def scales(mechanism: Mechanism) -> FloatArray:
    """Return what changes of the inputs (actuators,) are measured by: a rad, or the size."""
    return np.array([1.0 if a.rotary else mechanism.size for a in mechanism.actuators])


def pace(mechanism: Mechanism, values: FloatArray) -> float:
    """Return the fastest change of an input over a stretch, in turns (or 2 pi sizes)."""
    change = np.abs(np.diff(values, axis=1)).sum(axis=1)
    return float(np.max(change / scales(mechanism), initial=0.0) / (2.0 * math.pi))
