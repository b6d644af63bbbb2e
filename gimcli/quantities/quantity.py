"""A quantity: columns over the rows of a state, curves for the picture, and results for the whole motion."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gimcli.errors import UsageError
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.nearest import guess
from gimcli.quantities.state import State

if TYPE_CHECKING:
    from gimcli.rates.path_derivatives import PathDerivatives


@dataclass(frozen=True)
class Head:
    """Name and unit of a column, and the graph that it belongs to."""

    name: str
    unit: str = ""
    graph: str = ""  # "" for none


@dataclass
class ColumnRange:
    """Least and greatest finite value of a column, whether it has infinite values, and its number of empty rows."""

    least: float = math.nan
    greatest: float = math.nan
    infinite: bool = False
    empty: int = 0  # number of empty cells in solved rows

    def add(self, values: np.ndarray, solved: np.ndarray | bool = True) -> None:
        """Add values (rows,); by default empty cells of all rows count."""
        finite = values[np.isfinite(values)]
        if len(finite):
            self.least = float(np.fmin(self.least, finite.min()))
            self.greatest = float(np.fmax(self.greatest, finite.max()))
        self.infinite |= bool(np.isinf(values).any())
        self.empty += int(np.count_nonzero(np.isnan(values) & solved))


class Quantity(ABC):
    """One quantity for every row of a state; `heads` name its columns."""

    spec: str
    """The name of all its columns together, such as "P.v" or "centre:rod/rocker"."""
    heads: tuple[Head, ...]
    circular = False
    """Whether values that differ by full turns are the same."""

    @abstractmethod
    def values(self, state: State) -> Sequence[Any]:
        """Return one array (..., rows) per column in the file's units; NaN where it is not determined.

        The pieces of a motion must be given in order.
        """

    def curves(self, path: PathDerivatives) -> dict[str, ComplexArray]:
        """Return curves for the picture, in the file's coordinates."""
        return {}

    def outlines(self, path: PathDerivatives) -> list[ComplexArray]:
        """Return areas (vertices,) for the picture, in the file's coordinates."""
        return []

    def whole(self, state: State, ranges: Mapping[str, ColumnRange]) -> dict[str, Any]:
        """Return results of the motion as a whole, by name; its last piece or some rows, and the ranges of columns."""
        return {}


class Item(NamedTuple):
    """One column of a quantity."""

    quantity: Quantity
    column: int

    @property
    def head(self) -> Head:
        """Its name and unit."""
        return self.quantity.heads[self.column]


@dataclass(frozen=True)
class Kind:
    """A kind of quantity with arguments: its form in the command line, its help and its constructor."""

    name: str
    arguments: str  # as the user writes them
    text: str  # one line of help
    counts: tuple[int, ...]  # allowed numbers of names
    make: Callable[[Mechanism, str, Sequence[str]], Sequence[Quantity]]  # from the mechanism, the text and its names


def unit_of(mechanism: Mechanism, text: str = "{}") -> str:
    """Return a unit built from the file's unit of length, put in place of {}; "" if that is not physical."""
    return "" if mechanism.length_unit == "unit" else text.format(mechanism.length_unit)


def angle_to_file(mechanism: Mechanism, angle: FloatArray) -> FloatArray:
    """Return angles [rad] in the file's unit."""
    return np.degrees(angle) if mechanism.angle_unit == "deg" else angle


def place_of(spec: str, what: str, name: str, known: Iterable[str]) -> int:
    """Return the place of a name in a text of a quantity among those that are known; raise UsageError for others."""
    names = list(known)
    if name not in names:
        raise UsageError(f"measure '{spec}': no {what} '{name}'; {guess(name, names)}")
    return names.index(name)


def member_of(mechanism: Mechanism, spec: str, name: str) -> int:
    """Return the index of a member; `frame` and `ground` are the fixed member."""
    own = [m.name for m in mechanism.members]
    name = "frame" if name == "ground" and name not in own else name
    place = place_of(spec, "member", name, [*own[FRAME + 1 :], own[FRAME], "frame"])
    return FRAME + 1 + place if place < len(own) - 1 else FRAME


def point_names(mechanism: Mechanism) -> list[str]:
    """Return the names of points and nodes."""
    return [*(p.name for p in mechanism.points), *mechanism.nodes]
