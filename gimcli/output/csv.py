"""Comma-separated values: one header row, then the rows of a table; numbers are written in full precision."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from gimcli.errors import UsageError
from gimcli.output.atomic import written_text
from gimcli.table import Table

ROWS_AT_ONCE = 50_000
"""Rows that are converted to text at the same time, to limit memory."""


def refuse_repeated(names: Iterable[str]) -> None:
    """Raise UsageError if two columns of one file would have the same name."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise UsageError(f"two columns would be named '{name}': rename one of their parts in the model file")
        seen.add(name)


class CsvStream:
    """CSV text to which tables are appended.

    A file appears when the `with` block ends without an error. Text for a handle, such as standard output, is written
    immediately.
    """

    def __init__(self, target: Path | str | TextIO, names: Sequence[str]) -> None:
        self._target = target
        self._names = tuple(names)
        refuse_repeated(self._names)
        self._stack = ExitStack()
        self._handle: TextIO | None = None

    def __enter__(self) -> CsvStream:
        target = self._target
        if isinstance(target, Path | str):
            target = self._stack.enter_context(written_text(target))
        self._handle = target
        self._handle.write(",".join(map(_quoted, self._names)) + "\n")
        return self

    def __exit__(self, *fault: Any) -> None:
        self._handle = None
        self._stack.__exit__(*fault)

    def append(self, table: Table) -> None:
        """Write the rows of a table with the stream's columns."""
        if self._handle is None or table.names != self._names:
            raise ValueError(f"the stream is closed, or the table has columns {table.names}, not {self._names}")
        for start in range(0, len(table), ROWS_AT_ONCE):
            self._handle.write(_lines(table, slice(start, start + ROWS_AT_ONCE)))


def write_csv(table: Table, path: Path | str) -> None:
    """Write a table as a CSV file."""
    with CsvStream(path, table.names) as stream:
        stream.append(table)


def _lines(table: Table, rows: slice) -> str:
    columns = [_cells(column.values[rows]) for column in table.columns]
    if len(columns) == 1:  # CSV readers skip an empty line
        columns = [[cell or '""' for cell in columns[0]]]
    return "\n".join(map(",".join, zip(*columns, strict=True))) + "\n"


def _cells(values: NDArray[Any]) -> list[str]:
    """Return the texts of a column's cells."""
    if values.dtype.kind == "f":
        return _float_cells(values.astype(np.float64))
    if values.dtype.kind in "iu":
        return list(map(str, values.tolist()))
    return _text_cells([str(value) for value in values.tolist()])


def _float_cells(values: NDArray[np.float64]) -> list[str]:
    """Return the shortest texts from which the same numbers are read; an empty text for NaN."""
    cells = list(map(repr, values.tolist()))
    for row in np.flatnonzero(np.isnan(values)).tolist():
        cells[row] = ""
    return cells


def _text_cells(values: list[str]) -> list[str]:
    quoted = {value: _quoted(value) for value in set(values)}
    return [quoted[value] for value in values]


def _quoted(value: str) -> str:
    if not value:
        return ""
    buffer = io.StringIO()
    csv.writer(buffer).writerow([value])  # the line end "\r\n" makes the writer quote "\r" and "\n"
    return buffer.getvalue().removesuffix("\r\n")
