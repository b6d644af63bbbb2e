"""True errors: distances of positions from positions that are refined to 40 digits.

A converged position is refined by Newton-Raphson on the constraints as written, with residuals in high precision
and the Jacobian in double precision. Each step adds about 16 digits, less those lost to the condition of the
Jacobian. The dimensions and inputs are the doubles that all methods use. Only this module imports mpmath.

The equations of members, pairs and inputs are written here without the terms of the analyses, for double and high
precision. Because they are of second degree, central differences of any width give their exact Jacobian.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gimcli.continuation.gauss_newton import settle
from gimcli.mechanism import FRAME, HEIGHT, SPAN, BoolArray, ComplexArray, FloatArray, Mechanism, PairRow
from gimcli.structure.carried import carried_point
from gimcli.structure.kinematic_nodes import moving_nodes
from gimcli.structure.system import system_of


@dataclass(frozen=True)
class Precision:
    """Constants of the refinement."""

    digits: int = 40
    steps: int = 40  # Newton-Raphson steps, at most
    converged: float = 1e-30  # last correction, relative to the size
    rank: float = 1e-9  # smallest over largest singular value, below which the position is singular
    near: float = 1e-6  # largest distance between the given and the refined position, relative to the size
    same: float = 1e-6  # distance, relative to the size, below which two positions are on the same branch


PRECISION = Precision()


@dataclass(frozen=True)
class Truth:
    """True positions of the traced points, with twice the digits of a double, in the rows in which they are known."""

    mechanism: Mechanism = field(repr=False)
    inputs: FloatArray = field(repr=False)  # (actuators, rows)
    z: ComplexArray = field(repr=False)  # (nodes, rows) nodes, rounded to doubles
    points: ComplexArray = field(repr=False)  # (traced, rows) rounded to doubles
    rest: ComplexArray = field(repr=False)  # (traced, rows) rounding error of `points`
    known: BoolArray  # (rows,) rows with a true position

    def errors(self, z: ComplexArray) -> FloatArray:
        """Return the largest error (rows,) of the traced points at positions z (nodes, rows), relative to the size."""
        with np.errstate(all="ignore"):
            traced = np.array([carried_point(self.mechanism, name, z) for name in self.mechanism.traced])
            return np.asarray(np.max(np.abs(traced - self.points - self.rest), axis=0) / self.mechanism.size)

    def same_branch(self, z: ComplexArray, error: FloatArray) -> BoolArray:
        """Return for positions z (nodes, rows) with errors (rows,) whether they are on the branch of the motion.

        A position with a large error belongs to the branch to which Newton-Raphson converges from it.
        """
        same = np.asarray(error <= PRECISION.same)
        rough = np.flatnonzero(~same & self.known & np.all(np.isfinite(z), axis=0))
        if len(rough):
            there = polished(self.mechanism, z[:, rough], self.inputs[:, rough])
            apart = np.max(np.abs(there - self.z[:, rough]), axis=0)
            same[rough] = apart <= PRECISION.same * self.mechanism.size
        return same


def polished(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> ComplexArray:
    """Return the positions to which Newton's method converges from z (nodes, rows); NaN where it does not."""
    system = system_of(mechanism)
    starts = [system.coordinates(*pair) for pair in zip(z.T, inputs.T, strict=True)]
    x, good = settle(system.equations_at(inputs.T), np.reshape(starts, (-1, system.n)))
    return np.where(good, system.nodes(x.T), complex(np.nan, np.nan))


def refine(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, good: BoolArray) -> Truth:
    """Refine the positions z (nodes, rows) of the rows marked in `good` (rows,) at inputs (actuators, rows)."""
    import mpmath

    rows = np.flatnonzero(good)
    close = polished(mechanism, z[:, rows], inputs[:, rows])
    nodes = np.full(z.shape, complex(np.nan, np.nan))
    points = np.full((len(mechanism.traced), z.shape[1]), complex(np.nan, np.nan))
    rest, known = points.copy(), np.zeros(z.shape[1], dtype=bool)
    with mpmath.workdps(PRECISION.digits):
        for k, row in enumerate(rows):
            fine = _refined(mechanism, close[:, k], inputs[:, row])
            if fine is None or np.max(np.abs(_rounded(fine) - z[:, row])) > PRECISION.near * mechanism.size:
                continue
            traced = np.array([_point(mechanism, name, fine) for name in mechanism.traced], dtype=object)
            nodes[:, row], points[:, row], known[row] = _rounded(fine), _rounded(traced), True
            rest[:, row] = _rounded(traced - np.array([_exact(p) for p in points[:, row]], dtype=object))
    return Truth(mechanism, inputs, nodes, points, rest, known)


