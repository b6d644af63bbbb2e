"""A solved position and what it cost."""

from __future__ import annotations

from dataclasses import dataclass, field

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.residual import Residual


@dataclass(frozen=True)
class Position:
    """A solved position in the normal frame, and what it cost."""

    mechanism: Mechanism = field(repr=False)
    inputs: FloatArray  # (actuators,)
    z: ComplexArray = field(repr=False)  # (nodes,)
    status: Status
    residual: Residual  # one row
    sweeps: int  # sweeps or iterations
    error: float  # estimated error of the nodes, relative to the size
    history: FloatArray | None = field(default=None, repr=False)  # (sweeps + 1, 2) errors of each sweep
    options: Options | None = None

    @property
    def worst(self) -> str:
        """The constraint that is worst off."""
        return self.residual.worst[0]
