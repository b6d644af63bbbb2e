"""Compiled gears, belts, and racks with pinions."""

from __future__ import annotations

from dataclasses import dataclass

NO_PIVOT = -1
"""A rack has no pivot."""

EXTERNAL, INTERNAL, BELT, CROSSED, RACK = "external", "internal", "belt", "crossed", "rack"
"""Types of gears, as in the model file."""


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
