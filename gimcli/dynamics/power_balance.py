"""The power balance of inverse dynamics over a motion in pieces, as a check."""

from __future__ import annotations

import numpy as np

from gimcli.dynamics.forces import Forces
from gimcli.mechanism import FloatArray

SHOWN = 5
"""Rows that are left out whose inputs are reported."""


class PowerBalance:
    """The greatest power-balance error, and the number of rows next to singular positions."""

    def __init__(self) -> None:
        self.power = 0.0  # greatest absolute power of any kind, W
        self.error = 0.0  # greatest absolute error of the power balance, W
        self.left_out = 0  # rows whose forces have too great an estimated error
        self.left_out_at: list[FloatArray] = []  # inputs (actuators,) of the first `SHOWN` of these rows

    def add(self, forces: Forces) -> None:
        """Add the next rows."""
        rows = np.flatnonzero(forces.good & ~forces.bounded)
        self.left_out += len(rows)
        self.left_out_at += list(forces.course.inputs[:, rows[: SHOWN - len(self.left_out_at)]].T)
        kinds = [forces.drive_power, forces.loads.kinetic_rate, *forces.loads.power.values()]
        self.power = max([self.power, *(float(np.nanmax(np.abs(p[forces.good]), initial=0.0)) for p in kinds)])
        self.error = max(self.error, float(np.nanmax(np.abs(forces.power_error[forces.good]), initial=0.0)))

    @property
    def drift(self) -> float:
        """The greatest error relative to the greatest power."""
        return self.error / self.power if self.power else 0.0
