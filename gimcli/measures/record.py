"""Measures of a motion in pieces: their columns, their ranges, and results for the whole motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gimcli.measures import measures_of
from gimcli.measures.measure import Head, Measure
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.rates.member_angles import Angles, in_rows
from gimcli.rates.path_derivatives import PathDerivatives
from gimcli.table import Column


@dataclass
class ColumnRange:
    """Least and greatest finite value of a column, whether it has infinite values, and its number of empty rows."""

    least: float = math.nan
    greatest: float = math.nan
    infinite: bool = False
    empty: int = 0  # number of empty cells in solved rows

    def add(self, values: np.ndarray, solved: np.ndarray) -> None:
        """Add values (rows,)."""
        finite = values[np.isfinite(values)]
        if len(finite):
            self.least = float(np.fmin(self.least, finite.min()))
            self.greatest = float(np.fmax(self.greatest, finite.max()))
        self.infinite |= bool(np.isinf(values).any())
        self.empty += int(np.count_nonzero(np.isnan(values) & solved))


class Record:
    """Requested measures, and their ranges over the pieces so far."""

    def __init__(self, mechanism: Mechanism, specs: Sequence[str]) -> None:
        found = {m.spec: m for spec in specs for m in measures_of(mechanism, spec)}
        self.measures: tuple[Measure, ...] = tuple(found.values())
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
        derivatives, columns = derivatives_of(piece, angles), []
        for measure in self.measures:
            for head, values in zip(measure.heads, measure.values(derivatives), strict=True):
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
        derivatives, report = derivatives_of(motion), {}
        for measure in self.measures:
            columns = {head.name: {"unit": head.unit, **asdict(self.ranges[head.name])} for head in measure.heads}
            report[measure.spec] = {"columns": columns, **measure.whole(derivatives)}
        return report


def derivatives_of(motion: Motion, angles: Angles = in_rows) -> PathDerivatives:
    """Return the derivatives of a motion along its laws, or along the arc length of its curve if it is a circuit."""
    if motion.parameter is None:
        return PathDerivatives(motion, angles)
    from gimcli.rates.arclength_derivatives import ArclengthDerivatives

    return ArclengthDerivatives(motion, angles)
