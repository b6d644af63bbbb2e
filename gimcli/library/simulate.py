"""Simulate the motion of a mechanism with free inputs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from gimcli import graphs, output
from gimcli.canonical import TURN, counted
from gimcli.dynamics.force_motion import open_reactions
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.integrators import CAREFUL, INTEGRATORS, STEPPED, WITH_DRY_FRICTION
from gimcli.dynamics.kinematic_history import turning
from gimcli.dynamics.reducer import free_inputs
from gimcli.dynamics.simulation import simulate as simulate_times
from gimcli.dynamics.simulation_table import (
    ENERGIES,
    column_names,
    event_report,
    reaction_units,
    reactions as find_reactions,
    simulation_table,
)
from gimcli.dynamics.simulation_types import SIMULATION, Settings, Simulation
from gimcli.errors import UsageError, refuse
from gimcli.graphs.extras import Extras, texts
from gimcli.graphs.plots import drawn
from gimcli.library.by_name import ByName, angles
from gimcli.library.inputs import MOST_STEPS, Jit, Number, OneOf, Range
from gimcli.library.machines import accepted, driven_machines, for_each_machine
from gimcli.library.result import RowsResult
from gimcli.library.trace_result import Placed
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Machine, Mechanism
from gimcli.motion.motion import Motion
from gimcli.output.graph import Axis, Curve, CurveGraph
from gimcli.positions.dispatch import choose, plain
from gimcli.progress import Notify, Phases, limited, no_phases
from gimcli.quantities.state import MotionState
from gimcli.rates.derivatives import MotionRates
from gimcli.rates.member_angles import full_turn
from gimcli.status import Status
from gimcli.structure.carried import carried_point
from gimcli.table import Column, Table, per_second

ASKED = ("measure", "plot")
"""Arguments with texts of quantities."""

ROWS = 200
MOST_ROWS = 1_000_000
LEAST = 3e-14
"""Relative tolerance below which steps do not become more accurate."""

Duration = Annotated[float, Number("a number of seconds above 0 and below 1e9", lambda time: 0.0 < time < 1e9)]
Accuracy = Annotated[float, Number("a number from 1e-14 to 1e-2", lambda value: 1e-14 <= value <= 1e-2)]
Slip = Annotated[float | None, Number("a number of rad/s above 0", lambda slip: 0.0 < slip < 1e9)]

STEP = 1e-3
"""Default step of "rk4" [s]; a shorter motion is one step."""
WORK = 6e-4
"""Approximate time of one evaluation without compilation [s]."""
A_SECOND = 1500
"""Approximate number of evaluations for one second of motion."""


def _machines(mechanism: Mechanism, given: dict[str, Any]) -> Sequence[Machine]:
    """Return the machines with free inputs; the whole mechanism if there are none, or for a graph of several."""
    driven_machines(mechanism)  # refuses other parts that can move
    found = [m for m in mechanism.loaded_machines if any(r.free for r in m.mechanism.dynamics.releases)]
    own = [_own(one.mechanism, given) for one in found]
    known = {text for one in own for key in ASKED for text in one[key]}
    return (
        found
        if found and known >= {text for key in ASKED for text in texts(given.get(key, ()))}
        else [mechanism.as_machine]
    )


def _own(mechanism: Mechanism, given: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments for a machine: its own graphs."""
    own = {
        key: [text for text in texts(given.get(key, ())) if accepted(_extras, mechanism, **{key: text})]
        for key in ASKED
    }
    return {**given, **own} if _has_dry_friction(mechanism) else {**given, **own, "slip": None}


