"""Compiled couplings of inputs: actuators that follow others, gears, belts, and racks with pinions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gimcli.mechanism import Input

NO_PIVOT = -1
"""A rack has no pivot."""

EXTERNAL, INTERNAL, BELT, CROSSED, RACK = "external", "internal", "belt", "crossed", "rack"
"""Types of gears, as in the model file."""


@dataclass(frozen=True)
class Coupling:
    """An actuator whose input is a linear function of others: phase + sum of ratio times input.

    The input may also follow quantities that no actuator drives, such as the angle of a rocker with a gear; they are
    read from the position.
    """

    follower: int  # number of the actuator
    terms: tuple[tuple[int, float], ...]  # (actuator, ratio); these actuators follow no others
    phase: float = 0.0  # rad, or length in the normal frame
    geared: bool = False  # the gears impose it; else the actuator of the file that follows
    reads: tuple[tuple[Input, float], ...] = ()  # (angle or travel that is read, ratio)


@dataclass(frozen=True)
class GearPair:
    """Two members coupled by teeth or a belt; both turn about pivots on a carrier, or the second one slides on it.

    With the angles of both members relative to the carrier, the change of the second is `ratio` times that of the
    first. Of a rack, the second quantity is its travel, in lengths of the normal frame.
    """

    name: str
    kind: str  # EXTERNAL, INTERNAL, BELT, CROSSED or RACK
    members: tuple[int, int]
    carrier: int
    pivots: tuple[int, int]  # nodes; of a rack the second is NO_PIVOT
    ratio: float  # signed
    radii: tuple[float, float] | None = None  # of the pitch circles, normal frame; the rack's is 0; None: not known
    pressure_angle: float = 0.0  # rad
    slide: int = -1  # of a rack: its sliding pair (number of a row of Mechanism.pairs)
