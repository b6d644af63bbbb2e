"""The Krawczyk test on boxes, with the exact remainder of planar loops.

With Y = J^-1 at the middle of a box, and δ, σ the deviations of angles and slides, the loops are exactly

    Y f = Y f_m + Σ_c [(YJ)_c sin δ_c + H_c (cos δ_c - 1)] + Σ_q σ_q [(YJ)_q cos δ_r + B_q sin δ_r]

(r the rail of the slide, H = Y of the columns' own terms, B_q = Y of i times the slide's column). No series is
truncated, and H keeps the cancellation between the loops, which a bound |C| r of the change of the Jacobian would
lose. Rounding: each product is widened by a few eps times the same product of moduli. Y may be any matrix.
Source: Krawczyk 1969; Moore 1977 for existence and uniqueness in one test: |Yf| + |I - YJ(box)| r < r.
Boxes are along the first axis: middles (B, d), half-widths (B, d).

Proved solutions: refined, without duplicates, each with the largest known box without another solution.

Two proofs are of the same solution if the enclosure of one is inside the unique box of the other. A pair that can
neither be identified nor separated is undecided and not counted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.assemblies.cosine_rows import EPS
from gimcli.assemblies.loops import GROUND, Coefficients
from gimcli.canonical import TURN
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray


@dataclass(frozen=True)
class KrawczykConstants:
    """Constants for rounding and conditioning."""

    rounding: float = 3 * EPS  # per operation of a sum of products
    few: int = 8  # additional operations: cosines, complex products
    nudge: float = 1e-12  # perturbation relative to the Jacobian's norm that makes a singular one invertible
    widen: float = 1 + 16 * EPS  # factor of half-widths, so that middle and half-width cover the box
    narrowed: float = 8 * EPS  # relative rounding of computed bounds


CONSTANTS = KrawczykConstants()


@dataclass(frozen=True, eq=False)
class Local:
    """The preconditioned loops at the middles of B boxes."""

    value: FloatArray  # (B, d) Y f
    error: FloatArray  # (B, d) rounding of `value`
    J: FloatArray  # (B, d, d) Y J
    H: FloatArray  # (B, d, n) Y times the columns of the angles
    B: FloatArray  # (B, d, q) Y times i times the columns of the slides; zero for rails on the frame
    rounding: FloatArray  # (B, d, d) rounding of J, H and B
    carrier: IntArray  # (q,) angle of each slide's rail, n for the frame


def local(loops: Coefficients, x: FloatArray) -> Local:
    """Return the preconditioned loops (multiplied by Y) at points (B, d)."""
    n, carrier = loops.C.shape[1], np.where(loops.rail == GROUND, loops.C.shape[1], loops.rail)
    theta = np.concatenate([np.exp(1j * x[:, :n]), np.ones((len(x), 1))], axis=1)
    own = loops.C * theta[:, None, :n]
    along = loops.U * theta[:, None, carrier]
    parts = along * x[:, None, n:]
    turned = _carried(own, parts, carrier)
    jacobian = np.concatenate([1j * turned, along], axis=2)
    Y = _inverse(jacobian)
    f = loops.C0 + own.sum(axis=2) + parts.sum(axis=2)
    moduli = np.abs(loops.C0) + np.abs(own).sum(axis=2) + np.abs(parts).sum(axis=2)
    rounding = CONSTANTS.rounding * (3 * len(loops.C0) + CONSTANTS.few)
    columns = np.concatenate([_carried(np.abs(own), np.abs(parts), carrier), np.abs(along)], axis=2)
    return Local(
        _real(Y, f[:, :, None])[:, :, 0],
        rounding * (np.abs(Y) @ moduli[:, :, None])[:, :, 0],
        _real(Y, jacobian),
        _real(Y, turned),
        _real(Y, 1j * along) * (loops.rail != GROUND),
        rounding * (np.abs(Y) @ columns),
        carrier,
    )


def _carried(own: ComplexArray, parts: ComplexArray, carrier: IntArray) -> ComplexArray:
    """Return the terms of every angle (B, L, n), including slides on its rails."""
    total = own.copy()
    for slide, angle in enumerate(carrier):
        if angle < own.shape[2]:
            total[:, :, angle] += parts[:, :, slide]
    return total


def _inverse(jacobian: ComplexArray) -> ComplexArray:
    """Return Y (B, d, L) with Re(Y z) the inverse of the real Jacobian applied to complex loops z."""
    loops = jacobian.shape[1]
    real = np.concatenate([jacobian.real, jacobian.imag], axis=1)
    d = real.shape[1]
    norm = np.abs(real).max(axis=(1, 2), initial=0.0)[:, None, None]
    fixed = np.cos(np.arange(d * d, dtype=float) ** 2).reshape(d, d)  # an arbitrary matrix without structure
    nudged = real + CONSTANTS.nudge * (norm + (norm == 0.0)) * fixed
    try:
        inverse = np.linalg.inv(nudged)
    except np.linalg.LinAlgError:  # a matrix of the batch is singular nevertheless
        inverse = np.linalg.pinv(nudged)
    return np.asarray(inverse[:, :, :loops] - 1j * inverse[:, :, loops:])


def _real(Y: ComplexArray, z: ComplexArray) -> FloatArray:
    return np.asarray((Y @ z).real)


def narrow(at: Local, middle: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return bounds (B, d) of all solutions in boxes no wider than half a turn; low > high if there are none."""
    n = at.H.shape[2]
    r = half * CONSTANTS.widen
    sine, versine = _sines(r, n)
    swing = at.H * versine[:, None, :n]
    centre = 0.5 * swing.sum(axis=2) - at.value
    spread = at.error + 0.5 * np.abs(swing).sum(axis=2) + _product(at.rounding, 3.0 * r)
    off = np.abs(at.J - np.eye(len(middle[0])))
    spread += _product(off[:, :, :n], sine[:, :n]) + _product(off[:, :, n:], r[:, n:])
    turned = np.abs(at.J[:, :, n:]) * versine[:, None, at.carrier] + np.abs(at.B) * sine[:, None, at.carrier]
    spread += _product(turned, r[:, n:])
    spread += CONSTANTS.narrowed * (spread + np.abs(centre))
    low, high = centre - spread, centre + spread
    low[:, :n], high[:, :n] = _arcsine(low[:, :n]), _arcsine(high[:, :n])
    margin = CONSTANTS.narrowed * (np.abs(middle) + r)
    return (
        np.fmax(middle - half, middle + low - margin),
        np.fmin(middle + half, middle + high + margin),
    )