@for_each_machine(_machines, _own)
def simulate(
    mechanism: Mechanism, duration: Duration = 5.0, *, dt: float | None = None,
    integrator: Annotated[str, OneOf(INTEGRATORS)] = "", rtol: Accuracy = 1e-9,
    step: float | None = None, slip: Slip = None, standstills: Annotated[int, Range(0, MOST_STEPS)] = 0,
    reactions: bool = False, measure: str | Sequence[str] = (), plot: str | Sequence[str] = (), jit: Jit = "auto",
    notify: Notify | None = None, progress: Phases = no_phases, seconds: float | None = None,
) -> SimulateResult:  # fmt: skip
    """Simulate the motion of the free inputs (`free: true` in the model) under the forces that act (forward dynamics).

    Args:
        mechanism: from `load` or `loads`; it needs masses and at least one free input.
        duration: seconds of motion.
        dt: seconds between two rows, by default `duration` / 200.
        integrator: "dop853", "rk45", "radau", "lsoda" (steps from `rtol`), "rk4" (equal steps of time), "euler"
            (equal steps of the only free input) or "euler-exact" (the same with the exact dJ/dq); by default "dop853",
            with dry friction "lsoda", and "radau" where damping is stiff.
        rtol: relative tolerance of inputs and speeds; of the integrators with adaptive steps, from 1e-14 to 1e-2.
        step: step of "rk4" [s], of "euler" and "euler-exact" [rad, or the file's unit of length]; by default 0.001
            (for a length, of about the size of the mechanism).
        slip: slip speed of dry friction [rad/s] below which it grows smoothly with the speed, in guides times the unit
            of length of the normal frame (about the size of the mechanism); by default 1e-6 rad by `duration`.
        standstills: end at the standstill with this number of a free input; 0: do not end at standstills.
        reactions: add the reactions in all pairs to the columns.
        measure: quantities that are added to the columns, a text or a list, such as "P.vx" or "rocker.angle".
        plot: the graphs of the picture, a text or a list, such as "P.y,energy" (see `gim manual graphs`); by default
            inputs, speeds and energies. A graph of reactions adds their columns.
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        seconds: the simulation ends after this time with what was found (status "work-limit"); by default it has a
            bound in evaluations only, which is the same on every machine.

    Returns:
        A SimulateResult: `xy[name]` (rows, 2), `angle[member]` (rows,), `status` (rows,), `events`, and the columns of
        the CSV file by name, energies in J. Rows that were not reached have a status and NaN.

    Raises:
        UsageError: an invalid argument.
        ModelError: no masses are defined.
        StructureError: no input is free, or the mechanism is not fully driven or over-driven.
    """
    times = _times(duration, dt)
    turns = duration * max((abs(r.speed) / math.tau for r in mechanism.dynamics.releases if r.free), default=0.0)
    refuse(
        (
            slip is not None and not _has_dry_friction(mechanism),
            f"slip: no pair of {mechanism.name} has dry friction; add `mu` in `friction`, or leave it out",
        ),
        (
            turns > SIMULATION.work,
            f"speed: {turns:g} turns in {duration:g} s are too many to follow; reduce `speed` of the input",
        ),
    )
    extras = _extras(mechanism, measure, plot)
    run = choose(jit, (duration + turns) * A_SECOND * WORK, notify, ("move",))
    if integrator and INTEGRATORS[integrator].explicit and _has_dry_friction(mechanism) and notify is not None:
        notify(f"dry friction is stiff: {integrator} may take long; {WITH_DRY_FRICTION} and radau do not")
    short = jit == "auto" and run is plain
    most = SIMULATION.interpreted if short else SIMULATION.work
    own = _step(mechanism, integrator, step, duration)
    settings = Settings(integrator, max(rtol, LEAST), own, standstills, slip or 0.0, most)
    with limited(seconds=seconds) as limit:
        found = simulate_times(mechanism, times, settings, run, progress("simulating"))
        if short and found.status is Status.WORK_LIMIT and not limit.reached:
            run, settings = choose("on", 0.0, notify, ("move",)), replace(settings, work=SIMULATION.work)
            found = simulate_times(mechanism, times, settings, run, progress("simulating"))
    if notify is not None and not math.isnan(found.careful):
        notify(f"strong damping is stiff: integrated with {CAREFUL} from {found.careful:g} s on")
    if standstills and found.status.word == "ok":
        times = times[: len(found.time)]
    forces, names = None, simulation_table(found, times).names
    wanted = {name for plan in extras.plans for name in plan.columns} - set(names)
    if len(found.time) and (reactions or (wanted and not wanted.isdisjoint(reaction_units(mechanism)))):
        progress("reactions")
        forces = find_reactions(found)
    return SimulateResult(found, times, forces, extras)


def _step(mechanism: Mechanism, integrator: str, step: float | None, time: float) -> float:
    """Return the step of a method with equal steps [s, rad or length in the normal frame]; refuse it for others."""
    if step is None:
        return STEP
    method = INTEGRATORS.get(integrator)
    if method is None or not method.unit:
        raise UsageError(f"step: is for {STEPPED}; {integrator or 'the default integrator'} takes its steps from rtol")
    lengths = method.over_input and not any(mechanism.actuators[k].rotary for k in free_inputs(mechanism))
    unit, most = mechanism.scale if lengths else 1.0, 1.0 if method.over_input else max(time, STEP)
    refuse(
        (
            not 0.0 < step <= most * unit,
            f"step: expected a number above 0 and at most {most * unit:g} [{method.unit}], got {step:g}",
        )
    )
    return step / unit


def _has_dry_friction(mechanism: Mechanism) -> bool:
    return any(friction.mu > 0.0 for friction in mechanism.dynamics.frictions)


def _extras(mechanism: Mechanism, measure: str | Sequence[str] = (), plot: str | Sequence[str] = ()) -> Extras:
    """Read the texts of quantities and graphs; raise UsageError for an unknown one."""
    units = {**dict.fromkeys(column_names(mechanism), ""), **reaction_units(mechanism)} if texts(plot) else None
    return Extras(mechanism, measure, plot, columns=units)


