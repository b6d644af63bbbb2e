"""Designs x rows as a state of quantities: plain, or in dual numbers with the derivatives by the dimensions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.calculus.numbers import nominal
from gimcli.errors import UsageError
from gimcli.families.float_tables import FloatTables
from gimcli.families.planned_family import PlannedFamily
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.nearest import guess
from gimcli.quantities.catalogue import catalogue
from gimcli.quantities.forces import ForceQuantity, no_forces
from gimcli.quantities.kinds import KINDS
from gimcli.quantities.quantity import Item
from gimcli.quantities.state import ApartError, Needs, Positions

if TYPE_CHECKING:
    from gimcli.dynamics.forces import Forces


class DesignState(Positions):
    """Designs x rows, plain or in dual numbers whose first tangents are the dimensions."""

    def __init__(
        self, family: PlannedFamily, designs: FloatArray, z: Any, tables: FloatTables, given: Any = None,
        time: Any = None, items: Iterable[Item] = (), **options: Any,
    ) -> None:  # fmt: skip
        """Take positions z (designs, nodes, rows) of designs (designs, dimensions), and the numbers of their plans.

        given (designs or 1, orders, actuators, rows): inputs and their derivatives by the time [s] (designs or 1, rows)
        as far as they are known. Rates and forces of all `items` are computed together; `options` are jit and notify.
        """
        super().__init__(family.mechanism, z)
        self.family, self.designs, self.tables, self.given, self.clock = family, designs, tables, given, time
        self.inputs = None if given is None else given[:, 0]
        asked = [item.quantity for item in items]
        self._order = Needs(family.mechanism, asked).order
        self._formulas = [one.own.find for one in asked if isinstance(one, ForceQuantity)]
        self._options = options
        self._rates: tuple[Any, Any] | None = None
        self._forces: dict[Callable[[Forces], Any], Any] = {}

    def input_rates(self, order: int) -> Any:
        """Return the inputs and their derivatives by the time up to an order; raise ApartError if they are unknown."""
        if self.given is None:
            raise ApartError
        return self.given[:, : order + 1]

    def rates(self, order: int) -> tuple[Any, Any]:
        """Return the derivatives by the time up to an order, in the normal frame of the nominal design.

        Those of nodes are (designs, order + 1, nodes, rows), those of members (designs, order, members, rows).
        """
        found = self._rates
        if found is None or found[1].shape[1] < order:
            order = max(order, self._order)
            found = self.family.rates(order)(self.designs, self.z, self.input_rates(order), **self._options)
            self._rates = found
        return found

    def node(self, node: int, order: int = 0) -> Any:
        """Return the place of a node (designs, rows), or a derivative of it."""
        return self.rates(order)[0][:, order, node] if order else super().node(node)

    def turning(self, member: int, order: int) -> Any:
        """Return omega, alpha or angular jerk of a member (designs, rows)."""
        return self.rates(order)[1][:, order - 1, member - 1]

    def of_forces(self, find: Callable[[Forces], Any]) -> Any:
        """Return a formula of the forces (designs, rows)."""
        if find not in self._forces:
            made, given, every = self.family.forces, self.input_rates(2), dict.fromkeys((find, *self._formulas))
            if made is None:
                raise ApartError
            self._forces = made(every, self.designs, self.z, given, self.clock, **self._options)
        return self._forces[find]

    def row(self, name: str) -> Any:
        """Return the time [s], or an input in the file's unit (designs or 1, rows); raise ApartError if unknown."""
        names = [actuator.name for actuator in self.mechanism.actuators]
        if name in names and self.inputs is not None:
            k = names.index(name)
            return self.mechanism.value_to_file(k, self.inputs[:, k])
        if name != "time" or self.clock is None:
            raise ApartError
        return self.clock

    def local(self, table: str, row: int) -> Any:
        """Return a complex number of each design (designs, 1)."""
        pairs = getattr(self.tables, table)[:, row]
        return (pairs[:, 0] + 1j * pairs[:, 1])[:, None]

    def values(self, items: Sequence[Item]) -> FloatArray:
        """Return the values of columns (columns, designs, rows)."""
        shape = len(self.z), self.z.shape[-1]
        with np.errstate(all="ignore"):
            return np.stack([np.broadcast_to(nominal(self.value(*item)), shape) for item in items])

    def slopes(self, items: Sequence[Item]) -> FloatArray:
        """Return the derivatives of columns (columns, designs, tangents, rows) of a state in dual numbers."""
        with np.errstate(all="ignore"):
            return np.stack([np.moveaxis((self.value(*item) + 0.0 * self.z[:, 0].real).slopes, 0, 1) for item in items])


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
