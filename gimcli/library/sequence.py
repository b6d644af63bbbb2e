"""Find the sequence of the Geometrical-Iterative Method."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gimcli import output
from gimcli.gim.report import SequenceGroupReport, report as report_groups
from gimcli.library.inputs import Strategy, Tolerance, inputs_of
from gimcli.library.machines import for_each_machine
from gimcli.library.record import Records, RowField
from gimcli.library.result import Result
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.motion.solve import solve
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.drive_check import require_consistent
from gimcli.table import Table


@for_each_machine()
def sequence(
    mechanism: Mechanism, at: Mapping[str, float | str] | None = None, *, strategy: Strategy = "spectral",
    tolerance: Tolerance = 1e-10, **inputs: float,
) -> SequenceResult:  # fmt: skip
    """Search the sequence of moves of the Geometrical-Iterative Method, for example `sequence(m, motor=45)`.

    Args:
        mechanism: from `load` or `loads`.
        at: dict of inputs by name, for names that are not Python names or are names of arguments.
        strategy: "spectral" (the admissible sequence with the smallest spectral radius, which converges fastest) or
            "classic" (the sequence by the rules of the paper).
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        inputs: inputs by name, in the file's units. Inputs that are not given have the value at the start of their law.

    Returns:
        A SequenceResult: one row for each move, in groups in the order of solution; `report()` has the spectral radius
        and the expected number of sweeps of each group. If the position is not solved (`.status`), sequences are ranked
        at the drawn position.

    Raises:
        UsageError: an unknown name or an invalid argument.
        StructureError: the mechanism is not fully driven, over-driven or contradictory, or a pair cannot be written as
            the rules of the paper need it.
    """
    values = inputs_of(mechanism, at, inputs)
    position = solve(mechanism, values, Options(tolerance=tolerance))
    require_consistent(mechanism, position.z, values, position.status, tolerance)
    z = position.z if position.status is Status.OK else mechanism.drawn
    groups = report_groups(mechanism, z, values, strategy, tolerance)
    return SequenceResult(mechanism, groups, z, position.status)


class SequenceResult(Result):
    """The groups of the sequence in the order of solution, one row for each move."""

    KIND = "sequence"

    def __init__(
        self, mechanism: Mechanism, groups: list[SequenceGroupReport], z: ComplexArray, status: Status
    ) -> None:
        self.mechanism, self._found, self._z = mechanism, groups, z
        self.status = status.word

    def headline(self) -> str:
        """Return the result in one line."""
        moves = sum((s.rule, s.kind) != ("input", "RA") for g in self._found for s in g.steps)  # without placed arms
        counts = [f"{n} {word}{'s' * (n != 1)}" for n, word in ((len(self._found), "group"), (moves, "move"))]
        return f"{self.mechanism.name}: {', '.join(counts)} per sweep"

    def _moves(self, *groups: SequenceGroupReport) -> Records:
        """Return the moves of groups in the order of solution, one row each."""
        each = [(k, n, one) for k, group in enumerate(groups, 1) for n, one in enumerate(group.steps, 1)]
        return Records(
            RowField("group", [k for k, _, _ in each], int, key=False),
            RowField("step", [n for _, n, _ in each], head="step", key=False),
            RowField("node", [one.node for *_, one in each], str, head="move"),
            RowField("about", [list(one.about) for *_, one in each], list, head="about", text=" ".join),
            RowField("constraint", [one.constraint for *_, one in each], str, head="by"),
            RowField("rule", [one.rule for *_, one in each], str, head="rule"),
            RowField("kind", [one.kind for *_, one in each], str),
            RowField("states", [one.states for *_, one in each], head="states after it",
                     text=lambda own: " ".join(f"{node}:{state}" for node, state in own.items())),
        )  # fmt: skip

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        groups = [
            {
                "kind": one.kind, "nodes": list(one.nodes), "steps": self._moves(one).report(), "radius": one.radius,
                "predicted_sweeps": one.predicted_sweeps, "observed_sweeps": one.observed_sweeps,
                "candidates": one.candidates, "incomplete": one.incomplete,
            }
            for one in self._found
        ]  # fmt: skip
        return {"groups": groups}

    def table(self) -> Table:
        """Return one row for each move: group, moved node, nodes of the constraint, constraint, kind and rule."""
        return self._moves(*self._found).table("group", "node", "about", "constraint", "kind", "rule")

    def picture(self) -> output.picture.Content:
        """Return the position with numbered moves, coloured by group, and the table of the moves."""
        mechanism, groups, first = self.mechanism, dict[str, tuple[output.structure.DrawnMove, ...]](), 1
        for group in (group for group in self._found if group.steps):
            last = first + len(group.steps) - 1
            moves = tuple(
                output.structure.DrawnMove(
                    s.number, s.about_numbers, f"{s.node} about {', '.join(s.about)}: {s.constraint}"
                )
                for s in group.steps
            )
            count = f"move {first}" if first == last else f"moves {first} to {last}"
            name = f"{group.kind} {' '.join(group.nodes)}" if group.kind == "dyad" else f"{group.kind} group"
            groups[f"{name}: {count}"] = moves
            first = last + 1
        return output.structure.sequence_sheet(
            mechanism, mechanism.to_file(self._z), groups, f"{mechanism.name}: sequence"
        )