class SimulateResult(Placed, RowsResult):
    """A simulated motion: `xy[name]` (rows, 2), `angle[member]`, `status`, `events`, and the columns by name."""

    KIND = "simulation"

    def __init__(self, found: Simulation, times: FloatArray, forces: Forces | None, extras: Extras) -> None:
        self.mechanism, self._found, self.times, self._forces = found.mechanism, found, times, forces
        self._extras = extras
        self._table = table = simulation_table(found, times, forces)
        if extras.record.measures:
            self._table = Table((*table.columns, *self._padded(extras.measured(self._state, table.names))))

    @property
    def complete(self) -> bool:
        """Whether all rows were reached."""
        return len(self._found.time) == len(self.times)

    @property
    def slip(self) -> tuple[float, float] | None:
        """The slip speed of dry friction in pins [rad/s] and guides [m/s]; None without dry friction."""
        if self._found.friction is None:
            return None
        return self._found.slip, self._found.slip * (self.mechanism.dynamics.metre or 1.0)

    @property
    def events(self) -> list[dict[str, Any]]:
        """Standstills, dead points, pairs that stick or slide, and the event that ended the motion early."""
        return [event_report(self.mechanism, event) for event in self._found.events]

    @cached_property
    def angle(self) -> ByName:
        """Directions (rows,) of the members, from their first node to their second, in the file's angle unit.

        They are continuous: full turns are counted. NaN where a row was not reached.
        """
        each = angles(self.mechanism, self._z, np.asarray)
        return ByName(tuple(each), lambda name: self._counted(name, each[name]))

    def _counted(self, name: str, angle: FloatArray) -> FloatArray:
        """Return the angles of a member (rows,); angular velocities show the full turns between two rows."""
        first, second = next(m for m in self.mechanism.members[FRAME + 1 :] if m.name == name).nodes[:2]
        arm, rate = (self._nodes[k, second] - self._nodes[k, first] for k in (0, 1))
        omega = (arm.conj() * rate).imag / np.abs(arm) ** 2
        turn, ahead = full_turn(self.mechanism), 0.5 * (omega[1:] + omega[:-1]) * np.diff(self.times)
        return counted(angle, turn, ahead * turn / TURN)

    @cached_property
    def _nodes(self) -> ComplexArray:
        """Positions and rates (3, nodes, rows) in the normal frame, NaN in rows that were not reached."""
        missing = ((0, 0), (0, 0), (0, len(self.times) - len(self._found.time)))
        return np.asarray(np.pad(self._found.nodes, missing, constant_values=complex(np.nan, np.nan)))

    @property
    def _z(self) -> ComplexArray:
        return np.asarray(self._nodes[0])

    def _padded(self, columns: Sequence[Column]) -> list[Column]:
        """Return columns with NaN in rows that were not reached."""
        missing = (0, len(self.times) - len(self._found.time))
        return [Column(c.name, np.pad(c.values, missing, constant_values=np.nan), c.unit) for c in columns]

    @cached_property
    def _state(self) -> MotionState:
        """The rows that were reached, of which any quantity may be asked by its name."""
        found, own, course = self._found, self.mechanism, self._found.course()
        turned = [turning(own, course, k) for k in range(FRAME + 1, len(own.members))]
        angles = np.stack(turned, axis=1) if turned else np.zeros((2, 0, len(found.time)))
        rates = MotionRates(own, 2, found.nodes, angles)
        zero, start = np.zeros(len(found.time)), np.zeros(len(own.nodes), dtype=complex)
        motion = Motion(
            own, found.time / own.duration, found.inputs[0], found.nodes[0], zero.astype(int), zero, zero, start
        )
        return MotionState(
            motion, lambda _, member: self.angle[own.members[member].name][: len(found.time)],
            forces=lambda: self._forces or find_reactions(found), given=found.inputs, rates=rates,
        )  # fmt: skip

    def _asked(self, columns: list[NDArray[Any]]) -> Any:
        """Return one column (rows,), or several (rows, columns); NaN in rows that were not reached."""
        return super()._asked([one.values for one in self._padded([Column("", column) for column in columns])])

    @property
    def measured(self) -> dict[str, Any]:
        """Ranges of the measures, and their results for the whole motion."""
        return self._extras.report(self._state.motion, self._state)

    @property
    def open(self) -> list[str]:
        """The reactions that are not determined, because of redundant constraints."""
        return open_reactions(self._forces) if self._forces else []

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: {len(self._found.time)} of {len(self.times)} rows, {self._found.status.word}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found = self._found
        slip = {} if self.slip is None else {"slip": self.slip[0], "slip_of_guides": self.slip[1]}
        return slip | {
            "steps": len(self.times) - 1,
            "solved": len(found.time), "residual": found.contradiction, "status": found.status.word,
            "end": found.end, "events": self.events, "energy_drift": found.worst_drift,
            "energy_corrected": found.corrected, "evaluations": found.evaluations, "integrator_steps": found.steps,
            "reachable": _reached(found), "open": self.open, **self.measured,
        }  # fmt: skip

    def picture(self) -> output.picture.Content | None:
        """Return the mechanism above graphs, by default of inputs, speeds and energies; None without rows."""
        own, z = self.mechanism, self._found.nodes[0]
        if len(self._found.time) < 2:
            return None
        paths = {name: own.to_file(carried_point(own, name, z)) for name in own.traced}
        graphs = output.panels.history_sheet(self.graphs(), f"{own.name}: simulation")
        return output.picture.Sheet(
            "", (output.drawing.motion_picture(own, own.to_file(z).T, paths, graphs.title), *graphs.pictures)
        )

    def geometry(self) -> output.geometry.Geometry | None:
        """Return the first position and the curves of the traced points in true size; None without rows."""
        if not len(self._found.time):
            return None
        return output.geometry.motion_geometry(
            self.mechanism, self.mechanism.to_file(self._found.nodes[0][:, 0]), self.table()
        )

    def graphs(self) -> list[CurveGraph]:
        """Return the graphs of the picture as data."""
        if not self._extras.plans:
            return self._usual_graphs()
        columns = self._shown.by_name
        events = [(e["kind"], {"time": e["time"], **e["at"]}) for e in self.events if e["time"] <= self._found.end]
        return [drawn(plan, columns, columns["time"], events) for plan in self._extras.plans]

    @cached_property
    def _shown(self) -> Table:
        """The table with the columns of the graphs."""
        table = self.table()
        beside = self._padded(self._extras.beside(self._state, table.names)) if self._extras.plans else []
        return self._extras.with_expressions(Table((*table.columns, *beside)))

    def _usual_graphs(self) -> list[CurveGraph]:
        """Return graphs of inputs, speeds and energies over the time, with the events."""
        found, mechanism, graphs = self._found, self.mechanism, list[CurveGraph]()
        over = Axis("time", "s")
        for rotary, unit in ((True, mechanism.angle_unit), (False, mechanism.length_unit)):
            own = [k for k, a in enumerate(mechanism.actuators) if a.rotary is rotary]
            names = [mechanism.actuators[k].name for k in own]
            for order, title in enumerate((names[0] if len(own) == 1 else "inputs", "speed") if own else ()):
                values = [mechanism.value_to_file(k, found.inputs[order, k]) for k in own]
                curves = [Curve(name, found.time, y) for name, y in zip(names, values, strict=True)]
                axis = Axis(title, per_second(unit) if order else unit)
                graphs.append(CurveGraph(over, axis, curves, events=_marks(found, own, order)))
        energies = [Curve(n, found.time, e) for n, e in zip(ENERGIES, found.energy, strict=True) if e.any()]
        graphs.append(CurveGraph(over, Axis("energy", "J"), [*energies, Curve("total", found.time, found.total)]))
        return graphs

    def animation(self) -> output.animation.Animation | None:
        """Return the motion with its events and columns; None if it has no row."""
        requested = graphs.motion_animation.requested_graphs(self._shown, self._extras, "time")
        return graphs.motion_animation.simulation_animation(
            self._found, self._nodes, self.times, self._shown, requested
        )


