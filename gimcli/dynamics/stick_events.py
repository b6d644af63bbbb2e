"""Events of dry friction in a simulation: when a pair begins to stand still (sticks), and when it slides again.

A pair stands while its sliding speed is within a few slip speeds. A pair that only reverses leaves that range at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.dynamics.equations_of_motion import Equations
from gimcli.dynamics.simulation_types import SIMULATION, SLIDES, STICKS, Event


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
        low, high = solver.t_old, solver.t
        for _ in range(SIMULATION.bisections):
            middle = 0.5 * (low + high)
            if not low < middle < high or not self.equations.move(middle, path(middle)):
                break
            low, high = (low, middle) if bool(self._standing()[k]) == stands else (middle, high)
        self.equations.move(high, path(high))
        return float(high)

    def _event(self, kind: str, time: float, k: int) -> Event:
        reducer = self.equations.reducer
        inputs, speeds = reducer.inputs(reducer.at.v).copy(), reducer.inputs(reducer.room.velocity).copy()
        return Event(kind, time, inputs, speeds, pair=self.friction.names[k])
