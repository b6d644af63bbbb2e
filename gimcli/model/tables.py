"""The files of a model: its own, and the tables of laws, efforts and loads.

Tables are CSV files of two columns, time (or an input) and value.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from gimcli.errors import reason, refuse
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
    kind = "directory" if path.is_dir() else "device or a pipe"
    refuse((path.exists() and not path.is_file(), f"is a {kind}; name a CSV file"), error=ValueError)
    found = csv_rows(path, f"rows {first},value", "the path starts at the model's folder", MOST_BYTES)
    rows = list(islice(found, MOST_ROWS + 1))
    refuse((len(rows) > MOST_ROWS, f"has more than {MOST_ROWS} rows; reduce them"), error=ValueError)
    if rows and not any(numbers([cell]) for cell in rows[0][1]):
        rows = rows[1:]  # a header
    refuse((len(rows) < 2, f"has fewer than two rows of {first},value; add rows"), error=ValueError)
    pairs = [numbers(row) for _, row in rows]
    wanted = f"{first},value (two finite numbers up to {LARGEST:g})"
    refuse(*(
        (True, f"line {line}: expected {wanted}, got {','.join(row)[:40]}")
        for (line, row), pair in zip(rows, pairs, strict=True)
        if len(pair) != 2 or not all(abs(value) <= LARGEST for value in pair)
    ), error=ValueError)  # fmt: skip
    time, value = (list(column) for column in zip(*pairs, strict=True))
    least = CLOSEST * (max(time) - min(time))
    refuse(*(
        (True, f"line {line}: {first} {after:g} after {before:g}; {first} must increase from row to row")
        for (line, _), before, after in zip(rows[1:], time, time[1:], strict=False)
        if after - before <= least
    ), error=ValueError)  # fmt: skip
    return time, value


def csv_rows(path: Path, what: str, cure: str, most: int) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows of a CSV file that are not empty, each with its line number.

    what: names the content in messages. cure: ends that of a file that cannot be read. most: bytes that are read.
    Raises ValueError if the file is not readable, too large or not text.
    """
    try:
        with path.open("rb") as handle:
            raw = handle.read(most + 1)
    except OSError as error:
        raise ValueError(f"cannot be read: {reason(error)}; {cure}") from None
    text, strange = raw.decode("utf-8-sig", "surrogateescape"), f"is not a text file of {what}; name a CSV file"
    refuse(
        (len(raw) > most, f"is too large for a table; at most {most // 1_000_000} MB are read"),
        (CONTROL.search(text), strange),  # CONTROL has the surrogates
        error=ValueError,
    )
    reader = csv.reader(io.StringIO(text, newline=""))
    try:
        yield from ((reader.line_num, row) for row in reader if "".join(row).strip())
    except csv.Error:
        raise ValueError(strange) from None


def numbers(row: list[str]) -> list[float]:
    """Return the numbers of a row; none if one of them is no number."""
    try:
        return [float(cell) for cell in row]
    except ValueError:
        return []


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
