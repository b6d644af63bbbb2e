"""Quantities of a motion for graphs: their columns, the default abscissa, and the events on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.motion.summary import occurrences
from gimcli.table import Column

POINT_QUANTITIES = {"velocity": "v", "acceleration": "a", "jerk": "j"}
"""Magnitudes of the points' derivatives: letter of their columns."""

MEMBER_QUANTITIES = ("angle", "omega", "alpha")
"""Direction, angular velocity and acceleration of the members."""


def abscissa(motion: Motion) -> Column:
    """Return the abscissa of graphs of a motion; for a circuit the fraction of its length."""
    if motion.headings is not None:
        return Column("part of the length", motion.time)
    return input_or_time(motion.mechanism, motion.time, motion.inputs)


def input_or_time(mechanism: Mechanism, time: FloatArray, inputs: FloatArray) -> Column:
    """Return the only independent input of `inputs` (actuators, rows) if it is monotonic, else the time [s]."""
    if len(mechanism.drivers) == 1:
        (k,) = mechanism.drivers
        steps = np.diff(inputs[k])
        if np.all(steps > 0.0) or np.all(steps < 0.0):
            actuator = mechanism.actuators[k]
            return Column(actuator.name, mechanism.value_to_file(k, inputs[k]), mechanism.unit_of(actuator))
    return Column("time", time * mechanism.duration, "s")


def motion_events(motion: Motion) -> list[tuple[str, Mapping[str, float]]]:
    """Return limits and change points of a motion along its laws, with the time and the inputs there."""
    mechanism = motion.mechanism
    return [
        (kind, {"time": time * mechanism.duration, **mechanism.inputs_to_file(at)})
        for kind, time, at in occurrences(replace(motion, exchanged=()))
    ]