def _refined(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> Any:
    """Return one position (nodes,) in high precision; None if it is singular or does not converge."""
    import mpmath

    if not np.all(np.isfinite(z)):
        return None
    system = Constraints(mechanism)
    u, s, v = np.linalg.svd(system.jacobian(z[:, None], inputs[:, None])[0], full_matrices=False)
    if len(s) and not s[-1] > PRECISION.rank * s[0]:
        return None
    inverse = (v.T / s) @ u.T if len(s) else np.zeros((0, u.shape[0]))
    fine = np.array([_exact(p) for p in z], dtype=object)
    values = [mpmath.mpf(float(value)) for value in inputs]
    turns = [mpmath.expj(value) for value in values]
    for _ in range(PRECISION.steps):
        residual = []
        for part, value in system.equations(fine, values, turns, _exact):
            residual += [value.real] * (part != "imag") + [value.imag] * (part != "real")
        scale = max((abs(r) for r in residual), default=mpmath.mpf(0))
        if scale == 0:
            return fine
        change = inverse @ np.array([float(r / scale) for r in residual])  # scaled: too small for doubles
        steps = change[0::2] + 1j * change[1::2]
        fine[system.free] -= np.array([_exact(c) * scale for c in steps], dtype=object)
        if float(scale) * float(np.max(np.abs(change), initial=0.0)) <= PRECISION.converged * mechanism.size:
            return fine
    return None


def _exact(z: complex) -> Any:
    import mpmath

    return mpmath.mpc(complex(z))


def _rounded(z: Any) -> ComplexArray:
    return np.array([complex(p) for p in z], dtype=np.complex128)


def _point(mechanism: Mechanism, name: str, z: Any) -> Any:
    """Return a node or a coupler point of a position in high precision."""
    if name in mechanism.nodes:
        return z[mechanism.nodes.index(name)]
    point = next(p for p in mechanism.points if p.name == name)
    member = mechanism.members[point.member]
    if point.member == FRAME:
        return _exact(point.local)
    far = int(np.argmax(np.abs(member.shape - member.shape[0])))
    first = member.nodes[0]
    ratio = (_exact(point.local) - _exact(member.shape[0])) / (_exact(member.shape[far]) - _exact(member.shape[0]))
    return z[first] + ratio * (z[member.nodes[far]] - z[first])


class Constraints:
    """The equations of a mechanism in the coordinates of its moving nodes."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.free = list(moving_nodes(mechanism))

    def equations(self, z: Any, inputs: Any, turns: Any, exact: Any = complex) -> Iterator[tuple[str, Any]]:
        """Yield each equation (rows,), after the part of it that must be zero: "real", "imag" or "both".

        Numbers are complex doubles or of mpmath. z: positions (nodes, rows). inputs: (actuators, rows). turns: exp(i
        inputs). exact: converts a double to the precision of z.
        """
        for member in self.mechanism.members[FRAME + 1 :]:
            (u, v, _), first, far = member.ends, exact(member.shape[0]), exact(member.shape[member.base])
            arm, reach = z[v] - z[u], far - first
            yield "real", (arm * arm.conjugate() - reach * reach.conjugate()) / member.stretch**2
            for k, node in enumerate(member.nodes):
                if node not in (u, v) and node not in member.carried:
                    yield "both", z[node] - z[u] - (exact(member.shape[k]) - first) / reach * arm
        for row in self.mechanism.pairs:
            yield self.quantity(row, z, exact, 0.0, 1.0)
        for row, value, turn in zip(self.mechanism.actuators, inputs, turns, strict=True):
            yield self.quantity(row, z, exact, value, turn)

    def quantity(self, row: PairRow, z: Any, exact: Any, value: Any, turn: Any) -> tuple[str, Any]:
        """Return the equation of a pair or an actuator: its quantity minus the value."""
        if row.kind == SPAN:
            first, second = row.nodes
            arm = z[second] - z[first]
            return "real", arm * arm.conjugate() - value * value
        if row.kind == HEIGHT:
            place = self._in_guide(row.node, row.guide, row.point, z, exact)
            return "real", place * exact(row.normal).conjugate() - value
        arm, reference = (self._rotation(k, z, exact) for k in row.members)
        arm, reference = arm * exact(row.arm), reference * exact(row.reference)
        return "imag", arm * (reference * turn).conjugate()

    def residual(self, z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return the residuals of the equations (equations, rows) in double precision."""
        rows = []
        for part, value in self.equations(z, inputs + 0.0j, np.exp(1j * inputs)):
            rows += [value.real] * (part != "imag") + [value.imag] * (part != "real")
        return np.array(rows).reshape(len(rows), z.shape[1])

    def jacobian(self, z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return their derivatives (rows, equations, 2 x moving nodes), x and y of a node side by side."""
        columns = []
        for node in self.free:
            for step in (1.0, 1.0j):  # any width: the third derivatives are zero
                ahead, behind = z.copy(), z.copy()
                ahead[node] += step
                behind[node] -= step
                columns.append(0.5 * (self.residual(ahead, inputs) - self.residual(behind, inputs)))
        return np.moveaxis(np.array(columns), (0, 1, 2), (2, 1, 0))

    def _rotation(self, index: int, z: Any, exact: Any) -> Any:
        """Return e^(i phi) of a member as a linear function of two of its nodes."""
        member = self.mechanism.members[index]
        if index == FRAME:
            return exact(1.0)
        u, v, _ = member.ends
        return (z[v] - z[u]) / (exact(member.shape[member.base]) - exact(member.shape[0]))

    def _in_guide(self, node: int, index: int, point: complex, z: Any, exact: Any) -> Any:
        """Return the position of a node relative to a point of a member, in the member's own frame."""
        member = self.mechanism.members[index]
        if index == FRAME:
            return z[node] - exact(point)
        rotation = self._rotation(index, z, exact)
        origin = z[member.nodes[0]] - rotation * exact(member.shape[0])
        return (z[node] - origin - rotation * exact(point)) * rotation.conjugate()
