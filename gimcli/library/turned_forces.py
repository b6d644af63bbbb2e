"""Pin forces as seen from a member, for polar diagrams: `A@crank.fx`, `A@crank.fy`."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from gimcli.dynamics.bearing_loads import reaction_name
from gimcli.dynamics.statics import Statics
from gimcli.mechanism import FRAME, ComplexArray
from gimcli.table import Table, xy_columns


def turned_names(statics: Statics) -> list[str]:
    """Return the names of the columns that `with_turned` can add."""
    return [f"{name}.f{axis}" for name, _, _ in _turned(statics) for axis in "xy"]


def with_turned(table: Table, statics: Statics, z: ComplexArray, wanted: Collection[str]) -> Table:
    """Return a table with the wanted columns of pin forces in the frame of a member; z (nodes, rows).

    The x axis of a member's frame points from its first node to its second one, as in the model file.
    """
    columns = list(table.columns)
    for name, reaction, member in _turned(statics):
        if {f"{name}.fx", f"{name}.fy"} & set(wanted):
            first, second = statics.mechanism.members[member].nodes[:2]
            along = z[second] - z[first]
            force = table.floats(f"{reaction}.fx") + 1j * table.floats(f"{reaction}.fy")
            with np.errstate(invalid="ignore"):
                columns += xy_columns(f"{name}.f", force * along.conj() / np.abs(along), "N")
    return Table(tuple(columns))


def _turned(statics: Statics) -> Iterator[tuple[str, str, int]]:
    """Yield name, reaction and member of each force that can be seen from a member."""
    mechanism = statics.mechanism
    for pin in statics.pins:
        reactions = dict.fromkeys(reaction_name(statics, pin, member) for member in pin.members)
        if len(pin.members) == 2 and not pin.loaded:
            reactions = dict.fromkeys([mechanism.nodes[pin.node]])
        for reaction in reactions:
            for member in pin.members:
                if member != FRAME:
                    yield f"{reaction}@{mechanism.members[member].name}", reaction, member
