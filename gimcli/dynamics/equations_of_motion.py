"""The equations of motion M s'' = Q - h of the free inputs as a first-order system; other inputs follow their laws.

The state consists of the independent variables s, their speeds, and the energies dissipated and supplied since the
start. Near a dead point of the inputs M is unbounded; other variables are then chosen as independent. Source: Durango,
Giraldo, Calle & Mesa 2014, eq. 1, for any number of degrees of freedom; Wehage & Haug 1982 for the change of
independent variables.

The speeds of a conservative mechanism are corrected so that it keeps its initial energy. Source: Hairer, Lubich &
Wanner, Geometric Numerical Integration, 2006, algorithm IV.4.2, along the speeds.

Events of a simulation are found by sign changes over a step, bisection, and a step that ends at the event. Events of
dry friction are when a pair begins to stand still (sticks), and when it slides again: a pair stands while its sliding
speed is within a few slip speeds. A pair that only reverses leaves that range at once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gimcli.dynamics.physical import require_masses
from gimcli.dynamics.reducer import Reducer, free_inputs
from gimcli.dynamics.simulation_types import DEAD_POINT, SIMULATION, SLIDES, STANDSTILL, STICKS, Event
from gimcli.kernels.reduction import DISSIPATED, KINETIC, POTENTIAL, SUPPLIED
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.numerics.along import bisected
from gimcli.positions.newton import Run
from gimcli.rates.derivatives import law_rates
from gimcli.status import Status
from gimcli.structure.coordinate_partitioning import free_choice, input_choice

if TYPE_CHECKING:
    from gimcli.dynamics.regularised_friction import RegularisedFriction


NOTHING: FloatArray = np.zeros(0)
"""Accelerations of the inputs that follow laws, if there are no such inputs."""


class Equations:
    """The equations of motion of a mechanism, and the choice of their independent variables."""

    def __init__(self, mechanism: Mechanism, run: Run, slip: float = 0.0) -> None:
        require_masses(mechanism)
        self.mechanism = mechanism
        self.free = free_inputs(mechanism)
        self.reducer = Reducer(mechanism, self.free, run)
        self.reducer.continues = True
        ratios = [ratio for coupling in mechanism.couplings for _, ratio in (*coupling.terms, *coupling.reads)]
        self.fastest = float(np.max(np.abs(ratios), initial=1.0))  # of the inputs that follow others
        self.friction: RegularisedFriction | None = None  # with its slip speed; None without dry friction
        if any(friction.mu > 0.0 for friction in mechanism.dynamics.frictions):
            from gimcli.dynamics.regularised_friction import RegularisedFriction

            self.friction = RegularisedFriction(self.reducer, slip)

    # -- motion -------------------------------------------------------------------------------------

    def slopes(self, time: float, y: FloatArray) -> FloatArray:
        """Return y' (2 f + 2,), f being the number of free inputs; NaN if there is no position."""
        own = len(self.free)
        if not self.move(time, y):
            return np.full(len(y), np.nan)
        energy = self.reducer.out.energy
        return np.concatenate([y[own : 2 * own], self.reducer.gain[:own], energy[[DISSIPATED, SUPPLIED]]])

    def move(self, time: float, y: FloatArray) -> bool:
        """Move the reducer to a state; return whether it was reached, and dry friction is determined there."""
        own, reducer = len(self.free), self.reducer
        if not reducer.given:
            moved = reducer.move(y[:own], y[own : 2 * own], NOTHING, time)
            return moved and (self.friction is None or self.friction(NOTHING))
        laws = self.given(time)
        target = np.concatenate([y[:own], laws[0]])
        speeds = np.concatenate([y[own : 2 * own], laws[1]])
        gains = np.concatenate([np.zeros(own), laws[2]])
        return reducer.move(target, speeds, gains, time) and (self.friction is None or self.friction(gains[own:]))

    def jacobian(self, time: float, y: FloatArray) -> FloatArray:
        """Return the derivatives of y' by y, by differences, within the slip speed of dry friction; 0 if unknown."""
        own, base = len(self.free), self.slopes(time, y)
        table = np.zeros((len(y), len(y)))
        for k in range(2 * own):
            step = SIMULATION.difference * max(1.0, abs(float(y[k])))
            if k >= own and self.friction is not None:
                step = SIMULATION.difference * min(1.0, self.friction.slip)
            moved = y.copy()
            moved[k] += max(step, float(np.spacing(abs(y[k]))))
            table[:, k] = (self.slopes(time, moved) - base) / (moved[k] - y[k])
        return np.nan_to_num(table, posinf=0.0, neginf=0.0)

    def given(self, time: float) -> FloatArray:
        """Return the inputs that follow laws with two derivatives (3, inputs); beyond the law the speed is constant."""
        duration = self.mechanism.duration
        inside = min(max(time / duration, 0.0), 1.0)
        beyond = time - inside * duration if inside != time / duration else 0.0
        found = law_rates(self.mechanism, np.array([inside]), 2)[:, list(self.reducer.given), 0]
        return np.array([found[0] + beyond * found[1], found[1], found[2] * (not beyond)])

    def event(self, kind: str, time: float, actuator: int = -1, pair: str = "") -> Event:
        """Return an event at the reducer's last state."""
        inputs, speeds = map(self.reducer.inputs, (self.reducer.at.v, self.reducer.room.velocity))
        return Event(kind, time, inputs.copy(), speeds.copy(), actuator, pair)

    def velocity(self, time: float, y: FloatArray) -> FloatArray:
        """Return the velocities of all variables at a state; zeros if there is no position."""
        moved = self.move(time, y)
        return self.reducer.room.velocity.copy() if moved else np.zeros(self.reducer.terms.variables)

    # -- independent variables ----------------------------------------------------------------------

    @property
    def is_steep(self) -> bool:
        """Return whether other variables should be independent."""
        return bool(np.max(np.abs(self.reducer.base.b[: len(self.free)])) > self.fastest * SIMULATION.steep)

    @property
    def is_gentle(self) -> bool:
        """Return whether the inputs could be independent variables again."""
        reducer, own = self.reducer, len(self.free)
        if reducer.on_inputs:
            return False
        b = reducer.base.b[:own]
        inner = b[:, [reducer.terms.first_reading + k for k in self.free]]
        if not abs(np.linalg.det(inner)) > 1.0 / (self.fastest * SIMULATION.steep) ** own:
            return False
        return bool(np.max(np.abs(np.linalg.solve(inner, b))) < self.fastest * SIMULATION.gentle)

    def change(self, y: FloatArray, requested: bool) -> FloatArray | None:
        """Change the independent variables; return their values and speeds, None if no others are possible.

        With `requested` the inputs are preferred, and the same choice again is allowed.
        """
        reducer, own = self.reducer, len(self.free)
        v = reducer.base.v.copy()
        speeds = y[own : 2 * own] @ reducer.base.b[:own]
        if reducer.given:
            given = [reducer.terms.first_reading + k for k in reducer.given]
            speeds = speeds + reducer.room.velocity[given] @ reducer.base.b[own:]
        if requested and not reducer.on_inputs and self.is_gentle:
            choice = input_choice(reducer.terms, v, self.free, reducer.given)
        else:
            choice = free_choice(reducer.terms, v, reducer.given, own)
        if choice is None or (not requested and reducer.choice is not None and choice == reducer.choice):
            return None
        if not reducer.set_base(v, choice):
            return None
        return np.concatenate([v[reducer.own[:own]], speeds[reducer.own[:own]]])

    @property
    def is_jammed(self) -> bool:
        """Return whether dry friction had no solution in the last state."""
        return self.friction is not None and self.friction.failed

    def reason(self) -> Status:
        """Return why the motion cannot continue: friction jams, a law reaches a limit, or the position is singular."""
        reducer = self.reducer
        if self.is_jammed:
            return Status.JAMMED
        regular = free_choice(reducer.terms, reducer.base.v, (), len(self.free) + len(reducer.given))
        return Status.LIMIT if reducer.given and regular is not None else Status.SINGULAR


