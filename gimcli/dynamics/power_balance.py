"""The power balance of inverse dynamics over a motion in pieces, as a check."""

from __future__ import annotations

import numpy as np

from gimcli.dynamics.forces import Forces


class PowerBalance:
    """The greatest power-balance error, and the number of rows next to singular positions."""

    def __init__(self) -> None:
        self.power = 0.0  # greatest absolute power of any kind, W
        self.error = 0.0  # greatest absolute error of the power balance, W
        self.left_out = 0  # rows near singular positions, where reactions are unbounded

    def add(self, forces: Forces) -> None:
        """Add the next rows."""
        self.left_out += int(np.sum(forces.good & ~forces.bounded))
        kinds = [forces.drive_power, forces.loads.kinetic_rate, *forces.loads.power.values()]
        self.power = max([self.power, *(float(np.nanmax(np.abs(p[forces.good]), initial=0.0)) for p in kinds)])
        self.error = max(self.error, float(np.nanmax(np.abs(forces.power_error[forces.good]), initial=0.0)))

    @property
    def drift(self) -> float:
        """The greatest error relative to the greatest power."""
        return self.error / self.power if self.power else 0.0
