"""Settings, constants, events and results of a simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gimcli.dynamics.kinematic_history import Course
from gimcli.kernels.reduction import POTENTIAL
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.status import Status

STANDSTILL, DEAD_POINT, LIMIT, SINGULAR = "standstill", "dead point", "limit", "singular position"
STICKS, SLIDES, JAM = "sticks", "slides", "jam"


@dataclass(frozen=True)
class SimulationConstants:
    """Constants of the method, each with its reason."""

    steep: float = 12.0  # influence coefficient above which other variables are chosen: M grows with its square
    gentle: float = 6.0  # influence coefficient below which the inputs are chosen again; half, to avoid changes in turn
    absolute: float = 0.1  # absolute tolerance relative to rtol (rad, lengths about 1), for variables near 0
    energies: float = 1e30  # tolerance of the energies, so that they do not control the steps
    shortest: float = 1e-12  # least step relative to the whole time: shorter steps occur before a singular position
    beginning: float = 1e3  # least first step relative to the least step: rounded zeros suggest too short ones
    creep: float = 1e-7  # step relative to the whole time; the piece ends if more than `patience` steps ...
    patience: int = 300  # ... in succession are shorter, and none moves farther
    still: float = 1e-3  # than this (rad, sizes): where speeds are great, short steps are no creep
    beside: float = 2e-2  # determinant of a dyad below which every step is checked
    landing: float = 1e-2  # greatest correction of an event relative to the step; greater ones mean a change point
    slip: float = 1e-6  # slip speed of dry friction times the whole time: the creep of what should stand [rad]
    difference: float = 1e-5  # step of differences, relative to 1 or to the slip speed: errors are about its size
    lost: float = 1e-7  # tolerance of the energies with dry friction, relative to masses at a size (rad) per whole time
    resolved: float = 1e-2  # absolute tolerance of speeds relative to the slip speed of dry friction, at most
    reversal: float = 1e-3  # of the whole time: dry friction changes its sense within shorter steps than loads change
    standing: float = 4.0  # sliding speed relative to the slip speed up to which a pair stands: 1 - tanh(4) is 7e-4
    dwell: float = 1e-3  # least time relative to the whole time for which a pair stands: a reversal is shorter
    at_once: int = 100_000  # positions after which stiffness and the bound on work are examined again
    work: int = 10_000_000  # most positions of a motion; a turn of a crank takes some hundreds
    call: int = 40  # positions that take as long as a call from the interpreter
    window: int = 2_500  # positions that take as long as the search for a window about a change point
    interpreted: int = 400_000  # most positions without compilation, where that is not the choice of the user
    stiff: float = 1e5  # decay rate of speeds times the rest of the time, above which explicit steps are too many
    damped: float = 100.0  # least decay rate relative to the speeds: below, the motion itself needs short steps
    moving: float = 1e-2  # least kinetic energy relative to the greatest energies for a correction of the speeds


SIMULATION = SimulationConstants()


@dataclass(frozen=True)
class Settings:
    """Settings of an integration that the user chooses."""

    method: str = ""  # a name of INTEGRATORS; "": the usual one
    rtol: float = 1e-9  # relative tolerance of variables and speeds
    step: float = 1e-3  # s, of rk4; of euler and euler-exact rad, or length in the normal frame
    standstills: int = 0  # number of the standstill at which to end; 0: none
    slip: float = 0.0  # rad/s, slip speed of dry friction; 0: from the whole time
    work: int = SIMULATION.work  # most positions


@dataclass(frozen=True)
class Event:
    """An event of a simulation: a standstill, a dead point, the end of the motion, or a pair that sticks or slides."""

    kind: str
    time: float  # s
    inputs: FloatArray  # (actuators,) rad, or length in the normal frame
    speeds: FloatArray  # (actuators,) by s
    actuator: int = -1  # the input concerned; -1: several
    pair: str = ""  # the pair with dry friction that sticks or slides


@dataclass(frozen=True)
class Simulation:
    """The result of a simulation; rows after its end are missing."""

    mechanism: Mechanism = field(repr=False)
    time: FloatArray  # (rows,) s
    inputs: FloatArray = field(repr=False)  # (3, actuators, rows) values, speeds, accelerations by s
    nodes: ComplexArray = field(repr=False)  # (3, nodes, rows) normal frame
    efforts: FloatArray = field(repr=False)  # (actuators, rows) N m or N x length: of the inputs that follow laws
    energy: FloatArray = field(repr=False)  # (4, rows) J: kinetic, potential; dissipated and supplied since the start
    events: tuple[Event, ...]
    status: Status  # reason of the end
    end: float  # s
    evaluations: int  # of the equations of motion
    steps: int
    corrected: float  # J, sum of the absolute energy corrections
    contradiction: float  # greatest residual of all equations, including redundant ones
    friction: FloatArray | None = field(default=None, repr=False)  # (contacts, rows) N x length in pins, N in guides
    slip: float = 0.0  # rad/s, slip speed of dry friction; 0: there is none
    careful: float = math.nan  # s, time from which an implicit method continued, because of stiffness; NaN: never

    @property
    def total(self) -> FloatArray:
        """Kinetic plus potential plus dissipated minus supplied energy [J] (rows,): constant except for errors."""
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
        """Return positions, velocities and accelerations for the computation of reactions."""
        return Course(self.time, self.inputs[0], self.nodes)
