"""Search for events of a simulation: sign changes over a step, bisection, and a step that ends at the event.

Events of dry friction in a simulation: when a pair begins to stand still (sticks), and when it slides again.

A pair stands while its sliding speed is within a few slip speeds. A pair that only reverses leaves that range at once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.dynamics.equations_of_motion import Equations
from gimcli.dynamics.simulation_types import DEAD_POINT, SIMULATION, SLIDES, STANDSTILL, STICKS, Event
from gimcli.mechanism import FloatArray
from gimcli.numerics.roots import bisected


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
        return np.asarray(np.abs(self.friction.speeds) < SIMULATION.standing * self.friction.slip)

    def begin(self, time: float) -> None:
        """Take the initial state, to which the reducer was moved."""
        for k in np.flatnonzero(self._standing()).tolist():
            self.begun[k] = self._event(STICKS, time, k)

    def take(self, solver: Any) -> None:
        """Take a solver's last step, at whose end the reducer is."""
        standing = self._standing()
        changed = [k for k, begun in enumerate(self.begun) if standing[k] != (begun is not None)]
        if not changed:
            return
        path = solver.dense_output()
        for k in changed:
            time, begun = self._located(solver, path, k, bool(standing[k])), self.begun[k]
            if begun is None:
                self.begun[k] = self._event(STICKS, time, k)
                continue
            if time - begun.time > self.dwell:
                self.events += [begun, self._event(SLIDES, time, k)]
            self.begun[k] = None

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

    def _event(self, kind: str, time: float, k: int) -> Event:
        reducer = self.equations.reducer
        inputs, speeds = reducer.inputs(reducer.at.v).copy(), reducer.inputs(reducer.room.velocity).copy()
        return Event(kind, time, inputs, speeds, pair=self.friction.names[k])


Begin = Callable[[float, FloatArray, float], Any]
"""Makes a solver from a time, a state and an end."""


class EventSearch:
    """Finds standstills and dead points of the free inputs."""

    def __init__(self, equations: Equations, begin: Begin, lands: bool) -> None:
        self.equations, self.begin, self.lands = equations, begin, lands
        self.before: list[float] = []  # signals at the last accepted state
        self.last_y: FloatArray = np.zeros(0)  # the last accepted state
        self.evaluations = 0

    def keep(self, y: FloatArray) -> None:
        """Store the state of the reducer, at which the next step begins."""
        self.last_y = np.array(y)
        self.before = self._here(y)

    def keep_on_inputs(self, y: FloatArray) -> None:
        """Store a state whose independent variables are the inputs."""
        self.last_y, own = y.copy(), len(self.equations.free)
        self.before = list(y[own : 2 * own])

    def events(self, solver: Any, path: Callable[[], Any]) -> list[Event]:
        """Return the events of a solver's last step in order of time; `path` returns the states over the step."""
        crossed = self.crossed(solver)
        if not crossed:
            return []
        between = path()
        return sorted((self._refined(solver, between, k) for k in crossed), key=lambda event: event.time)

    def crossed(self, solver: Any) -> list[int]:
        """Return the numbers of the signals that change their sign over a solver's last step."""
        after = self._signals(solver.t, solver.y)
        return [k for k, (a, b) in enumerate(zip(self.before, after, strict=True)) if a * b < 0.0]

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
        reducer = self.equations.reducer
        state = reducer.state()
        return Event(kind, time, reducer.inputs(state.v), reducer.inputs(state.velocity), actuator)

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
            gain = reducer.state().acceleration[reducer.terms.first_reading + equations.free[signal]]
            if not reducer.on_inputs and len(equations.free) == 1:
                gain = slopes[1]
            rest = -speed / gain if gain else 0.0
            if not abs(rest) < SIMULATION.landing * (solver.t - start):
                return near, path(near)
            time += rest
        return time, fine.y + rest * slopes
