"""Simulate the motion of a mechanism with free inputs."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.dynamics.force_table import open_reactions
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.integrators import INTEGRATORS
from gimcli.dynamics.simulation import simulate as simulate_times
from gimcli.dynamics.simulation_table import ENERGIES, event_report, simulation_table
from gimcli.dynamics.simulation_table import reactions as find_reactions
from gimcli.dynamics.simulation_types import Settings, Simulation
from gimcli.errors import UsageError
from gimcli.library.inputs import MOST_STEPS, refuse_choice, refuse_count
from gimcli.library.places import angles, pairs, places
from gimcli.library.result import ByName, RowsResult
from gimcli.mechanism import FRAME, FloatArray, Mechanism
from gimcli.positions.dispatch import choose
from gimcli.positions.options import JIT
from gimcli.progress import Notify, Phases, no_phases
from gimcli.rates.member_angles import counted
from gimcli.structure.drive_check import explained

if TYPE_CHECKING:
    from gimcli.output.animation import Animation
    from gimcli.output.picture import Content

ROWS = 200
MOST_ROWS = 1_000_000
LEAST = 3e-14
"""Relative tolerance below which steps do not become more accurate."""
WORK = 6e-4
"""Approximate time of one evaluation without compilation [s]."""
A_SECOND = 1500
"""Approximate number of evaluations for one second of motion."""


def simulate(
    mechanism: Mechanism, time: float = 5.0, *, dt: float | None = None, integrator: str = "dop853",
    rtol: float = 1e-9, step: float = 1e-3, standstills: int = 0, reactions: bool = False, jit: str = "auto",
    notify: Notify | None = None, progress: Phases = no_phases, method: str = "",
) -> SimulateResult:  # fmt: skip
    """Simulate the motion of the free inputs (`free: true` in the model) under the forces that act (forward dynamics).

    Args:
        mechanism: from `load` or `loads`; it needs masses and at least one free input.
        time: duration of the motion [s].
        dt: time between two rows [s]; by default time / 200.
        integrator: "dop853", "rk45", "radau", "lsoda" (steps from `rtol`), "rk4" (equal steps of time) or "euler"
            (equal steps of the only free input).
        rtol: relative tolerance of the integrators with adaptive steps, from 1e-14 to 1e-2.
        step: time step of "rk4" [s].
        standstills: end at the standstill with this number of a free input; 0: do not end at standstills.
        reactions: add the reactions in all pairs to the columns.
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        method: the older name of `integrator`.

    Returns:
        A SimulateResult: `xy[name]` (rows, 2), `angle[member]` (rows,), `status` (rows,), `events`, and the columns of
        the CSV file by name, energies in J. Rows that were not reached have a status and NaN.

    Raises:
        UsageError: an invalid argument.
        ModelError: no masses are defined.
        StructureError: no input is free, or the mechanism is not fully driven or over-driven.
    """
    times = _times(time, dt)
    if not 1e-14 <= rtol <= 1e-2:
        raise UsageError(f"rtol: expected a number from 1e-14 to 1e-2, got {rtol:g}")
    if not 0.0 < step <= time:
        raise UsageError(f"step: expected a number of seconds above 0 and at most the time {time:g}, got {step:g}")
    integrator = method or integrator
    refuse_choice("integrator", integrator, INTEGRATORS)
    refuse_choice("jit", jit, JIT)
    refuse_count("standstills", standstills, 0, MOST_STEPS)
    run = choose(jit, time * A_SECOND * WORK, notify, ("move",))
    settings = Settings(integrator, max(rtol, LEAST), step, standstills)
    with explained(mechanism):
        found = simulate_times(mechanism, times, settings, run, progress("simulating"))
    if standstills and found.status.word == "ok":
        times = times[: len(found.time)]
    forces = None
    if reactions and len(found.time):
        progress("reactions")
        forces = find_reactions(found)
    return SimulateResult(found, times, forces)


class SimulateResult(RowsResult):
    """A simulated motion: `xy[name]` (rows, 2), `angle[member]`, `status`, `events`, and the columns by name."""

    KIND = "simulation"

    def __init__(self, found: Simulation, times: FloatArray, forces: Forces | None) -> None:
        self.mechanism, self.found, self.times, self.forces = found.mechanism, found, times, forces
        self._table = simulation_table(found, times, forces)

    @property
    def complete(self) -> bool:
        """Whether all rows were reached."""
        return len(self.found.time) == len(self.times)

    @property
    def events(self) -> list[dict[str, Any]]:
        """Standstills, dead points, and the event that ended the motion early."""
        return [event_report(self.mechanism, event) for event in self.found.events]

    @cached_property
    def xy(self) -> ByName:
        """Coordinates (rows, 2) of nodes and points in the file's length unit; NaN where a row was not reached."""
        return places(self.mechanism, self._z, pairs)

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
        arm, rate = (self.found.nodes[k, second] - self.found.nodes[k, first] for k in (0, 1))
        omega = (arm.conj() * rate).imag / np.abs(arm) ** 2
        ahead = 0.5 * (omega[1:] + omega[:-1]) * np.diff(self.found.time)
        return counted(self.mechanism, angle, np.degrees(ahead) if self.mechanism.angle_unit == "deg" else ahead)

    @cached_property
    def _z(self) -> Any:
        z = self.found.nodes[0]
        missing = np.full((len(z), len(self.times) - z.shape[1]), complex(np.nan, np.nan))
        return np.concatenate([z, missing], axis=1)

    @property
    def open(self) -> list[str]:
        """The reactions that are not determined, because of redundant constraints."""
        return open_reactions(self.forces) if self.forces else []

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: {len(self.found.time)} of {len(self.times)} rows, {self.found.status.word}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found = self.found
        return {
            "steps": len(self.times) - 1,
            "solved": len(found.time), "residual": found.contradiction, "status": found.status.word,
            "end": found.end, "events": self.events, "energy_drift": found.worst_drift,
            "energy_corrected": found.corrected, "evaluations": found.evaluations, "integrator_steps": found.steps,
            "reachable": _reached(found), "open": self.open,
        }  # fmt: skip

    def picture(self) -> Content | None:
        """Return the mechanism above graphs of inputs, speeds and energies; None if there is nothing to draw."""
        from gimcli.library.simulation_picture import with_mechanism
        from gimcli.output.history import Panel, history_sheet

        found, mechanism, panels = self.found, self.mechanism, list[Panel]()
        if len(found.time) < 2:
            return None
        for drive, unit in ((True, mechanism.angle_unit), (False, mechanism.length_unit)):
            own = [k for k, a in enumerate(mechanism.actuators) if a.rotary is drive]
            for order, what in enumerate((f"[{unit}]", f"[{unit}/s]")):
                curves = [
                    (mechanism.actuators[k].name, found.time, mechanism.value_to_file(k, found.inputs[order, k]))
                    for k in own
                ]
                name = mechanism.actuators[own[0]].name if len(own) == 1 else "inputs"
                marks = [
                    _mark(mechanism, event, k, order) for k in own for event in found.events if event.time <= found.end
                ]
                if own:
                    panels.append(Panel(f"{'speed of ' * order}{name} {what}", curves, marks))
        energies = [(n, found.time, e) for n, e in zip(ENERGIES, found.energy, strict=True) if e.any()]
        panels.append(Panel("energy [J]", [*energies, ("total", found.time, found.total)]))
        return with_mechanism(found, history_sheet(panels, "time [s]", f"{mechanism.name}: simulation"))

    def animation(self) -> Animation | None:
        """Return the motion with its events and columns; None if it has no row."""
        from gimcli.library.simulation_animation import simulation_animation

        return simulation_animation(self.found, self.times, self.table())


