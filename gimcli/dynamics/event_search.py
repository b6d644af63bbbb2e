"""Events of a simulation: a sign that changes over a step, bisection, and steps that end there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gimcli.dynamics.equations_of_motion import Equations
from gimcli.dynamics.simulation_types import DEAD_POINT, SIMULATION, STANDSTILL, Event
from gimcli.mechanism import FloatArray

Begin = Callable[[float, FloatArray, float], Any]
"""Makes a solver from a time, a state and an end."""


class EventSearch:
    """Watches free inputs for standstills and dead points."""

    def __init__(self, equations: Equations, begin: Begin, lands: bool) -> None:
        self.equations, self.begin, self.lands = equations, begin, lands
        self.standing: list[float] = []  # signals at the last accepted state
        self.last_y: FloatArray = np.zeros(0)  # that state
        self.evaluations = 0

    def stand(self, y: FloatArray) -> None:
        """Keep the state where the reducer stands: the next step begins there."""
        self.last_y = np.array(y)
        self.standing = self._here(y)

    def stand_on_inputs(self, y: FloatArray) -> None:
        """Keep a state whose independent variables are the inputs."""
        self.last_y, own = y.copy(), len(self.equations.free)
        self.standing = list(y[own : 2 * own])

    def events(self, solver: Any, path: Callable[[], Any]) -> list[Event]:
        """Return the events of a solver's last step by their times; `path` makes its states between."""
        crossed = self.crossed(solver)
        if not crossed:
            return []
        between = path()
        return sorted((self._refined(solver, between, k) for k in crossed), key=lambda event: event.time)

    def crossed(self, solver: Any) -> list[int]:
        """Return which signals change their sign over a solver's last step."""
        after = self._signals(solver.t, solver.y)
        return [k for k, (a, b) in enumerate(zip(self.standing, after, strict=True)) if a * b < 0.0]

    def _signals(self, time: float, y: FloatArray) -> list[float]:
        """Return what changes its sign at the events of a state."""
        reducer, own = self.equations.reducer, len(self.equations.free)
        if reducer.on_inputs:
            return [float(v) for v in y[own : 2 * own]]
        return self._here(y) if self.equations.move(time, y) else [0.0] * len(self.standing)

    def _here(self, y: FloatArray) -> list[float]:
        """Return the speeds of the free inputs, and what vanishes at their dead point, where the reducer stands."""
        reducer, own = self.equations.reducer, len(self.equations.free)
        if reducer.on_inputs:
            return [float(v) for v in y[own : 2 * own]]
        inputs = [reducer.terms.first_reading + k for k in self.equations.free]
        b = reducer.at.b[:own][:, inputs]
        if own == 1:
            return [float(y[1]), float(b[0, 0])]
        return [*(float(v) for v in reducer.room.velocity[inputs]), float(np.linalg.det(b))]

    def _refined(self, solver: Any, path: Any, signal: int) -> Event:
        """Find an event by bisection of the states between, then by one step that ends there."""
        low, high = solver.t_old, solver.t
        sign, free = self.standing[signal], self.equations.free
        for _ in range(SIMULATION.bisections):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if self._signals(middle, path(middle))[signal] * sign > 0.0:
                low = middle
            else:
                high = middle
        time, y = high, path(high)
        kind, actuator = (STANDSTILL, free[signal]) if signal < len(free) else (DEAD_POINT, free[0])
        if self.lands and kind == STANDSTILL and time > solver.t_old:
            time, y = self._landed(solver, path, time, signal)
        self.equations.move(time, y)
        reducer = self.equations.reducer
        state = reducer.state()
        return Event(kind, time, reducer.inputs(state.v), reducer.inputs(state.velocity), actuator)

    def _landed(self, solver: Any, path: Any, time: float, signal: int) -> tuple[float, FloatArray]:
        """Integrate from the last step to an event, and go the rest by a tangent: not what lies between steps."""
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
