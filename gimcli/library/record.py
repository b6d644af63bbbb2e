"""The values of a result, declared once: what the report, the table and the terminal say of each.

A result is a list of rows with the same fields, or a single row, whose fields are its facts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.library.by_name import coordinates
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.rounding import greatest, input_value, number
from gimcli.table import Column, Table, labelled, xy_columns

Values = Sequence[Any] | NDArray[Any]


class RowField:
    """A value of each row: its key in the report, its column in the table, its cells in the terminal."""

    def __init__(
        self, name: str, values: Values | Callable[[], Values], kind: type | None = None, unit: str = "", *,
        head: str | None = None, text: Callable[[Any], str] | Sequence[str] | None = None, size: float = 0.0,
        key: bool = True,
    ) -> None:  # fmt: skip
        """Declare a field.

        Args:
            name: the key and the name of the column.
            values: (rows,) as the report has them; or a function that returns them, called where they are read.
            kind: of the column: str, int, float, or list for words in one cell; None: there is no column.
            unit: of the values.
            head: of the terminal's table, where the unit follows unless `text` is given; None: it is not in that table.
            text: gives the cell of a value, or the cells (rows,); by default words joined by commas, and rounded
                numbers. None is an empty cell.
            size: the size to which floating-point numbers are rounded.
            key: whether it is in the report.
        """
        self.name, self._values, self.kind, self.unit = name, values, kind, unit
        usual = _listed if kind is list else partial(number, size=size) if kind is float else str
        self.head, self.text, self.key, self.rounded = head, text or usual, key, text is None

    @property
    def values(self) -> Values:
        """The values (rows,)."""
        return self._values() if callable(self._values) else self._values

    def columns(self) -> list[Column]:
        """Return the columns; None becomes NaN in a column of numbers."""
        if self.kind is list:
            return [Column(self.name, np.array([" ".join(map(str, one)) for one in self.values], dtype=str))]
        return [Column(self.name, np.array(self.values, dtype=self.kind), self.unit)]

    def cells(self) -> Iterator[tuple[str, bool, list[str]]]:
        """Yield head, whether these are numbers, and the cells (rows,)."""
        text = self.text
        texts = ["" if v is None else text(v) for v in self.values] if callable(text) else list(text)
        yield labelled(self.head or "", self.unit * self.rounded), self.kind in (int, float), texts


def fact(name: str, value: Any, text: str | None = None, **form: Any) -> RowField:
    """Return the field of a single row, as of a whole result; `text` is its cell, `form` as for `RowField`."""
    return RowField(name, [value], text=None if text is None else [text], **form)


class InputsField(RowField):
    """The inputs of each row, dicts by name in the file's units; one column for each actuator."""

    def __init__(self, mechanism: Mechanism, name: str, values: Sequence[Mapping[str, float]], tail: str = "") -> None:
        """Declare the inputs; `tail` ends the names of the columns."""
        super().__init__(name, values, float, head=name)
        self.mechanism, self.tail = mechanism, tail

    def columns(self) -> list[Column]:
        """Return the column of each actuator."""
        return [
            Column(a.name + self.tail, np.array([one[a.name] for one in self.values], dtype=float), unit)
            for a, unit in self._units()
        ]

    def cells(self) -> Iterator[tuple[str, bool, list[str]]]:
        """Yield head, True, and the cells (rows,) of each actuator."""
        for a, unit in self._units():
            own = [input_value(self.mechanism, a.name, one[a.name]) for one in self.values]
            yield labelled(a.name, unit), True, own

    def _units(self) -> Iterator[tuple[Any, str]]:
        return ((a, self.mechanism.unit_of(a)) for a in self.mechanism.actuators)


