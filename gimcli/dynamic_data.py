"""What acts on a mechanism: inertia, gravity, loads, springs, dampers, friction and drives, as compiled.

SI units (kg, N, m, s, rad) but for places and lengths, which are those of the normal frame; `metre` tells how many m
its unit is. A mechanism whose file says nothing of them has an empty `Dynamics`, which costs nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

TIME = -1
"""A curve that runs over the time [s]."""


class LoadCurve(Protocol):
    """A value over the time [s] or an input (rad, or length in the normal frame)."""

    def __call__(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the value at each place."""
        ...


@dataclass(frozen=True)
class Inertia:
    """A member's mass, its moment of inertia about the centre of mass, and where that is."""

    member: int
    mass: float  # kg
    moment: float  # kg m2
    centre: complex  # in the member's own frame, normal frame
    stated: bool = True  # the moment; where it is not, it is 0


@dataclass(frozen=True)
class AppliedLoad:
    """A force at a point of a member, or a torque on it; a curve multiplies it."""

    name: str
    member: int
    point: complex  # in the member's own frame, normal frame
    force: complex = 0.0j  # N, in the frame, or in the member's own frame where it follows
    torque: float = 0.0  # N m
    follows: bool = False
    curve: LoadCurve | None = field(default=None, repr=False)
    over: int = TIME  # or the actuator whose value the curve runs over


@dataclass(frozen=True)
class SpringForce:
    """Stiffness of what a gauge reads: N/m, or N m/rad for an angle."""

    name: str
    gauge: int  # of Mechanism.gauges
    stiffness: float
    free: float  # reading without force: rad, or length in the normal frame


@dataclass(frozen=True)
class DampingForce:
    """Damping of what a gauge reads: N s/m, or N m s/rad for an angle."""

    name: str
    gauge: int
    damping: float


@dataclass(frozen=True)
class Friction:
    """Viscous friction in the revolute pairs at a node [N m s/rad], or in a sliding pair [N s/m]."""

    name: str
    damping: float
    node: int = -1
    slide: int = -1  # of Mechanism.slides: the pair's first


@dataclass(frozen=True)
class DrivingEffort:
    """Driving torque [N m] or force [N]: constant, a curve, or a line from stall to idle speed."""

    constant: float = 0.0
    curve: LoadCurve | None = field(default=None, repr=False)
    over: str = "time"  # or "value", "speed" of the own input
    idle: float = 0.0  # speed at which the line is 0 [rad/s, or normal frame's length per s]; 0: no line


@dataclass(frozen=True)
class Release:
    """How an actuator takes part where the loads decide the motion."""

    actuator: int
    free: bool = False  # it moves as the loads will, and not by its law
    start: float | None = None  # rad, or length in the normal frame; None: where its law starts
    speed: float = 0.0  # per s
    effort: DrivingEffort = DrivingEffort()
