"""Find the circuits of a mechanism."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.branching.enumeration import Circuits, EnumerationConstants, Strand, circuits as all_circuits
from gimcli.continuation.curve import LONGEST
from gimcli.library.inputs import in_file_units, interval_of, refuse_count, refuse_linked
from gimcli.library.machines import driven_machines, for_each_machine
from gimcli.library.places import coordinates, input_columns
from gimcli.library.result import Result
from gimcli.library.rounding import at_inputs, intervals
from gimcli.mechanism import Mechanism
from gimcli.progress import WORK, Phases, limited, no_phases
from gimcli.structure.drive_check import explained
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.output.animation import Animation
    from gimcli.output.geometry import Geometry
    from gimcli.output.picture import Content

ROUND = 1e-12
"""A smaller input, in the file's unit, is shown as 0."""

LEAST, USUAL, MOST = 4, 72, 100_000
"""Smallest, usual and largest number of samples of the input."""


@for_each_machine(driven_machines)
def circuits(
    mechanism: Mechanism, *, samples: int = USUAL, progress: Phases = no_phases, seconds: float | None = None
) -> CircuitsResult:
    """Find the circuits of a mechanism: the configurations that are connected without disassembly.

    All configurations at `samples` values of the input are listed, and each is followed along its circuit.

    Args:
        mechanism: from `load` or `loads`.
        samples: number of values of the input, 4 to 100 000.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        seconds: the search ends after this time with what was found; by default it has a bound in positions only.

    Returns:
        A CircuitsResult: `.count`, `.complete`, and one row for each branch with the interval of every input in the
        file's units. It is empty if the mechanism cannot be assembled at the samples. Of several independent machines a
        MachinesResult, whose `each` has one by the name of each machine.

    Raises:
        UsageError: `samples` is not a whole number in its range.
        StructureError: the mechanism has no actuator, or is not fully driven or over-driven.
    """
    refuse_linked(mechanism, "circuits")
    refuse_count("samples", samples, LEAST, MOST)
    constants = EnumerationConstants(samples=samples)
    with explained(mechanism), limited(WORK * max(1.0, samples / USUAL), seconds) as limit:
        found = all_circuits(mechanism, constants, progress("configurations and their circuits"))
    return CircuitsResult(mechanism, found, limit.reached)


class CircuitsResult(Result):
    """The circuits: `count` and `complete`, one row for each branch; `report()` has curves and configurations."""

    KIND = "circuits"

    def __init__(self, mechanism: Mechanism, found: Circuits, limited: bool = False) -> None:
        self.mechanism, self.found, self.limited = mechanism, found, limited

    @property
    def count(self) -> int:
        """The number of circuits."""
        return self.found.count

    @property
    def answered(self) -> bool:
        """Whether there is at least one circuit."""
        return bool(self.found.strands)

    @property
    def complete(self) -> bool:
        """Whether all configurations at the samples are proved to be known, and each is on a circuit of the list."""
        return self.found.complete

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: {self.found.count} circuit{'s' * (self.found.count != 1)}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found, mechanism = self.found, self.mechanism
        curves = [
            {
                "curve": curve_label(found, k), "circuit": s.number + 1, "closed": s.circuit.closed,
                "ended": s.circuit.ended,
                "turns": abs(s.circuit.turns), "interval": span(found, s),
                "branches": [{"from": inputs_at(found, b.start), "to": inputs_at(found, b.end)} for b in s.branches],
            }
            for k, s in enumerate(found.strands)
        ]  # fmt: skip
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
            "curves": curves, "at": inputs_at(found, found.curve.begin()), "configurations": listed,
        }  # fmt: skip

    def table(self) -> Table:
        """Return one row for each branch: curve, circuit, and the ends of the interval of every input."""
        found = self.found
        rows = [(curve_label(found, k), s.number + 1, b) for k, s in enumerate(found.strands) for b in s.branches]
        columns = [
            Column("curve", np.array([row[0] for row in rows], dtype=str)),
            Column("circuit", np.array([row[1] for row in rows], dtype=np.int64)),
        ]
        for end in ("from", "to"):
            values = [inputs_at(found, b.start if end == "from" else b.end) for _, _, b in rows]
            columns += input_columns(self.mechanism, values, f".{end}")
        return Table(tuple(columns))

    def picture(self) -> Content | None:
        """Return the paths of one point on all circuits and a graph over the input; None if there is no circuit."""
        from gimcli.library.circuits_picture import circuits_picture

        found = self.found
        if not found.strands:
            return None
        labels = [curve_label(found, k) for k in range(len(found.strands))]
        title = f"{self.mechanism.name}: {found.count} circuit{'s' * (found.count != 1)}"
        return circuits_picture(found, labels, title)

    def geometry(self) -> Geometry | None:
        """Return the paths of the traced points on all circuits and a position, in true size; None without circuits."""
        from gimcli.library.circuits_picture import circuits_geometry

        found = self.found
        labels = [curve_label(found, k) for k in range(len(found.strands))]
        return circuits_geometry(found, labels) if found.strands else None

    def animation(self) -> Animation | None:
        """Return the circuits, one clip for each curve; None if there is no circuit."""
        from gimcli.library.circuit_animation import ShownCircuit, SingularPlace, circuits_animation

        found, mechanism, shown = self.found, self.mechanism, []
        for k, strand in enumerate(found.strands):
            branches = f"; {len(strand.branches)} branches" * (len(strand.branches) > 1)
            note = intervals(mechanism, span(found, strand), strand.circuit.turns) + branches
            at = [at_inputs(mechanism, inputs_at(found, float(one.p[-1]))) for one in strand.limits]
            places = tuple(
                SingularPlace(one.fraction, one.kind, f"{one.kind} at {text}", one.p)
                for one, text in zip(strand.limits, at, strict=True)
            )
            shown.append(ShownCircuit(f"circuit {curve_label(found, k)}", strand.circuit, note, places))
        return circuits_animation(mechanism, self.headline(), shown, "Circuit")


def inputs_at(found: Circuits, q: float) -> dict[str, float]:
    """Return the inputs at a parameter of the curve, in the file's units."""
    values = in_file_units(found.curve.mechanism, found.curve.inputs(q))
    return {name: value if abs(value) > ROUND else 0.0 for name, value in values.items()}


def curve_label(found: Circuits, index: int) -> str:
    """Return the label of a strand: the number of its circuit, and a letter if the circuit has several curves."""
    own = found.strands[index].number
    same = [k for k, s in enumerate(found.strands) if s.number == own]
    return f"{own + 1}" + ("" if len(same) == 1 else chr(ord("a") + same.index(index)))


def span(found: Circuits, strand: Strand) -> dict[str, list[float]]:
    """Return the smallest and the largest value of every input along a strand."""
    return interval_of(*(inputs_at(found, q) for q in strand.interval))


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
