"""The equations F(x, u) = 0 of a mechanism, of second degree in the coordinates x of its moving nodes.

F is a sum of polynomials c + L x + x Q x / 2, each multiplied by a function of an input u: 1, u, u^2, cos u or sin u.
The Jacobian is therefore linear in x and the second derivatives are constant; continuation and bifurcation analysis
use both.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.polynomials import ONE, SINE, SQUARE, Terms, make_terms
from gimcli.structure.quadric import Quadric

ZERO = 1e-13
"""A coefficient below this is a rounding error of 0; gradients have lengths of about 1."""

SMALL = 1e-9
"""A gradient below this is 0 at the drawing; it has no scale."""

NEAR = 100.0
"""Largest coordinate, in sizes of the mechanism, of the place where gradients give the scale of equations."""

Part = tuple[int, FloatArray, FloatArray, FloatArray]
"""Actuator (-1: none), and c (m,), L (m, n), Q (m n, n) of the polynomials for one function of its input."""


class System:
    """The equations (m,) of a mechanism in the coordinates (n,) of its moving nodes, x and y of a node side by side."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._at_rest = mechanism.drawn.copy()
        frame = mechanism.members[0]
        self._at_rest[list(frame.nodes)] = frame.shape
        terms = make_terms(mechanism.nearby)
        self.free = [variable // 2 for variable in terms.moving[::2]]
        self.n = len(terms.moving)
        self.m = len(terms.equations)
        self._parts = self._polynomials(terms)
        self.scale = self._scale()
        self._parts = [self._scaled(*part) for part in self._parts]

    def coordinates(self, z: ComplexArray) -> FloatArray:
        """Return the coordinates x (n,) of positions z (nodes,)."""
        return np.ascontiguousarray(self.mechanism.near(z)[self.free]).view(float).copy()

    def nodes(self, x: FloatArray) -> ComplexArray:
        """Return the positions (nodes,) of x (n,), or (nodes, rows) of x (n, rows)."""
        rows = 1 if x.ndim == 1 else x.shape[1]
        z = self.placed(np.repeat(self._at_rest[:, None], rows, axis=1), x.reshape(self.n, -1))
        return z[:, 0] if x.ndim == 1 else z

    def placed(self, z: ComplexArray, x: FloatArray) -> ComplexArray:
        """Return positions z (nodes, ...) of the fixed nodes with those of x (n, ...), or the rates of all nodes."""
        z[self.free] = x[0::2] + 1j * x[1::2]
        return self.mechanism.whole(z)

    def residual(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return F (m,) at x (n,) and inputs u (actuators,)."""
        return self._polynomial(x, self._values(u, 0))

    def jacobian(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return F_x (m, n)."""
        return self._slope(x, self._values(u, 0))

    def along_inputs(self, x: FloatArray, u: FloatArray, rate: FloatArray) -> FloatArray:
        """Return F_u rate (m,) for rates of the inputs (actuators,)."""
        own = np.append(rate, 0.0)[self._owner]  # 0 for the constant part, whose owner is -1
        return self._polynomial(x, self._values(u, 1) * own)

    def second(self, x: FloatArray, u: FloatArray, v: FloatArray, w: FloatArray) -> FloatArray:
        """Return the second derivative of F (m,) along v and w (n + actuators,)."""
        n = self.n
        first, curve = self._values(u, 1), self._values(u, 2)
        mixed = np.zeros(self.m)
        for k in range(len(u)):
            own = self._owner == k
            mixed += w[n + k] * self._slope(x, np.where(own, first, 0.0)) @ v[:n]
            mixed += v[n + k] * self._slope(x, np.where(own, first, 0.0)) @ w[:n]
            mixed += v[n + k] * w[n + k] * self._polynomial(x, np.where(own, curve, 0.0))
        values = self._values(u, 0)
        return mixed + sum(value * ((q @ w[:n]).reshape(self.m, n) @ v[:n]) for value, q in self._curved(values))

    def jacobian_along(self, x: FloatArray, u: FloatArray, v: FloatArray) -> FloatArray:
        """Return the derivative of [F_x F_u] (m, n + actuators) along v (n + actuators,)."""
        n = self.n
        first, curve, values = self._values(u, 1), self._values(u, 2), self._values(u, 0)
        table = np.zeros((self.m, n + len(u)))
        for value, q in self._curved(values):
            table[:, :n] += value * (q @ v[:n]).reshape(self.m, n)
        for k in range(len(u)):
            own = self._owner == k
            slope = self._slope(x, np.where(own, first, 0.0))
            table[:, :n] += v[n + k] * slope
            table[:, n + k] = slope @ v[:n] + v[n + k] * self._polynomial(x, np.where(own, curve, 0.0))
        return table

    def third(self, x: FloatArray, u: FloatArray, v: FloatArray) -> FloatArray:
        """Return the third derivative of F (m,) along v (n + actuators,), taken three times."""
        along, total = v[: self.n], np.zeros(self.m)
        orders = [self._values(u, order) for order in range(4)]
        for k, rate in enumerate(v[self.n :].tolist()):
            first, second, third = (np.where(self._owner == k, values, 0.0) for values in orders[1:])
            total += rate**3 * self._polynomial(x, third) + 3.0 * rate**2 * self._slope(x, second) @ along
            for value, q in self._curved(first):
                total += 3.0 * rate * value * (q @ along).reshape(self.m, self.n) @ along
        return total

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The member, sliding pair or actuator of each equation (m,)."""
        mechanism = self.mechanism
        members = [m.name for m in mechanism.members[1:] for _ in range(2 * len(m.nodes) - 2 * len(m.carried) - 3)]
        return (*members, *(row.pair for row in mechanism.pairs), *(a.name for a in mechanism.actuators))

    def quadric(self, u: FloatArray) -> Quadric:
        """Return the equations for constant inputs (actuators,); those of the actuators are the last ones."""
        values, n = self._values(u, 0), self.n
        c, linear = (np.asarray(sum(v * part[k] for v, (part, _) in self._active(values))) for k in (1, 2))
        q = sum((v * part for v, part in self._curved(values)), start=np.zeros((self.m * n, n)))
        return Quadric(c, linear, q.reshape(self.m, n, n))

    def _polynomial(self, x: FloatArray, values: FloatArray) -> FloatArray:
        total = np.zeros(self.m)
        for value, ((_, c, linear, q), curved) in self._active(values):
            slope = linear + 0.5 * (q @ x).reshape(self.m, self.n) if curved else linear
            total += value * (c + slope @ x)
        return total

    def _slope(self, x: FloatArray, values: FloatArray) -> FloatArray:
        total = np.zeros((self.m, self.n))
        for value, ((_, _, linear, q), curved) in self._active(values):
            total += value * (linear + (q @ x).reshape(self.m, self.n) if curved else linear)
        return total

    def _active(self, values: FloatArray) -> Iterator[tuple[float, tuple[Part, bool]]]:
        """Yield value, part and whether it is of second degree, of the parts whose function of the inputs is not 0."""
        for value, part, curved in zip(values.tolist(), self._parts, self._is_curved, strict=True):
            if value != 0.0:
                yield value, (part, curved)

    def _curved(self, values: FloatArray) -> Iterator[tuple[float, FloatArray]]:
        """Yield the functions of the inputs and Q of the parts of second degree."""
        return ((value, part[3]) for value, (part, curved) in self._active(values) if curved)

    @cached_property
    def _is_curved(self) -> list[bool]:
        """Whether each part is of second degree; most parts that depend on an input are linear."""
        return [bool(part[3].any()) for part in self._parts]

    @cached_property
    def _owner(self) -> FloatArray:
        """Actuator of every part; -1 for the constant part."""
        return np.array([part[0] for part in self._parts])

    def _values(self, u: FloatArray, order: int) -> FloatArray:
        """Return the functions of the inputs for all parts, or their derivatives of some order by their own input."""
        values = [1.0 if order == 0 else 0.0]
        for k, actuator in enumerate(self.mechanism.actuators):
            if actuator.rotary:
                values += [np.cos(u[k] + order * np.pi / 2), np.sin(u[k] + order * np.pi / 2)]
            else:
                values += [(u[k], 1.0, 0.0, 0.0)[order], (u[k] ** 2, 2.0 * u[k], 2.0, 0.0)[order]]
        return np.array(values, dtype=float)

    def _polynomials(self, terms: Terms) -> list[Part]:
        """Return all parts: the constant one, then two for each input (u and u^2, or cos u and sin u)."""
        m, n, column = self.m, self.n, {variable: k for k, variable in enumerate(terms.moving)}
        owners = [-1, *(k for k in range(terms.readings) for _ in (0, 1))]
        tables = [(np.zeros(m), np.zeros((m, n)), np.zeros((m, n, n))) for _ in owners]
        for row, equation in enumerate(terms.equations):
            for term in equation:
                c, linear, q = tables[_part_of(term.function)]
                at = [column[variable] for variable in (term.first, term.second) if variable in column]
                if len(at) == 2:
                    q[row, at[0], at[1]] += term.factor
                    q[row, at[1], at[0]] += term.factor
                elif at:
                    linear[row, at[0]] += term.factor
                else:
                    c[row] += term.factor
        return [(k, c, linear, q.reshape(-1, n)) for k, (c, linear, q) in zip(owners, tables, strict=True)]

    def _scale(self) -> FloatArray:
        """Return the factors (m,), powers of 2, by which the gradients at the drawing have lengths of about 1."""
        mechanism = self.mechanism
        near = np.clip(self.coordinates(mechanism.drawn), -NEAR, NEAR)  # a mistyped node may be drawn far away
        lengths = np.linalg.norm(self.jacobian(near, mechanism.drawn_inputs), axis=1)
        return np.asarray(np.exp2(-np.round(np.log2(np.where(lengths > SMALL, lengths, 1.0)))))

    def _scaled(self, owner: int, c: FloatArray, linear: FloatArray, q: FloatArray) -> Part:
        linear, q = linear * self.scale[:, None], q * np.repeat(self.scale, self.n)[:, None]
        linear[np.abs(linear) < ZERO], q[np.abs(q) < ZERO] = 0.0, 0.0
        return owner, c * self.scale, linear, q


def _part_of(function: int) -> int:
    """Return the number of the part for a function of `Terms`: 0 for 1, then u or cos u, u^2 or sin u of each input."""
    reading, which = divmod(function - 1, 4)
    return 0 if function == ONE else 1 + 2 * reading + (which + 1 in (SQUARE, SINE))


@derived
def system_of(mechanism: Mechanism) -> System:
    """Return the equations of a mechanism."""
    return System(mechanism)
