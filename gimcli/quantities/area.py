"""Area swept by a member: the area of the region that its outline covers, and the signed area of its line.

The region (each part counted once) is a union of triangles between close poses, see below. The signed area is
swept by the line from the member's first node A to its second node B, positive if the line moves to its left:
d(area)/dt = Im((B - A)* (v_A + v_B) / 2). Over a closed cycle it is the area inside B's path minus that inside A's
(planimeter). It is integrated by the trapezoidal rule with end corrections, of fourth order. Source: Bottema & Roth,
Theoretical Kinematics, 1979, chapter VIII (Holditch).

The region that a moving outline covers, and its area.

Between the rows the corners follow polynomials of fifth degree through positions, velocities and accelerations. From
one interpolated pose to the next every side covers one or two triangles. The area of their union is the integral of the
length of horizontal lines inside them, by the midpoint rule in an angle, for which the integrand is smooth at the ends.
The error estimate is the difference from a computation with half the rows, poses and lines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.errors import refuse
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.quantities.quantity import ColumnRange, Head, Kind, Quantity, member_of, unit_of
from gimcli.quantities.state import State
from gimcli.rates.path_derivatives import PathDerivatives
from gimcli.structure.carried import carried_point
from gimcli.structure.convex_hull import convex_hull

SMOOTH = 1e-2
"""Greatest distance of a position from the curve through the rows beside it, relative to their distance."""


def quintic(h: FloatArray, before: ComplexArray, after: ComplexArray) -> ComplexArray:
    """Return coefficients (6, ...) in s = 0..1 of curves with given positions, rates and accelerations at both ends.

    The ends (3, ...) are `h` apart in time.
    """
    (p0, v0, a0), (p1, v1, a1) = before, after
    v0, v1, a0, a1, d = v0 * h, v1 * h, a0 * h**2, a1 * h**2, p1 - p0
    third = 10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1
    fourth = -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1
    return np.array([p0, v0, a0 / 2, third, fourth, 6 * d - 3 * (v0 + v1) - (a0 - a1) / 2])


def completed(time: FloatArray, paths: ComplexArray) -> ComplexArray:
    """Return paths (points, 3, rows) in which missing rates of single rows are filled if the motion is smooth there.

    They are those of the polynomial of sixth degree through the position of the row and all values of the rows beside.
    """
    known = np.all(np.isfinite(paths), axis=(0, 1)).reshape(-1)
    alone = np.flatnonzero(~known[1:-1] & known[:-2] & known[2:]) + 1
    if not len(alone):
        return paths
    before, after, here = (np.moveaxis(paths[:, :, alone + k], 1, 0) for k in (-1, 1, 0))
    ahead, behind = time[alone + 1] - time[alone], time[alone] - time[alone - 1]
    h = ahead + behind
    place, rate, change = _derivatives(quintic(h, before, after), behind / h)
    off = (here[0] - place) / -((ahead * behind) ** 3)  # a multiple of u^3, u = (t - t_before) (t - t_after)
    u, slope = -ahead * behind, behind - ahead
    rate = rate / h + off * 3.0 * u**2 * slope
    change = change / h**2 + off * (6.0 * u * slope**2 + 6.0 * u**2)
    smooth = np.abs(here[0] - place) <= SMOOTH * np.abs(after[0] - before[0])
    filled = paths.copy()
    filled[:, 1, alone] = np.where(smooth, rate, here[1])
    filled[:, 2, alone] = np.where(smooth, change, here[2])
    return filled


def _derivatives(table: ComplexArray, s: FloatArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return the values of polynomials (6, ...) at s, and their first two derivatives by it."""
    place = sum(c * s**k for k, c in enumerate(table))
    rate = sum(k * c * s ** (k - 1) for k, c in enumerate(table) if k)
    change = sum(k * (k - 1) * c * s ** (k - 2) for k, c in enumerate(table) if k > 1)
    return np.asarray(place), np.asarray(rate), np.asarray(change)


