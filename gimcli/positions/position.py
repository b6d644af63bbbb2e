"""One solved position: a row of a motion, from which the next rows are continued, or a result of its own."""

from __future__ import annotations

from dataclasses import dataclass, field

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.residual import Residual


@dataclass
class Row:
    """One solved position in the normal frame, and the measures that identify its branch."""

    time: float
    x: FloatArray  # (nodes,)
    y: FloatArray
    g: FloatArray  # (branches,) signed measure of each step with two solutions, see `kernels.loci`
    error: float = 0.0  # estimated error of the nodes


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
