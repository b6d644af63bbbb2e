"""Curves of critical positions, followed by continuation until they close or an input reaches an end of its range.

Critical positions of a point: singularities of the map y = Y x + y0 on the positions G(x) = 0.

A position is critical if l = (lambda, alpha) != 0 exists with lambda' G_x = alpha' Y: no velocity of the mechanism
moves the point along alpha. With l as additional unknowns, of length 1, these positions are a curve of a regular system
(Jo & Haug 1989; Haug, Luh, Adkins & Wang 1996). With one degree of freedom all positions are critical: alpha is normal
to the path, and the equations are G alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from gimcli.continuation import arclength
from gimcli.continuation.arclength import CurvePoint
from gimcli.mechanism import FloatArray
from gimcli.numerics.along import hermite, hermite_slope
from gimcli.progress import spend
from gimcli.reach.task import SLACK, WorkspaceTask
from gimcli.structure.quadric import Quadric

NOTHING = 1e-9
"""Multiplier below which it is rounding; tangents, and multipliers of folds, have length 1."""


@dataclass(frozen=True)
class Stratum:
    """The set of positions with some inputs at an end of their ranges."""

    form: Quadric  # G: members and pairs, then one equation per input at an end
    table: FloatArray  # Y (2, n)
    held: tuple[tuple[int, float], ...] = ()  # actuator; +1 at the low end of its range, -1 at the high end

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.form.n

    @property
    def freedoms(self) -> int:
        """Dimension of the set of positions."""
        return self.n - self.form.m


class CriticalPath:
    """The positions of a stratum with one degree of freedom: p = x (n,)."""

    def __init__(self, stratum: Stratum) -> None:
        self.stratum = stratum

    def linearised(self, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return G and G_x."""
        return self.stratum.form.value(p), self.stratum.form.slope(p)

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return G_x."""
        return self.stratum.form.slope(p)

    def starts(self, x: FloatArray) -> FloatArray:
        """Return starts p (rows, n) of positions x (rows, n)."""
        return x

    def multipliers(self, p: FloatArray, tangent: FloatArray) -> FloatArray:
        """Return l (m + 2,): alpha is the point's velocity turned to the left, 0 where the point is at rest."""
        form, velocity = self.stratum.form, self.stratum.table @ tangent
        alpha = np.array([-velocity[1], velocity[0]])
        weights = np.linalg.lstsq(form.slope(p).T, self.stratum.table.T @ alpha, rcond=None)[0]
        return np.concatenate([weights, alpha])


