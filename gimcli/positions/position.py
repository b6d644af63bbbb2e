"""The result of the solution of one position."""

from __future__ import annotations

from dataclasses import dataclass, field

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.residual import Residual


@dataclass(frozen=True)
class Position:
    """A position in the normal frame, with its status, errors and number of iterations."""

    mechanism: Mechanism = field(repr=False)
    inputs: FloatArray  # (actuators,)
    z: ComplexArray = field(repr=False)  # (nodes,)
    status: Status
    residual: Residual  # one row
    sweeps: int  # number of sweeps or iterations
    history: FloatArray | None = field(default=None, repr=False)  # (sweeps + 1, 2) errors after each sweep
    options: Options | None = None
    known: ComplexArray | None = field(default=None, repr=False)  # of several machines: z, NaN of those without one

    @property
    def worst(self) -> str:
        """Name of the constraint with the greatest error."""
        return self.residual.worst[0]
