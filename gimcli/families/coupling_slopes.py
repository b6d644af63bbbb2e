"""Derivatives of inputs that follow others by the dimensions of a mechanism, and what follows from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual, variables
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
        every = {driver: own, **dict(self._followers(designs, {driver: own}, 1.0 + 0.0 * own))}
        return np.stack([every[k] for k in range(len(every))], axis=1)

    def moving(self, nominal: FloatArray, given: FloatArray) -> Dual:
        """Return inputs and their derivatives (orders, actuators, rows) in dual numbers, for dimensions (dimensions,).

        The tangents are the dimensions at constant inputs of the drivers, and all inputs; the followers follow them.
        """
        count, actuators = len(nominal), given.shape[1]
        slopes = np.zeros((count + actuators, *given.shape))
        slopes[count:, 0] = np.eye(actuators)[..., None]
        every = {k: Dual(given[:, k], slopes[:, :, k]) for k in range(actuators)}
        one = Dual(np.eye(len(given), 1), np.zeros((count + actuators, 1, 1)))
        for k, value in self._followers(variables(nominal[None], actuators), every, one):
            slopes[:, :, k] += value.slopes
        return Dual(given, slopes)

    def _followers(self, designs: Any, every: Mapping[int, Any], one: Any) -> Iterator[tuple[int, Any]]:
        """Yield the number and the value of each follower for designs (designs, dimensions), plain or dual.

        every: the inputs of the drivers, or their derivatives of several orders. one: the constant 1 of the same shape.
        """
        found = self.recording.evaluate([designs[:, k, None] for k in range(designs.shape[1])], self._places)

        def number(value: Any) -> Any:
            return found[value.place] if isinstance(value, Recorded) else value

        for coupling in self.couplings:
            followed = (number(ratio) * every[k] for k, ratio in coupling.terms)
            yield coupling.follower, sum(followed, number(coupling.phase) * one)
