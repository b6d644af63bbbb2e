"""A law from a row of its motion on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.input_laws import FloatArray, InputLaw


@dataclass(frozen=True)
class LaterLaw:
    """A law from the normalised time `first` on, at which its own time is 0."""

    law: InputLaw
    first: float

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value or a derivative by the time of this law."""
        left = 1.0 - self.first
        return np.asarray(left**order * self.law(np.minimum(self.first + left * np.asarray(time), 1.0), order))

    def stops(self) -> FloatArray:
        """Return the times at which the law may reverse."""
        found = self.law.stops()
        return np.asarray((found[found > self.first] - self.first) / (1.0 - self.first))
