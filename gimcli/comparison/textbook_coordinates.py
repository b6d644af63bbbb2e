"""Textbook Newton-Raphson in the coordinates of multibody programs; `COORDINATES` is their registry.

Reference implementations for comparisons. The whole mechanism is one system of equations that includes the drivers.
Each row starts from the previous one. The iteration stops when no correction exceeds the tolerance (lengths relative
to the mechanism's size, angles in rad), like the Newton-Raphson that Petuya et al. 2004 compare their method with.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gimcli.comparison.absolute import AbsoluteCoordinates
from gimcli.comparison.joint import JointCoordinates
from gimcli.comparison.natural import NaturalCoordinates
from gimcli.comparison.stop import Stop
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.positions.newton import Run


@dataclass(frozen=True)
class TextbookConstants:
    """Constants of the iteration."""

    iterations: int = 50  # maximum number for one position
    length: float = math.nan  # corrections of lengths are relative to it [normal frame]; NaN: the mechanism's size


@dataclass(frozen=True)
class Followed:
    """The positions of a motion that were computed by `follow`."""

    z: ComplexArray  # (nodes, rows), NaN where not solved
    iterations: FloatArray  # (rows,)
    good: BoolArray  # (rows,) whether the iteration converged


class Coordinates(Protocol):
    """A mechanism in one kind of coordinates."""

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""

    @property
    def equations(self) -> int:
        """Number of equations."""

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""

    def follow(
        self, inputs: FloatArray, start: ComplexArray, stop: Stop, run: Run
    ) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """Solve inputs (actuators, rows) from a position (nodes,); return z, iterations and 1 for converged rows."""


COORDINATES: dict[str, Callable[[Mechanism], Coordinates]] = {
    "joint": JointCoordinates,
    "absolute": AbsoluteCoordinates,
    "natural": NaturalCoordinates,
}


def follow(
    system: Coordinates, inputs: FloatArray, start: ComplexArray, tolerance: float, run: Run,
    constants: TextbookConstants | None = None,
) -> Followed:  # fmt: skip
    """Solve inputs (actuators, rows) from an assembled position (nodes,), each row from the previous one."""
    constants = constants or TextbookConstants()
    length = system.mechanism.size if math.isnan(constants.length) else constants.length
    with np.errstate(all="ignore"):
        z, iterations, converged = system.follow(inputs, start, Stop(tolerance, length, constants.iterations), run)
    good = (converged == 1.0) & np.all(np.isfinite(z), axis=0)
    z[:, ~good] = complex(np.nan, np.nan)
    return Followed(z, iterations, good)
