"""Columns of numbers from a CSV file."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from gimcli.errors import UsageError, refuse
from gimcli.mechanism import FloatArray
from gimcli.model.tables import csv_rows, numbers

MOST_BYTES = 400_000_000
"""Largest file that is read."""


def number_columns(path: Path, what: str, known: str = "") -> dict[str, FloatArray]:
    """Return the columns (rows,) of a CSV file of numbers with a row of names.

    `what` names its content in messages, `known` ends those about the names.
    """
    try:
        rows = [*csv_rows(path, what, f"name a CSV file of {what}", MOST_BYTES)]
    except ValueError as error:
        raise UsageError(f"{path}: {error}") from None
    refuse((len(rows) < 2, f"{path}: expected a row of names and rows of numbers{known}"))
    names = [name.strip() for name in rows[0][1]]
    refuse(
        (len(set(names)) < len(names), f"{path}: two columns have the same name{known}"),
        (";" in names[0], f"{path}: the columns are separated by semicolons; separate them by commas"),
    )
    values = [numbers(row) for _, row in rows[1:]]
    refuse(*(
        (True, f"{path}: line {line}: expected {len(names)} finite numbers, got '{','.join(row)[:40]}'")
        for (line, row), own in zip(rows[1:], values, strict=True)
        if len(own) != len(names) or not all(map(math.isfinite, own))
    ))  # fmt: skip
    return dict(zip(names, np.array(values).T, strict=True))
