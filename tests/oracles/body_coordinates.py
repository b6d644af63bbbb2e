"""Dry friction in body coordinates: all multipliers and all friction equations at once, for any few bodies.

An independent formulation. A body has x, y and an angle; joints are equations between points of two bodies, and their
multipliers are the reactions. Friction enters the equations of motion as moments and forces in proportion to the
multipliers, and scipy finds the root of everything. Lengths in m; body 0 is the frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import root


def turn(z):
    return np.exp(1j * z)


@dataclass
class Pin:
    """A revolute pair at points a of body i and b of body j; `rho` is the friction radius, the pin is fixed to i."""

    i: int
    a: complex
    j: int
    b: complex
    rho: float = 0.0
    rows = 2

    def equations(self, place):
        away = place(self.j, self.b) - place(self.i, self.a)
        return [away.real, away.imag]

    def rubs(self, reactions, speed):
        """Yield the friction: body, place (None for a couple), force or moment."""
        moment = -self.rho * abs(complex(*reactions)) * np.sign(speed.turn(self.j) - speed.turn(self.i))
        yield self.j, None, moment
        yield self.i, None, -moment


@dataclass
class Slot:
    """Point b of body j on the line through point a of body i with direction `along`; friction mu |N|."""

    i: int
    a: complex
    along: complex
    j: int
    b: complex
    mu: float = 0.0
    rows = 1

    def equations(self, place):
        away = place(self.j, self.b) - place(self.i, self.a)
        return [(away * np.conj(place.direction(self.i, 1j * self.along))).real]

    def rubs(self, reactions, speed):
        yield from slid(self, speed, self.mu * abs(reactions[0]))


@dataclass
class Block:
    """Body j slides on the line of body i without turning; two contacts `length` apart, their middle at b of body j."""

    i: int
    a: complex
    along: complex
    j: int
    b: complex
    mu: float = 0.0
    length: float = 1.0
    rows = 2

    def equations(self, place):
        away = [place(self.j, self.b + s * self.length / 2) - place(self.i, self.a) for s in (-1, 1)]
        return [(z * np.conj(place.direction(self.i, 1j * self.along))).real for z in away]

    def rubs(self, reactions, speed):
        yield from slid(self, speed, self.mu * (abs(reactions[0]) + abs(reactions[1])))


def slid(pair, speed, friction):
    """Yield the friction of a sliding pair against the motion of body j along body i."""
    at = speed.place(pair.j, pair.b)
    along = speed.place.direction(pair.i, pair.along)
    rate = ((speed.point(pair.j, pair.b) - speed.on(pair.i, at)) * np.conj(along)).real
    yield pair.j, at, -friction * np.sign(rate) * along
    yield pair.i, at, friction * np.sign(rate) * along


@dataclass
class Place:
    """Positions of the bodies."""

    q: np.ndarray

    def body(self, k):
        return (0.0, 0.0, 0.0) if k == 0 else self.q[3 * k - 3 : 3 * k]

    def __call__(self, k, local):
        x, y, angle = self.body(k)
        return x + 1j * y + turn(angle) * local

    def direction(self, k, local):
        return turn(self.body(k)[2]) * local


@dataclass
class Speed:
    """Velocities of the bodies."""

    place: Place
    v: np.ndarray

    def turn(self, k):
        return 0.0 if k == 0 else self.v[3 * k - 1]

    def on(self, k, at):
        """Return the velocity of the material point of body k at a place."""
        if k == 0:
            return 0.0j
        x, y, _ = self.place.body(k)
        return self.v[3 * k - 3] + 1j * self.v[3 * k - 2] + 1j * self.turn(k) * (at - (x + 1j * y))

    def point(self, k, local):
        return self.on(k, self.place(k, local))


@dataclass
class Bodies:
    """Bodies with joints; `driver` is (body, law): the angle of a body, or (body, law, axis) its x (0) or y (1)."""

    start: np.ndarray  # (3 n,)
    joints: list
    driver: tuple
    loads: list = field(default_factory=list)  # body, local point (None for a couple), force or moment
    masses: dict = field(default_factory=dict)  # body: (mass, inertia); coordinates are of the centre of mass
    gravity: complex = 0.0j

    def residual(self, q, t):
        place = Place(q)
        drive = q[3 * self.driver[0] - 3 + (self.driver[2] if len(self.driver) > 2 else 2)] - self.driver[1](t)
        return np.array([e for joint in self.joints for e in joint.equations(place)] + [drive])

    def jacobian(self, q, t, h=5e-3):
        """Return the derivatives of the equations, by central differences of order 8."""
        weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
        columns = [
            sum(w * self.residual(q + s * h * unit, t) for w, s in zip(weights, range(-4, 5), strict=True) if w) / h
            for unit in np.eye(len(q))
        ]
        return np.array(columns).T

    def at(self, t, q):
        """Return positions at a time, from a guess."""
        for _ in range(30):
            step = np.linalg.solve(self.jacobian(q, t), self.residual(q, t))
            q = q - step
            if np.max(np.abs(step)) < 1e-13:
                break
        return q

    def velocity(self, q, t, h=1e-3):
        law = self.driver[1]
        rate = (8 * (law(t + h) - law(t - h)) - law(t + 2 * h) + law(t - 2 * h)) / (12 * h)
        right = np.zeros(len(q))
        right[-1] = rate
        return np.linalg.solve(self.jacobian(q, t), right)

    def effort(self, t, guess=None):
        """Return the driving effort at a time, and all multipliers."""
        q = self.at(t, self.start if guess is None else guess)
        jacobian, place = self.jacobian(q, t), Place(q)
        speed = Speed(place, self.velocity(q, t))
        applied = self._applied(place) - self._inertia(t, q)

        def balance(unknown):
            return jacobian.T @ unknown + applied + self._friction(unknown, speed)

        first = np.linalg.solve(jacobian.T, -applied)
        found = root(balance, first, tol=1e-14)
        assert np.max(np.abs(balance(found.x))) < 1e-9 * max(1.0, np.max(np.abs(found.x)))
        return found.x[-1], found.x[:-1], q

    def _generalised(self, place, body, at, force):
        found = np.zeros(len(self.start))
        if body:
            x, y, _ = place.body(body)
            if at is None:
                found[3 * body - 1] = force
            else:
                found[3 * body - 3 : 3 * body] = force.real, force.imag, (np.conj(at - (x + 1j * y)) * force).imag
        return found

    def _applied(self, place):
        found = sum(
            (
                self._generalised(place, body, None if local is None else place(body, local), force)
                for body, local, force in self.loads
            ),
            np.zeros(len(self.start)),
        )
        for body, (mass, _) in self.masses.items():
            found += self._generalised(place, body, place(body, 0.0), mass * self.gravity)
        return found

    def _inertia(self, t, q, h=1e-3):
        found = np.zeros(len(q))
        if self.masses:
            ends = [self.velocity(self.at(t + s * h, q), t + s * h) for s in (-2, -1, 1, 2)]
            gain = (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / (12 * h)
            for body, (mass, inertia) in self.masses.items():
                part = slice(3 * body - 3, 3 * body)
                found[part] = gain[part] * np.array([mass, mass, inertia])
        return found

    def _friction(self, multipliers, speed):
        found, k = np.zeros(len(self.start)), 0
        for joint in self.joints:
            for body, at, force in joint.rubs(multipliers[k : k + joint.rows], speed):
                found += self._generalised(speed.place, body, at, force)
            k += joint.rows
        return found
