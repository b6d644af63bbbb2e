"""The files of a model: its own, and the tables of laws, efforts and loads.

Tables are CSV files of two columns, time (or an input) and value.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from gimcli.errors import reason
from gimcli.model.part import Part
from gimcli.model.schema import LARGEST, Model
from gimcli.model.source import CONTROL, MOST_BYTES

MOST_ROWS = 100_000
CLOSEST = 1e-12
"""Least distance of two rows, relative to the range of the table; slopes over less could overflow."""


def read_table(path: Path, first: str = "time") -> tuple[list[float], list[float]]:
    """Return the first column, time [s] or the variable `first`, and the second, the value (file's unit).

    Raises ValueError if the file is not readable, not a table of two columns, or its first column does not increase.
    """
    rows = _rows(path, first)
    if rows and not any(map(_is_number, rows[0][1])):
        rows = rows[1:]  # a header
    if len(rows) < 2:
        raise ValueError(f"has fewer than two rows of {first},value; add rows")
    for line, row in rows:
        if len(row) != 2 or not all(map(_fits, row)):
            text = ",".join(row)[:40]
            raise ValueError(f"line {line}: expected {first},value (two finite numbers up to {LARGEST:g}), got {text}")
    time, value = ([float(row[k]) for _, row in rows] for k in (0, 1))
    least = CLOSEST * (max(time) - min(time))
    for (line, _), before, after in zip(rows[1:], time, time[1:], strict=False):
        if after - before <= least:
            raise ValueError(f"line {line}: {first} {after:g} after {before:g}; {first} must increase from row to row")
    return time, value


def _rows(path: Path, first: str) -> list[tuple[int, list[str]]]:
    """Return the rows that are not empty, each with its line number."""
    reader = csv.reader(io.StringIO(_text(path, first), newline=""))
    rows: list[tuple[int, list[str]]] = []
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                rows.append((reader.line_num, row))
            if len(rows) > MOST_ROWS:
                raise ValueError(f"has more than {MOST_ROWS} rows; reduce them")
    except csv.Error:
        raise ValueError(f"is not a text file of rows {first},value; name a CSV file") from None
    return rows


def _text(path: Path, first: str) -> str:
    """Return the text of a regular file of at most MOST_BYTES; raise ValueError for any other."""
    try:
        if path.exists() and not path.is_file():
            raise ValueError(f"is a {'directory' if path.is_dir() else 'device or a pipe'}; name a CSV file")
        with path.open("rb") as handle:
            raw = handle.read(MOST_BYTES + 1)
    except OSError as error:
        raise ValueError(f"cannot be read: {reason(error)}; the path starts at the model's folder") from None
    if len(raw) > MOST_BYTES:
        raise ValueError(f"is too large for a table; at most {MOST_BYTES // 1_000_000} MB are read")
    text = raw.decode("utf-8-sig", "surrogateescape")  # CONTROL has the surrogates
    if CONTROL.search(text):
        raise ValueError(f"is not a text file of rows {first},value; name a CSV file")
    return text


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _fits(cell: str) -> bool:
    return _is_number(cell) and abs(float(cell)) <= LARGEST


# -- names of the files -------------------------------------------------------------------------


def files_read(model: Model, path: Path | None, folder: Path) -> tuple[Path, ...]:
    """Return the model file, if there is one, and every table of laws, efforts and loads."""
    found = (*([path] if path else []), *(folder / name for name in tables_of(model)))
    return tuple(file.absolute() for file in found)


def tables_of(data: Any) -> tuple[str, ...]:
    """Return the tables of laws, efforts and loads as a model, or the data of a model file, names them."""
    return tuple(dict.fromkeys(_tables(data)))


def _tables(data: Any) -> Iterator[str]:
    """Yield the text of every key `table`, at any depth."""
    parts: dict[str, Any] = vars(data) if isinstance(data, Part) else data if isinstance(data, dict) else {}
    for key, value in parts.items():
        if key == "table" and isinstance(value, str):
            yield value
        elif isinstance(value, dict | Part):
            yield from _tables(value)
