"""Measures of a motion in pieces: their columns, their ranges, and results for the whole motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from gimcli.mechanism import ComplexArray
from gimcli.motion.motion import Motion
from gimcli.quantities.quantity import ColumnRange, Quantity
from gimcli.quantities.state import MotionState, derivatives_of


class Record:
    """Requested quantities, and their ranges over the pieces so far."""

    def __init__(self, measures: Sequence[Quantity]) -> None:
        self.measures = tuple(measures)
        self.ranges = {head.name: ColumnRange() for measure in measures for head in measure.heads}
        self.memory: dict[str, Any] = {}

    def add(self, state: MotionState) -> None:
        """Add the next piece of a motion."""
        for measure in self.measures:
            for k, head in enumerate(measure.heads):
                self.ranges[head.name].add(state.value(measure, k), state.motion.good)

    def curves(self, motion: Motion) -> dict[str, ComplexArray]:
        """Return the curves that the measures add to a drawing of a motion."""
        derivatives = derivatives_of(motion)
        return {name: curve for measure in self.measures for name, curve in measure.curves(derivatives).items()}

    def outlines(self, motion: Motion) -> list[ComplexArray]:
        """Return the areas that the measures add to a drawing of a motion."""
        derivatives = derivatives_of(motion)
        return [outline for measure in self.measures for outline in measure.outlines(derivatives)]

    def results(self, state: MotionState) -> dict[str, dict[str, Any]]:
        """Return ranges and results of the measures for the whole motion, of which `state` has some rows."""
        report = {}
        for measure in self.measures:
            columns = {head.name: {"unit": head.unit, **asdict(self.ranges[head.name])} for head in measure.heads}
            report[measure.spec] = {"columns": columns, **measure.whole(state, self.ranges)}
        return report