class Projection:
    """Projects states to the initial energy."""

    def __init__(self, reducer: Reducer, allowed: bool) -> None:
        self.reducer = reducer
        self.active = allowed and reducer.conservative
        self.start: float | None = None  # initial energy, J
        self.greatest_kinetic = 0.0  # greatest kinetic energy so far, J
        self.total = 0.0  # sum of the absolute corrections, J

    def begin(self) -> None:
        """Store the energy of the reducer's last state as the initial energy."""
        if self.start is None:
            self.start = self._energies[0] + self._energies[1]

    @property
    def _energies(self) -> tuple[float, float]:
        energy = self.reducer.out.energy
        return float(energy[KINETIC]), float(energy[POTENTIAL])

    def __call__(self, y: FloatArray) -> tuple[FloatArray, float]:
        """Return the reducer's last state `y` with corrected speeds, and its excess of energy before [J]."""
        if not self.active or self.start is None:
            return y, 0.0
        kinetic, potential = self._energies
        self.greatest_kinetic = max(self.greatest_kinetic, kinetic)
        if not kinetic > SIMULATION.moving * max(self.greatest_kinetic, abs(potential)):
            return y, 0.0
        excess, own = kinetic + potential - self.start, len(self.reducer.free)
        y = y.copy()
        y[own : 2 * own] *= 1.0 - 0.5 * excess / kinetic
        return y, excess


