"""Work of the actuators, and of every kind of force, over a motion; positive and negative parts apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.dynamics.forces import Forces
from gimcli.dynamics.row_integrals import RowIntegrals
from gimcli.mechanism import FloatArray, Mechanism


@dataclass(frozen=True)
class Work:
    """Work [J] over the determined rows: while the power is positive, and while it is negative."""

    positive: float
    negative: float

    @property
    def net(self) -> float:
        """The sum of both."""
        return self.positive + self.negative


class WorkBalance:
    """Integrates the powers of a motion in pieces."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._sums: RowIntegrals | None = None
        self.names: tuple[str, ...] = ()

    def add(self, forces: Forces) -> None:
        """Add the next rows."""
        efforts = {f"{name}.effort": power for name, power in actuator_powers(forces).items()}
        powers = {**efforts, **forces.loads.power}
        if self._sums is None:
            self.names, self._sums = tuple(powers), RowIntegrals(len(powers), signed=len(powers))
        self._sums.add(np.array([np.where(forces.good, power, np.nan) for power in powers.values()]))

    def result(self, closed: bool, step: float) -> dict[str, Work]:
        """Return the work of each actuator, and of each kind of force; `step` is the time of a step [s]."""
        if self._sums is None:
            return {}
        self._sums.finish(closed)
        positive, net = self._sums.positive * step, self._sums.net * step
        return {
            name: Work(float(up), float(whole - up)) for name, up, whole in zip(self.names, positive, net, strict=True)
        }


def actuator_powers(forces: Forces) -> dict[str, FloatArray]:
    """Return the power [W] of each actuator by its name (rows,)."""
    return {a.name: forces.power(k) for k, a in enumerate(forces.mechanism.actuators)}
