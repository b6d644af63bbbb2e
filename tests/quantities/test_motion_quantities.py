"""Derivatives of the quantities whose extremes are searched: equal to differences of their values."""

from __future__ import annotations

from functools import partial

import numpy as np
from bundled import MODELS

import gimcli
from gimcli.model.source import read_source
from gimcli.motion.motion import trace
from gimcli.quantities.extremes import RateRows, Sought
from gimcli.quantities.motion_summary import angular_speed, flatness, rotation, speed
from gimcli.quantities.transmission import output_joints
from gimcli.rates.derivatives import rates

STEPS = 20_000


def test_derivatives_are_differences():
    """A block on an arm whose line misses the pivot by 0.3, with a rod to a slider on the frame."""
    data = read_source(MODELS / "whitworth.yaml").data
    slot = next(name for name, pair in data["prismatic"].items() if pair["guide"][0] != "G")
    data["prismatic"][slot]["offset"] = 0.3
    m = gimcli.load({**data, "duration": 0.7})
    motion = trace(m, STEPS)
    rows = RateRows(motion.time, rates(m, motion.time, motion.z, 3))
    formulas = [
        partial(speed, "R", 1),
        partial(speed, "E", 2),
        partial(angular_speed, 2, 1),
        partial(angular_speed, 3, 2),
    ]
    formulas += [partial(RateRows.travel, slide=k) for k in range(len(m.slides))]
    quantities = [
        rotation(rows, 2),
        *map(Sought, [*formulas, *(partial(flatness, joint) for joint in output_joints(m, coupled=False))]),
    ]
    assert len(quantities) >= 8
    step = 1.0 / STEPS
    for quantity in quantities:
        f, df = quantity.of(rows)
        difference = (f[2:] - f[:-2]) / (2.0 * step)
        smooth = np.abs(np.diff(np.sign(df)))[1:] + np.abs(np.diff(np.sign(df)))[:-1] == 0.0  # no kink of a magnitude
        error = np.abs(difference - df[1:-1])[smooth]
        assert error.max() < 1e-5 * np.abs(df).max(), quantity
