"""Count the freedoms of a mechanism."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.errors import UnassembledError
from gimcli.library.result import Result
from gimcli.mechanism import Mechanism
from gimcli.structure.mobility import Mobility, assembled
from gimcli.structure.mobility import mobility as mobility_at
from gimcli.table import Column, Table


def mobility(mechanism: Mechanism) -> MobilityResult:
    """Analyse the mobility at the assembled position nearest to the drawn one.

    Raises UnassembledError where there is none near.
    """
    z = assembled(mechanism)
    if z is None:
        raise UnassembledError(
            f"{mechanism.name} cannot be assembled near its drawn position: draw it closer, or see `gim solve` for the"
            " constraint that is worst off"
        )
    found = mobility_at(mechanism, z, mechanism.drawn_inputs)
    start = "regular"
    if found.stuck:
        from gimcli.branching.singular_start import singular_start

        start = singular_start(mechanism, z)
    return MobilityResult(mechanism, found, start)


class MobilityResult(Result):
    """Grübler's count, rank, mobility, and what is redundant, undriven or over-driven, by name (`found`)."""

    KIND = "mobility"

    def __init__(self, mechanism: Mechanism, found: Mobility, start: str) -> None:
        self.mechanism, self.found, self.start = mechanism, found, start

    @property
    def mobility(self) -> int:
        """The confirmed number of freedoms."""
        return self.found.mobility

    @property
    def status(self) -> str:
        """What the drawn position is: "regular", or which kind of singular position."""
        return self.start

    def headline(self) -> str:
        """Return the result in one line."""
        found = self.found
        return f"{self.mechanism.name}: mobility {found.mobility}, Grübler's count {found.gruebler}, rank {found.rank}"

    def report(self) -> dict[str, Any]:
        """Return what --json prints."""
        found = self.found
        return {
            "gruebler": found.gruebler, "rank": found.rank, "mobility": found.mobility,
            "redundant": list(found.redundant), "undriven": list(found.undriven),
            "actuators": len(found.actuators), "start": self.start,
            "overdriven": list(found.overdriven), "apparent": found.apparent, "singular": found.singular,
        }  # fmt: skip

    def table(self) -> Table:
        """Return what is told, as text."""
        names, values = zip(*self.rows(), strict=True)
        return Table((Column("quantity", np.array(names)), Column("value", np.array(values))))

    def rows(self) -> list[tuple[str, str]]:
        """Return quantities and values as text."""
        found = self.found
        return [
            ("Grübler's count", str(found.gruebler)),
            ("rank of the constraint Jacobian", str(found.rank)),
            ("mobility", str(found.mobility)),
            ("redundant constraints", ", ".join(found.redundant) or "none"),
            ("actuators", ", ".join(a.name for a in self.mechanism.actuators) or "none"),
            ("undriven nodes", ", ".join(found.undriven) or "none"),
            ("over-driven by", ", ".join(found.overdriven) or "none"),
        ]
