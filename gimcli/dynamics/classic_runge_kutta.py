"""The classic Runge-Kutta method with equal steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gimcli.mechanism import FloatArray
from gimcli.numerics.along import hermite


class ClassicRungeKutta:
    """The Runge-Kutta method of fourth order with equal steps, with the interface of scipy's solvers.

    Source: Kutta 1901. Dense output is a cubic Hermite interpolation.
    """

    def __init__(
        self, fun: Callable[[float, FloatArray], FloatArray], t0: float, y0: FloatArray, t_bound: float, step: float
    ) -> None:
        self.fun, self.t, self.y, self.t_bound, self.step_size = fun, t0, np.array(y0, dtype=float), t_bound, step
        self.status, self.nfev, self.t_old, self.slope = "running", 1, t0, fun(t0, self.y)
        self._last = (self.y, self.slope)

    def step(self) -> str | None:
        """Take one step; return the reason if it failed, else None."""
        t, y, h = self.t, self.y, min(self.step_size, self.t_bound - self.t)
        k1 = self.slope
        k2 = self.fun(t + 0.5 * h, y + 0.5 * h * k1)
        k3 = self.fun(t + 0.5 * h, y + 0.5 * h * k2)
        k4 = self.fun(t + h, y + h * k3)
        end = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        self._last = (y, k1)
        self.t_old, self.t, self.y, self.slope = t, t + h, end, self.fun(t + h, end)
        self.nfev += 4
        if not np.all(np.isfinite(end)) or not np.all(np.isfinite(self.slope)):
            self.t, self.y, self.slope, self.status = t, y, k1, "failed"
            return "no position"
        if self.t_bound - self.t <= 1e-12 * h:
            self.t, self.status = self.t_bound, "finished"
        return None

    def dense_output(self) -> Any:
        """Return the interpolation of the states over the last step, a function of time."""
        (before, slope), start, h = self._last, self.t_old, self.t - self.t_old
        return lambda t: hermite(before, h * slope, self.y, h * self.slope, (t - start) / h)
