"""The equations F(x, u) = 0 of a mechanism in the unknowns x: the coordinates of its moving nodes.

F consists of the terms of second degree of `Terms`. Continuation, bifurcation analysis and equilibria use its values
and derivatives up to the third. Where the linkage itself turns gears, the inputs that follow it and the quantities that
they follow are unknowns too, after the coordinates.

Positions x (..., n), inputs u (..., actuators) and directions may have leading axes: many positions in one call.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.equations import linked_terms, variables_at
from gimcli.structure.quadric import Quadric
from gimcli.structure.terms import TermArrays, places

ZERO = 1e-13
"""A coefficient below this is a rounding error of 0; gradients have lengths of about 1."""

SMALL = 1e-9
"""A gradient below this is 0 at the drawing; it has no scale."""

NEAR = 100.0
"""Largest coordinate, in sizes of the mechanism, of the place where gradients give the scale of equations."""

Equations = Callable[[FloatArray, IntArray], tuple[FloatArray, FloatArray]]
"""Returns residuals (rows, m) and their derivatives (rows, m, n) at x (rows, n), for rows with numbers (rows,)."""


class System:
    """The equations (m,) of a mechanism in its unknowns (n,): x and y of a moving node side by side."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._at_rest = mechanism.drawn.copy()
        frame = mechanism.members[0]
        self._at_rest[list(frame.nodes)] = frame.shape
        self.followers = [coupling.follower for coupling in mechanism.couplings if coupling.reads]
        terms = linked_terms(mechanism.nearby)
        first, count = terms.first_reading, len(mechanism.actuators)
        unknown = [*terms.moving, *(first + k for k in (*self.followers, *range(count, terms.readings)))]
        given = [-1 if k in self.followers else first + k for k in range(count)]  # -1: none
        self.free = [variable // terms.dimension for variable in terms.moving[:: terms.dimension]]
        self.n, self.m, self.coordinated = len(unknown), len(terms.equations), len(terms.moving)
        self._unknown = unknown
        self._terms, self._arrays = terms, TermArrays(terms.equations, first, [*unknown, *given, terms.variables - 1])
        self.scale = self._scale()
        self._arrays.scale(self.scale, ZERO, self.n)

    def coordinates(self, z: ComplexArray, inputs: FloatArray | None = None) -> FloatArray:
        """Return the unknowns x (n,) of positions z (nodes,) at inputs (actuators,), by default those as drawn."""
        values = self.mechanism.drawn_inputs if inputs is None else inputs
        return variables_at(self._terms, self.mechanism.near(z), values)[self._unknown]

    def following(self, x: FloatArray) -> FloatArray:
        """Return the inputs that follow the linkage (..., followers), or their rates, of x (..., n)."""
        return x[..., self.coordinated :][..., : len(self.followers)]

    def nodes(self, x: FloatArray) -> ComplexArray:
        """Return the positions (nodes,) of x (n,), or (nodes, rows) of x (n, rows)."""
        rows = 1 if x.ndim == 1 else x.shape[1]
        z = self.placed(np.repeat(self._at_rest[:, None], rows, axis=1), x.reshape(self.n, -1))
        return z[:, 0] if x.ndim == 1 else z

    def placed(self, z: ComplexArray, x: FloatArray) -> ComplexArray:
        """Return positions z (nodes, ...) of the fixed nodes with those of x (n, ...), or the rates of all nodes."""
        z[self.free] = places(x[: self.coordinated].T).T
        return self.mechanism.whole(z)

    def residual(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return F (..., m) at x (..., n) and inputs u (..., actuators)."""
        return self._arrays.values(_joined(x, u, 1.0))

    def jacobian(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return F_x (..., m, n)."""
        return self.jacobians(x, u)[..., : self.n]

    def jacobians(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return [F_x F_u] (..., m, n + actuators)."""
        return self._arrays.slopes(_joined(x, u, 1.0))[..., :-1]

    def linearised(self, x: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return F (..., m) and [F_x F_u] (..., m, n + actuators)."""
        value, table = self._arrays.linearised(_joined(x, u, 1.0))
        return value, table[..., :-1]

    def along_inputs(self, x: FloatArray, u: FloatArray, rate: FloatArray) -> FloatArray:
        """Return F_u rate (..., m) for rates of the inputs (..., actuators)."""
        return np.asarray((self.jacobians(x, u)[..., self.n :] @ rate[..., None])[..., 0])

    def second(self, x: FloatArray, u: FloatArray, v: FloatArray, w: FloatArray) -> FloatArray:
        """Return the second derivative of F (..., m) along v and w (..., n + actuators)."""
        return np.asarray((self.jacobian_along(x, u, v) @ w[..., None])[..., 0])

    def jacobian_along(self, x: FloatArray, u: FloatArray, v: FloatArray) -> FloatArray:
        """Return the derivative of [F_x F_u] (..., m, n + actuators) along v (..., n + actuators)."""
        return self._arrays.slopes_along(_joined(x, u, 1.0), self._direction(v))[..., :-1]

    def third(self, x: FloatArray, u: FloatArray, v: FloatArray) -> FloatArray:
        """Return the third derivative of F (..., m) along v (..., n + actuators), taken three times."""
        return self._arrays.third(_joined(x, u, 1.0), self._direction(v))

    def derivatives(self, x: FloatArray, rates: FloatArray) -> FloatArray:
        """Return the derivatives of x (orders, ..., n) by a parameter, x itself first; at most three.

        rates: the inputs and their derivatives by the parameter (orders, ..., actuators), the values first.
        """
        u, found = rates[0], [x]
        jacobians = self.jacobians(x, u)
        inverse = np.linalg.pinv(jacobians[..., : self.n])
        for order in range(1, len(rates)):
            right = (jacobians[..., self.n :] @ rates[order][..., None])[..., 0]
            along = [np.concatenate([own, rate], axis=-1) for own, rate in zip(found[1:], rates[1:], strict=False)]
            if order > 1:
                right = right + (1.0, 3.0)[order - 2] * self.second(x, u, along[0], along[-1])
            if order > 2:
                right = right + self.third(x, u, along[0])
            found.append(-(inverse @ right[..., None])[..., 0])
        return np.array(found)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The member, sliding pair, actuator or follower of each equation (m,)."""
        mechanism = self.mechanism
        members = [m.name for m in mechanism.members[1:] for _ in range(2 * len(m.nodes) - 2 * len(m.carried) - 3)]
        actuators = self._terms.mechanism.actuators
        followers = (mechanism.actuators[k].name for k in self.followers)
        return (*members, *(row.pair for row in mechanism.pairs), *(a.name for a in actuators), *followers)

    def quadric(self, u: FloatArray) -> Quadric:
        """Return the equations for constant inputs (actuators,); those of the actuators are the last ones."""
        n, arrays = self.n, self._arrays
        pair = (arrays.row * (n + 1) + np.minimum(arrays.first, n)) * (n + 1) + np.minimum(arrays.second, n)
        parts = arrays.parts(_joined(np.ones(n), u, 1.0))
        half = np.bincount(pair, parts, self.m * (n + 1) ** 2).astype(float).reshape(self.m, n + 1, n + 1)
        whole = half + half.swapaxes(1, 2)  # of pairs of unknowns, after which 1 stands
        return Quadric(0.5 * whole[:, n, n], whole[:, :n, n].copy(), whole[:, :n, :n].copy())

    def equations_at(self, u: FloatArray) -> Equations:
        """Return a function of positions (rows, n) that returns residuals and Jacobians.

        u: inputs (actuators,) of all rows, or (rows, actuators).
        """
        if u.ndim > 1:
            return lambda x, k: (self.residual(x, u[k]), self.jacobian(x, u[k]))
        if self.followers:
            return lambda x, _: (self.residual(x, u), self.jacobian(x, u))
        form = self.quadric(u)
        return lambda x, _: (form.value(x), form.slope(x))

    def _direction(self, v: FloatArray) -> FloatArray:
        """Return a direction (..., columns) of v (..., n + actuators)."""
        return _joined(v[..., : self.n], v[..., self.n :], 0.0)

    def _scale(self) -> FloatArray:
        """Return the factors (m,), powers of 2, by which the gradients at the drawing have lengths of about 1."""
        mechanism = self.mechanism
        near = np.clip(self.coordinates(mechanism.drawn), -NEAR, NEAR)  # a mistyped node may be drawn far away
        lengths = np.linalg.norm(self.jacobian(near, mechanism.drawn_inputs), axis=1)
        return np.asarray(np.exp2(-np.round(np.log2(np.where(lengths > SMALL, lengths, 1.0)))))


def _joined(x: FloatArray, u: FloatArray, one: float) -> FloatArray:
    """Return the variables (..., columns) of x (..., n) and u (..., actuators); `one` is the last of them."""
    n, count = x.shape[-1], u.shape[-1]
    v = np.empty((*x.shape[:-1], n + count + 1))
    v[..., :n], v[..., n:-1], v[..., -1] = x, u, one
    return v


@derived
def system_of(mechanism: Mechanism) -> System:
    """Return the equations of a mechanism."""
    return System(mechanism)
