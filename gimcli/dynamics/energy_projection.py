"""Correction of the speeds so that a conservative mechanism keeps its initial energy.

Source: Hairer, Lubich & Wanner, Geometric Numerical Integration, 2006, algorithm IV.4.2, along the speeds.
"""

from __future__ import annotations

from gimcli.dynamics.reducer import Reducer
from gimcli.dynamics.simulation_types import SIMULATION
from gimcli.kernels.reduction import KINETIC, POTENTIAL
from gimcli.mechanism import FloatArray


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
