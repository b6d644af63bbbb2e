"""Tables of an input's law: two columns, time and value, in a CSV file."""

from __future__ import annotations

import csv
import math
from pathlib import Path


def read_table(path: Path) -> tuple[list[float], list[float]]:
    """Return time [s] and value (file's unit); raise ValueError that says what is wrong."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as handle:
            rows = [row for row in csv.reader(handle) if row]
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ValueError("is not a text file") from None
    if rows and not _numeric(rows[0]):
        rows = rows[1:]  # a header
    if len(rows) < 2:
        raise ValueError("needs at least two rows of time,value")
    for number, row in enumerate(rows, start=1):
        if len(row) != 2 or not _numeric(row):
            raise ValueError(f"row {number} is not time,value: {','.join(row)[:40]}")
    time, value = ([float(row[k]) for row in rows] for k in (0, 1))
    if any(b <= a for a, b in zip(time, time[1:], strict=False)):
        raise ValueError("time must increase from row to row")
    return time, value


def _numeric(row: list[str]) -> bool:
    try:
        return all(math.isfinite(float(cell)) for cell in row)
    except ValueError:
        return False
