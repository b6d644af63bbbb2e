"""Find the positions of static equilibrium of released inputs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from gimcli import output
from gimcli.dynamic_data import DrivingEffort
from gimcli.dynamics.equilibria_balance import StaticBalance
from gimcli.dynamics.equilibria_circuit import CircuitEquilibria, released_circuit
from gimcli.dynamics.equilibria_curve import Equilibria, Push
from gimcli.dynamics.equilibria_search import released_search
from gimcli.graphs.extras import Extras
from gimcli.library.assembled import ListedPosition, listed_position
from gimcli.library.inputs import ROUND, Range, Seed, Time, Tolerance, in_file_units, inputs_of
from gimcli.library.machines import for_each_machine, released_inputs, released_machines
from gimcli.library.record import InputsField, NodesField, Records, RowField
from gimcli.library.result import Result
from gimcli.library.solved_positions import positions_at_rest
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.progress import Phases, limited, no_phases
from gimcli.quantities.state import SeparateState
from gimcli.rounding import greatest
from gimcli.status import Status
from gimcli.table import Column, Table

MOST_STARTS = 100_000

SAMPLES = 65
"""Number of values of a law from which its middle is determined."""

SENSES = {1: "up", -1: "down"}
"""Words for the sense in which an input is pushed, as in the names of columns."""


MULTIPLE = {2: " (double root)", 0: " (one of a continuum)"}
"""What the terminal adds to the stability of a multiplicity."""


@for_each_machine(released_machines)
def equilibrium(
    mechanism: Mechanism, at: Mapping[str, float | str] | None = None, free: str | Sequence[str] = (), *,
    time: Time = 0.0, measure: str | Sequence[str] = (), starts: Annotated[int, Range(1, MOST_STARTS)] = 24,
    seed: Seed = 0, tolerance: Tolerance = 1e-10,
    progress: Phases = no_phases, seconds: float | None = None, **inputs: float,
) -> EquilibriumResult:  # fmt: skip
    """Find the positions in which weight, springs, loads and constant efforts balance.

    With one released input all positions of the circuit of the start position are examined. With several, Newton's
    method is used from the start position and from random ones: others may exist.

    Args:
        mechanism: from `load` or `loads`; it needs masses, loads or springs.
        at: dict of inputs by name, for names that are not Python names or are names of arguments.
        free: names of inputs that are released besides those with `free: true`; a single input needs no name.
        time: time of tables over the time [s].
        measure: quantities of each equilibrium at rest, a text or a list, such as "A.fx" or "strut.length".
        starts: with several released inputs, starts in a row that find nothing new before the search ends; the first
            one is the start position, and there are at most 8 times as many.
        seed: seed of the random starts.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        seconds: the search ends after this time with what was found (status "work-limit"); by default there is a bound
            in positions only, which is the same on every machine.
        inputs: inputs by name, in the file's units, at which the others are held and the search begins. Inputs that
            are not given have the value at the start of their law.

    Returns:
        An EquilibriumResult: one row for each equilibrium, with inputs, potential, stability and the efforts that push
        the mechanism over the next one. `.everywhere` is true if all positions balance.

    Raises:
        UsageError: an unknown name, an invalid argument, or several inputs of which none is released.
        ModelError: no masses, loads or springs are defined, or the unit of length is not physical.
        StructureError: the mechanism has no actuator, or is not fully driven, over-driven or contradictory.
        UnassembledError: the start position cannot be assembled.
    """
    extras = Extras(mechanism, measure)
    released, values = released_inputs(mechanism, free), inputs_of(mechanism, at, inputs)
    balance = StaticBalance(mechanism, released, time)
    with limited(seconds=seconds):
        if len(released) == 1:
            circuit = released_circuit(mechanism, released[0], values, tolerance)
            middle = _middle(mechanism, released[0], values)
            found = CircuitEquilibria(circuit, balance, middle, progress("forces along the circuit")).run()
        else:
            search = released_search(mechanism, released, values, balance, tolerance)
            found = search.run(starts, seed, progress("searching equilibria"))
    return EquilibriumResult(mechanism, found, time, extras)


class EquilibriumResult(Result):
    """The equilibria, one row each; `everywhere`, `equilibria` (a list of dicts) and `holding` (efforts at the start).

    With one released input `curve()` is the table of potential and effort along the circuit.
    """

    KIND = "equilibrium"

    def __init__(self, mechanism: Mechanism, found: Equilibria, time: float, extras: Extras) -> None:
        self.mechanism, self._found, self.time, self.limited = mechanism, found, time, found.limited
        self.count, self.everywhere = len(found.found), found.everywhere  # whether all examined positions balance
        self.released = tuple(mechanism.actuators[k].name for k in found.released)
        own = extras.beside(self._state, ()) if extras.wanted else []
        self._measured = [replace(column, values=column.values[: self.count]) for column in own]

    # -- what was found -------------------------------------------------------------------------------

    @property
    def complete(self) -> bool:
        """Whether the whole circuit of one released input was examined; a search of several is no proof."""
        found = self._found
        return found.history is not None and not (found.cut or found.crossings or found.limited) and self.answered

    @property
    def answered(self) -> bool:
        """Whether all iterations converged; of the starts with several released inputs, at least one."""
        found = self._found
        lost = found.starts > 0 and found.failed == found.starts
        return not lost and all(one.status is Status.OK for one in found.found)

    @cached_property
    def _listed(self) -> list[ListedPosition | None]:
        return [listed_position(self.mechanism, one.z, one.inputs) for one in self._found.found]

    @property
    def assemblies(self) -> list[int | None]:
        """The numbers of the equilibria in the lists of `solve --all`; None if one is not in its list."""
        return [None if own is None else own.number for own in self._listed]

    @property
    def elsewhere(self) -> list[bool]:
        """Whether `solve` finds another configuration at the inputs of each equilibrium."""
        return [own is not None and own.elsewhere for own in self._listed]

    @cached_property
    def _state(self) -> SeparateState:
        """The equilibria at rest, of which any quantity may be asked by its name; without any the initial position."""
        own, each = self.mechanism, [(one.inputs, one.z) for one in self._found.found]
        inputs, z = (np.stack(some, axis=1) for some in zip(*(each or [(own.start_inputs, own.drawn)]), strict=True))
        return positions_at_rest(own, self.time, inputs, z)

    def _asked(self, columns: list[NDArray[Any]]) -> Any:
        """Return one column (equilibria,), or several (equilibria, columns)."""
        return super()._asked([column[: self.count] for column in columns])

    @property
    def driven(self) -> tuple[str, ...]:
        """The names of the released inputs with an effort of their own in the file, which acts."""
        actuators = self.mechanism.actuators
        own = [r for r in self.mechanism.dynamics.releases if r.actuator in self._found.released]
        return tuple(actuators[r.actuator].name for r in own if r.effort != DrivingEffort())

    @property
    def holding(self) -> dict[str, float]:
        """The efforts [N m or N] of the released inputs, besides their own, that hold the mechanism at the start."""
        return {name: float(value) for name, value in zip(self.released, self._found.holding, strict=True)}

    @property
    def equilibria(self) -> list[dict[str, Any]]:
        """The equilibria: inputs, potential, stability, stiffness, pushes over the next one, coordinates of nodes."""
        return self._records.report()

    def unit(self, number: int) -> str:
        """Return the unit of the effort of an actuator."""
        return "N m" if self.mechanism.actuators[number].rotary else "N"

    # -- reports --------------------------------------------------------------------------------------

    def headline(self) -> str:
        """Return the result in one line."""
        name, found = self.mechanism.name, self._found
        if found.everywhere:
            why = "no force acts on the released inputs" if not found.size else "all examined positions balance"
            return f"{name}: in equilibrium everywhere ({why})"
        stable = sum(one.stability == "stable" for one in found.found)
        count = f"{self.count} equilibri{'um' if self.count == 1 else 'a'}" if self.count else "no equilibrium"
        return f"{name}: {count}{f', {stable} stable' if self.count else ''}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found, history = self._found, self._found.history
        return {
            "released": list(self.released), "time": self.time,
            "at": in_file_units(self.mechanism, found.start_inputs, ROUND),
            "holding": {name: value if math.isfinite(value) else None for name, value in self.holding.items()},
            "everywhere": found.everywhere, "conservative": found.conservative, "complete": self.complete,
            "status": self.outcome,
            "equilibria": self.equilibria,
            **({"starts": found.starts, "failed": found.failed} if history is None else {
                "potential": [float(np.min(history.potential)), float(np.max(history.potential))],
                "closed": found.closed, "ended": found.ended, "crossings": found.crossings, "gain": found.gain,
                "winds": found.winds,
            }),
        }  # fmt: skip

    @cached_property
    def _records(self) -> Records:
        """The equilibria, one row each: inputs, potential, stability, stiffness, pushes, coordinates."""
        found, mechanism = self._found.found, self.mechanism
        energy, single = greatest(one.potential for one in found), len(self._found.released) == 1
        return Records(
            RowField("number", range(1, len(found) + 1), int, head=""),
            InputsField(mechanism, "inputs", [in_file_units(self.mechanism, one.inputs, ROUND) for one in found]),
            RowField("potential", [one.potential for one in found], float, "J", head="potential", size=energy),
            RowField("stability", [one.stability for one in found], str, head="stability",
                     text=[one.stability + MULTIPLE.get(one.multiplicity, "") for one in found]),
            RowField("negative", [one.negative for one in found], int, head=None if single else "unstable directions"),
            RowField("multiplicity", [one.multiplicity for one in found], int),
            RowField("stiffness", [None if one.stiffness is None else one.stiffness.tolist() for one in found]),
            *(self._of_one_input(energy) if single else ()),
            *(
                RowField(c.name, c.values.tolist(), float, c.unit, head=c.name, size=greatest(c.values.tolist()))
                for c in self._measured
            ),
            RowField("residual", [one.residual for one in found], float),
            RowField("status", [one.status.word for one in found], str),
            RowField("assembly", lambda: self.assemblies),
            RowField("pushes", [[self._push(push) for push in one.pushes] for one in found]),
            NodesField(mechanism, [one.z for one in found]),
        )  # fmt: skip

    def _of_one_input(self, energy: float) -> Iterator[RowField]:
        """Yield the fields of one released input: its stiffness, and what pushes it over the next equilibrium."""
        found, main = self._found.found, self._found.released[0]
        actuator, pushed = self.mechanism.actuators[main], any(one.pushes for one in found)
        stiffness = [math.nan if one.stiffness is None else float(one.stiffness[0, 0]) for one in found]
        unit = "N m/rad" if actuator.rotary else "N/m"
        yield RowField("stiffness", stiffness, float, unit, head="stiffness", key=False)
        for sense, word in SENSES.items():
            own = [next((p for p in one.pushes if p.sense == sense), None) for one in found]
            efforts = [p and (math.nan if p.effort is None else p.effort) for p in own]
            at = [p and in_file_units(self.mechanism, p.inputs, ROUND)[actuator.name] for p in own]
            heads = (word, "barrier") if pushed else (None, None)
            yield RowField(f"{word}.effort", efforts, float, self.unit(main), head=heads[0], key=False)
            yield RowField(f"{word}.at", at, float, self.mechanism.unit_of(actuator), key=False)
            yield RowField(f"{word}.barrier", [p and p.barrier for p in own], float, "J", head=heads[1], size=energy,
                           key=False)  # fmt: skip

    def _push(self, push: Push) -> dict[str, Any]:
        return {
            "sense": SENSES[push.sense], "effort": push.effort, "at": in_file_units(self.mechanism, push.inputs, ROUND),
            "barrier": push.barrier, "to": push.target + 1,
        }  # fmt: skip

    def curve(self) -> Table | None:
        """Return inputs, potential [J] and holding effort along the circuit; None with several released inputs."""
        history, mechanism = self._found.history, self.mechanism
        if history is None:
            return None
        effort = np.where(np.isfinite(history.effort), history.effort, np.nan)
        inputs = (
            Column(a.name, mechanism.value_to_file(k, history.inputs[k]), mechanism.unit_of(a))
            for k, a in enumerate(mechanism.actuators)
        )
        return Table(
            (
                Column("fraction", history.fraction),
                *inputs,
                Column("potential", history.potential, "J"),
                Column("effort", effort, self.unit(self._found.released[0])),
            )
        )

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the columns, and those of the curve as `curve.NAME`."""
        curve = self.curve()
        more = {} if curve is None else {f"curve.{column.name}": column.values for column in curve.columns}
        return {**super().arrays(), **more}

    def picture(self) -> output.picture.Content | None:
        """Return potential and effort over the input, and the mechanism in each equilibrium."""
        return output.circuits.equilibrium_picture(self.mechanism, self._found, self.headline())


def _middle(mechanism: Mechanism, released: int, values: FloatArray) -> float:
    """Return the middle of the law of an input; of a law that does not contain its start value, this value."""
    law = mechanism.actuators[released].law(np.linspace(0.0, 1.0, SAMPLES))
    inside = float(np.min(law)) <= values[released] <= float(np.max(law))
    return 0.5 * float(np.min(law) + np.max(law)) if inside else float(values[released])
