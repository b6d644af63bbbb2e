"""Forces, moments, powers and energies as quantities of a motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import chain
from typing import TYPE_CHECKING, Any

from gimcli.errors import GimError
from gimcli.mechanism import Mechanism
from gimcli.quantities.quantity import Head, Quantity
from gimcli.quantities.state import ApartError, State

if TYPE_CHECKING:
    from gimcli.dynamics.force_columns import ForceColumn

NO_LIMITS = "a simulation has the friction itself, not its limits: `gim forces` has them"


class ForceQuantity(Quantity):
    """A force, a moment, a power or an energy."""

    def __init__(self, own: ForceColumn) -> None:
        self.own, self.spec = own, own.name
        self.heads = tuple(Head(name, own.unit, own.name.rpartition(".")[2]) for name in own.names)

    def values(self, state: State) -> Sequence[Any]:
        """Return the value, of a vector its components."""
        if self.own.dry and state.forces.dry is None:
            raise ApartError(NO_LIMITS)
        found = state.of_forces(self.own.find)
        return (found.real, found.imag) if self.own.vector else [found]


def force_quantities(mechanism: Mechanism) -> Iterator[ForceQuantity]:
    """Yield the quantities of the forces of a mechanism; none without masses, loads, springs, or a physical unit."""
    if mechanism.dynamics.empty or mechanism.dynamics.metre is None or len(mechanism.machines) > 1:
        return
    from gimcli.dynamics.coulomb_table import friction_formulas  # imported late: few ask
    from gimcli.dynamics.force_columns import reactions, rotors, seen_from_members, springs, totals
    from gimcli.dynamics.statics import statics

    with suppress(GimError):  # not driven by its inputs
        own = statics(mechanism)
        every = (reactions, totals, rotors, springs, friction_formulas, seen_from_members)
        yield from map(ForceQuantity, chain.from_iterable(formulas(own) for formulas in every))
