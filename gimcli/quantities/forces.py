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

ENDS, BEGINS = ("effort", "fx", "fy", "f", "normal", "moment", "torque", "force"), ("power", "energy", "shaking")
"""Words with which the names of these quantities end or begin."""

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


def no_forces(mechanism: Mechanism, name: str) -> str:
    """Return why a mechanism does not have a quantity with the name of a force; "" for another name, or if it may."""
    words = name.split(".")
    if len(words) < 2 or not (words[-1] in ENDS or words[0] in BEGINS):
        return ""
    if mechanism.dynamics.empty:
        return "forces and energies need masses, loads or springs in the model file"
    if mechanism.dynamics.metre is None:
        return "forces and energies need a physical unit of length in the model file"
    return "of several machines `forces` has the forces of each" if len(mechanism.machines) > 1 else ""


def force_quantities(mechanism: Mechanism) -> Iterator[ForceQuantity]:
    """Yield the quantities of the forces of a mechanism; none without masses, loads, springs, or a physical unit."""
    if mechanism.dynamics.empty or mechanism.dynamics.metre is None or len(mechanism.machines) > 1:
        return
    from gimcli.dynamics.efficiency import friction_formulas  # imported late: few ask
    from gimcli.dynamics.force_columns import reactions, rotors, seen_from_members, springs, totals
    from gimcli.dynamics.statics import statics

    with suppress(GimError):  # not driven by its inputs
        own = statics(mechanism)
        every = (reactions, totals, rotors, springs, friction_formulas, seen_from_members)
        yield from map(ForceQuantity, chain.from_iterable(formulas(own) for formulas in every))
