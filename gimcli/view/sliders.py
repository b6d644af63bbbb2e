"""The sliders of the page: one for each input and one for each parameter, with its range."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from gimcli.library.trace import MotionTraceResult
from gimcli.mechanism import SPAN, ComplexArray, FloatArray, Mechanism
from gimcli.motion.dragging import InputDrag
from gimcli.positions.inputs import law_inputs, law_times
from gimcli.status import Status

SMALLEST = 0.01
"""Part of a turn, or of twice the size, below which the range of a law is replaced by a whole one."""

PARTS = 600
"""Approximate number of steps of a slider."""


def sliders(result: MotionTraceResult) -> list[dict[str, Any]]:
    """Return name, unit, least, greatest and first value and step of each input, in the file's units.

    The range is that of the law; where the motion of one input meets a limit, or the law does not move it, it is the
    range between its limits.
    """
    mechanism, found = result.mechanism, []
    for k in mechanism.drivers:
        actuator = mechanism.actuators[k]
        ends, moves = law_range(mechanism, k)
        if len(mechanism.drivers) == 1 and not (moves and result.complete):
            ends = between_limits(result, *ends)
        low, high = mechanism.value_to_file(k, np.array(ends)).tolist()
        unit = mechanism.unit_of(actuator)
        found.append(
            {
                "name": actuator.name, "unit": "" if unit == "unit" else unit, "step": step_of(high - low),
                "low": _rounded(low), "high": _rounded(high),
                "value": _rounded(float(mechanism.value_to_file(k, result.motions[0].inputs[k, :1])[0])),
            }
        )  # fmt: skip
    return found


def parameter_sliders(given: Mapping[str, float], mechanism: Mechanism) -> list[dict[str, Any]]:
    """Return name, least, greatest, present and given value and step of each parameter that is given by a number.

    The range is half to double the given value; for 0 it is the size of the mechanism in both directions.
    """
    size, found = mechanism.size * mechanism.scale, []
    for name, value in given.items():
        low, high = sorted((0.5 * value, 2.0 * value)) if value else (-size, size)
        now = mechanism.written.dimension(name).value
        found.append(
            {
                "name": name, "unit": "", "step": step_of(high - low), "low": _rounded(low), "high": _rounded(high),
                "value": _rounded(now), "given": _rounded(value),
            }
        )  # fmt: skip
    return found


def law_range(mechanism: Mechanism, k: int) -> tuple[tuple[float, float], bool]:
    """Return the least and greatest value of the law of an input; a wide range, and False, if it hardly moves it."""
    values = law_inputs(mechanism)(law_times(mechanism))[k]
    low, high, whole = float(values.min()), float(values.max()), _whole(mechanism, k)
    if high - low >= SMALLEST * whole:
        return (low, high), True
    return (_possible(mechanism, k, low - 0.5 * whole), high + 0.5 * whole), False


def between_limits(result: MotionTraceResult, low: float, high: float) -> tuple[float, float]:
    """Return the range of a single input between the limits of its motion; `low` and `high` where there is none."""
    mechanism, ends = result.mechanism, [low, high]
    (own,) = mechanism.drivers
    whole = _whole(mechanism, own)
    for k, beyond in enumerate((_possible(mechanism, own, low - whole), high + whole)):
        inputs = mechanism.start_inputs
        inputs[own] = beyond
        found = InputDrag(mechanism, starts(result)).to(mechanism.coupled(inputs))
        if found.status is Status.LIMIT:
            ends[k] = float(found.inputs[own])
    return ends[0], ends[1]


def starts(result: MotionTraceResult, time: float = 0.0) -> Iterator[tuple[FloatArray, ComplexArray]]:
    """Yield inputs and positions of the solved rows of a motion, the nearest in time [s] first."""
    for motion in result.motions:
        good = np.flatnonzero(motion.good)
        far = np.abs(motion.time[good] * result.mechanism.duration - time)
        for k in good[np.argsort(far, kind="stable")].tolist():
            yield motion.inputs[:, k], motion.z[:, k]


def step_of(span: float) -> float:
    """Return the step of a slider: 1, 2 or 5 times a power of ten."""
    least = span / PARTS
    power = 10.0 ** math.floor(math.log10(least))
    return max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= least * (1.0 + 1e-9))


def _rounded(value: float) -> float:
    """Return a value without the rounding errors of its conversion to the file's unit."""
    return float(f"{value:.12g}")


def _whole(mechanism: Mechanism, k: int) -> float:
    """Return a turn, or twice the size."""
    return 2.0 * math.pi if mechanism.actuators[k].rotary else 2.0 * mechanism.size


def _possible(mechanism: Mechanism, k: int, value: float) -> float:
    """Return a value, or the least possible one: distances are above 0."""
    return max(value, SMALLEST * mechanism.size) if mechanism.actuators[k].kind == SPAN else value