def _times(time: float, dt: float | None) -> FloatArray:
    every = time / ROWS if dt is None else dt
    if not 0.0 < time < 1e9:
        raise UsageError(f"time: expected a number of seconds above 0 and below 1e9, got {time:g}")
    if not 0.0 < every <= time:
        raise UsageError(f"dt: expected a number of seconds above 0 and at most the time {time:g}, got {every:g}")
    count = int(time / every * (1.0 + 1e-12))
    if count > MOST_ROWS:
        raise UsageError(f"dt: {every:g} s gives {count} rows, more than {MOST_ROWS}; use a longer dt")
    return np.asarray(np.arange(count + 1) * every, dtype=np.float64)


def _mark(mechanism: Mechanism, event: Any, k: int, order: int) -> complex:
    values = event.inputs if order == 0 else event.speeds
    return complex(event.time, float(mechanism.value_to_file(k, values[k : k + 1])[0]))


def _reached(found: Simulation) -> dict[str, list[list[float]]]:
    """Return the interval of each input in all rows, in the file's unit."""
    mechanism = found.mechanism
    rows = {a.name: mechanism.value_to_file(k, found.inputs[0, k]) for k, a in enumerate(mechanism.actuators)}
    return {name: [[float(u.min()), float(u.max())]] if len(u) else [] for name, u in rows.items()}
