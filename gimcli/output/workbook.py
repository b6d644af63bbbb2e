"""What a spreadsheet contains: the report, and a sheet for each kind of column of the table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gimcli.table import Column, Table

FIRST = ("step", "time", "branch", "design", "configuration", "curve", "circuit", "node")
"""Columns that stand first on each sheet, besides the inputs and columns of words."""

POINTS = {"x": "Positions", "y": "Positions", "vx": "Velocities", "vy": "Velocities", "ax": "Accelerations",
          "ay": "Accelerations", "jx": "Jerks", "jy": "Jerks"}  # fmt: skip
MEMBERS = {"angle": "Angles", "omega": "Angular velocities", "alpha": "Angular accelerations", "jerk": "Angular jerks"}
INPUTS = {"speed": "Inputs", "acceleration": "Inputs", "effort": "Efforts", "torque": "Efforts"}
PAIRS = {"fx": "Reactions", "fy": "Reactions", "moment": "Reactions"}
ENDS = POINTS | MEMBERS | INPUTS
"""Kinds by the part of a column's name after the last dot."""

WHOLE = {"shaking": "Shaking", "power": "Power", "energy": "Energy"}
"""Kinds by the part of a column's name before the first dot."""

OWN = {"residual": "Solution", "sweeps": "Solution"}
OTHER, ALL = "Values", "Table"

LISTED = 1000
"""Largest number of values in a row of the report."""


@dataclass(frozen=True)
class ColumnSheet:
    """One sheet: a title, and columns of equal length."""

    title: str
    columns: tuple[Column, ...]


@dataclass(frozen=True)
class Workbook:
    """The content of a spreadsheet file."""

    headline: str
    report: Mapping[str, Any]
    table: Table
    inputs: tuple[str, ...] = ()  # names of the actuators

    @property
    def sheets(self) -> list[ColumnSheet]:
        """The sheets of the table, in the order in which their first columns come; each begins with the same columns.

        A table whose columns have no kind is one sheet.
        """
        first, kinds = list[Column](), dict[str, list[Column]]()
        for column in self.table.columns:
            if column.name in (*FIRST, *self.inputs) or column.values.dtype.kind == "U":
                first.append(column)
            else:
                kinds.setdefault(kind_of(column.name), []).append(column)
        if set(kinds) <= {OTHER}:
            return [ColumnSheet(ALL, self.table.columns)]
        return [ColumnSheet(kind, (*first, *own)) for kind, own in kinds.items()]

    @property
    def facts(self) -> Iterator[tuple[str, Sequence[Any]]]:
        """The entries of the report: their path such as "points.P.x", and their values."""
        return _facts(self.report, "")


def kind_of(name: str) -> str:
    """Return the kind of a column by its name."""
    if ":" in name:
        return "Measures"
    if "/" in name:
        return "Derivatives"
    start, end = name.partition(".")[0], name.rpartition(".")[2]
    return OWN.get(name) or ENDS.get(end) or WHOLE.get(start) or PAIRS.get(end) or OTHER


def _facts(value: Any, path: str) -> Iterator[tuple[str, Sequence[Any]]]:
    """Yield the single values and lists of single values of a report."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _facts(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list | tuple) and any(isinstance(inner, Mapping | list | tuple) for inner in value):
        for number, inner in enumerate(value, start=1):
            yield from _facts(inner, f"{path}.{number}")
    else:
        values = value if isinstance(value, list | tuple) else [value]
        yield path, values if len(values) <= LISTED else [*values[:LISTED], "..."]
