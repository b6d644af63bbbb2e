"""Positions of designs as a state of quantities: plain, or in dual numbers with the derivatives by the dimensions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.calculus.numbers import nominal
from gimcli.errors import UsageError
from gimcli.families.float_tables import FloatTables
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.nearest import guess
from gimcli.quantities.catalogue import catalogue
from gimcli.quantities.forces import no_forces
from gimcli.quantities.kinds import KINDS
from gimcli.quantities.quantity import Item
from gimcli.quantities.state import ApartError, Needs, Positions

if TYPE_CHECKING:
    from gimcli.dynamics.forces import Forces


class PositionState(Positions):
    """Positions z (designs, nodes, rows) of designs with the numbers of their plans (designs, ...), or duals."""

    def __init__(
        self, mechanism: Mechanism, z: Any, tables: FloatTables, rates: Callable[[int], Any] | None = None,
        forces: Callable[[Callable[[Forces], Any]], Any] | None = None, inputs: Any = None,
    ) -> None:  # fmt: skip
        """Take the positions; `rates` returns points[order, node] and angles[order - 1, member - 1] up to an order.

        `forces` returns a formula of the forces (designs, rows), or (rows,) of one design. inputs (actuators, rows).
        """
        super().__init__(mechanism, z)
        self.tables, self._rates, self._forces, self._inputs = tables, rates, forces, inputs

    def rates(self, order: int) -> Any:
        """Return points[order, node] and angles[order - 1, member - 1] (designs, rows); raise ApartError if unknown."""
        if self._rates is None:
            raise ApartError
        return self._rates(order)

    def node(self, node: int, order: int = 0) -> Any:
        """Return the place of a node (designs, rows), or a derivative of it."""
        return self.rates(order)[0][order, node] if order else super().node(node)

    def turning(self, member: int, order: int) -> Any:
        """Return omega, alpha or angular jerk of a member."""
        return self.rates(order)[1][order - 1, member - 1]

    def of_forces(self, find: Callable[[Forces], Any]) -> Any:
        """Return a formula of the forces (designs, rows)."""
        if self._forces is None:
            raise ApartError
        return np.reshape(self._forces(find), (len(self.z), -1))

    def row(self, name: str) -> Any:
        """Return an input (1, rows) in the file's unit; raise ApartError for the time and the like."""
        names = [actuator.name for actuator in self.mechanism.actuators]
        if self._inputs is None or name not in names:
            raise ApartError
        k = names.index(name)
        return self.mechanism.value_to_file(k, self._inputs[k])[None]

    def local(self, table: str, row: int) -> Any:
        """Return a complex number of each design (designs, 1)."""
        return design_number(self.tables, table, row)

    def values(self, items: Sequence[Item]) -> FloatArray:
        """Return the values of columns (columns, designs, rows)."""
        shape = len(self.z), self.z.shape[-1]
        with np.errstate(all="ignore"):
            return np.stack([np.broadcast_to(nominal(self.value(*item)), shape) for item in items])

    def slopes(self, items: Sequence[Item]) -> FloatArray:
        """Return the derivatives of columns (columns, designs, tangents, rows) of a state in dual numbers."""
        with np.errstate(all="ignore"):
            return np.stack([np.moveaxis((self.value(*item) + 0.0 * self.z[:, 0].real).slopes, 0, 1) for item in items])


def design_number(tables: FloatTables, table: str, row: int) -> Any:
    """Return a complex number of each design (designs, 1)."""
    pairs = getattr(tables, table)[:, row]
    return (pairs[:, 0] + 1j * pairs[:, 1])[:, None]


def position_items(mechanism: Mechanism, text: str, order: int = 0) -> tuple[Item, ...]:
    """Return the quantities of positions of a text such as P, P.x, rocker, angle:A/B or transmission.

    They may need derivatives by the time up to an order. A member stands for its direction. Raises UsageError for other
    texts, and for what is no quantity of a position.
    """
    known = catalogue(mechanism)
    items = known.find(f"{text}.angle" if text in known.members else text)
    if not items and (text.partition(":")[0] in KINDS or "(" in text or "|" in text):
        items = known.asked(text)  # raises the reason
    needs = Needs(mechanism, (item.quantity for item in items))
    rows = set(needs.rows) - ({actuator.name for actuator in mechanism.actuators} if order else set())
    if items and (needs.order > order or rows or (needs.forced and not order)):
        what = "positions, rates and forces have" if order else "positions have"
        raise UsageError(f"of '{text}': only {what} exact derivatives; `gim sweep --keep` has its values")
    if not items:
        axes = (f"{name}.{axis}" for name in known.points for axis in "xy")
        near = no_forces(mechanism, text) or guess(text, [*known.points, *known.members, "transmission", *axes])
        raise UsageError(
            f"of '{text}': expected a node or point such as {mechanism.traced[0]}, its coordinate, a member,"
            f" transmission or angle:A/B; {near}"
        )
    return items
