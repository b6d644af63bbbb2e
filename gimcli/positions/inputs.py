"""Inputs as functions of time, and the straight line in the space of the inputs that they follow, if they do."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from gimcli.canonical import beside, first_greatest
from gimcli.input_laws import ConstantLaw
from gimcli.mechanism import FloatArray, IntArray, Mechanism

Inputs = Callable[[FloatArray], FloatArray]
"""Returns inputs (actuators, rows) at times (rows,); also valid slightly beyond the ends of the motion."""

BEYOND = 1e-12
"""Distance beyond a limit, relative to the input, up to which an input is at it: the accuracy of limits."""

SAMPLES = 65
"""Number of times at which laws are sampled."""

STRAIGHT = 1e-13
"""Distance from a line, relative to its length, below which inputs are on it: a few rounding errors."""

LARGEST = 1000
"""Greatest denominator of a ratio that counts as rational, and its rounding error."""
EXACT = 1e-12


@dataclass(frozen=True)
class InputLine:
    """A straight line in the space of the inputs.

    Its parameter q is the value of the independent input that changes most.
    """

    base: FloatArray  # (actuators,) inputs at q = 0
    along: FloatArray  # (actuators,) change of the inputs with q
    main: int  # the independent input that changes most: its base is 0, its along 1

    def at(self, q: FloatArray) -> FloatArray:
        """Return the inputs (actuators, rows) at parameters (rows,)."""
        return np.asarray(self.base[:, None] + self.along[:, None] * q)


def line_through(mechanism: Mechanism, values: FloatArray) -> InputLine | None:
    """Return the line that contains inputs (actuators, times); None if there is none or all inputs are constant.

    A single input is always on a line.
    """
    if len(values) == 1:
        return InputLine(np.zeros(1), np.ones(1), 0)
    change = values - values[:, :1]
    reach = np.max(np.abs(change), axis=1, initial=0.0) / scales(mechanism)
    if not len(reach):
        return None
    own = reach[list(mechanism.drivers)]
    main = mechanism.drivers[first_greatest(own)] if own.any() else first_greatest(reach)
    far = first_greatest(np.abs(change[main]))
    if not reach[main] > 0.0:
        return None
    along = change[:, far] / change[main, far]
    beside = np.abs(change - along[:, None] * change[main])
    if np.any(beside > STRAIGHT * np.max(np.abs(values), axis=1, keepdims=True) + STRAIGHT * np.abs(change[main, far])):
        return None
    base = values[:, 0] - along * values[main, 0]
    base[main], along[main] = 0.0, 1.0
    return InputLine(base, along, main)


def driven(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose inputs are functions of the drivers' only: what they read of the linkage counts as 0."""
    linked = [coupling.follower for coupling in mechanism.couplings if coupling.reads]
    if not linked:
        return mechanism
    actuators = list(mechanism.actuators)
    for k in linked:
        actuators[k] = replace(actuators[k], law=ConstantLaw())
    couplings = tuple(replace(coupling, reads=()) for coupling in mechanism.couplings)
    return replace(mechanism, actuators=tuple(actuators), couplings=couplings)


def leading(mechanism: Mechanism) -> int | None:
    """Return the actuator that determines all inputs: the only one, or the only one that follows no other, else None.

    It is None as well if an input follows a quantity of the linkage.
    """
    if len(mechanism.drivers) != 1 or any(coupling.reads for coupling in mechanism.couplings):
        return None
    return mechanism.drivers[0]


def input_line(mechanism: Mechanism) -> InputLine | None:
    """Return the line that the inputs follow under the laws; None if there is none or all inputs are constant.

    Where one actuator leads all others, its input is the parameter.
    """
    if mechanism.couplings and (driver := leading(mechanism)) is not None:
        base = mechanism.coupled(np.zeros(len(mechanism.actuators)))
        return InputLine(base, mechanism.following[:, 0].copy(), driver)
    few = len(mechanism.actuators) < 2
    return line_through(mechanism, law_inputs(mechanism)(np.zeros(1) if few else law_times(mechanism)))


def law_times(mechanism: Mechanism) -> FloatArray:
    """Return times at which to sample the laws: evenly spaced ones, and all at which a law may reverse."""
    stops = [actuator.law.stops() for actuator in mechanism.actuators]
    return np.unique(np.concatenate([np.linspace(0.0, 1.0, SAMPLES), *stops]))


def law_inputs(mechanism: Mechanism) -> Inputs:
    """Return the inputs under the laws; beyond the times 0 and 1 they are extrapolated linearly."""

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


def nearest_turns(mechanism: Mechanism, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return `start` with its rotary values shifted by whole turns to be closest to those of `end`."""
    moved = start.copy()
    for k, actuator in enumerate(mechanism.actuators):
        if actuator.rotary:
            moved[k] = beside(start[k], end[k])
    return moved


def scales(mechanism: Mechanism) -> FloatArray:
    """Return the units (actuators,) for changes of the inputs: 1 rad, or the size of the mechanism."""
    return np.array([1.0 if a.rotary else mechanism.size for a in mechanism.actuators])


def pace(mechanism: Mechanism, values: FloatArray) -> float:
    """Return the greatest total change of an input over values (actuators, rows), in turns (or 2 pi sizes)."""
    change = np.abs(np.diff(values, axis=1)).sum(axis=1)
    return float(np.max(change / scales(mechanism), initial=0.0) / (2.0 * math.pi))


def turns_until_repeated(mechanism: Mechanism, driver: int | None = None) -> int | None:
    """Return after how many turns of a rotary driver all followers are back, modulo turns; None if never.

    driver: by default the only one. One turn without followers, or if there are several drivers.
    """
    driver = mechanism.drivers[0] if driver is None and len(mechanism.drivers) == 1 else driver
    if driver is None or not mechanism.actuators[driver].rotary:
        return 1
    from fractions import Fraction  # imported late: it takes as long as a short motion

    turns = 1
    for k, ratio in enumerate(mechanism.following[:, mechanism.drivers.index(driver)].tolist()):
        rotary = mechanism.actuators[k].rotary
        found = Fraction(ratio).limit_denominator(LARGEST)
        if (ratio and not rotary) or abs(float(found) - ratio) > EXACT * max(1.0, abs(ratio)):
            return None
        turns = int(np.lcm(turns, found.denominator))
    return turns


def divided(values: FloatArray, parts: IntArray) -> FloatArray:
    """Return values (..., rows) with each step divided into `parts` (rows - 1,); the given values stay exact."""
    row = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(row)) - (np.cumsum(parts) - parts)[row]) / parts[row]
    return np.concatenate([values[..., row] + share * np.diff(values)[..., row], values[..., -1:]], axis=-1)
