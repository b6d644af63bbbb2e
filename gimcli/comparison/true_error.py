"""True errors: distances of positions from positions that are refined to 40 digits.

A converged position is refined by Newton-Raphson on the constraints as written, with residuals in high precision
and the Jacobian in double precision. Each step adds about 16 digits, less those lost to the condition of the
Jacobian. The dimensions and inputs are the doubles that all methods use. Only this module imports mpmath.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gimcli.comparison.exact_equations import Constraints
from gimcli.mechanism import FRAME, BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.structure.carried import carried_point

Flags = BoolArray


@dataclass(frozen=True)
class Precision:
    """Constants of the refinement."""

    digits: int = 40
    steps: int = 40  # Newton-Raphson steps, at most
    converged: float = 1e-30  # last correction, relative to the size
    rank: float = 1e-9  # smallest over largest singular value, below which the position is singular
    near: float = 1e-6  # largest distance between the given and the refined position, relative to the size
    polish: int = 30  # Newton-Raphson steps in double precision, at most
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
    known: Flags  # (rows,) rows with a true position

    def errors(self, z: ComplexArray) -> FloatArray:
        """Return the largest error (rows,) of the traced points at positions z (nodes, rows), relative to the size."""
        with np.errstate(all="ignore"):
            traced = np.array([carried_point(self.mechanism, name, z) for name in self.mechanism.traced])
            return np.asarray(np.max(np.abs(traced - self.points - self.rest), axis=0) / self.mechanism.size)

    def same_branch(self, z: ComplexArray, error: FloatArray) -> Flags:
        """Return for positions z (nodes, rows) with errors (rows,) whether they are on the branch of the motion.

        A position with a large error belongs to the branch to which Newton-Raphson converges from it.
        """
        same = np.asarray(error <= PRECISION.same)
        rough = np.flatnonzero(~same & self.known & np.all(np.isfinite(z), axis=0))
        if len(rough):
            there = polished(self.mechanism, z[:, rough], self.inputs[:, rough], PRECISION.polish)
            apart = np.max(np.abs(there - self.z[:, rough]), axis=0)
            same[rough] = apart <= PRECISION.same * self.mechanism.size
        return same


def polished(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, steps: int) -> ComplexArray:
    """Return the positions to which Newton-Raphson converges from z (nodes, rows); NaN where it diverges."""
    system, z = Constraints(mechanism), z.copy()
    with np.errstate(all="ignore"):
        for _ in range(steps):
            jacobian, residual = system.jacobian(z, inputs), system.residual(z, inputs)
            fine = np.all(np.isfinite(jacobian), axis=(1, 2)) & np.all(np.isfinite(residual), axis=0)
            z[:, ~fine] = complex(np.nan, np.nan)
            if not fine.any():
                break
            inverse = np.linalg.pinv(jacobian[fine])
            change = (inverse @ residual.T[fine][:, :, None])[:, :, 0]
            z[np.ix_(np.array(system.free, dtype=np.int64), np.flatnonzero(fine))] -= (
                change[:, 0::2] + 1j * change[:, 1::2]
            ).T
            if np.max(np.abs(change)) <= 4.0 * np.finfo(float).eps * mechanism.size:
                break
    return z


def refine(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, good: Flags) -> Truth:
    """Refine the positions z (nodes, rows) of the rows marked in `good` (rows,) at inputs (actuators, rows)."""
    import mpmath

    rows = np.flatnonzero(good)
    close = polished(mechanism, z[:, rows], inputs[:, rows], PRECISION.polish)
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
