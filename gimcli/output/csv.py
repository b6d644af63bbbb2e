"""Comma-separated values: one header row, then the rows of a table; numbers are written in full precision."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self, TextIO

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


class TableStream(ExitStack, ABC):
    """A file to which tables are appended; it appears when the `with` block ends without an error."""

    def __init__(self, target: Path | str | TextIO, names: Sequence[str]) -> None:
        """Raise UsageError if two of the names of the columns are equal."""
        super().__init__()
        refuse_repeated(names)
        self._target: Any = target
        self._names = tuple(names)
        self._file: Any = None  # what the rows are written to

    def __enter__(self) -> Self:
        self._file = self._opened()
        return self

    def append(self, table: Table) -> None:
        """Add the rows of a table with the stream's columns."""
        if self._file is None or table.names != self._names:
            raise ValueError(f"the stream is closed, or the table has columns {table.names}, not {self._names}")
        self._add(table)

    @abstractmethod
    def _opened(self) -> Any:
        """Open the file with all that ends with the `with` block, and return what the rows are written to."""

    @abstractmethod
    def _add(self, table: Table) -> None:
        """Write the rows of a table."""


class CsvStream(TableStream):
    """CSV text to which tables are appended.

    A file appears when the `with` block ends without an error. Text for a handle, such as standard output, is written
    immediately.
    """

    def _opened(self) -> Any:
        named = isinstance(self._target, Path | str)
        handle = self.enter_context(written_text(self._target)) if named else self._target
        handle.write(",".join(map(_quoted, self._names)) + "\n")
        return handle

    def _add(self, table: Table) -> None:
        for start in range(0, len(table), ROWS_AT_ONCE):
            self._file.write(_lines(table, slice(start, start + ROWS_AT_ONCE)))


def write_csv(table: Table, target: Path | str | TextIO) -> None:
    """Write a table as a CSV file, or to a handle."""
    with CsvStream(target, table.names) as stream:
        stream.append(table)


def _lines(table: Table, rows: slice) -> str:
    columns = [_cells(column.values[rows]) for column in table.columns]
    if len(columns) == 1:  # CSV readers skip an empty line
        columns = [[cell or '""' for cell in columns[0]]]
    return "\n".join(map(",".join, zip(*columns, strict=True))) + "\n"


def _cells(values: NDArray[Any]) -> list[str]:
    """Return the texts of a column's cells: the shortest from which the same numbers are read, none for NaN."""
    if values.dtype.kind == "f":
        cells = list(map(repr, values.astype(np.float64).tolist()))
        for row in np.flatnonzero(np.isnan(values)).tolist():
            cells[row] = ""
        return cells
    texts = list(map(str, values.tolist()))
    quoted = {} if values.dtype.kind in "iu" else {text: _quoted(text) for text in set(texts)}
    return [quoted.get(text, text) for text in texts]


def _quoted(value: str) -> str:
    """Return a text as a cell. Source: RFC 4180, section 2, rules 5 to 7."""
    return '"' + value.replace('"', '""') + '"' if re.search('[,"\r\n]', value) else value
