"""Derivatives of inputs that follow others by the dimensions of a mechanism, and what follows from them."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
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

    def all_inputs(self, designs: Any, own: Any, driver: int) -> Any:
        """Return the inputs (designs, actuators, rows) of designs (designs, dimensions) with one driver, plain or dual.

        own: the input of the driver (designs, rows).
        """
        found = self.recording.evaluate([designs[:, k, None] for k in range(designs.shape[1])], self._places)
        every = {driver: own}

        def number(value: Any) -> Any:
            return found[value.place] if isinstance(value, Recorded) else value

        for one in self.couplings:
            followed = (number(ratio) * every[k] for k, ratio in one.terms)
            every[one.follower] = sum(followed, number(one.phase) + 0.0 * own)
        return np.stack([every[k] for k in range(len(every))], axis=1)

    def moving(self, nominal: FloatArray, given: FloatArray) -> Dual:
        """Return inputs and their derivatives (orders, actuators, rows) in dual numbers, for dimensions (dimensions,).

        The tangents are the dimensions at constant inputs of the drivers, and all inputs; the followers follow them.
        """
        count, actuators = len(nominal), given.shape[1]
        tangents = self.recording.tangents(nominal[:, None], self._places)
        slopes = np.zeros((count + actuators, *given.shape))
        slopes[count:, 0] = np.eye(actuators)[..., None]

        def slope(number: Any) -> Any:
            return tangents[number.place].slopes if isinstance(number, Recorded) else 0.0

        for coupling in self.couplings:
            own = slopes[:, :, coupling.follower]
            own[:count, 0] += slope(coupling.phase)
            for actuator, ratio in coupling.terms:
                own[:count] += np.reshape(slope(ratio), (-1, 1, 1)) * given[:, actuator]
                own[count + actuator, 0] += float(getattr(ratio, "value", ratio))
        return Dual(given, slopes)
