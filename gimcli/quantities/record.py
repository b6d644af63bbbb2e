"""Measures of a motion in pieces: their columns, their ranges, and results for the whole motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.quantities.formula import asked
from gimcli.quantities.quantity import ColumnRange, Head, Quantity
from gimcli.quantities.state import MotionState, derivatives_of
from gimcli.rates.member_angles import Angles, in_rows
from gimcli.table import Column


class Record:
    """Requested measures, and their ranges over the pieces so far."""

    def __init__(self, mechanism: Mechanism, specs: Sequence[str]) -> None:
        found = {m.spec: m for spec in specs for m in asked(mechanism, spec)}
        self.measures: tuple[Quantity, ...] = tuple(found.values())
        self.memory: dict[str, Any] = {}
        self.ranges = {head.name: ColumnRange() for head in self.heads}

    @property
    def heads(self) -> list[Head]:
        """Names and units of the columns."""
        return [head for measure in self.measures for head in measure.heads]

    def head_columns(self, rows: int) -> list[Column]:
        """Return empty columns, for the header of a table."""
        return [Column(head.name, np.full(rows, np.nan), head.unit) for head in self.heads]

    def columns(self, piece: Motion, angles: Angles = in_rows) -> list[Column]:
        """Return the columns of the next piece of a motion; `angles` counts full turns."""
        state, columns = MotionState(piece, angles, self.memory), []
        for measure in self.measures:
            for head, values in zip(measure.heads, measure.values(state), strict=True):
                self.ranges[head.name].add(values, piece.good)
                columns.append(Column(head.name, values, head.unit))
        return columns

    def curves(self, motion: Motion) -> dict[str, ComplexArray]:
        """Return the curves that the measures add to a drawing of a motion."""
        derivatives = derivatives_of(motion)
        return {name: curve for measure in self.measures for name, curve in measure.curves(derivatives).items()}

    def outlines(self, motion: Motion) -> list[ComplexArray]:
        """Return the areas that the measures add to a drawing of a motion."""
        derivatives = derivatives_of(motion)
        return [outline for measure in self.measures for outline in measure.outlines(derivatives)]

    def results(self, motion: Motion) -> dict[str, dict[str, Any]]:
        """Return ranges and results of the measures for the whole motion, of which `motion` has some rows."""
        state, report = MotionState(motion, memory=self.memory), {}
        for measure in self.measures:
            columns = {head.name: {"unit": head.unit, **asdict(self.ranges[head.name])} for head in measure.heads}
            report[measure.spec] = {"columns": columns, **measure.whole(state, self.ranges)}
        return report
