"""A table of named columns with units: analyses produce it, writers of file formats take it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Column:
    """One named column; a NaN in a float column is written as an empty cell."""

    name: str
    values: NDArray[Any]  # (rows,) float, integer or string
    unit: str = ""  # "": no unit


def labelled(name: str, unit: str) -> str:
    """Return a name with its unit in brackets; no brackets for lengths without a physical unit."""
    return f"{name} [{unit}]" if unit not in ("", "unit") else name


def per_second(unit: str, order: int = 1) -> str:
    """Return the unit of a derivative by time, such as mm/s^2; lengths without a physical unit give 1/s^2."""
    own = "1" if unit in ("", "unit") else unit
    return f"{own}/s" if order == 1 else f"{own}/s^{order}"


def xy_columns(name: str, z: NDArray[np.complexfloating], unit: str) -> list[Column]:
    """Return the columns `name` + "x" and `name` + "y" of positions or vectors x + iy (rows,)."""
    return [Column(f"{name}x", z.real, unit), Column(f"{name}y", z.imag, unit)]


@dataclass(frozen=True)
class Table:
    """Columns of equal length."""

    columns: tuple[Column, ...]

    def __len__(self) -> int:
        return len(self.columns[0].values) if self.columns else 0

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.by_name[name].values

    @cached_property
    def by_name(self) -> dict[str, Column]:
        """The columns by their names."""
        return {column.name: column for column in self.columns}

    @property
    def names(self) -> tuple[str, ...]:
        """Names in the order of the columns."""
        return tuple(column.name for column in self.columns)

    def floats(self, name: str) -> NDArray[np.float64]:
        """Return a column as floats; raises KeyError if there is no such column."""
        return np.asarray(self[name], dtype=np.float64)