class StickEvents:
    """The pairs that stand, since when, and the events so far."""

    def __init__(self, equations: Equations, duration: float) -> None:
        assert equations.friction is not None
        self.equations, self.friction = equations, equations.friction
        self.dwell = SIMULATION.dwell * duration
        self.begun: list[Event | None] = [None] * len(self.friction.names)  # the event by which each pair stands
        self.events: list[Event] = []

    def _standing(self) -> NDArray[np.bool_]:
        """Return which contacts stand in the last state."""
        return np.asarray(np.abs(self.friction.loop.speed) < SIMULATION.standing * self.friction.slip)

    def begin(self, time: float) -> None:
        """Take the initial state, to which the reducer was moved."""
        names = self.friction.names
        for k in np.flatnonzero(self._standing()).tolist():
            self.begun[k] = self.equations.event(STICKS, time, pair=names[k])

    def take(self, solver: Any) -> None:
        """Take a solver's last step, at whose end the reducer is."""
        standing = self._standing()
        changed = [k for k, begun in enumerate(self.begun) if standing[k] != (begun is not None)]
        if not changed:
            return
        path, names = solver.dense_output(), self.friction.names
        for k in changed:
            time, begun = self._located(solver, path, k, bool(standing[k])), self.begun[k]
            if begun is not None and time - begun.time > self.dwell:
                self.events += [begun, self.equations.event(SLIDES, time, pair=names[k])]
            self.begun[k] = self.equations.event(STICKS, time, pair=names[k]) if begun is None else None

    def all(self, end: float) -> list[Event]:
        """Return the events up to the end of the simulation."""
        last = [event for event in self.begun if event is not None and end - event.time > self.dwell]
        return [*self.events, *last]

    def _located(self, solver: Any, path: Any, k: int, stands: bool) -> float:
        """Return the time of the change within a step, by bisection; the reducer is moved there."""

        def after(time: float) -> bool:
            return self.equations.move(time, path(time)) and bool(self._standing()[k]) == stands

        time = bisected(after, solver.t_old, solver.t)[1]
        self.equations.move(time, path(time))
        return float(time)


class EventSearch:
    """Finds standstills and dead points of the free inputs."""

    def __init__(
        self, equations: Equations, begin: Callable[[float, FloatArray, float], Any], lands: bool
    ) -> None:  # fmt: skip
        """Take the equations; `begin` makes a solver from a time, a state and an end."""
        self.equations, self.begin, self.lands = equations, begin, lands
        self.before: list[float] = []  # signals at the last accepted state
        self.last_y: FloatArray = np.zeros(0)  # the last accepted state
        self.evaluations = 0

    def keep(self, y: FloatArray) -> None:
        """Store the state of the reducer, at which the next step begins."""
        self.last_y = np.array(y)
        self.before = self._here(y)

    def events(self, solver: Any, path: Callable[[], Any]) -> list[Event]:
        """Return the events of a solver's last step in order of time; `path` returns the states over the step."""
        after = self._signals(solver.t, solver.y)
        crossed = [k for k, (a, b) in enumerate(zip(self.before, after, strict=True)) if a * b < 0.0]
        return sorted((self._refined(solver, path(), k) for k in crossed), key=lambda event: event.time)

    def _signals(self, time: float, y: FloatArray) -> list[float]:
        """Return the signals of a state: values that change their sign at an event."""
        known = self.equations.reducer.on_inputs or self.equations.move(time, y)
        return self._here(y) if known else [0.0] * len(self.before)

    def _here(self, y: FloatArray) -> list[float]:
        """Return the signals of the reducer's state: speeds of free inputs, and a value that is 0 at a dead point."""
        reducer, own = self.equations.reducer, len(self.equations.free)
        if reducer.on_inputs:
            return [float(v) for v in y[own : 2 * own]]
        inputs = [reducer.terms.first_reading + k for k in self.equations.free]
        b = reducer.at.b[:own][:, inputs]
        if own == 1:
            return [float(y[1]), float(b[0, 0])]
        return [*(float(v) for v in reducer.room.velocity[inputs]), float(np.linalg.det(b))]

    def _refined(self, solver: Any, path: Any, signal: int) -> Event:
        """Find an event by bisection of the interpolated states, then by a step that ends at the event."""
        sign, free = self.before[signal], self.equations.free
        time = bisected(lambda t: not self._signals(t, path(t))[signal] * sign > 0.0, solver.t_old, solver.t)[1]
        y = path(time)
        kind, actuator = (STANDSTILL, free[signal]) if signal < len(free) else (DEAD_POINT, free[0])
        if self.lands and kind == STANDSTILL and time > solver.t_old:
            time, y = self._landed(solver, path, time, signal)
        self.equations.move(time, y)
        return self.equations.event(kind, time, actuator)

    def _landed(self, solver: Any, path: Any, time: float, signal: int) -> tuple[float, FloatArray]:
        """Return time and state of an event by integration to its estimated time and a Newton step from there."""
        start, y, near, equations = solver.t_old, self.last_y, time, self.equations
        reducer = equations.reducer
        for _ in range(2):
            fine = self.begin(start, y, time)
            while fine.status == "running":
                if fine.step() is not None:
                    return time, path(time)
            self.evaluations += fine.nfev
            slopes = equations.slopes(time, fine.y)
            speed = self._here(fine.y)[signal]
            gain = reducer.acceleration[reducer.terms.first_reading + equations.free[signal]]
            if not reducer.on_inputs and len(equations.free) == 1:
                gain = slopes[1]
            rest = -speed / gain if gain else 0.0
            if not abs(rest) < SIMULATION.landing * (solver.t - start):
                return near, path(near)
            time += rest
        return time, fine.y + rest * slopes
