"""Requests of the page for positions at inputs, and for motions with parameters, that are set by hand.

The page has one slider for each input and one for each parameter, with its range.
"""

from __future__ import annotations

import math
import sys
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from gimcli.canonical import beside
from gimcli.errors import UsageError
from gimcli.library.inputs import in_file_units, inputs_of
from gimcli.library.solved_positions import positions_state
from gimcli.library.trace import MotionTraceResult
from gimcli.mechanism import SPAN, ComplexArray, FloatArray, Mechanism
from gimcli.motion.dragging import DraggedPosition, InputDrag
from gimcli.positions.inputs import law_inputs, law_times
from gimcli.quantities.catalogue import catalogue
from gimcli.quantities.state import ApartError
from gimcli.rates.member_angles import full_turn
from gimcli.rounding import at_inputs, round_below
from gimcli.status import Status
from gimcli.table import Table
from gimcli.view.live_model import LiveContent, LiveModel

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
        value = float(mechanism.value_to_file(k, result._motions[0].inputs[k, :1])[0])
        found.append(_slider(actuator.name, "" if unit == "unit" else unit, low, high, value=value))
    return found


def parameter_sliders(given: Mapping[str, float], mechanism: Mechanism) -> list[dict[str, Any]]:
    """Return name, least, greatest, present and given value and step of each parameter that is given by a number.

    The range is half to double the given value; for 0 it is the size of the mechanism in both directions.
    """
    size, found = mechanism.size * mechanism.scale, []
    for name, value in given.items():
        low, high = sorted((0.5 * value, 2.0 * value)) if value else (-size, size)
        now = mechanism.written.dimension(name).value
        found.append(_slider(name, "", low, high, value=now, given=value))
    return found


def _slider(name: str, unit: str, low: float, high: float, **values: float) -> dict[str, Any]:
    """Return a slider with a range and values, without the rounding errors of their conversion to the file's unit."""
    numbers = {key: float(f"{value:.12g}") for key, value in {"low": low, "high": high, **values}.items()}
    return {"name": name, "unit": unit, "step": round_below((high - low) / PARTS), **numbers}


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
    for motion in result._motions:
        good = np.flatnonzero(motion.good)
        far = np.abs(motion.time[good] * result.mechanism.duration - time)
        for k in good[np.argsort(far, kind="stable")].tolist():
            yield motion.inputs[:, k], motion.z[:, k]


def _whole(mechanism: Mechanism, k: int) -> float:
    """Return a turn, or twice the size."""
    return 2.0 * math.pi if mechanism.actuators[k].rotary else 2.0 * mechanism.size


def _possible(mechanism: Mechanism, k: int, value: float) -> float:
    """Return a value, or the least possible one: distances are above 0."""
    return max(value, SMALLEST * mechanism.size) if mechanism.actuators[k].kind == SPAN else value


ROWS = ("time", "residual")
"""Columns that a position set by hand does not have."""

PAGES = 8
"""Number of pages that have a position of their own; the one that was used least recently is forgotten."""

LONGEST = 64
"""Most characters of the name of a page."""


class Outdated(Exception):  # noqa: N818  # an outcome, not an error
    """The page asks for a position of a motion that has been replaced."""


