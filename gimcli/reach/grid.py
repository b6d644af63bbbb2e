"""The grid of inputs for `--grid`, from the ranges of the laws."""

from __future__ import annotations

import math

import numpy as np

from gimcli.errors import UsageError
from gimcli.mechanism import FRAME, Mechanism
from gimcli.motion.scatter import Carried, InputGrid
from gimcli.rates.plan_rates import carrier
from gimcli.reach.task import FULL, law_range

MOST = 50_000_000
"""Most positions of a grid."""


def input_grid(mechanism: Mechanism, count: int) -> InputGrid:
    """Return a grid of `count` values per moving input over the range of its law; a full turn has no end value.

    Raises UsageError for more than MOST positions.
    """
    spans = [law_range(mechanism, k) for k in range(len(mechanism.actuators))]
    rotary = [a.rotary for a in mechanism.actuators]
    turning = tuple(r and 2.0 * s.half >= FULL for s, r in zip(spans, rotary, strict=True))
    high = [s.low + 2.0 * math.pi if t else s.high for s, t in zip(spans, turning, strict=True)]
    grid = InputGrid(np.array([s.low for s in spans]), np.array(high), turning, count)
    if grid.rows > MOST:
        raise UsageError(f"grid {count}: {grid.rows} combinations of {len(spans)} inputs, more than {MOST}; reduce it")
    return grid


def carried_by(mechanism: Mechanism, name: str) -> Carried:
    """Return a node or point as a linear combination of two nodes; raise UsageError for a fixed point."""
    if any(point.name == name and point.member == FRAME for point in mechanism.points):
        raise UsageError(f"'{name}' does not move: give a moving node or point")
    return Carried(*carrier(mechanism, name))
