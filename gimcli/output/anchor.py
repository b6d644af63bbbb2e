"""Places of a drawing that move with the mechanism."""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.mechanism import FRAME


@dataclass(frozen=True)
class Anchor:
    """A place that moves with the mechanism: a node, or a point in the coordinate system of a member."""

    node: int = -1  # -1: a point of the member
    member: int = FRAME
    local: complex = 0.0j
