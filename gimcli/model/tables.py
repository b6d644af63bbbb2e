"""Tables of laws and loads: two columns, time (or an input) and value, in a CSV file."""

from __future__ import annotations

import csv
import math
from pathlib import Path


def read_table(path: Path, first: str = "time") -> tuple[list[float], list[float]]:
    """Return time [s], or what `first` names, and value (file's unit).

    Raises ValueError that says what is wrong and what to do.
    """
    rows = _rows(path, first)
    if rows and not _numeric(rows[0][1]):
        rows = rows[1:]  # a header
    if len(rows) < 2:
        raise ValueError(f"has fewer than two rows of {first},value; add some")
    for line, row in rows:
        if len(row) != 2 or not _numeric(row):
            raise ValueError(f"line {line} is not {first},value: {','.join(row)[:40]}; write two finite numbers")
    time, value = ([float(row[k]) for _, row in rows] for k in (0, 1))
    for (line, _), before, after in zip(rows[1:], time, time[1:], strict=False):
        if after <= before:
            raise ValueError(f"line {line}: {first} {after:g} after {before:g}; {first} must increase from row to row")
    return time, value


def _rows(path: Path, first: str) -> list[tuple[int, list[str]]]:
    """Return the rows that hold something, each with its line."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as handle:
            reader = csv.reader(handle)
            return [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror}; its path starts at the model's folder") from None
    except (UnicodeDecodeError, csv.Error):
        raise ValueError(f"is not a text file of rows {first},value; name a CSV file") from None


def _numeric(row: list[str]) -> bool:
    try:
        return all(math.isfinite(float(cell)) for cell in row)
    except ValueError:
        return False