@dataclass(frozen=True)
class Fineness:
    """Resolution of a region."""

    poses: int = 1440  # poses per turn: chords have an error of 3e-6 of a circle's area
    turns: tuple[float, float] = (0.05, 6.0)  # least and greatest number of turns for the number of poses
    lines: int = 2048  # horizontal lines; at the edge of a hole the error decreases with their power -3/2
    block: int = 200_000  # sections computed in one call
    thin: float = 1e-9  # width of an outline, relative to its length, below which it is a line


FINENESS = Fineness()


def corners_of(mechanism: Mechanism, index: int) -> list[str]:
    """Return the names of the nodes and points of a member at the corners of its convex hull, in their order."""
    member = mechanism.members[index]
    places = {mechanism.nodes[n]: complex(z) for n, z in zip(member.nodes, member.shape, strict=True)}
    places |= {p.name: p.local for p in mechanism.points if p.member == index}
    names = list(places)
    return [names[k] for k in convex_hull(np.array(list(places.values())), FINENESS.thin)]


def swept_area(derivatives: PathDerivatives, corners: Sequence[str]) -> tuple[float, float]:
    """Return the area of the region that an outline covers, and its error estimate; normal frame."""
    rows = derivatives.motion.solved
    if not rows:
        return 0.0, 0.0
    parts = max(2, int(np.ceil(FINENESS.poses * _turns(derivatives, corners) / max(1, rows - 1))))
    fine = union_area(swept(derivatives, corners, parts), FINENESS.lines)
    coarse = union_area(swept(derivatives, corners, parts, every=2), FINENESS.lines // 2)
    return fine, abs(fine - coarse)


def _turns(derivatives: PathDerivatives, corners: Sequence[str]) -> float:
    """Return the approximate number of turns of a member or its corners, within the limits."""
    z = derivatives.motion.z[:, derivatives.motion.good]
    paths = np.array([carried_point(derivatives.mechanism, name, z) for name in corners])
    arm = paths[1] - paths[0]
    turned = np.sum(np.abs(np.angle(arm[1:] * np.conj(arm[:-1])))) / (2.0 * np.pi)
    span = max(float(np.ptp(paths.real)), float(np.ptp(paths.imag)))
    round_about = np.max(np.sum(np.abs(np.diff(paths)), axis=1)) / (np.pi * span)
    return float(np.clip(max(turned, round_about), *FINENESS.turns))


def swept(derivatives: PathDerivatives, corners: Sequence[str], parts: int, every: int = 1) -> ComplexArray:
    """Return triangles (triangles, 3) that cover the region of an outline, each step divided into `parts`."""
    time = derivatives.clock
    paths = np.array([derivatives.timed.point(name) for name in corners])  # (corners, 3, rows)
    paths[:, 0] = [
        carried_point(derivatives.mechanism, name, derivatives.motion.z) for name in corners
    ]  # also in rows without velocities
    good = np.flatnonzero(derivatives.motion.good)
    found = [np.zeros((0, 3), dtype=complex)]
    edges = range(1, 2) if len(corners) == 2 else range(len(corners))
    for run in np.split(good, np.flatnonzero(np.diff(good) > 1) + 1):
        chosen = np.union1d(run[::every], run[-1:])
        if len(chosen):
            outline = _between(time[chosen], completed(time[chosen], paths[:, :, chosen]), parts)
            found += [_fan(outline[:, 0]), *(_sides(outline[k - 1], outline[k]) for k in edges)]
    return np.concatenate(found)


def _between(time: FloatArray, paths: ComplexArray, parts: int) -> ComplexArray:
    """Return corners (corners, poses) at the rows and between them: quintic, or linear without velocities."""
    if len(time) == 1:
        return np.asarray(paths[:, 0])
    s, h = np.arange(parts) / parts, np.diff(time)
    known = np.moveaxis(paths, 1, 0)
    table = quintic(h, known[:, :, :-1], known[:, :, 1:])
    curve = sum(c[..., None] * s**k for k, c in enumerate(table))
    straight = paths[:, 0, :-1, None] + np.diff(paths[:, 0])[..., None] * s
    curve = np.where(np.isfinite(curve), curve, straight)
    return np.concatenate([curve.reshape(len(paths), -1), paths[:, 0, -1:]], axis=1)


def _fan(outline: ComplexArray) -> ComplexArray:
    """Return the triangles of one pose of a convex outline."""
    return np.array([[outline[0], outline[k], outline[k + 1]] for k in range(1, len(outline) - 1)]).reshape(-1, 3)


def _sides(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return the triangles that a segment a-b (poses,) covers from each pose to the next."""
    a0, b0, a1, b1 = a[:-1], b[:-1], a[1:], b[1:]
    with np.errstate(all="ignore"):
        cross = _cross(b0 - a0, b1 - a1)
        at, there = _cross(a1 - a0, b1 - a1) / cross, _cross(a1 - a0, b0 - a0) / cross
        crossing = (at > 0.0) & (at < 1.0) & (there > 0.0) & (there < 1.0)
        meet = a0 + np.where(crossing, at, 0.0) * (b0 - a0)
        same = _cross(b0 - a0, b1 - a0) * _cross(b1 - a0, a1 - a0) >= 0.0  # the diagonal a0-b1 lies inside
    first = np.where(crossing, [a0, a1, meet], np.where(same, [a0, b0, b1], [a0, b0, a1]))
    second = np.where(crossing, [b0, b1, meet], np.where(same, [a0, b1, a1], [b0, b1, a1]))
    return np.concatenate([first, second], axis=1).T


def _cross(a: ComplexArray, b: ComplexArray) -> FloatArray:
    return np.asarray((np.conj(a) * b).imag)


def union_area(triangles: ComplexArray, lines: int) -> float:
    """Return the area of a union of triangles (triangles, 3), from their sections with horizontal lines."""
    if not len(triangles):
        return 0.0
    if np.sum(np.ptp(triangles.real, axis=1)) < np.sum(np.ptp(triangles.imag, axis=1)):
        triangles = 1j * triangles  # so that lines cross fewer triangles
    low, high = float(triangles.imag.min()), float(triangles.imag.max())
    angle = (np.arange(lines) + 0.5) * np.pi / lines
    y = (low + high) / 2.0 - (high - low) / 2.0 * np.cos(angle)
    weight = (high - low) / 2.0 * np.sin(angle) * np.pi / lines
    corners = np.take_along_axis(triangles, np.argsort(triangles.imag, axis=1), axis=1)
    first, last = (np.searchsorted(y, corners[:, k].imag) for k in (0, 2))
    sections = np.bincount(first, minlength=lines + 1) - np.bincount(last, minlength=lines + 1)
    ends = np.cumsum(np.cumsum(sections)[:-1])
    blocks = np.unique(np.searchsorted(ends, np.arange(0, ends[-1] + FINENESS.block, FINENESS.block)[1:]) + 1)
    total, start = 0.0, 0
    for stop in np.minimum(blocks, lines).tolist():
        if stop > start:
            lengths = _section_lengths(corners, np.clip(first, start, stop), np.clip(last, start, stop), y)
            total += float(np.sum(lengths[start:stop] * weight[start:stop]))
            start = stop
    return total


def _section_lengths(corners: ComplexArray, first: IntArray, last: IntArray, y: FloatArray) -> FloatArray:
    """Return the length of each line (lines,) inside a union of triangles, each of which crosses lines first..last."""
    count = last - first
    which = np.repeat(np.arange(len(corners)), count)
    line = np.arange(len(which)) - np.repeat(np.cumsum(count) - count - first, count)
    a, b, c = corners[which].T
    h = y[line]
    long, short = _at(a, c, h), np.where(h < b.imag, _at(a, b, h), _at(b, c, h))
    left, right = np.minimum(long, short), np.maximum(long, short)
    order = np.lexsort((left, line))
    line, left, right = line[order], left[order], right[order]
    # the lines are shifted one behind the other, so that one running maximum gives the covered part of each
    width = float(np.max(right, initial=0.0) - np.min(left, initial=0.0)) + 1.0
    shift = line * width
    covered = np.maximum.accumulate(np.concatenate([[-np.inf], right + shift]))[:-1] - shift
    fresh = np.maximum(0.0, right - np.maximum(left, covered))
    return np.asarray(np.bincount(line, weights=fresh, minlength=len(y)), dtype=np.float64)


def _at(p: ComplexArray, q: ComplexArray, y: FloatArray) -> FloatArray:
    """Return x of the line p-q at the ordinate y."""
    with np.errstate(all="ignore"):
        s = np.where(q.imag == p.imag, 0.0, (y - p.imag) / (q.imag - p.imag))
    return np.asarray(p.real + np.clip(s, 0.0, 1.0) * (q.real - p.real))


class Area(Quantity):
    """The signed area up to each row, and the area of the region of the whole motion."""

    def __init__(self, mechanism: Mechanism, spec: str, member: int) -> None:
        self.mechanism, self.spec, self.member = mechanism, spec, member
        self.unit = unit_of(mechanism, "{}^2")
        self.heads = (Head(f"{spec}.signed", self.unit, "signed area swept"),)

    def values(self, state: State) -> Sequence[Any]:
        """Return the signed area swept up to each row; intervals that are not solved add nothing."""
        rows, (last, before) = self._signed_rate(state.swept()), state.memory.get(self.spec, (None, 0.0))
        steps = _signed_steps(rows if last is None else np.concatenate([last, rows], axis=1))
        total = before + np.concatenate([np.zeros(rows.shape[1] - len(steps)), np.cumsum(steps)])
        state.memory[self.spec] = rows[:, -1:], float(total[-1])
        return [np.where(state.path.motion.good, total, np.nan) * self.mechanism.scale**2]

    def _signed_rate(self, path: PathDerivatives) -> ComplexArray:
        """Return time, rate, its derivative, arm and middle (5, rows)."""
        ends = list(self.mechanism.members[self.member].nodes[:2])
        z = path.motion.z[ends]  # known also in rows without velocities
        paths = np.moveaxis(path.timed.nodes[:, ends], 0, 1).copy()
        paths[:, 0] = z
        a, b = completed(path.clock, paths)
        arm, middle = b - a, (a + b) / 2.0
        rate = (np.conj(arm[0]) * middle[1]).imag
        change = (np.conj(arm[1]) * middle[1] + np.conj(arm[0]) * middle[2]).imag
        return np.array([path.clock + 0j, rate + 0j, change + 0j, z[1] - z[0], (z[0] + z[1]) / 2.0])

    def outlines(self, path: PathDerivatives) -> list[ComplexArray]:
        """Return the triangles that cover the region."""
        corners = corners_of(self.mechanism, self.member)
        return list(swept(path, corners, 1) * self.mechanism.scale + self.mechanism.origin)

    def whole(self, state: State, ranges: Mapping[str, ColumnRange]) -> dict[str, Any]:
        """Return area and error estimate of the region, and the signed area of the whole motion."""
        area, error = swept_area(state.path, corners_of(self.mechanism, self.member))
        square, signed = self.mechanism.scale**2, state.memory[self.spec][1]
        return {"area": area * square, "error": error * square, "signed": signed * square, "unit": self.unit}


def _signed_steps(rows: ComplexArray) -> FloatArray:
    """Return the signed area swept between successive rows; by the chord where a velocity is unknown."""
    time, rate, change = rows[:3].real
    h = np.diff(time)
    smooth = h / 2.0 * (rate[1:] + rate[:-1]) + h**2 / 12.0 * (change[:-1] - change[1:])
    arm, middle = rows[3], rows[4]
    chord = (np.conj(arm[1:] + arm[:-1]) / 2.0 * np.diff(middle)).imag
    steps = np.where(np.isfinite(smooth), smooth, chord)
    return np.where(np.isfinite(steps), steps, 0.0)


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> Sequence[Quantity]:
    index = member_of(mechanism, spec, names[0])
    refuse((index == FRAME, f"measure '{spec}': expected a moving member, got the frame"))
    return [Area(mechanism, spec, index)]


KIND = Kind(
    "area", "MEMBER",
    "area that a member sweeps: signed area of its line, and area of the region it covers (printed at the end)",
    (1,), _make,
)  # fmt: skip
