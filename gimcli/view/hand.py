"""Requests of the page for positions at inputs, and for motions with parameters, that are set by hand."""

from __future__ import annotations

import math
import sys
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.library.inputs import in_file_units, inputs_of
from gimcli.library.rounding import at_inputs
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.dragging import DraggedPosition, InputDrag
from gimcli.status import Status
from gimcli.view.live_model import LiveContent, LiveModel
from gimcli.view.sliders import parameter_sliders, sliders, starts

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
            return {"motion": number, **answer(mechanism, wanted, drag.to(wanted))}

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


def _checked(request: Any) -> tuple[str, int, dict[str, float], float | None]:
    """Return page, motion, inputs and time of a request."""
    if not isinstance(request, Mapping) or not set(request) <= {"page", "motion", "inputs", "time"}:
        raise UsageError("expected an object with the keys page, motion, inputs, time")
    page, motion, inputs, time = (request.get(key) for key in ("page", "motion", "inputs", "time"))
    if not isinstance(page, str) or not len(page) <= LONGEST:
        raise UsageError(f"page: expected a text of at most {LONGEST} characters")
    if isinstance(motion, bool) or not isinstance(motion, int):
        raise UsageError("motion: expected a whole number")
    if not isinstance(inputs, Mapping) or not all(map(_is_number, inputs.values())):
        raise UsageError("inputs: expected an object of numbers")
    if time is not None and not (_is_number(time) and math.isfinite(time)):
        raise UsageError("time: expected a finite number")
    return page, motion, dict(inputs), time


def _is_number(value: Any) -> bool:
    known = isinstance(value, int | float) and not isinstance(value, bool)
    return known and (isinstance(value, float) or abs(value) <= sys.float_info.max)
