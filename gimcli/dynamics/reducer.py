"""Reduction of a mechanism to its independent variables: position on a branch, inertia, bias and forces in one call.

`ReducedEquations` has the variables, equations and forces of a mechanism in the arrays of the kernels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from gimcli.dynamic_data import TIME, Release
from gimcli.dynamics.load_arrays import acting, moving_loads, with_force_gauges
from gimcli.dynamics.physical import require_masses
from gimcli.dynamics.simulation_types import SIMULATION
from gimcli.dynamics.windows import WEAK, WindowSearch, no_windows, with_window
from gimcli.errors import StructureError
from gimcli.kernels import influence, reduction
from gimcli.kernels.windows import TOGETHER, window_of
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run
from gimcli.structure.coordinate_partitioning import Choice, free_choice, input_choice, make_chart
from gimcli.structure.equations import coupled_terms, variables_at, with_gauges, with_linked_gauges
from gimcli.structure.terms import places


class ReducedEquations:
    """The equations of a mechanism in variables: x and y of nodes, inputs, gauges, 1; normal frame and rad.

    The gauges are those of the mechanism, then those of gears turned by the linkage and of forces.
    """

    def __init__(self, mechanism: Mechanism, released: Sequence[int], metre: float) -> None:
        self.mechanism = mechanism
        self.read = with_force_gauges(with_linked_gauges(mechanism)).nearby
        self.terms = coupled_terms(with_gauges(self.read))
        self.acting = acting(self.read, released, metre)
        first = self.terms.first_reading
        self.input_variables = slice(first, first + len(mechanism.actuators))

    def variables(self, z: ComplexArray, inputs: FloatArray, gauges: FloatArray | None = None) -> FloatArray:
        """Return the variables at a position; angles are near those of the gauges given, or the initial ones."""
        return variables_at(self.terms, self.mechanism.near(z), inputs, gauges)

    def choose(self, choice: Choice) -> None:
        """Set independent variables: make the chart, scratch arrays and results."""
        self.chart = make_chart(self.terms, choice)
        size, variables = len(choice.independent), self.terms.variables
        widest = max([1, size, *(b[2] - b[1] for b in self.chart.blocks)])
        self.room = influence.InfluenceScratch(
            np.zeros((3, self.terms.functions)), np.zeros((widest, widest)), np.zeros(2 * widest), np.zeros(widest),
            np.zeros(variables), np.zeros(variables), np.zeros(size), np.zeros(2, dtype=np.int64), np.zeros(3),
        )  # fmt: skip
        self.room.f[0, 0] = 1.0
        self.out = reduction.Reduced(
            np.zeros((size, size)), np.zeros(size), np.zeros(size), np.zeros(reduction.ENERGIES), np.zeros(variables)
        )

    def place(self, v: FloatArray) -> influence.InfluencePosition:
        """Return the arrays of a position with these variables."""
        size, variables = len(self.chart.independent), self.terms.variables
        return influence.InfluencePosition(v.copy(), np.zeros((size, variables)), np.zeros(len(self.chart.blocks)))

    def nodes(self, v: FloatArray) -> ComplexArray:
        """Return x + iy of the nodes from variables (..., variables)."""
        return self.mechanism.whole(places(v[..., : self.terms.first_reading]), -1)

    def inputs(self, v: FloatArray) -> FloatArray:
        """Return the values of the actuators from variables (..., variables)."""
        return np.asarray(v[..., self.input_variables])


CORRECTIONS = 20
"""Most Newton corrections of a singular initial position."""

ASSEMBLED = 1e-13
"""Residual below which a position is assembled; the equations are scaled to about 1."""

BESIDE = 0.9
"""Least determinant allowed outside of a window, relative to the determinant at its edges."""

NEAREST = 1e-6
"""Least determinant: below it no window is searched, and no position is reached without a window."""

MOST_OPENED = 10
"""Most windows opened in one step; the motion ends where more change points are close together."""

SOFT = 1e-6
"""Singular values below this fraction of the greatest are ignored in the corrections of a singular position."""


class Reducer(ReducedEquations):
    """Follows the branch of a mechanism from a base position; `chart` has the independent variables there."""

    def __init__(self, mechanism: Mechanism, free: Sequence[int], run: Run = plain) -> None:
        super().__init__(mechanism, free, require_masses(mechanism))
        self.free, self.run = tuple(free), run
        self.given = tuple(k for k in mechanism.drivers if k not in self.free)
        self.loads = moving_loads(self.read)
        self.releases = {r.actuator: r for r in mechanism.dynamics.releases}
        self.choice: Choice | None = None
        self.continues = False  # whether motions pass change points, by windows

    # -- base position ------------------------------------------------------------------------------

    def start(self, z: ComplexArray, inputs: FloatArray) -> bool:
        """Set the base to an assembled position; return whether the motion from there is unique."""
        return self.set_base(self.variables(z, inputs))

    def start_singular(self, inputs: FloatArray) -> bool:
        """Set the base to the corrected initial position, which may be singular; return whether it is assembled."""
        terms, first = self.terms, self.terms.first_reading
        v = self.variables(self.mechanism.drawn, inputs)
        open_ones = [*terms.moving, *range(first + len(inputs), terms.variables - 1)]
        for _ in range(CORRECTIONS):
            error = terms.arrays.values(v)
            if np.max(np.abs(error)) <= ASSEMBLED:
                break
            v[open_ones] -= np.linalg.lstsq(terms.arrays.slopes(v)[:, open_ones], error, rcond=SOFT)[0]
        return bool(np.max(np.abs(terms.arrays.values(v))) <= ASSEMBLED and self.set_base(v))

    def set_base(self, v: FloatArray, choice: Choice | None = None) -> bool:
        """Set the base to a position and choose its independent variables; return whether that is possible."""
        choice = choice or input_choice(self.terms, v, self.free, self.given)
        if choice is None:
            choice = free_choice(self.terms, v, self.given, len(self.free))
        if choice is None:
            return False
        if choice == self.choice:
            return self._set_base_only(v)
        before = self.tried
        self.choice, size = choice, len(choice.independent)
        self.choose(choice)
        self.base, self.last, self.at = (self.place(v) for _ in range(3))
        self.room.weakest[1] = before
        self.gain, self.factors = np.zeros(size), np.ones(len(self.loads))
        self.own = list(choice.independent)
        return self._set_base_only(v)

    def _set_base_only(self, v: FloatArray) -> bool:
        """Set the base to a position without a change of the independent variables; return whether it is regular."""
        self.windows, self.opened = no_windows(len(self.own), len(v), len(self.chart.blocks)), 0
        self.watch()
        self.base.v[:] = v
        self.run(influence.set_signs)(self.chart, self.base, self.room)
        return bool(self.run(influence.settle)(self.chart, self.base, np.zeros(len(self.own)), self.room))

    @property
    def tried(self) -> int:
        """Number of positions of all motions so far, also those between two states; a call counts as several."""
        return int(self.room.weakest[1]) if self.choice is not None else 0

    @property
    def on_inputs(self) -> bool:
        """Return whether the inputs are the independent variables."""
        first = self.terms.first_reading
        return self.own[: len(self.free)] == [first + k for k in self.free]

    # -- one call -----------------------------------------------------------------------------------

    def move(self, target: FloatArray, speeds: FloatArray, given: FloatArray, time: float = 0.0) -> bool:
        """Move from the base to a state of the independent variables (k,); return whether it was reached.

        `given` (k,) ends with the accelerations of the inputs that follow laws.
        """
        self._force(target, speeds, time)
        self.room.weakest[1] += SIMULATION.call
        while True:
            moved = self.run(reduction.move)(
                self.chart, self.acting, self.base, self.last, self.at, self.windows, target, speeds, given,
                len(self.free), self.factors, self.room, self.out, self.gain,
            )  # fmt: skip
            if moved or not self.open_window():
                return bool(moved)

    def watch(self) -> None:
        """Make `move` stop near change points without a window."""
        self.room.weak[1:] = WEAK if self.continues else 0.0, 0.0

    @property
    def is_within(self) -> bool:
        """Return whether the base is in a window."""
        return bool(self.run(window_of)(self.windows, self.base.v[self.own]) >= 0)

    def open_window(self) -> bool:
        """Open a window at the change point where `move` stopped, or allow a smaller distance; return success."""
        room = self.room
        if not room.weak[2]:
            return False
        self.opened += 1
        room.weakest[1] += SIMULATION.window
        nearer, together = max(0.25 * room.weak[1], NEAREST), bool(room.weak[2] == TOGETHER)
        if self.opened > MOST_OPENED or not room.weak[1] > NEAREST:
            room.weak[2] = 0.0
            return False
        room.weak[1:] = 0.0
        search = WindowSearch(self.run, self.terms, self.chart, self.own, self.base, room)
        found = search.find(self.last, self.at, together)
        if found is None:
            room.weak[1] = nearer
        else:
            self.windows = with_window(self.windows, found, self.base.v[self.own])
            room.weak[1] = min(WEAK, BESIDE * float(found.weakest[0]))
        return True

    def accept(self) -> None:
        """Set the base to the position of the last `move`."""
        self.run(influence.copy_place)(self.base, self.at)
        self.opened = 0
        if self.room.weak[0] > 2.0 * WEAK:
            self.watch()

    @property
    def acceleration(self) -> FloatArray:
        """Accelerations of all variables after the last `move`."""
        return np.asarray(self.room.acceleration + self.gain @ self.at.b)

    @cached_property
    def constant(self) -> bool:
        """Return whether no load and no effort has a table."""
        efforts = [self.releases[k].effort for k in self.free if k in self.releases]
        return all(load.curve is None for load in self.loads) and all(e.curve is None for e in efforts)

    @cached_property
    def steady(self) -> bool:
        """Return whether all forces depend on the position alone and there are no loads."""
        p = self.acting
        return self.constant and not (len(p.loads) or len(p.dampers) or len(p.rubs) or np.any(p.motor[:, 1]))

    @cached_property
    def conservative(self) -> bool:
        """Return whether nothing dissipates or supplies energy."""
        p = self.acting
        driven = bool(np.any(p.motor[:, 0])) or any(r.effort.curve is not None for r in self.releases.values())
        return not (len(p.loads) or len(p.dampers) or len(p.rubs) or self.given or driven)

    def _force(self, target: FloatArray, speeds: FloatArray, time: float) -> None:
        """Evaluate the tables of loads and efforts at a state."""
        if self.constant:
            return
        first = self.terms.first_reading
        for k, load in enumerate(self.loads):
            if load.curve is not None:
                moves = load.over != TIME
                value = self._moving(first + load.over, target, np.zeros(len(target)))[0] if moves else 0.0
                self.factors[k] = load.factor(np.array([time]), {load.over: np.array([value])})[0]
        for k, actuator in enumerate(self.free):
            effort = self.releases[actuator].effort
            if effort.curve is not None:
                value, speed = self._moving(first + actuator, target, speeds)
                self.acting.motor[k, 0] = effort.at([time], [value], [speed])[0]

    def _moving(self, variable: int, target: FloatArray, speeds: FloatArray) -> tuple[float, float]:
        """Return value and speed of a variable at a state."""
        if variable in self.own:
            k = self.own.index(variable)
            return float(target[k]), float(speeds[k])
        self.run(influence.copy_place)(self.last, self.base)
        if not self.run(influence.follow)(self.chart, self.last, self.at, target, speeds, self.room):
            return math.nan, math.nan
        return float(self.at.v[variable]), float(self.room.velocity[variable])

    # -- results at a position ----------------------------------------------------------------------

    def error(self, v: FloatArray) -> float:
        """Return the greatest residual of all equations, including redundant ones, which may be contradictory."""
        return float(np.max(np.abs(self.terms.arrays.values(v)), initial=0.0))


def free_inputs(mechanism: Mechanism) -> tuple[int, ...]:
    """Return the free inputs; raise StructureError if there is none."""
    free = tuple(r.actuator for r in mechanism.dynamics.releases if r.free)
    if not free:
        names = ", ".join(a.name for a in mechanism.actuators)
        cure = f"write `free: true` at one of {names}" if names else "add an actuator with `free: true`"
        raise StructureError(f"{mechanism.name} has no free input: {cure}")
    return free


def release_of(mechanism: Mechanism, actuator: int) -> Release:
    """Return whether an input is free, with its initial state and effort."""
    return next((r for r in mechanism.dynamics.releases if r.actuator == actuator), Release(actuator))


def with_released(mechanism: Mechanism, released: Sequence[int]) -> Mechanism:
    """Return the mechanism in which exactly these inputs are free, with the efforts of the file."""
    releases = [replace(release_of(mechanism, k), free=k in released) for k in range(len(mechanism.actuators))]
    return replace(mechanism, dynamics=replace(mechanism.dynamics, releases=tuple(releases)))
