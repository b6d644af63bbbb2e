"""The targets of a fit, and the inputs at which they are compared with the motion."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import FloatArray

TURN = 2.0 * math.pi

FREE, GIVEN, STEP = TIMINGS = ("free", "given", "step")
"""Each target has an unknown input; its input is given; the differences of the inputs are given."""


@dataclass(frozen=True)
class FitRange:
    """The inputs that a fit may use: whole turns, or from `low` to `high` [rad, or length in the normal frame]."""

    low: float
    high: float
    turning: bool

    def grid(self, rows: int) -> FloatArray:
        """Return equidistant inputs (rows,); those of a turn do not repeat its start."""
        return np.linspace(self.low, self.high, rows, endpoint=not self.turning)

    def nearest(self, inputs: FloatArray, rows: int) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
        """Return the places in the grid that are nearest to some inputs."""
        step = (self.high - self.low) / (rows if self.turning else rows - 1)
        places = np.rint((inputs - self.low) / step).astype(np.int64)
        return np.asarray(places % rows if self.turning else np.clip(places, 0, rows - 1))


@dataclass(frozen=True, eq=False)
class Targets:
    """Values that a quantity takes one after another.

    The error is `constant` + the sum over the targets and components of (weight * difference)^2.
    """

    values: FloatArray  # (targets, components): file's unit of length, or rad
    weights: FloatArray  # (components,)
    circular: FloatArray  # (components,) 1 for angles, whose full turns do not count; 0 for lengths
    inputs: FloatArray  # (targets,) rad, or length in the normal frame; timing "step": differences count
    timing: str
    range: FitRange
    constant: float = 0.0
    in_order: bool = True  # timing "free": the targets follow each other in order

    @property
    def unknown(self) -> int:
        """The number of unknown inputs of their own: one for each target with timing "free"."""
        return len(self.values) if self.timing == FREE else 0

    def residuals(self, values: FloatArray) -> FloatArray:
        """Return the weighted differences (designs, targets, components) of some values from the targets."""
        differences = values - self.values
        turns = np.rint(differences / TURN) * TURN
        return np.asarray((differences - np.where(self.circular > 0.0, turns, 0.0)) * self.weights)

    def ordered(self, inputs: FloatArray, sense: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Return whether inputs (designs, targets) follow each other in a sense (designs,) of +1 or -1, in one turn."""
        steps = np.diff(inputs, axis=1) * sense[:, None]
        good = np.all(steps >= 0.0, axis=1)
        if self.range.turning:
            good &= np.sum(steps, axis=1) <= TURN
        return np.asarray(good)
