"""Compiled dynamics of a mechanism: inertia, gravity, loads, springs, dampers, friction and drives.

Units are SI (kg, N, m, s, rad), except for positions and lengths, which are in the normal frame; `Dynamics.metre` is
the length of its unit in m. A mechanism without such data has an empty `Dynamics`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gimcli.calculus.numbers import RuleNumber

TIME = -1
"""The curve is a function of the time [s], not of an input."""
NO_MEMBER = NO_NODE = -1
"""The part belongs to a node, not to a member; or to a member, not to a node."""


class LoadCurve(Protocol):
    """A function of the time [s] or of an input (rad, or length in the normal frame)."""

    @property
    def at(self) -> NDArray[np.float64]:
        """The abscissas of the table; the factor is constant outside."""

    def __call__(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the values at times or inputs `at`."""

    def slope(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivatives at times or inputs `at`; 0 outside of the table."""


def evaluated(curve: LoadCurve, at: Any) -> Any:
    """Return the values of a table at times, inputs or speeds (rows,)."""
    return at.through(curve) if isinstance(at, RuleNumber) else curve(np.asarray(at))


@dataclass(frozen=True)
class Inertia:
    """Mass, centre of mass, and moment of inertia about the centre of mass, of a member; or a point mass at a node.

    A point mass belongs to the pin of its node, not to a member.
    """

    member: int  # NO_MEMBER for a point mass
    mass: float  # kg
    moment: float  # kg m^2
    centre: complex  # in the member's own frame, normal frame
    stated: bool = True  # whether the file gives the moment of inertia; if not, it is 0
    node: int = NO_NODE  # of a point mass


@dataclass(frozen=True)
class AppliedLoad:
    """A force at a point of a member or at a node, or a torque on a member, multiplied by a curve if there is one."""

    name: str
    member: int  # NO_MEMBER for a force at a node
    point: complex  # in the member's own frame, normal frame
    force: complex = 0.0j  # N; in the member's own frame if `follows`, else in the fixed frame
    torque: float = 0.0  # N m
    follows: bool = False
    curve: LoadCurve | None = field(default=None, repr=False)
    over: int = TIME  # argument of the curve: the time, or the value of the actuator of this number
    node: int = NO_NODE  # of a force on the pin of a node

    def factor(self, time: Any, inputs: Mapping[int, Any] | Sequence[Any] | NDArray[np.float64]) -> Any:
        """Return the factor at times [s] (rows,) and values inputs[actuator] (rows,)."""
        if self.curve is None:
            return 1.0
        return evaluated(self.curve, time if self.over == TIME else inputs[self.over])


@dataclass(frozen=True)
class SpringForce:
    """A spring on the quantity that a gauge measures; stiffness in N/m, or N m/rad for an angle."""

    name: str
    gauge: int  # of Mechanism.gauges
    stiffness: float
    free: float  # unloaded value: rad, or length in the normal frame

    @property
    def law(self) -> tuple[float, ...]:
        """The parameters of `gimcli.kernels.laws.spring`."""
        return self.free, self.stiffness

    @property
    def proportional(self) -> bool:
        """Whether the effort is proportional to the reading in all designs."""
        return not isinstance(self.free, RuleNumber) and self.free == 0.0


@dataclass(frozen=True)
class DampingForce:
    """A viscous damper on the quantity that a gauge measures; damping in N s/m, or N m s/rad for an angle."""

    name: str
    gauge: int
    damping: float


@dataclass(frozen=True)
class Friction:
    """Friction in the revolute pairs at a node, or in a sliding pair: viscous, and dry (Coulomb) if mu > 0.

    The pin of a node is fixed to its first member; each other member turns on it. In a sliding pair with two nodes the
    two contacts lie `length` apart on both sides of the middle of its nodes.
    """

    name: str
    damping: float  # viscous [N m s/rad], or [N s/m] of a sliding pair
    node: int = -1
    slide: int = -1  # number in Mechanism.slides of the pair's first height
    mu: float = 0.0  # coefficient of dry friction
    radius: float = 0.0  # of the pin, normal frame
    length: float = 0.0  # distance of the contacts of a sliding pair, normal frame; 0 for a pin in a slot

    @property
    def circle(self) -> float:
        """The radius of the friction circle of a pin, r mu / sqrt(1 + mu^2) (normal frame)."""
        return self.radius * self.mu / math.sqrt(1.0 + self.mu**2)


@dataclass(frozen=True)
class DrivingEffort:
    """Driving torque [N m] or force [N]: constant, a curve, or linear in the speed (0 at the idle speed)."""

    constant: float = 0.0
    curve: LoadCurve | None = field(default=None, repr=False)
    over: str = "time"  # argument of the curve: "time", or "value" or "speed" of its own input
    idle: float = 0.0  # speed at which the effort is 0 [rad/s, or normal length per s]; 0: independent of the speed

    def at(self, time: Any, value: Any, speed: Any) -> Any:
        """Return the constant, or the value of the curve at times, values or speeds of the input (rows,)."""
        arguments = {"time": time, "value": value, "speed": speed}
        return self.constant if self.curve is None else evaluated(self.curve, arguments[self.over])


@dataclass(frozen=True)
class RotorInertia:
    """The rotor of the motor of an actuator, with the kinetic energy of its rotation relative to the motor's frame.

    The axis of a rotor may have any direction: the moment by which its own rotation acts on its mount is left out.
    Source: Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109 (1987), assumption A1.
    """

    actuator: int
    inertia: float  # kg m^2
    ratio: float  # rad of the rotor per rad, or per normal length, of the input

    @property
    def reflected(self) -> float:
        """Inertia on the input, J per square of its rate: kg m^2, or kg m^2 per square of the normal length."""
        return self.inertia * self.ratio**2


@dataclass(frozen=True)
class Release:
    """The role of an actuator in a simulation (forward dynamics): driven by its law, or released (free).

    A free actuator moves under the loads and its driving effort, from a start value and a start speed.
    """

    actuator: int
    free: bool = False  # released: the loads determine its motion, not its law
    start: float | None = None  # start value: rad, or length in the normal frame; None: start value of its law
    speed: float = 0.0  # start speed: rad/s, or normal length per s
    effort: DrivingEffort = DrivingEffort()
