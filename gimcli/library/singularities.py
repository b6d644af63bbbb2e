"""List the singular positions of a mechanism."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from gimcli import graphs, output
from gimcli.branching.singular_positions import Found, Survey, first_turn, survey
from gimcli.branching.singularities import STATIONARY, BranchRates, input_ends, rates
from gimcli.continuation.circuit import Circuit
from gimcli.library.inputs import ROUND, in_file_units, interval_of
from gimcli.library.machines import driven_machines, for_each_machine
from gimcli.library.record import InputsField, NodesField, Records, RowField
from gimcli.library.result import Result
from gimcli.mechanism import Mechanism
from gimcli.progress import Phases, no_phases
from gimcli.rounding import at_inputs, intervals
from gimcli.table import Table

CURVES = 6
"""Largest number of curves in the picture."""


MEMBERS = 3
"""Most members whose rates are compared in the terminal."""

ALIKE = 1e-6
"""Relative differences between branches below this are rounding: tangents are accurate to half the digits or better."""


@for_each_machine(driven_machines)
def singularities(mechanism: Mechanism, *, progress: Phases = no_phases) -> SingularitiesResult:
    """List limits, dead points, change points, tangencies and stationary positions.

    The whole circuit of the initial position is searched, and all branches that meet it.

    Args:
        mechanism: from `load` or `loads`.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.

    Returns:
        A SingularitiesResult: `.events` is a list of dicts with kind, inputs and node coordinates in the file's units.
        Of several independent machines a MachinesResult, whose `each` has one by the name of each machine.

    Raises:
        StructureError: the mechanism has no actuator, or is not fully driven or over-driven.
        UnassembledError: no assembled position to start from was found.
    """
    return SingularitiesResult(mechanism, survey(mechanism, progress=progress("following branches")))


class SingularitiesResult(Result):
    """The singular positions (`events`), one row each, and the branches on which they are."""

    KIND = "singularities"
    answered = True  # the list is a result also if branches are missing

    def __init__(self, mechanism: Mechanism, found: Survey) -> None:
        self.mechanism, self._found = mechanism, found

    @property
    def complete(self) -> bool:
        """Whether all branches that meet were followed."""
        return self._found.complete

    @property
    def events(self) -> list[dict[str, Any]]:
        """The singular positions: kind, inputs, branches, tangents, coordinates of the nodes."""
        return self._records.report()

    def _inputs(self, one: Found) -> dict[str, float]:
        """Return the inputs at a singular position in the file's units."""
        p = np.append(one.what.p[:-1], first_turn(self._found, float(one.what.p[-1])))
        return in_file_units(self.mechanism, self._found.curve.inputs(p), ROUND)

    def _interval(self, number: int) -> dict[str, list[float]]:
        """Return the smallest and the largest value of every input on a branch."""
        ends = input_ends(self._found.branches.circuits[number], self._found.reach[number])
        return interval_of(*(in_file_units(self.mechanism, end, ROUND) for end in ends))

    def headline(self) -> str:
        """Return the result in one line."""
        still = sum(one.what.kind == STATIONARY for one in self._found.found)
        counts = ((len(self._found.found) - still, "singular"), (still, "stationary"))
        text = ", ".join(f"{n} {kind} position{'s' * (n != 1)}" for n, kind in counts if n)
        return f"{self.mechanism.name}: {text or 'no singular position'}"

    @cached_property
    def _records(self) -> Records:
        """The singular positions, one row each."""
        found, curve = self._found.found, self._found.curve
        kinds = [f"{one.what.kind}{' (' + one.what.end + ')' if one.what.end else ''}" for one in found]
        tangents = [[rates(curve, one.what.p, v) for v in one.what.branches] for one in found]
        texts = [_compared(own, one.what.loose) for own, one in zip(tangents, found, strict=True)]
        return Records(
            RowField("number", range(1, len(found) + 1), int, head="", key=False),
            RowField("kind", [one.what.kind for one in found], str, head="kind", text=kinds),
            InputsField(self.mechanism, "at", [self._inputs(one) for one in found]),
            RowField("end", [one.what.end or None for one in found]),
            RowField("about", [list(one.what.about) for one in found], list, head="members"),
            RowField("freer", [one.what.loose for one in found]),
            RowField("branches", [[k + 1 for k in one.circuits] for one in found], list, head="branch"),
            RowField("tangents", [[{"inputs": t.inputs, "members": t.members} for t in own] for own in tangents]),
            RowField("rates", texts, head="relative rates on each branch" if any(texts) else None, key=False),
            NodesField(self.mechanism, [curve.nodes(one.what.p) for one in found]),
        )

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        circuits = [
            {
                "branch": k + 1, "closed": c.closed, "ended": c.ended, "turns": abs(c.turns),
                "interval": self._interval(k),
            }
            for k, c in enumerate(self._found.branches.circuits)
        ]  # fmt: skip
        return {"circuits": circuits, "singularities": self._records.report(), "complete": self._found.complete}

    def table(self) -> Table:
        """Return one row for each singular position: kind, inputs, coordinates of the nodes, members, branches."""
        return self._records.table("kind", "at", "nodes", "about", "branches")

    def picture(self) -> output.picture.Content:
        """Return the numbered positions and the curves of the traced points."""
        from gimcli.branching.resampling import along
        from gimcli.structure.carried import carried_point

        found, curve, mechanism = self._found, self._found.curve, self.mechanism
        several = len(found.branches.circuits) > 1
        names = mechanism.traced[: max(1, CURVES // len(found.branches.circuits))]
        paths = [curve.nodes(along(one, max(361, len(one.places)))) for one in found.branches.circuits]
        curves = {
            f"{name}, branch {k}" if several else name: mechanism.to_file(carried_point(mechanism, name, z))
            for k, z in enumerate(paths, 1)
            for name in names
        }
        shown = []
        for number, one in enumerate(found.found, start=1):
            z = curve.nodes(one.what.p)
            at = tuple(complex(mechanism.to_file(carried_point(mechanism, n, z[:, None]))[0]) for n in names[:1])
            shown.append(output.pose.Shown(number, one.what.kind, mechanism.to_file(z), at))
        return output.circuits.singular_picture(mechanism, shown, curves, self.headline())

    def animation(self) -> output.animation.Animation | None:
        """Return the branches with all singular and stationary positions as events."""
        circuits, shown = self._found.branches.circuits, []
        for number, circuit in enumerate(circuits):
            own = [one for one in self._found.found if number in one.circuits]
            places = tuple(self._place(circuit, number, one) for one in own)
            name = f"branch {number + 1}" if len(circuits) > 1 else "circuit"
            note = intervals(self.mechanism, self._interval(number), circuit.turns)
            shown.append(graphs.circuit_animation.ShownCircuit(name, circuit, note, places))
        return graphs.circuit_animation.circuits_animation(self.mechanism, self.headline(), shown, "Branch")

    def _place(self, circuit: Circuit, number: int, one: Found) -> graphs.circuit_animation.SingularPlace:
        """Return a singular position as a mark on a circuit; stationary members are named."""
        kind = one.what.kind
        words = f"{', '.join(one.what.about)} stationary" if kind == STATIONARY else kind
        text = f"{words} at {at_inputs(self.mechanism, self._inputs(one))}"
        return graphs.circuit_animation.SingularPlace(
            graphs.circuit_animation.part_of(circuit, number, one.what), kind, text, one.what.p
        )


def _compared(tangents: list[BranchRates], loose: bool) -> str:
    """Return, for every branch, the members whose rates differ most between branches."""
    free = ["more than one freedom in this position"] * loose
    if not tangents:
        return "".join(free)
    names = list(tangents[0].members)
    spread = {n: max(t.members[n] for t in tangents) - min(t.members[n] for t in tangents) for n in names}
    least = ALIKE * max(spread.values(), default=0.0)
    chosen = [n for n in sorted(names, key=lambda n: -spread[n])[:MEMBERS] if spread[n] > least] or names[:MEMBERS]
    lines = [
        ("with the input at rest: " if t.rests else "") + ", ".join(f"{n} {t.members[n]:+.6g}" for n in chosen)
        for t in tangents
    ]
    return "\n".join(lines + free)
