"""Derivatives of inputs that follow others by the dimensions of a mechanism, and what follows from them."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.calculus.recorded import Recorded, Recording
from gimcli.input_laws import InputLaw
from gimcli.mechanism import FloatArray, Mechanism


class CouplingSlopes:
    """How the couplings of a mechanism depend on its dimensions."""

    def __init__(self, recorded: Mechanism, recording: Recording) -> None:
        """Read the couplings of a mechanism with recorded numbers."""
        self.couplings, self.recording = recorded.couplings, recording
        self.laws: list[InputLaw] = [recorded.actuators[c.follower].law for c in self.couplings]
        numbers: list[Any] = [n for c in self.couplings for n in (c.phase, *(ratio for _, ratio in c.terms))]
        self._places = sorted({n.place for n in numbers if isinstance(n, Recorded)})

    @property
    def varied(self) -> bool:
        """Whether a dimension changes a ratio or a phase."""
        return bool(self._places)

    def followed(self, slopes: FloatArray, nominal: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return derivatives at constant inputs of the drivers, of those at constant inputs of all actuators.

        Args:
            slopes: derivatives by the dimensions and by all inputs (quantities, dimensions + actuators, rows).
            nominal: the dimensions (dimensions,).
            inputs: the inputs (actuators, rows).
        """
        count, found = len(nominal), slopes.copy()
        tangents = self.recording.tangents(nominal[:, None], self._places)

        def slope(number: Any) -> FloatArray | float:
            return tangents[number.place].slopes if isinstance(number, Recorded) else 0.0

        for coupling in self.couplings:
            own = slopes[:, count + coupling.follower]
            change = slope(coupling.phase) + np.zeros((count, 1))
            for actuator, ratio in coupling.terms:
                change = change + slope(ratio) * inputs[actuator]
                found[:, count + actuator] += float(getattr(ratio, "value", ratio)) * own
            found[:, :count] += own[:, None] * change
        return found
