"""A motion in true size, for drawing programs: a position, and the curves of the traced points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.table import Table

if TYPE_CHECKING:
    from gimcli.output.geometry import Geometry

BRANCH = "branch"


def motion_geometry(mechanism: Mechanism, pose: ComplexArray, table: Table) -> Geometry:
    """Return a position (nodes,) in the file's coordinates and the paths that a table has, with all its rows."""
    from gimcli.output.geometry import Geometry

    found = Geometry(mechanism.length_unit)
    found.add_mechanism(mechanism, pose)
    for name in (*mechanism.nodes, *(point.name for point in mechanism.points)):
        if {f"{name}.x", f"{name}.y"} <= set(table.names):
            z = table.floats(f"{name}.x") + 1j * table.floats(f"{name}.y")
            for tail, rows in _parts(table):
                found.add_curve(f"curve {name}{tail}", z[rows])
    return found


def _parts(table: Table) -> list[tuple[str, np.ndarray]]:
    """Return the rows of each branch, and the end of its name."""
    if BRANCH not in table.names:
        return [("", np.arange(len(table)))]
    own = table[BRANCH]
    return [(f" {BRANCH} {number}", np.flatnonzero(own == number)) for number in np.unique(own)]
