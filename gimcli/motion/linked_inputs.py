"""Inputs that follow the linkage itself, such as the angle of a gear that a rocker turns, along a motion.

The position and these inputs are followed together from the drawn position, to the start of the laws and along them,
by Newton's method with steps that the curvature limits; the laws of the followers are then evaluated between these
points at any time, with derivatives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gimcli.errors import UnassembledError
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.numerics.along import sign_changes
from gimcli.numerics.follower import Follower
from gimcli.positions.inputs import nearest_turns, straight_inputs
from gimcli.structure.system import System, system_of


@dataclass(frozen=True)
class LinkedConstants:
    """Constants of the method; lengths and angles are about 1."""

    longest: float = 0.15  # greatest change of an unknown between two points
    bend: float = 0.2  # greatest correction of an extrapolated point, relative to the step
    first: float = 1e-2  # first step, relative to the whole motion
    shortest: float = 1e-9  # least step: before a limit or a singular position
    growth: float = 1.5  # factor from one step to the next
    iterations: int = 12
    exact: float = 1e-13  # residual of a solved position
    orders: int = 3  # of derivatives


LINKED = LinkedConstants()
SAMPLES = 1025
"""Times between which a law that follows is searched for changes of its sense."""


class LinkedPath(Follower[FloatArray, FloatArray]):
    """Unknowns x (n,) of a motion with inputs u(s) (actuators,) of drivers, from s = 0 to 1 or to a limit before."""

    def __init__(self, system: System, start: FloatArray, u: Callable[[float], FloatArray]) -> None:
        self.system, self.u = system, u
        self.places, self.points = [0.0], [start]
        self.step, self.shortest = LINKED.first, LINKED.shortest
        while self.limit is not None and self.go():
            self.step *= LINKED.growth

    @property
    def limit(self) -> float | None:
        """The parameter at which the motion ends before 1."""
        return None if self.places[-1] >= 1.0 else self.places[-1]

    @property
    def ahead(self) -> float:
        """The parameter after a step."""
        return min(1.0, self.places[-1] + self.step)

    def predict(self) -> FloatArray:
        """Return the point extrapolated from the last two."""
        last = self.points[-1]
        if len(self.points) == 1:
            return last
        gap = self.places[-1] - self.places[-2]
        return last + (last - self.points[-2]) * (self.ahead - self.places[-1]) / gap

    def correct(self, guess: FloatArray) -> FloatArray | None:
        """Return the point near an extrapolated one; None if the step is too long."""
        found, exact = settled(self.system, guess, self.u(self.ahead))
        if not exact:
            return None
        change = float(np.max(np.abs(found - self.points[-1])))
        bend = float(np.max(np.abs(found - guess)))
        smooth = bend <= LINKED.bend * change or bend <= LINKED.bend * LINKED.first
        return found if change <= LINKED.longest and smooth else None

    def accept(self, there: FloatArray) -> bool:
        """Add a point."""
        self.places.append(self.ahead)
        self.points.append(there)
        return True

    def at(self, places: FloatArray) -> FloatArray:
        """Return the unknowns (rows, n) at parameters (rows,); beyond a limit those at the limit."""
        return np.array([np.interp(places, self.places, row) for row in np.array(self.points).T]).T


def settled(system: System, x: FloatArray, u: FloatArray) -> tuple[FloatArray, bool]:
    """Return solutions near guesses x (..., n), for inputs u (..., actuators) of drivers, and whether all are exact."""
    for _ in range(LINKED.iterations):
        residual = system.residual(x, u)
        error = float(np.max(np.abs(residual), initial=0.0))
        if not error > LINKED.exact:
            return x, error <= LINKED.exact  # False for NaN
        x = x - (np.linalg.pinv(system.jacobian(x, u)) @ residual[..., None])[..., 0]
    return x, False


class LinkedMotion:
    """The inputs that follow the linkage along the laws of the drivers."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._last: tuple[bytes, FloatArray] | None = None

    @cached_property
    def path(self) -> LinkedPath:
        """The points along the laws; a motion that cannot begin has its limit at 0."""
        start = moved_from_drawing(self.mechanism, self._drivers(np.zeros(1))[0, 0])
        return LinkedPath(system_of(self.mechanism), start, lambda time: self._drivers(np.array([time]))[0, 0])

    def values(self, time: FloatArray) -> FloatArray:
        """Return the followers and their derivatives by the normalised time (orders, followers, rows)."""
        key = time.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = key, self._values(time)
        return self._last[1]

    def _values(self, time: FloatArray) -> FloatArray:
        path, system = self.path, system_of(self.mechanism)
        end = path.places[-1]
        inside = np.clip(time, 0.0, end)
        x, rates = path.at(inside), self._drivers(inside, LINKED.orders)
        x, _ = settled(system, x, rates[0])
        found = np.moveaxis(system.following(system.derivatives(x, rates)), 1, 2)
        found[1:, :, time > end] = 0.0
        return found

    def _drivers(self, time: FloatArray, orders: int = 0) -> FloatArray:
        """Return the inputs of the laws, those that follow linearly too, with derivatives (orders, rows, actuators)."""
        mechanism = self.mechanism
        laws = [[mechanism.actuators[k].law(time, order) for k in mechanism.drivers] for order in range(orders + 1)]
        found = np.array([mechanism.following @ np.reshape(own, (-1, len(time))) for own in laws])
        found[0] = mechanism.coupled(found[0])
        return np.moveaxis(found, 1, 2)


