"""The quantities of a mechanism by name: what may be kept, plotted, compared, and asked of any result."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

from gimcli.errors import UsageError
from gimcli.mechanism import FRAME, Mechanism
from gimcli.quantities.coordinates import LETTERS, TURNING, MemberTurning, PointVector, RowValue
from gimcli.quantities.forces import ForceQuantity, force_quantities
from gimcli.quantities.kinds import KINDS, quantities_of
from gimcli.quantities.quantity import Item, Quantity
from gimcli.structure.derived import derived


class Catalogue:
    """The quantities of a mechanism."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.points = tuple(dict.fromkeys([*mechanism.traced, *(p.name for p in mechanism.points), *mechanism.nodes]))
        self.members = {m.name: k for k, m in enumerate(mechanism.members) if k != FRAME}
        self.rows = {"step": "", "time": "s", "residual": ""}
        self.rows |= {a.name: mechanism.unit_of(a) for a in mechanism.actuators}
        self._known: dict[str, tuple[Item, ...]] = {}

    @property
    def columns(self) -> Iterator[str]:
        """The names of all columns but those of kinds with arguments."""
        yield from self.rows
        yield from (f"{name}.{letter}{axis}" for name in self.points for letter in LETTERS for axis in "xy")
        yield from (f"{name}.{word}" for name in self.members for word in TURNING)
        yield from (head.name for one in self.forces for head in one.heads)

    @cached_property
    def forces(self) -> tuple[ForceQuantity, ...]:
        """The quantities of forces."""
        return tuple(force_quantities(self.mechanism))

    def find(self, name: str) -> tuple[Item, ...]:
        """Return the column with a name, or the columns of a point, a vector such as P.v or a kind; () if unknown."""
        if name not in self._known:
            self._known[name] = tuple(self._found(name))
        return self._known[name]

    def column(self, name: str) -> Item | None:
        """Return the one column with a name; None if there is none."""
        return next((item for item in self.find(name) if item.head.name == name), None)

    def _found(self, name: str) -> Iterator[Item]:
        head, _, tail = name.rpartition(".")
        if name in self.rows:
            yield Item(RowValue(name, self.rows[name]), 0)
        elif head in self.members and tail in TURNING:
            yield Item(MemberTurning(self.mechanism, self.members[head], TURNING.index(tail)), 0)
        elif head in self.points and tail[-1:] in ("x", "y") and tail[:-1] in LETTERS:
            vector = PointVector(self.mechanism, head, LETTERS.index(tail[:-1]))
            yield Item(vector, "xy".index(tail[-1]))
        elif name in self.points or (head in self.points and tail in LETTERS[1:]):
            order = 0 if name in self.points else LETTERS.index(tail)
            yield from _items(PointVector(self.mechanism, name if not order else head, order))
        elif name.partition(":")[0] in KINDS:
            yield from self._of_kind(name)
        else:
            vectors = [one for one in self.forces if one.own.vector and one.spec in (name, f"{name}.f")]
            alone = [item for one in self.forces for item in _items(one) if item.head.name == name]
            yield from alone or [item for one in vectors[:1] for item in _items(one)]

    def _of_kind(self, name: str) -> Iterator[Item]:
        """Yield the columns of a kind with arguments, such as centre:a/b, or the one with this name."""
        parts = name.split(".")
        for k in range(len(parts), 0, -1):
            try:
                items = [item for one in quantities_of(self.mechanism, ".".join(parts[:k])) for item in _items(one)]
            except UsageError:
                continue
            exact = [item for item in items if item.head.name == name]
            yield from exact or (items if k == len(parts) else [])
            return


@derived
def catalogue(mechanism: Mechanism) -> Catalogue:
    """Return the quantities of a mechanism."""
    return Catalogue(mechanism)


def _items(quantity: Quantity) -> Iterator[Item]:
    return (Item(quantity, k) for k in range(len(quantity.heads)))