class HandMotion:
    """The mechanism of the last motion, moved by hand; each open page has its own position."""

    def __init__(self, model: LiveModel) -> None:
        self.model = model
        self._drags: OrderedDict[tuple[str, int], InputDrag] = OrderedDict()
        self._sliders: dict[str, Any] = {"motion": 0, "inputs": [], "parameters": []}

    def inputs(self) -> dict[str, Any]:
        """Return the number of the motion, and its sliders."""
        shown = self.model.shown
        with self.model.solving:
            if shown.result is not None and shown.motion != self._sliders["motion"]:
                own = parameter_sliders(shown.parameters, shown.result.mechanism)
                self._sliders = {"motion": shown.motion, "inputs": sliders(shown.result), "parameters": own}
            return self._sliders

    def solve(self, request: Any) -> dict[str, Any]:
        """Return the position that a request asks for.

        The request has the keys `page` (a name that the page has chosen), `motion` (its number), `inputs` (values by
        name, in the file's units; an input that is missing keeps its value) and `time` (s, if the motion by hand starts
        from this time of the motion; otherwise it continues from the last position).

        Raises UsageError for an invalid request, Outdated if the motion has been replaced.
        """
        page, number, inputs, time = _checked(request)
        shown = self.model.shown
        if shown.result is None or number != shown.motion:
            raise Outdated
        with self.model.solving:
            drag = self._drag(shown, page, time)
            mechanism = shown.result.mechanism
            last = in_file_units(mechanism, drag.last.inputs)
            own = {mechanism.actuators[k].name: last[mechanism.actuators[k].name] for k in mechanism.drivers}
            wanted = inputs_of(mechanism, {**own, **inputs}, {})
            found = drag.to(wanted)
            values = {} if shown.table is None else values_at(mechanism, found, shown.table)
            return {"motion": number, **answer(mechanism, wanted, found), "values": values}

    def set_parameters(self, request: Any) -> dict[str, Any]:
        """Set the parameters that a request names, and solve again; raise UsageError for an invalid request.

        The request has the key `parameters`: values by name, in the file's units.
        """
        values = request.get("parameters") if isinstance(request, Mapping) and len(request) == 1 else None
        if not isinstance(values, Mapping) or not all(_is_number(v) and math.isfinite(v) for v in values.values()):
            raise UsageError("expected an object with the key parameters: an object of finite numbers")
        self.model.set_parameters(values)
        return {"motion": self.model.shown.motion}

    def _drag(self, shown: LiveContent, page: str, time: float | None) -> InputDrag:
        """Return the drag of a page; it begins at a time of the motion, or continues."""
        assert shown.result is not None
        key = page, shown.motion
        if time is not None or key not in self._drags:
            self._drags[key] = InputDrag(shown.result.mechanism, starts(shown.result, time or 0.0))
        self._drags.move_to_end(key)
        while len(self._drags) > PAGES:
            self._drags.popitem(last=False)
        return self._drags[key]


def answer(mechanism: Mechanism, wanted: FloatArray, found: DraggedPosition) -> dict[str, Any]:
    """Return a position for the page: status, inputs, and the coordinates of the nodes in the file's unit."""
    inputs, z = in_file_units(mechanism, found.inputs), mechanism.to_file(found.z)
    reason = ""
    if found.status is Status.LIMIT:
        asked = at_inputs(mechanism, in_file_units(mechanism, wanted))
        reason = f"the motion to {asked} ends at a limit, {at_inputs(mechanism, inputs)}"
    elif found.status is not Status.OK:
        reason = found.status.plain_text
    return {
        "status": found.status.word, "reason": reason, "inputs": inputs, "text": at_inputs(mechanism, inputs),
        "nodes": np.stack([z.real, z.imag], axis=1).tolist(),
    }  # fmt: skip


def values_at(mechanism: Mechanism, found: DraggedPosition, table: Table) -> dict[str, float]:
    """Return the values of the columns of a table at a position, by name; without those that only a motion has."""
    known, turn, values = catalogue(mechanism), full_turn(mechanism), dict[str, float]()
    state = positions_state(mechanism, found.inputs[:, None], found.z[:, None], np.zeros(1), [int(found.status)])
    for column in table.columns:
        with suppress(UsageError, ApartError):
            (item,) = (item for item in known.asked(column.name) if item.head.name == column.name)
            value = float(state.value(*item)[0])
            if item.quantity.circular:
                value = float(beside(value, np.nanmean(column.values), turn))
            values |= {column.name: value} if math.isfinite(value) and column.name not in ROWS else {}
    return values


def _checked(request: Any) -> tuple[str, int, dict[str, float], float | None]:
    """Return page, motion, inputs and time of a request."""
    if not isinstance(request, Mapping) or not set(request) <= {"page", "motion", "inputs", "time"}:
        raise UsageError("expected an object with the keys page, motion, inputs, time")
    given: dict[str, Any] = {"page": None, "motion": None, "inputs": None, "time": None, **request}
    page, motion, inputs, time = given.values()
    numbers = isinstance(inputs, Mapping) and all(map(_is_number, inputs.values()))
    expected = {
        f"page: expected a text of at most {LONGEST} characters": isinstance(page, str) and len(page) <= LONGEST,
        "motion: expected a whole number": isinstance(motion, int) and not isinstance(motion, bool),
        "inputs: expected an object of numbers": numbers,
        "time: expected a finite number": time is None or (_is_number(time) and math.isfinite(time)),
    }
    for sentence in (sentence for sentence, met in expected.items() if not met):
        raise UsageError(sentence)
    return page, motion, dict(inputs), time


def _is_number(value: Any) -> bool:
    known = isinstance(value, int | float) and not isinstance(value, bool)
    return known and (isinstance(value, float) or abs(value) <= sys.float_info.max)