class Fold:
    """The critical positions of a stratum with several degrees of freedom: p = (x, lambda, alpha)."""

    def __init__(self, stratum: Stratum) -> None:
        self.stratum = stratum

    def linearised(self, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return G, lambda' G_x - alpha' Y and |l|^2 - 1, and their derivatives; p may have leading axes."""
        form, n = self.stratum.form, self.stratum.n
        x, weights, alpha = p[..., :n], p[..., n:-2], p[..., -2:]
        balance = np.einsum("...mn,...m->...n", form.slope(x), weights) - alpha @ self.stratum.table
        length = np.sum(p[..., n:] ** 2, axis=-1, keepdims=True) - 1.0
        return np.concatenate([form.value(x), balance, length], axis=-1), self.jacobian(p)

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return the derivatives of the residual by p."""
        form, n, m = self.stratum.form, self.stratum.n, self.stratum.form.m
        slope = form.slope(p[..., :n])
        table = np.zeros((*p.shape[:-1], m + n + 1, n + m + 2))
        table[..., :m, :n] = slope
        table[..., m : m + n, :n] = form.weighted(p[..., n:-2], p[..., :n])
        table[..., m : m + n, n:-2] = np.swapaxes(slope, -1, -2)
        table[..., m : m + n, -2:] = -self.stratum.table.T
        table[..., -1, n:] = 2.0 * p[..., n:]
        return table

    def starts(self, x: FloatArray) -> FloatArray:
        """Return starts p (2 rows, ·) at positions x (rows, n), with the two least singular vectors as multipliers."""
        slope = self.stratum.form.slope(x)
        minus = np.broadcast_to(-self.stratum.table, (len(x), *self.stratum.table.shape))
        left = np.linalg.svd(np.concatenate([slope, minus], axis=1))[0]
        return np.concatenate([np.concatenate([x, left[:, :, -1 - k]], axis=1) for k in range(2)])

    def multipliers(self, p: FloatArray, tangent: FloatArray) -> FloatArray:
        """Return l (m + 2,)."""
        return p[self.stratum.n :]


Critical = CriticalPath | Fold


def critical(stratum: Stratum) -> Critical:
    """Return the curve of a stratum's critical positions."""
    return CriticalPath(stratum) if stratum.freedoms == 1 else Fold(stratum)


def sides(curve: Critical, p: FloatArray, tangent: FloatArray) -> FloatArray:
    """Return on which sides of its path the point can move from a critical position, positive along alpha.

    There is one number for each input at an end, released into its range (0 if the point then moves only along the
    path), and one for each curvature: alpha . y'' = -lambda' G_xx (v, v) for the velocities v at which the point rests.
    """
    stratum = curve.stratum
    multipliers, x = curve.multipliers(p, tangent), p[: stratum.n]
    weights, base = multipliers[:-2], stratum.form.m - len(stratum.held)
    released = [weights[base + k] * inward for k, (_, inward) in enumerate(stratum.held)]
    released = [0.0 if abs(gain) <= NOTHING else gain for gain in released]
    count = stratum.freedoms - 1
    if not count:
        return np.array(released)
    across = np.linalg.svd(np.vstack([stratum.form.slope(x), stratum.table]))[2][-count:]
    bend = -across @ stratum.form.weighted(weights, x) @ across.T
    return np.concatenate([released, np.linalg.eigvalsh(bend)])


WALK = arclength.ArclengthConstants(first=5e-3, longest=3e-2, bend=0.05, points=20_000)
"""Steps short enough for cubics between two points to be accurate to about 1e-8."""

FAR = 30.0
"""Distance in sizes beyond which a curve is no longer followed."""


@dataclass(frozen=True)
class CriticalCurveConstants:
    """Constants for points on a curve."""

    degree: int = 6  # of the interpolating polynomial over a step
    least: int = 5  # least number of its points
    same: float = 0.1  # distance from the tangent, relative to that from the knot, of positions on the curve
    near: float = 2.0  # greatest distance from a knot, in longest steps, for this check
    still: float = 1e-6  # least component of the tangent in the positions
    within: float = 1e-9  # fraction of a step within which a zero counts as its end
    fitted: float = 1e-6  # greatest distance of the polynomial from the curve


LOCATING = CriticalCurveConstants()


@dataclass(frozen=True, eq=False)
class CriticalPoint:
    """A point of a curve with its unit tangent."""

    p: FloatArray
    tangent: FloatArray


@dataclass(frozen=True, eq=False)
class CriticalCurve:
    """A curve between two ends, or a closed curve, whose last knot is its first."""

    curve: Critical
    knots: tuple[CriticalPoint, ...]
    closed: bool = False

    @property
    def x(self) -> FloatArray:
        """Positions (knots, n)."""
        return np.array([k.p[: self.curve.stratum.n] for k in self.knots])

    @cached_property
    def cubics(self) -> FloatArray:
        """Control points (pieces, 4, n) of the cubics between the knots."""
        ends = np.array([_ends(*pair) for pair in pairwise(self.knots)])[..., : self.curve.stratum.n]
        here, ahead, there, behind = np.moveaxis(ends, 1, 0)
        return np.stack([here, here + ahead / 3.0, there - behind / 3.0, there], axis=1)


Tests = Callable[[CriticalPoint], FloatArray]
"""Function of a point that returns values (tests,) with sign changes at the points to be found."""


class CriticalWalker:
    """Finds the curves of critical positions from seeds."""

    def __init__(self, task: WorkspaceTask, curve: Critical) -> None:
        self.task, self.curve = task, curve
        self.n = curve.stratum.n
        self.found: list[CriticalCurve] = []
        held = {actuator for actuator, _ in curve.stratum.held}
        names = [(r.actuator, end) for end in (1.0, -1.0) for r in task.limited]
        self._ends = [
            names.index(pair) for pair in curve.stratum.held
        ]  # an input's equation also holds half a turn away
        self._loose = np.tile([r.actuator not in held for r in task.limited], 2).astype(bool)
        self._points, self._tangents = np.zeros((0, self.n)), np.zeros((0, self.n))

    def take(self, seeds: FloatArray) -> list[CriticalCurve]:
        """Follow the curves of seeds p (rows, ·) that have not been followed yet; return the new curves."""
        new: list[CriticalCurve] = []
        x = seeds[:, : self.n]
        for p in seeds[self.task.allowed(x) & np.all(np.abs(self.task.margins(x)[:, self._ends]) < SLACK, axis=1)]:
            start = None if spend(1) or self._known(p[: self.n]) else self._start(p)
            branch = None if start is None else self._walked(start)
            if branch is not None:
                new.append(branch)
                self._remember(branch)
        self.found += new
        return new

    def _start(self, p: FloatArray) -> CurvePoint | None:
        found = arclength.correct(self.curve, p, WALK)
        if found is None:
            return None
        start = arclength.place(self.curve, found, np.ones(len(found)))
        moving = np.linalg.norm(start.tangent[: self.n]) > LOCATING.still
        return start if moving and start.regular > WALK.rank else None

    def _walked(self, start: CurvePoint) -> CriticalCurve | None:
        ahead, closed = self._half(start)
        if closed:
            return CriticalCurve(self.curve, tuple(ahead), True)
        behind, _ = self._half(replace(start, tangent=-start.tangent))
        knots = tuple([CriticalPoint(k.p, -k.tangent) for k in behind[:0:-1]] + ahead)
        return CriticalCurve(self.curve, knots) if len(knots) > 1 else None

    def _half(self, start: CurvePoint) -> tuple[list[CriticalPoint], bool]:
        """Return the knots from a start in one direction, and whether the curve closes."""
        knots = [CriticalPoint(start.p, start.tangent)]
        for there in arclength.walk(self.curve, start, WALK):
            here, next_knot = knots[-1], CriticalPoint(there.p, there.tangent)
            beyond = self._margins(next_knot) < -SLACK  # an input may be at an end of its range along the whole curve
            if np.any(beyond):
                if np.any(self._margins(here)[beyond] <= SLACK):
                    return knots, False
                end = next(zeros(self.curve, here, next_knot, self._margins), None)
                return (knots if end is None else [*knots, end]), False
            near = self.task.beside(start.p[: self.n], there.p[: self.n])
            first = replace(start, p=np.append(near, start.p[self.n :]))
            if len(knots) > 2 and self._closes(first, here, next_knot):
                ends = (turned(first, self.n, sign) for sign in (1.0, -1.0))
                return [*knots, min(ends, key=lambda k: float(np.linalg.norm(k.p - here.p)))], True
            knots.append(next_knot)
            if np.abs(there.p[: self.n]).max() > FAR:
                break
        return knots, False

    def _margins(self, knot: CriticalPoint) -> FloatArray:
        """Return the distances of the other inputs from the ends of their ranges, positive inside."""
        return np.asarray(self.task.margins(knot.p[: self.n])[self._loose])

    def _closes(self, start: CurvePoint, here: CriticalPoint, there: CriticalPoint) -> bool:
        """Return whether the start is between two knots; the multipliers may have the opposite sign."""
        n, first = self.n, start.p[: self.n]
        step = there.p[:n] - here.p[:n]
        length = float(np.linalg.norm(step))
        gone = float((first - here.p[:n]) @ step) / max(length, 1e-300)
        aside = np.linalg.norm(first - here.p[:n] - gone * step / max(length, 1e-300))
        if not (-0.5 * length < gone <= 1.5 * length and aside <= 0.1 * length):
            return False
        for sign in (1.0, -1.0):
            back = turned(start, self.n, sign)
            if np.linalg.norm(back.p - here.p) <= 2.0 * np.linalg.norm(there.p - here.p):
                return float(back.tangent @ here.tangent) > 0.5
        return False

    def _known(self, x: FloatArray) -> bool:
        """Return whether a position is on a curve that has been followed."""
        apart = self.task.beside(x, self._points) - self._points
        far = np.linalg.norm(apart, axis=1)
        near = far < LOCATING.near * WALK.longest
        if not near.any():
            return False
        apart, tangents, far = apart[near], self._tangents[near], far[near]
        aside = np.linalg.norm(apart - np.sum(apart * tangents, axis=1)[:, None] * tangents, axis=1)
        return bool(np.any(aside <= LOCATING.same * far + WALK.rounding))

    def _remember(self, branch: CriticalCurve) -> None:
        tangents = np.array([k.tangent[: self.n] for k in branch.knots])
        length = np.linalg.norm(tangents, axis=1, keepdims=True)
        self._points = np.concatenate([self._points, branch.x])
        self._tangents = np.concatenate([self._tangents, tangents / np.maximum(length, 1e-300)])


def zeros(curve: Critical, here: CriticalPoint, there: CriticalPoint, tests: Tests) -> Iterator[CriticalPoint]:
    """Yield the points between two knots at which a test changes its sign, in order.

    They are zeros of a polynomial through corrected points, so that branches may intersect there.
    """
    from numpy.polynomial import chebyshev as poly

    grid, knots = _sampled(curve, here, there)
    if len(grid) < LOCATING.least:
        return
    values = np.array([tests(k) for k in knots])
    if not np.any(np.diff(np.sign(values), axis=0)):
        return
    degree = len(grid) - 1
    table = poly.chebfit(grid, np.array([k.p for k in knots]), degree)
    rates = poly.chebder(table)
    edge = 1.0 - LOCATING.within
    found: list[float] = []
    for column in values.T:
        if (column[0] or column[-1]) and np.any(np.diff(np.sign(column))):
            roots = poly.chebroots(poly.chebtrim(poly.chebfit(grid, column, degree), 1e-14 * np.abs(column).max()))
            found += [float(r.real) for r in roots if abs(r.imag) < 1e-9 and -edge < r.real < edge]
    for at in sorted(found):
        p, tangent = np.asarray(poly.chebval(at, table)), np.asarray(poly.chebval(at, rates))
        tangent = tangent / np.linalg.norm(tangent)
        exact = arclength.correct(curve, p, WALK, tangent)
        if exact is not None and np.linalg.norm(exact - p) <= LOCATING.fitted:
            p = exact
        yield CriticalPoint(p, tangent)


def _sampled(curve: Critical, here: CriticalPoint, there: CriticalPoint) -> tuple[FloatArray, list[CriticalPoint]]:
    """Return parameters in -1..1 and corrected points between two knots, in planes normal to the first tangent."""
    grid = -np.cos(np.pi * np.arange(LOCATING.degree + 1) / LOCATING.degree)
    t, ends, normal = 0.5 * (1.0 + grid[1:-1, None]), _ends(here, there), here.tangent
    guess, slope = hermite(*ends, t), hermite_slope(*ends, t)
    guess += ((here.p - guess) @ normal[:, None] + t * ((there.p - here.p) @ normal)) * normal
    p, good = arclength.corrected(curve, guess, WALK, np.tile(normal, (len(t), 1)))
    slope /= np.linalg.norm(slope, axis=1, keepdims=True)
    found = map(CriticalPoint, p[good], slope[good])
    return np.array([-1.0, *grid[1:-1][good], 1.0]), [here, *found, there]


def point_between(here: CriticalPoint, there: CriticalPoint, t: float) -> FloatArray:
    """Return the point at the parameter t in 0..1 of the cubic between two knots."""
    return hermite(*_ends(here, there), t)


def _ends(here: CriticalPoint, there: CriticalPoint) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the ends of the cubic between two knots and its derivatives there by t: its length to fourth order."""
    bend = np.linalg.norm(there.tangent - here.tangent)
    h = np.linalg.norm(there.p - here.p) * (1.0 + bend**2 / 24.0)
    return here.p, h * here.tangent, there.p, h * there.tangent


def split(branch: CriticalCurve, tests: Tests) -> list[CriticalCurve]:
    """Return the pieces of a branch between the points at which a test changes its sign."""
    values = np.array([tests(k) for k in branch.knots])

    def changes(k: int) -> Iterator[CriticalPoint]:
        here, there = branch.knots[k : k + 2]
        if np.any(np.sign(values[k]) != np.sign(values[k + 1])):
            yield from zeros(branch.curve, here, there, tests)
        if np.any((values[k + 1] == 0.0) & (values[k] != 0.0)):
            yield there

    return cut(branch, changes)


def cut(branch: CriticalCurve, cuts: Callable[[int], Iterable[CriticalPoint]]) -> list[CriticalCurve]:
    """Return the pieces of a branch between points; `cuts` returns those between a knot, of a number, and the next."""
    runs = [[branch.knots[0]]]
    for k, there in enumerate(branch.knots[1:]):
        for point in cuts(k):
            runs[-1].append(point)
            runs.append([point])
        if runs[-1][-1] is not there:
            runs[-1].append(there)
    whole = len(runs) == 1
    if branch.closed and not whole:  # join the pieces at the seam of a closed curve
        last = runs.pop()
        runs[0] = [*last[:-1], *seamless(last[-1], runs[0], branch.curve.stratum.n)]
    return [CriticalCurve(branch.curve, tuple(run), branch.closed and whole) for run in runs if len(run) > 1]


def seamless(seam: CriticalPoint, knots: Sequence[CriticalPoint], n: int) -> Sequence[CriticalPoint]:
    """Return knots of n coordinates that continue a seam: the first of them is the seam after full periods of inputs.

    Their multipliers are changed in sign if necessary.
    """
    sign = 1.0 if len(seam.p) == n or float(knots[0].p[n:] @ seam.p[n:]) > 0.0 else -1.0
    return [turned(k, n, sign, seam.p[:n] - knots[0].p[:n]) for k in knots]


def turned(place: CurvePoint | CriticalPoint, n: int, sign: float, shift: FloatArray | float = 0.0) -> CriticalPoint:
    """Return a point of n coordinates, shifted, with its multipliers times a sign."""
    turn = np.concatenate([np.ones(n), np.full(len(place.p) - n, sign)])
    p = place.p * turn
    p[:n] += shift
    return CriticalPoint(p, place.tangent * turn)