def _times(time: float, dt: float | None) -> FloatArray:
    every = time / ROWS if dt is None else dt
    refuse(
        (
            not 0.0 < every <= time,
            f"dt: expected a number of seconds above 0 and at most the time {time:g}, got {every:g}",
        )
    )
    count = int(time / every * (1.0 + 1e-12))
    refuse((count > MOST_ROWS, f"dt: {every:g} s gives {count} rows, more than {MOST_ROWS}; use a longer dt"))
    return np.asarray(np.arange(count + 1) * every, dtype=np.float64)


def _marks(found: Simulation, own: Sequence[int], order: int) -> dict[str, list[complex]]:
    """Return the places of the events on the curves of some inputs, by kind."""
    marks: dict[str, list[complex]] = {}
    for event in (event for event in found.events if event.time <= found.end):
        for k in own:
            value = (event.speeds if order else event.inputs)[k : k + 1]
            place = complex(event.time, float(found.mechanism.value_to_file(k, value)[0]))
            marks.setdefault(event.kind, []).append(place)
    return marks


def _reached(found: Simulation) -> dict[str, list[list[float]]]:
    """Return the interval of each input in all rows, in the file's unit."""
    mechanism = found.mechanism
    rows = {a.name: mechanism.value_to_file(k, found.inputs[0, k]) for k, a in enumerate(mechanism.actuators)}
    return {name: [[float(u.min()), float(u.max())]] if len(u) else [] for name, u in rows.items()}