def _arcsine(value: FloatArray) -> FloatArray:
    """Return the angles in [-pi/2, pi/2] of sines; infinite for values beyond -1 or 1."""
    angle = np.arcsin(np.clip(value, -1.0, 1.0))
    return np.where(value < -1.0, -np.inf, np.where(value > 1.0, np.inf, angle))


def _sines(r: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Return bounds of |sin δ| and 1 - cos δ of the angles, and zeros for the frame; (B, n + 1)."""
    still = np.zeros((len(r), 1))
    sine = np.concatenate([np.sin(np.minimum(r[:, :n], 0.5 * np.pi)), still], axis=1)
    versine = np.concatenate([2.0 * np.sin(0.5 * np.minimum(r[:, :n], np.pi)) ** 2, still], axis=1)
    return sine * CONSTANTS.widen, versine * CONSTANTS.widen


def _product(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    return np.asarray((matrix @ vector[:, :, None])[:, :, 0])


def image(at: Local, half: FloatArray) -> FloatArray:
    """Return the half-widths (B, d) of the Krawczyk image about the middles of boxes.

    If all are less than those of the box, the box contains exactly one solution, and it is inside the image.
    """
    n = at.H.shape[2]
    r = half * CONSTANTS.widen
    sine, versine = _sines(r, n)
    slope = np.abs(at.J - np.eye(r.shape[1])) + 3.0 * at.rounding
    slope[:, :, :n] += np.abs(at.J[:, :, :n]) * versine[:, None, :n] + np.abs(at.H) * sine[:, None, :n]
    B, A = np.abs(at.B), np.abs(at.J[:, :, n:])
    slope[:, :, n:] += A * versine[:, None, at.carrier] + B * sine[:, None, at.carrier]
    for slide, angle in enumerate(at.carrier):
        if angle < n:
            carried = A[:, :, slide] * sine[:, angle, None] + B[:, :, slide]
            slope[:, :, angle] += carried * r[:, n + slide, None]
    total = np.abs(at.value) + at.error + _product(slope, r)
    return np.asarray(total * CONSTANTS.widen)


@dataclass(frozen=True)
class IsolatedRootConstants:
    """Constants of the refinement."""

    newton: int = 4  # Newton-Raphson corrections
    largest: float = 1.0  # rad: first half-width tried for the unique box
    rungs: int = 50  # number of half-widths tried, each half of the previous one
    smallest: float = 3.0  # half-width of the enclosure relative to Newton's last correction and its rounding
    turn: float = 16 * EPS  # rad: rounding of a subtracted turn
    widen: float = 1 + 8 * EPS  # factor of half-widths against rounding


ISOLATED = IsolatedRootConstants()


def centred(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return middles and half-widths of boxes, rounded outwards."""
    middle = 0.5 * (low + high)
    return middle, np.maximum(high - middle, middle - low) * ISOLATED.widen


def wrap(x: FloatArray, n: int) -> FloatArray:
    """Return points (..., d) with their first n coordinates, the angles, in [-pi, pi]."""
    wrapped = np.array(x, dtype=float)
    wrapped[..., :n] -= TURN * np.round(wrapped[..., :n] / TURN)
    return wrapped


class IsolatedRoots:
    """Proved solutions (R, d), angles first, with half-widths `radius` of enclosures and `unique` of unique boxes."""

    def __init__(self, loops: Coefficients, unit: FloatArray) -> None:
        self.loops, self.unit, self.n = loops, unit, loops.C.shape[1]
        self.roots, self.radius, self.unique = (np.zeros((0, len(unit))) for _ in range(3))

    def add(self, middle: FloatArray, half: FloatArray) -> BoolArray:
        """Add boxes (B, d) that contain exactly one solution each; return which solutions are now listed."""
        known = np.zeros(len(middle), dtype=bool)
        tried = np.zeros(len(middle), dtype=bool)
        while True:
            known |= np.any(np.all(self._apart(middle) + self.radius <= half[:, None], axis=2), axis=1)
            open_ = np.nonzero(~known & ~tried)[0]
            if not len(open_):
                return known
            tried[open_[0]] = True
            known[open_[0]] = self._refine(middle[open_[0]], half[open_[0]])

    def holds(self, low: FloatArray, high: FloatArray) -> BoolArray:
        """Return which boxes (B, d) are inside the unique box of a solution."""
        middle, half = centred(low, high)
        return np.asarray(np.any(np.all(self._apart(middle) + half[:, None] <= self.unique, axis=2), axis=1))

    def _apart(self, x: FloatArray) -> FloatArray:
        """Return distances (B, R, d) of points from the solutions, those of angles modulo a turn."""
        return np.abs(wrap(x[:, None] - self.roots, self.n)) * ISOLATED.widen

    def _refine(self, middle: FloatArray, half: FloatArray) -> bool:
        """Enclose the solution of a box tightly; return whether it is now listed."""
        x = middle[None]
        for _ in range(ISOLATED.newton):
            x = x - local(self.loops, x).value
        at = local(self.loops, x)
        radius = ISOLATED.smallest * (np.abs(at.value) + at.error)
        enclosed = np.all(image(at, radius) < radius) and np.all(np.abs(x - middle) + radius <= half)
        if not enclosed:
            return False
        near = np.all(self._apart(x)[0] <= self.radius + radius, axis=1)
        if near.any():  # the same solution if inside the unique box, otherwise undecided
            return bool(np.any(np.all((self._apart(x)[0] + radius <= self.unique)[near], axis=1)))
        self._append(x[0], radius[0])
        return True

    def _append(self, x: FloatArray, radius: FloatArray) -> None:
        """Store a new solution with the largest box that is proved to contain no other."""
        rungs = ISOLATED.largest * 0.5 ** np.arange(ISOLATED.rungs)[:, None] * self.unit
        rungs = rungs[(rungs >= radius).all(axis=1)]
        at = local(self.loops, np.repeat(x[None], len(rungs), axis=0))
        proved = np.nonzero((image(at, rungs) < rungs).all(axis=1))[0]
        unique = rungs[proved[0]] if len(proved) else radius
        self.roots = np.vstack([self.roots, wrap(x, self.n)])
        self.radius = np.vstack([self.radius, radius + ISOLATED.turn])
        self.unique = np.vstack([self.unique, unique - ISOLATED.turn])

    def inside(self, reach: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the solutions whose slides may be within the reach, with radius and unique box."""
        within = (np.abs(self.roots[:, self.n :]) - self.radius[:, self.n :] <= reach).all(axis=1)
        order = np.lexsort(self.roots[within].T[::-1])
        return self.roots[within][order], self.radius[within][order], self.unique[within][order]
