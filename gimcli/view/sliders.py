"""The sliders of the page: one for each input, with its range."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gimcli.library.trace import MotionTraceResult
from gimcli.mechanism import SPAN, Mechanism
from gimcli.positions.inputs import law_inputs, law_times

SMALLEST = 0.01
"""Part of a turn, or of twice the size, below which the range of a law is replaced by a whole one."""

PARTS = 600
"""Approximate number of steps of a slider."""


def sliders(result: MotionTraceResult) -> list[dict[str, Any]]:
    """Return name, unit, least, greatest and first value and step of each input, in the file's units.

    The range is that of the law; where the motion of one input meets a limit, it is the range on its circuit.
    """
    mechanism = result.mechanism
    on_circuit = _on_circuit(result) if len(mechanism.actuators) == 1 else {}
    found = []
    for k, actuator in enumerate(mechanism.actuators):
        low, high = on_circuit.get(actuator.name) or law_range(mechanism, k)
        step = step_of(high - low)
        unit = mechanism.unit_of(actuator)
        found.append(
            {
                "name": actuator.name, "unit": "" if unit == "unit" else unit, "step": step,
                "low": _rounded(low), "high": _rounded(high),
                "value": _rounded(float(mechanism.value_to_file(k, result.motions[0].inputs[k, :1])[0])),
            }
        )  # fmt: skip
    return found


def law_range(mechanism: Mechanism, k: int) -> tuple[float, float]:
    """Return the least and greatest value of the law of an input, or a wide range where the law hardly moves it."""
    actuator = mechanism.actuators[k]
    whole = 2.0 * math.pi if actuator.rotary else 2.0 * mechanism.size
    values = law_inputs(mechanism)(law_times(mechanism))[k]
    low, high = float(values.min()), float(values.max())
    if high - low < SMALLEST * whole:
        low, high = low - 0.5 * whole, high + 0.5 * whole
        if actuator.kind == SPAN:
            low = max(low, SMALLEST * whole)
    ends = mechanism.value_to_file(k, np.array([low, high]))
    return float(ends[0]), float(ends[1])


def step_of(span: float) -> float:
    """Return the step of a slider: 1, 2 or 5 times a power of ten."""
    least = span / PARTS
    power = 10.0 ** math.floor(math.log10(least))
    return max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= least * (1.0 + 1e-9))


def _rounded(value: float) -> float:
    """Return a value without the rounding errors of its conversion to the file's unit."""
    return float(f"{value:.12g}")


def _on_circuit(result: MotionTraceResult) -> dict[str, tuple[float, float]]:
    """Return the range of the input on the circuit of a motion that meets a limit; empty if it is not known."""
    spans = [event["interval"] for event in result.events if event["kind"] == "limit"]
    known = spans[0].items() if spans else ()
    return {name: (low, high) for name, (low, high) in known if math.isfinite(high - low) and high > low}
