"""Roots of the force along a circuit, with their multiplicity."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from gimcli.continuation.arclength import ArclengthConstants, beside
from gimcli.dynamics.equilibria_curve import BALANCE, BalanceCurve, BalancePoint, distance

CORRECTIONS = ArclengthConstants(corrections=12, rounding=1e-10, noise=1e-10, pull=0.2, bend=math.acos(0.9))

DIVISIONS = 8
"""Most halvings of an interval in which a cubic has two extremes."""

POLISHED = 4
"""Most Newton corrections of a root."""


class CurveRoot:
    """A root of the force: the point, its multiplicity, and the change of sign of the force."""

    def __init__(self, at: BalancePoint, multiplicity: int, rises: bool, scale: float) -> None:
        self.at, self.multiplicity, self.rises, self.scale = at, multiplicity, rises, scale

    @property
    def residual(self) -> float:
        """The force, relative to the sum of its contributions near the root."""
        return abs(self.at.force) / self.scale if self.scale else 0.0

    @property
    def converged(self) -> bool:
        """Whether the force is 0 to rounding."""
        return self.residual <= BALANCE.residual

    @property
    def smooth(self) -> bool:
        """Whether the slope agrees with the change of sign; not at the jump of a spring whose ends meet."""
        return self.multiplicity > 1 or (self.at.slope > 0.0) == self.rises


def curve_roots(curve: BalanceCurve, points: list[BalancePoint], known: Sequence[CurveRoot] = ()) -> list[CurveRoot]:
    """Return the roots between resolved points that are not known, in their order; at the bound on work those found."""
    found: list[CurveRoot] = []
    for here, there in pairwise(points):
        if curve.ended(BALANCE.more):
            break
        for raw, sense in _isolated(curve, here, there, DIVISIONS):
            root = _examined(curve, raw, max(here.size, there.size, raw.size), sense)
            if not any(_same(curve, root, other) for other in (*known, *found)):
                found.append(root)
    return sorted(found, key=lambda root: root.at.mark)


def _isolated(curve: BalanceCurve, a: BalancePoint, b: BalancePoint, depth: int) -> Iterator[tuple[BalancePoint, int]]:
    """Yield the roots between two points, and whether the force rises (1), falls (-1) or only touches 0 there (0)."""
    steep = max(abs(a.slope), abs(b.slope)) * distance(a, b) > BALANCE.touching * max(a.size, b.size)
    if steep and _sign(a.slope) != _sign(b.slope):
        extreme = curve.between(a, b, "slope")
        if abs(extreme.force) <= BALANCE.touching * max(a.size, b.size, extreme.size):
            yield extreme, 0
            return
        for one, other in ((a, extreme), (extreme, b)):
            if _sign(one.force) != _sign(other.force):
                yield curve.between(one, other, "force"), -_sign(one.force)
        return
    if steep and depth and (part := _vertex(a, b)) is not None:
        middle = curve.middle(a, b, part)
        yield from _isolated(curve, a, middle, depth - 1)
        yield from _isolated(curve, middle, b, depth - 1)
    elif _sign(a.force) != _sign(b.force):
        yield curve.between(a, b, "force"), -_sign(a.force)


def _sign(value: float) -> int:
    """Return the sign of a value; 0 counts as positive in all intervals, so that no root is found twice."""
    return 1 if value >= 0.0 else -1


def _vertex(a: BalancePoint, b: BalancePoint) -> float | None:
    """Return the fraction at which the slope of the cubic is least or greatest, if the cubic has two extremes."""
    h = distance(a, b)
    rise, low, high = b.force - a.force, h * a.slope, h * b.slope
    square, linear = 3.0 * (low + high - 2.0 * rise), 2.0 * (3.0 * rise - 2.0 * low - high)  # slope: low + l t + s t^2
    if not square:
        return None
    t = -0.5 * linear / square
    inside = 0.0 < t < 1.0 and (low + 0.5 * linear * t) * low < 0.0
    return min(max(t, 0.1), 0.9) if inside else None


def _examined(curve: BalanceCurve, raw: BalancePoint, scale: float, sense: int) -> CurveRoot:
    """Return a root to full accuracy, with its multiplicity; `sense` as from `_isolated`."""
    if sense == 0 or abs(raw.slope) <= BALANCE.flat * scale:
        multiple = _multiple(curve, raw, scale)
        if multiple is not None and not (sense == 0 and multiple.multiplicity == 2):
            return multiple
    if sense == 0:  # the root of the slope is more accurate
        return CurveRoot(raw, 2, False, scale)
    return CurveRoot(_polished(curve, raw), 1, sense > 0, scale)


def _polished(curve: BalanceCurve, root: BalancePoint) -> BalancePoint:
    """Return a simple root after Newton corrections that decrease the force."""
    for _ in range(POLISHED):
        if not root.slope or not root.force or abs(root.force / root.slope) > BALANCE.cluster:
            break
        better = _beside(curve, root, -root.force / root.slope)
        if better is None or abs(better.force) >= abs(root.force):
            break
        root = better
    return root


def _beside(curve: BalanceCurve, root: BalancePoint, offset: float) -> BalancePoint | None:
    """Return the point at a distance along the tangent of another point."""
    shift = np.append(np.zeros(len(root.p) - 1), root.stop.round * curve.turn)
    target = root.p - shift + offset * root.tangent
    found = beside(curve.circuit.curve, root.tangent, target, offset, CORRECTIONS, root.tangent)
    return None if found is None else curve.near(root.stop, found)


def _multiple(curve: BalanceCurve, raw: BalancePoint, scale: float) -> CurveRoot | None:
    """Return a multiple root near a point, by the polynomial through the force at points around it; None if none is.

    The mean of the roots of a cluster is accurate, each of them is not.
    """
    offsets = BALANCE.window * np.cos(np.pi * (np.arange(9) + 0.5) / 9.0)
    around = [_beside(curve, raw, float(s)) for s in offsets]
    forces = np.array([at.force / scale for at in around if at is not None])
    if len(forces) < len(offsets):
        return None
    fit = np.polynomial.Polynomial.fit(offsets / BALANCE.window, forces, len(offsets) - 1, domain=[-1.0, 1.0])
    every = np.asarray(fit.roots(), dtype=complex)
    near = every[np.abs(every) * BALANCE.window <= BALANCE.cluster]
    if len(near) < 2:
        return None
    offset = float(np.mean(near.real)) * BALANCE.window
    at = _beside(curve, raw, offset)
    if at is None or abs(at.force) > BALANCE.residual * scale:
        return None
    rises = len(near) % 2 == 1 and float(fit(0.5)) > 0.0  # at the half of the window
    return CurveRoot(at, len(near), rises, scale)


def _same(curve: BalanceCurve, one: CurveRoot, other: CurveRoot) -> bool:
    """Return whether two roots are the same, up to the accuracy of a multiple root."""
    near = BALANCE.cluster if max(one.multiplicity, other.multiplicity) >= 2 else 1e-9
    change = curve.circuit.curve.apart(one.at.p, other.at.p)
    springs = len(curve.balance.twisted)
    wound = np.max(np.abs(one.at.angles - other.at.angles)[:springs], initial=0.0)
    return bool(np.linalg.norm(change) <= near and wound <= 1.0)
