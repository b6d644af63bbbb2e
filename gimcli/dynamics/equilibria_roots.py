"""Roots of the force along a circuit, with their multiplicity."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from gimcli.dynamics.equilibria_curve import BALANCE, BalanceCurve, BalancePoint, distance

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
    raw = _isolated(curve, [Span(a, b, max(a.size, b.size)) for a, b in pairwise(points)])
    for root in _examined(curve, sorted(raw, key=lambda one: one.at.mark)):
        if not any(_same(curve, root, other) for other in (*known, *found)):
            found.append(root)
    return sorted(found, key=lambda root: root.at.mark)


class Span(NamedTuple):
    """Two points of the same step of the circuit."""

    a: BalancePoint
    b: BalancePoint
    size: float  # greatest sum of contributions to the force at the ends of the whole interval

    @property
    def steep(self) -> bool:
        """Whether the force changes in it."""
        a, b = self.a, self.b
        return max(abs(a.slope), abs(b.slope)) * distance(a, b) > BALANCE.touching * max(a.size, b.size)


def _isolated(curve: BalanceCurve, spans: list[Span], depth: int = DIVISIONS) -> list[CurveRoot]:
    """Return the roots in some spans: simple ones, and double ones where the force only touches 0."""
    if not spans or curve.ended(BALANCE.more):
        return []
    found: list[CurveRoot] = []
    crossed, divided, bent = list[Span](), list[tuple[Span, float]](), list[Span]()
    for span in spans:
        if span.steep and _sign(span.a.slope) != _sign(span.b.slope):
            bent.append(span)
        elif span.steep and depth and (part := _vertex(span.a, span.b)) is not None:
            divided.append((span, part))
        else:
            crossed.append(span)
    for span, extreme in zip(bent, curve.between([(s.a, s.b) for s in bent], "slope"), strict=True):
        if abs(extreme.force) <= BALANCE.touching * max(span.a.size, span.b.size, extreme.size):
            found.append(CurveRoot(extreme, 2, False, max(span.size, extreme.size)))
        else:
            crossed += [span._replace(b=extreme), span._replace(a=extreme)]
    middles = curve.middles((span.a, span.b, part) for span, part in divided)
    halves = [half for (s, _), m in zip(divided, middles, strict=True) for half in (s._replace(b=m), s._replace(a=m))]
    crossed = [span for span in crossed if _sign(span.a.force) != _sign(span.b.force)]
    for span, root in zip(crossed, curve.between([(s.a, s.b) for s in crossed], "force"), strict=True):
        found.append(CurveRoot(root, 1, _sign(span.a.force) < 0, max(span.size, root.size)))
    return found + _isolated(curve, halves, depth - 1)


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


def _examined(curve: BalanceCurve, raw: list[CurveRoot]) -> Iterator[CurveRoot]:
    """Yield isolated roots to full accuracy, with their multiplicity."""
    multiple = [
        _multiple(curve, one.at, one.scale)
        if one.multiplicity == 2 or abs(one.at.slope) <= BALANCE.flat * one.scale
        else None
        for one in raw
    ]
    both = list(zip(raw, multiple, strict=True))
    simple = iter(_polished(curve, [one.at for one, own in both if own is None and one.multiplicity == 1]))
    for one, own in both:
        if own is not None and not one.multiplicity == own.multiplicity == 2:
            yield own
        elif one.multiplicity == 2:  # the root of the slope is more accurate
            yield one
        else:
            yield CurveRoot(next(simple), 1, one.rises, one.scale)


def _polished(curve: BalanceCurve, found: list[BalancePoint]) -> list[BalancePoint]:
    """Return simple roots after Newton corrections that decrease the force."""
    going = list(range(len(found)))
    for _ in range(POLISHED):
        going = [
            k for k in going if (at := found[k]).slope and at.force and abs(at.force / at.slope) <= BALANCE.cluster
        ]
        each = [found[k] for k in going]
        beside = zip(going, curve.beside(each, np.array([-at.force / at.slope for at in each])), strict=True)
        better = {k: at for k, at in beside if at is not None and abs(at.force) < abs(found[k].force)}
        going = list(better)
        for k, at in better.items():
            found[k] = at
    return found


def _multiple(curve: BalanceCurve, raw: BalancePoint, scale: float) -> CurveRoot | None:
    """Return a multiple root near a point, by the polynomial through the force at points around it; None if none is.

    The mean of the roots of a cluster is accurate, each of them is not.
    """
    offsets = BALANCE.window * np.cos(np.pi * (np.arange(9) + 0.5) / 9.0)
    around = curve.beside([raw] * len(offsets), offsets)
    forces = np.array([at.force / scale for at in around if at is not None])
    if len(forces) < len(offsets):
        return None
    fit = np.polynomial.Polynomial.fit(offsets / BALANCE.window, forces, len(offsets) - 1, domain=[-1.0, 1.0])
    every = np.asarray(fit.roots(), dtype=complex)
    near = every[np.abs(every) * BALANCE.window <= BALANCE.cluster]
    if len(near) < 2:
        return None
    offset = float(np.mean(near.real)) * BALANCE.window
    (at,) = curve.beside([raw], np.array([offset]))
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
