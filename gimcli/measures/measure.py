"""Base class of measures: columns over a motion, curves for the picture, and results for the whole motion."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.rates.path_derivatives import PathDerivatives


@dataclass(frozen=True)
class Head:
    """Name and unit of a column, and the graph that it belongs to."""

    name: str
    unit: str = ""
    graph: str = ""  # "" for none


class Measure(ABC):
    """One quantity for every row of a motion; `heads` name its columns."""

    spec: str
    """The text of the measure, such as "centre:rod/rocker"."""
    heads: tuple[Head, ...]

    @abstractmethod
    def values(self, derivatives: PathDerivatives) -> list[FloatArray]:
        """Return one array (rows,) per column in the file's units; NaN where it is not determined.

        The pieces of a motion must be given in order.
        """

    def curves(self, derivatives: PathDerivatives) -> dict[str, ComplexArray]:
        """Return curves for the picture, in the file's coordinates."""
        return {}

    def outlines(self, derivatives: PathDerivatives) -> list[ComplexArray]:
        """Return areas (vertices,) for the picture, in the file's coordinates."""
        return []

    def whole(self, derivatives: PathDerivatives) -> dict[str, Any]:
        """Return results of the motion as a whole, by name."""
        return {}


@dataclass(frozen=True)
class Kind:
    """A kind of measure: its form in the command line, its help and its constructor."""

    name: str
    arguments: str  # as the user writes them
    text: str  # one line of help
    counts: tuple[int, ...]  # allowed numbers of names
    make: Callable[[Mechanism, str, Sequence[str]], list[Measure]]  # from the mechanism, the text and its names


def unit_of(mechanism: Mechanism, text: str = "{}") -> str:
    """Return a unit built from the file's unit of length, put in place of {}; "" if that is not physical."""
    return "" if mechanism.length_unit == "unit" else text.format(mechanism.length_unit)


def angle_to_file(mechanism: Mechanism, angle: FloatArray) -> FloatArray:
    """Return angles [rad] in the file's unit."""
    return np.degrees(angle) if mechanism.angle_unit == "deg" else angle
