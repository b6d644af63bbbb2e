"""Distance of two nodes or points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gimcli.errors import refuse
from gimcli.mechanism import Mechanism
from gimcli.quantities.quantity import Head, Kind, Quantity, place_of, point_names
from gimcli.quantities.state import State


class Distance(Quantity):
    """The distance of two points."""

    def __init__(self, mechanism: Mechanism, spec: str, names: Sequence[str]) -> None:
        self.spec, self.names = spec, tuple(names)
        self.heads = (Head(spec, mechanism.length_unit, "distance"),)

    def values(self, state: State) -> Sequence[Any]:
        """Return the distance."""
        first, second = map(state.point, self.names)
        return [abs(second - first) * state.mechanism.scale]


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> Sequence[Quantity]:
    for name in names:
        place_of(spec, "point or node", name, point_names(mechanism))
    refuse((names[0] == names[1], f"measure '{spec}': expected two different points"))
    return [Distance(mechanism, spec, names)]


KIND = Kind("distance", "POINT/POINT", "distance of two nodes or points", (2,), _make)
