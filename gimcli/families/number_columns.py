"""Columns of numbers from a CSV file."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from gimcli.errors import UsageError, reason, refuse
from gimcli.mechanism import FloatArray

MOST_BYTES = 400_000_000
"""Largest file that is read."""


def number_columns(path: Path, what: str, known: str = "") -> dict[str, FloatArray]:
    """Return the columns (rows,) of a CSV file of numbers with a row of names.

    `what` names its content in messages, `known` ends those about the names.
    """
    try:
        if path.stat().st_size > MOST_BYTES:
            raise UsageError(f"{path}: is too large; at most {MOST_BYTES // 1_000_000} MB are read")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {reason(error)}; name a CSV file of {what}") from None
    except UnicodeDecodeError:
        raise UsageError(f"{path}: is not a text file; name a CSV file of {what}") from None
    rows = [(k, row) for k, row in enumerate(csv.reader(text.splitlines()), 1) if any(cell.strip() for cell in row)]
    refuse((len(rows) < 2, f"{path}: expected a row of names and rows of numbers{known}"))
    names = [name.strip() for name in rows[0][1]]
    refuse(
        (len(set(names)) < len(names), f"{path}: two columns have the same name{known}"),
        (";" in names[0], f"{path}: the columns are separated by semicolons; separate them by commas"),
    )
    values = [_numbers(path, line, row, len(names)) for line, row in rows[1:]]
    return dict(zip(names, np.array(values).T, strict=True))


def _numbers(path: Path, line: int, row: list[str], count: int) -> list[float]:
    try:
        values = [float(cell) for cell in row]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise UsageError(f"{path}: line {line}: expected {count} finite numbers, got '{','.join(row)[:40]}'")
    return values
