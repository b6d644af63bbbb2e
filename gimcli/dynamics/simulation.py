"""Forward dynamics: the motion of a mechanism with free inputs under weight, loads and driving efforts.

The integrator `euler` is the scheme of its source: Euler's method with steps of the coordinate q, dJ/dq by forward
differences or exact.

    w_{i+1}^2 = w_i^2 + 2 a_i dq,   a_i = (tau_i - (J_{i+1} - J_i) / (2 dq) w_i^2) / J_i,   t += 2 dq / (w_i + w_{i+1})

It is provided to compare its error with the other methods: on the Watt six-bar 0.8 % of the energy, 0.4 % with the
exact dJ/dq. Source: Durango, Giraldo, Calle & Mesa 2014, section 3.3.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gimcli.dynamics.integration import Integration
from gimcli.dynamics.integrators import INTEGRATORS
from gimcli.dynamics.simulation_types import STANDSTILL, Event, Settings, Simulation
from gimcli.errors import UsageError
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run
from gimcli.progress import Progress, no_progress
from gimcli.status import Status

AT_REST = 1e-9
"""Reduced torque below which a mechanism at rest is in equilibrium."""


Step = tuple[float, float, float, float]
"""Time, coordinate and speed at the beginning of a step, and the acceleration during it."""


class EulerIntegration(Integration):
    """Integration with steps of the coordinate instead of the time."""

    def simulation(self) -> Simulation:
        """Integrate, then evaluate the rows."""
        reducer = self.reducer
        if len(self.free) != 1 or reducer.given:
            raise UsageError("integrator euler is for one free input and no other; choose dop853")
        if not reducer.steady:
            raise UsageError(
                "integrator euler allows only forces that depend on the position: no dampers, friction, tables or"
                " torque-speed lines; choose dop853"
            )
        time = float(self.times[0])
        y = self._start(time)
        if y is None:
            return self._result(time)
        self._keep_row(time, y)
        self._accept(time, y)
        sweeps = self._swept(time, y)
        self._resample(sweeps)
        return self._result(sweeps[-1][0])

    def _swept(self, time: float, y: FloatArray) -> list[Step]:
        """Return the steps up to the last time, the last requested standstill, or a singular position."""
        q, speed, sweeps = float(y[0]), float(y[1]), []
        inertia, torque, slope = self._reduced(q)
        step = math.copysign(self.settings.step, speed or torque)
        stops = 0
        while time <= self.times[-1] and (speed or abs(torque) > AT_REST):
            if self._ends_early():
                break
            ahead = self._reduced(q + step)
            if ahead is None:
                self.status = Status.SINGULAR
                break
            half = slope if self.integrator.exact else 0.5 * (ahead[0] - inertia) / step
            gain = (torque - half * speed * speed) / inertia
            sweeps.append((time, q, speed, gain))
            square = speed * speed + 2.0 * gain * step
            if square <= 0.0:  # a standstill within the step
                q, time, speed, step = q - 0.5 * speed * speed / gain, time - speed / gain, 0.0, -step
                stops += 1
                inputs = self.mechanism.coupled(np.full(len(self.mechanism.actuators), q))
                self.events.append(Event(STANDSTILL, time, inputs, np.zeros(len(inputs)), self.free[0]))
                if stops == self.settings.standstills:
                    break
                inertia, torque, slope = self._reduced(q)
                continue
            after = math.copysign(math.sqrt(square), step)
            time += 2.0 * step / (speed + after)
            q, speed, (inertia, torque, slope) = q + step, after, ahead
            self.reducer.accept()
            self.progress(min(999, int(1000 * time / self.times[-1])), 1000)
        self.steps = len(sweeps)
        sweeps.append((time, q, speed, 0.0))
        stopped = stops > 0 and stops == self.settings.standstills
        if self.status is Status.OK and not stopped and time < self.times[-1]:  # at rest in equilibrium until the end
            sweeps.append((float(self.times[-1]), q, 0.0, 0.0))
        return sweeps

    def _reduced(self, q: float) -> Any:
        """Return J, tau and the exact dJ/dq / 2; None if there is no position."""
        self.evaluations += 1
        if not self.reducer.move(np.array([q]), np.ones(1), np.zeros(0)):
            return None
        out = self.reducer.out
        return float(out.m[0, 0]), float(out.q[0]), float(out.h[0])

    def _resample(self, sweeps: list[Step]) -> None:
        """Evaluate the rows that the steps reach; the acceleration is constant within a step."""
        begin, k = np.array([time for time, *_ in sweeps]), 0
        first = self.rows[0][0][0]
        self.reducer.set_base(first, self.reducer.choice)
        acting = self.reducer.acting
        effort = float(acting.motor[0, 0] * acting.units[acting.motors[0]])  # constant
        for row in range(1, len(self.times)):
            at = float(self.times[row])
            if at > begin[-1]:
                break
            index = int(np.searchsorted(begin, at, side="right")) - 1
            while k < index:  # the reducer follows the branch in parts of at most 100 steps
                k = min(k + 100, index)
                self._accept(sweeps[k][0], np.array([*sweeps[k][1:3], 0.0, 0.0]))
            (_, q, speed, gain), late = sweeps[index], at - begin[index]
            q, speed = q + speed * late + 0.5 * gain * late * late, speed + gain * late
            self._keep_row(at, np.array([q, speed, 0.0, effort * (q - first[self.reducer.own[0]])]))


def simulate(
    mechanism: Mechanism, times: FloatArray, settings: Settings | None = None, run: Run = plain,
    progress: Progress = no_progress,
) -> Simulation:  # fmt: skip
    """Simulate a mechanism from its initial state at times[0]; return the states at `times` (rows,) [s], ascending.

    Raises UsageError for an unknown method, StructureError without a free input, ModelError without masses.
    """
    settings = settings or Settings()
    if settings.method and settings.method not in INTEGRATORS:
        raise UsageError(f"integrator: expected one of {', '.join(INTEGRATORS)}, got '{settings.method}'")
    over_input = bool(settings.method) and INTEGRATORS[settings.method].over_input
    kind = EulerIntegration if over_input else Integration
    return kind(mechanism, np.asarray(times, dtype=float), settings, run, progress).simulation()