@dataclass(frozen=True)
class LinkedLaw:
    """The law of an input that follows the linkage."""

    motion: LinkedMotion
    number: int  # of the follower

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value or a derivative by the normalised time."""
        t = np.asarray(time, dtype=float)
        return np.asarray(self.motion.values(t.ravel())[order, self.number].reshape(t.shape))

    def stops(self) -> FloatArray:
        """Return the times at which the law reverses, and those at which a driver may."""
        mechanism = self.motion.mechanism
        found = [mechanism.actuators[k].law.stops() for k in mechanism.drivers]
        return np.unique(np.concatenate([self._reversals, *found]))

    @cached_property
    def _reversals(self) -> FloatArray:
        """The times at which the derivative changes its sign (rows,), to rounding."""
        return sign_changes(lambda time: self(time, 1), np.linspace(0.0, 1.0, SAMPLES))


def moved_from_drawing(mechanism: Mechanism, inputs: FloatArray) -> FloatArray:
    """Return the unknowns x (n,) at drivers' inputs (actuators,) that is reached from the drawing without disassembly.

    Raises UnassembledError if it is not reached.
    """
    system = system_of(mechanism)
    start = nearest_turns(mechanism, mechanism.drawn_inputs, inputs)
    first, exact = settled(system, system.coordinates(mechanism.drawn), mechanism.coupled(start))
    if exact:
        line = straight_inputs(start, inputs)
        path = LinkedPath(system, first, lambda s: mechanism.coupled(line(np.array([s]))[:, 0]))
        if path.limit is None:
            return path.points[-1]
    names = ", ".join(f"'{mechanism.actuators[k].name}'" for k in system.followers)
    raise UnassembledError(
        f"{mechanism.name}: the linkage that turns {names} cannot reach these inputs from the drawing; use other"
        " inputs, or initial coordinates closer to an assembled position"
    )


def linked_position(mechanism: Mechanism, inputs: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """Return all inputs (actuators,) and the positions (nodes,) for inputs of the drivers (actuators,)."""
    system, x = system_of(mechanism), moved_from_drawing(mechanism, inputs)
    found = mechanism.coupled(inputs)
    found[system.followers] = system.following(x)
    return found, system.nodes(x)


def followed(mechanism: Mechanism, inputs: FloatArray) -> FloatArray:
    """Return inputs (actuators,) in which the followers have the values that those of the drivers give.

    Raises UnassembledError if the linkage that turns a gear cannot reach them from the drawing.
    """
    if mechanism.complete is not None:
        return linked_position(mechanism, inputs)[0]
    return mechanism.coupled(inputs) if mechanism.couplings else inputs


def linked_limit(mechanism: Mechanism) -> float | None:
    """Return the normalised time at which the motion of the linkage that turns gears ends before that of the laws."""
    laws = (mechanism.actuators[c.follower].law for c in mechanism.couplings if c.reads)
    return next(law.motion.path.limit for law in laws if isinstance(law, LinkedLaw))


def with_linked_laws(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose inputs that follow the linkage have their laws; others are returned unchanged."""
    linked = [coupling.follower for coupling in mechanism.couplings if coupling.reads]
    if not linked:
        return mechanism
    motion, actuators = LinkedMotion(mechanism), list(mechanism.actuators)
    for number, follower in enumerate(linked):
        actuators[follower] = replace(actuators[follower], law=LinkedLaw(motion, number))
    return replace(mechanism, actuators=tuple(actuators), complete=with_linked_laws)
