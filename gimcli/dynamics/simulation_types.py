"""What a simulation is asked for and what it gives."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gimcli.dynamics.kinematic_history import Course
from gimcli.kernels.reduction import POTENTIAL
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.status import Status

STANDSTILL, DEAD_POINT, LIMIT, SINGULAR = "standstill", "dead point", "limit", "singular position"


@dataclass(frozen=True)
class Settings:
    """What the user decides about an integration."""

    method: str = "dop853"
    rtol: float = 1e-9  # of variables and speeds
    step: float = 1e-3  # s, of rk4
    standstills: int = 0  # end at this one; 0: do not


@dataclass(frozen=True)
class SimulationConstants:
    """Constants of the method, each with its reason."""

    steep: float = 12.0  # influence coefficient above which other variables are better: M grows with its square
    gentle: float = 6.0  # below which the inputs serve again: half of it, so that they do not change to and fro
    absolute: float = 0.1  # absolute tolerance (rad, lengths about 1) beside the relative one: where a variable is 0
    energies: float = 1e30  # tolerance of the energies: they follow the motion, the steps do not follow them
    shortest: float = 1e-12  # step beside the whole time: shorter ones lead nowhere, as before a singular position
    beginning: float = 1e3  # first step beside that: rounded zeros in the state suggest shorter ones
    creep: float = 1e-7  # step beside the whole time: shorter ones lead nowhere ...
    patience: int = 300  # ... if more come one after the other
    beside: float = 2e-2  # determinant of a dyad below which steps are watched one by one
    landing: float = 1e-2  # of a step: corrections of an event beyond that come from a change point on the way
    bisections: int = 60  # of a bracket: to the last digit
    moving: float = 1e-2  # part of the greatest energies above which the kinetic one determines speeds to enough digits


SIMULATION = SimulationConstants()


@dataclass(frozen=True)
class Event:
    """Something that happened on the way."""

    kind: str
    time: float  # s
    inputs: FloatArray  # (actuators,)
    speeds: FloatArray  # (actuators,) by s
    actuator: int = -1  # the input that it is about


@dataclass(frozen=True)
class Simulation:
    """A motion as it came about; rows after its end are missing."""

    mechanism: Mechanism = field(repr=False)
    time: FloatArray  # (rows,) s
    inputs: FloatArray = field(repr=False)  # (3, actuators, rows) values, speeds, accelerations by s
    nodes: ComplexArray = field(repr=False)  # (3, nodes, rows) normal frame
    efforts: FloatArray = field(repr=False)  # (actuators, rows) N m or N x length: of the inputs that follow laws
    energy: FloatArray = field(repr=False)  # (4, rows) J: kinetic, potential; dissipated and supplied since the start
    events: tuple[Event, ...]
    status: Status  # how it ended
    end: float  # s
    evaluations: int
    steps: int
    corrected: float  # J: what the steps alone would have let the energy drift by, added up without signs
    contradiction: float  # greatest residual of all equations, those not used among them

    @property
    def total(self) -> FloatArray:
        """Kinetic and potential energy and what has been dissipated, less what has been supplied [J] (rows,)."""
        kinetic, potential, dissipated, supplied = self.energy
        return np.asarray(kinetic + potential + dissipated - supplied)

    @property
    def drift(self) -> FloatArray:
        """Change of the total since the start [J] (rows,)."""
        return np.asarray(self.total - self.total[0]) if len(self.time) else self.total

    @property
    def worst_drift(self) -> float:
        """Greatest drift relative to the greatest of the energies."""
        if not len(self.time):
            return float("nan")
        scale = max(float(np.max(np.abs(self.energy))), float(np.ptp(self.energy[POTENTIAL])))
        return float(np.max(np.abs(self.drift))) / scale if scale > 0.0 else 0.0

    def course(self) -> Course:
        """Return the motion as what reactions are asked for."""
        return Course(self.time, self.inputs[0], self.nodes)
