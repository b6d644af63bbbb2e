"""Find the circuits of a mechanism."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any

import numpy as np

from gimcli import graphs, output
from gimcli.assemblies import drawn_configuration
from gimcli.branching.enumeration import CircuitBranch, Circuits, EnumerationConstants, Strand, circuits as all_circuits
from gimcli.branching.singularities import input_ends
from gimcli.continuation.curve import LONGEST
from gimcli.library.by_name import coordinates
from gimcli.library.inputs import ROUND, Range, in_file_units, interval_of
from gimcli.library.machines import driven_machines, for_each_machine
from gimcli.library.record import InputsField, Records, RowField
from gimcli.library.result import Result
from gimcli.mechanism import Mechanism
from gimcli.progress import WORK, Phases, limited, no_phases
from gimcli.rounding import at_inputs, how_it_ends, intervals
from gimcli.table import Table

LEAST, USUAL, MOST = 4, 72, 100_000
"""Smallest, usual and largest number of samples of the input."""


@for_each_machine(driven_machines)
def circuits(
    mechanism: Mechanism, *, values: Annotated[int, Range(LEAST, MOST)] = USUAL, progress: Phases = no_phases,
    seconds: float | None = None,
) -> CircuitsResult:  # fmt: skip
    """Find the circuits of a mechanism: the configurations that are connected without disassembly.

    All configurations at a number of values of the input are listed, and each is followed along its circuit.

    Args:
        mechanism: from `load` or `loads`.
        values: number of values of the input, 4 to 100 000, at which all configurations are found.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        seconds: the search ends after this time with what was found; by default there is a bound in positions only.

    Returns:
        A CircuitsResult: `.count`, `.complete`, and one row for each branch with the interval of every input in the
        file's units. It is empty if the mechanism cannot be assembled at the samples. Of several independent machines a
        MachinesResult, whose `each` has one by the name of each machine.

    Raises:
        UsageError: `values` is not a whole number in its range.
        StructureError: the mechanism has no actuator, or is not fully driven or over-driven.
    """
    constants = EnumerationConstants(samples=values)
    with limited(WORK * max(1.0, values / USUAL), seconds) as limit:
        found = all_circuits(mechanism, constants, progress("configurations and their circuits"))
    return CircuitsResult(mechanism, found, limit.reached)


class CircuitsResult(Result):
    """The circuits: their number `count`, and one row for each branch; `report()` has curves and configurations."""

    KIND = "circuits"

    def __init__(self, mechanism: Mechanism, found: Circuits, limited: bool = False) -> None:
        self.mechanism, self._found, self.count, self.limited = mechanism, found, found.count, limited

    @property
    def answered(self) -> bool:
        """Whether there is at least one circuit."""
        return bool(self._found.strands)

    @property
    def complete(self) -> bool:
        """Whether all configurations at the samples are proved to be known, and each is on a circuit of the list."""
        return self._found.complete

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: {self._found.count} circuit{'s' * (self._found.count != 1)}"

    @cached_property
    def initial(self) -> int | None:
        """The index of the curve of the initial configuration; None if it is on none."""
        drawn = drawn_configuration(self._found.start)
        return next((k for k, _ in self._found.places[drawn]), None) if drawn is not None else None

    @cached_property
    def _curves(self) -> Records:
        """The curves of the circuits, one row each."""
        found, strands, labels = self._found, self._found.strands, self._labels
        ways, spans = [s.circuit for s in strands], [span(found, s) for s in strands]
        at = at_inputs(self.mechanism, in_file_units(self.mechanism, found.start.inputs, ROUND))
        return Records(
            RowField("curve", labels),
            RowField("circuit", [s.number + 1 for s in strands]),
            RowField("closed", [c.closed for c in ways]),
            RowField("ended", [c.ended for c in ways]),
            RowField("turns", [abs(c.turns) for c in ways]),
            RowField("interval", spans),
            RowField("branches", [[self._ends(branch) for branch in s.branches] for s in strands]),
            RowField("shown", lambda: [f"{one}{' *' * (k == self.initial)}" for k, one in enumerate(labels)],
                     head="circuit", key=False),
            RowField("how", [how_it_ends(c.closed, c.ended, c.turns) for c in ways], head="", key=False),
            RowField("range", [intervals(self.mechanism, s, c.turns, "\n") for s, c in zip(spans, ways, strict=True)],
                     head="input", key=False),
            RowField("count", [len(s.branches) for s in strands], int, head="branches", key=False),
            RowField("there", [self._there(k) for k in range(len(strands))], head=f"configurations at {at}", key=False),
        )  # fmt: skip

    def _ends(self, branch: CircuitBranch) -> dict[str, dict[str, float]]:
        start, end = self._found.curve.inputs(branch.start), self._found.curve.inputs(branch.end)
        return {"from": in_file_units(self.mechanism, start, ROUND), "to": in_file_units(self.mechanism, end, ROUND)}

    def _there(self, curve: int) -> str:
        """Return the configurations on a curve, as text."""
        several = len(self._found.strands[curve].branches) > 1
        there = ((i, b) for i, at in enumerate(self._found.places) for k, b in at if k == curve)
        return ", ".join(f"{i + 1}{f' (branch {b + 1})' * several}" for i, b in there) or "none"

    @property
    def _labels(self) -> list[str]:
        return [curve_label(self._found, k) for k in range(len(self._found.strands))]

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found, mechanism = self._found, self.mechanism
        listed = [
            {
                "circuit": found.strands[at[0][0]].number + 1 if at else None,
                "branches": [f"{curve_label(found, k)}.{b + 1}" for k, b in at],
                "nodes": coordinates(dict(zip(mechanism.nodes, z, strict=True))),
            }
            for z, at in zip(mechanism.to_file(found.start.z), found.places, strict=True)
        ]
        return {
            "circuits": found.count, "status": self.outcome, "complete": found.complete, "samples": len(found.sampled),
            "spacing": spacing(found)[0], "lost": found.lost,
            "curves": self._curves.report(), "at": in_file_units(mechanism, found.start.inputs, ROUND),
            "configurations": listed,
        }  # fmt: skip

    def table(self) -> Table:
        """Return one row for each branch: curve, circuit, and the ends of the interval of every input."""
        found = self._found
        strands = enumerate(found.strands)
        rows = [(curve_label(found, k), s.number + 1, self._ends(b)) for k, s in strands for b in s.branches]
        return Records(
            RowField("curve", [curve for curve, _, _ in rows], str),
            RowField("circuit", [circuit for _, circuit, _ in rows], int),
            InputsField(self.mechanism, "from", [ends["from"] for _, _, ends in rows], ".from"),
            InputsField(self.mechanism, "to", [ends["to"] for _, _, ends in rows], ".to"),
        ).table()

    def picture(self) -> output.picture.Content | None:
        """Return the paths of one point on all circuits and a graph over the input; None if there is no circuit."""
        return (
            output.circuits.circuits_picture(self._found, self._labels, self.headline())
            if self._found.strands
            else None
        )

    def geometry(self) -> output.geometry.Geometry | None:
        """Return the paths of the traced points on all circuits and a position, in true size; None without circuits."""
        return output.circuits.circuits_geometry(self._found, self._labels) if self._found.strands else None

    def animation(self) -> output.animation.Animation | None:
        """Return the circuits, one clip for each curve; None if there is no circuit."""
        found, mechanism, shown = self._found, self.mechanism, []
        for k, strand in enumerate(found.strands):
            branches = f"; {len(strand.branches)} branches" * (len(strand.branches) > 1)
            note = intervals(mechanism, span(found, strand), strand.circuit.turns) + branches
            at = [
                at_inputs(mechanism, in_file_units(mechanism, found.curve.inputs(one.p), ROUND))
                for one in strand.limits
            ]
            places = tuple(
                graphs.circuit_animation.SingularPlace(one.fraction, one.kind, f"{one.kind} at {text}", one.p)
                for one, text in zip(strand.limits, at, strict=True)
            )
            shown.append(
                graphs.circuit_animation.ShownCircuit(f"circuit {curve_label(found, k)}", strand.circuit, note, places)
            )
        return graphs.circuit_animation.circuits_animation(mechanism, self.headline(), shown, "Circuit")


def curve_label(found: Circuits, index: int) -> str:
    """Return the label of a strand: the number of its circuit, and a letter if the circuit has several curves."""
    own = found.strands[index].number
    same = [k for k, s in enumerate(found.strands) if s.number == own]
    return f"{own + 1}" + ("" if len(same) == 1 else chr(ord("a") + same.index(index)))


def span(found: Circuits, strand: Strand) -> dict[str, list[float]]:
    """Return the smallest and the largest value of every input along a strand."""
    return interval_of(
        *(in_file_units(found.curve.mechanism, end, ROUND) for end in input_ends(strand.circuit, strand.interval))
    )


def spacing(found: Circuits) -> tuple[float, str]:
    """Return the spacing of the samples of the input, and its unit; for several inputs a part of the laws' range."""
    mechanism, spacing = found.curve.mechanism, np.array([found.spacing])
    if not found.curve.single:
        low, high = found.curve.laws
        return float(found.spacing / (high - low)), "times the range of the laws"
    main = found.curve.main
    unit = mechanism.unit_of(mechanism.actuators[main])
    return float(mechanism.value_to_file(main, spacing)[0]), "" if unit == "unit" else unit


def verdict(found: Circuits) -> str:
    """Return as text whether the list of circuits is complete."""
    count = len(found.sampled)
    if not found.complete:
        lost = f"; {found.lost} configurations could not be followed" if found.lost else ""
        return f"not proved complete: at some of {count} input values configurations may be missing{lost}"
    if not found.strands:
        return f"cannot be assembled at {count} sampled input values (proved)"
    step = "{:.3g} {}".format(*spacing(found)).rstrip()
    open_ended = found.curve.single and found.curve.rotary[found.curve.main] and not found.curve.periodic
    name = found.curve.mechanism.actuators[found.curve.main].name
    beyond = (
        f"; only the turns of {name} in its law are searched, since the inputs that follow it are not the same again"
        f" within {LONGEST} turns"
    )
    return (
        f"all configurations at {count} sampled input values are proved, and each is on a circuit of this list; a"
        f" circuit with a range of less than {step} between these values may be missing{beyond if open_ended else ''}"
    )