class VectorField(RowField):
    """Vectors x + iy of each row: two columns, in the terminal also their amounts if these have a head."""

    def __init__(self, name: str, z: Values, unit: str, amount: str = "", **form: Any) -> None:
        """Declare the vectors (rows,); `name` is the beginning of both names, `form` as for `RowField`."""
        self.z, self.amount = np.asarray(z), amount
        super().__init__(name, self.z, float, unit, head=name, key=False, **form)
        self.size = form.get("size") or greatest(np.abs(self.z).tolist())

    def columns(self) -> list[Column]:
        """Return the columns of x and y."""
        return xy_columns(self.name, self.z, self.unit)

    def cells(self) -> Iterator[tuple[str, bool, list[str]]]:
        """Yield head, True, and the cells (rows,) of x, y and the amount."""
        amounts = [Column(self.amount, np.abs(self.z), self.unit)] if self.amount else []
        for one in (*self.columns(), *amounts):
            yield labelled(one.name, one.unit), True, [number(value, self.size) for value in one.values.tolist()]


class NodesField(RowField):
    """The coordinates of the nodes of each row: in the report by name, in the table two columns for each node."""

    def __init__(self, mechanism: Mechanism, z: Sequence[ComplexArray]) -> None:
        """Declare the positions (nodes,) of each row, in the normal frame."""
        self.mechanism, self.z = mechanism, np.array([mechanism.to_file(one) for one in z])
        super().__init__("nodes", [coordinates(dict(zip(mechanism.nodes, one, strict=True))) for one in self.z], float)

    def columns(self) -> list[Column]:
        """Return the columns of x and y of each node."""
        nodes, unit = self.mechanism.nodes, self.mechanism.length_unit
        each = zip(nodes, self.z.reshape(-1, len(nodes)).T, strict=True)
        return [column for name, z in each for column in xy_columns(f"{name}.", z, unit)]


class Records:
    """Rows with the same fields. A view takes all fields that it shows, or those of the given names in their order."""

    made_again = True
    """Whether a result is pickled without it."""

    def __init__(self, *fields: RowField) -> None:
        self.fields = fields

    def report(self) -> list[dict[str, Any]]:
        """Return the rows as the report lists them."""
        own = [field for field in self.fields if field.key]
        return [
            dict(zip([f.name for f in own], row, strict=True)) for row in zip(*(f.values for f in own), strict=True)
        ]

    def entry(self) -> dict[str, Any]:
        """Return the only row as the report has it."""
        (own,) = self.report()
        return own

    def by(self, name: str) -> dict[Any, dict[str, Any]]:
        """Return the rows as the report has them by the values of a field, without the field itself."""
        return {row[name]: {key: row[key] for key in row if key != name} for row in self.report()}

    def table(self, *names: str) -> Table:
        """Return the columns."""
        return Table(tuple(c for field in self._named(names) if field.kind is not None for c in field.columns()))

    def cells(self, *names: str) -> tuple[list[str], list[tuple[str, ...]], list[int]]:
        """Return for the terminal: the heads, the rows, and which columns are numbers."""
        shown = [cell for field in self._named(names) if field.head is not None for cell in field.cells()]
        rows = list(zip(*(texts for _, _, texts in shown), strict=True))
        return [head for head, _, _ in shown], rows, [k for k, (_, number, _) in enumerate(shown) if number]

    def pairs(self, *names: str) -> list[tuple[str, str]]:
        """Return head and cell of each field of the only row, for the terminal."""
        head, (row,), _ = self.cells(*names)
        return list(zip(head, row, strict=True))

    def _named(self, names: Sequence[str]) -> Sequence[RowField]:
        return [field for name in names for field in self.fields if field.name == name] if names else self.fields


def quantity_rows(columns: Sequence[Column]) -> Records:
    """Return the quantities of one position as rows, from their columns (1,)."""
    return Records(
        RowField("name", [c.name for c in columns], head="quantity", text=[labelled(c.name, c.unit) for c in columns]),
        RowField("unit", [c.unit for c in columns]),
        RowField("value", [float(c.values[0]) for c in columns], float, head="value"),
    )


def _listed(words: Sequence[Any]) -> str:
    return ", ".join(map(str, words))
