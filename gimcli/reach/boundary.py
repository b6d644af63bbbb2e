"""The workspace of a point: its curves are found, cut, sorted into boundary and inner curves, and checked.

Cutting of paths at all their intersections, without duplicates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from gimcli.connected import unlike
from gimcli.errors import UnassembledError, UsageError
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.progress import Progress, no_progress, spend
from gimcli.reach.arcs import MEETING, Cut, PathArc, PathIndex, footpoints
from gimcli.reach.coupled_task import CoupledTask
from gimcli.reach.critical_curves import (
    Critical,
    CriticalCurve,
    CriticalPath,
    CriticalPoint,
    CriticalWalker,
    Stratum,
    critical,
    sides,
    split,
)
from gimcli.reach.region import ALONE, INNER, OPEN, Edge, Loop, loops, outside, sorted_edges
from gimcli.reach.sampling import Bank, SamplingConstants
from gimcli.reach.task import SLACK, WorkspaceTask, unreached
from gimcli.structure.mobility import require_driven


def arranged(arcs: Sequence[PathArc]) -> list[PathArc]:
    """Return paths that meet only at their ends, without duplicates and without paths of zero length."""
    pieces = [piece for arc in arcs if arc.length > MEETING.least for piece in _once(arc)]
    pieces = distinct(pieces)
    pieces = _cut(pieces, _at_ends(pieces))
    pieces = distinct([p for p in pieces if p.length > MEETING.least])
    pieces = _cut(pieces, _at_crossings(pieces))
    return distinct([p for p in pieces if p.length > MEETING.same])


def _once(arc: PathArc) -> list[PathArc]:
    """Return the path, or its thirds if it covers itself, so that each part covers a point only once."""
    thirds = arc.cut([arc.halfway(part) for part in ((1 / 6, 1 / 2, 5 / 6) if arc.closed else (1 / 3, 2 / 3))])
    for part in thirds:
        z = part.at(*part.halfway(0.5))[None, :]
        if any(other is not part and footpoints(other, z)[0] is not None for other in thirds):
            return thirds
    return [arc]


def distinct(arcs: Sequence[PathArc]) -> list[PathArc]:
    """Return the paths without duplicates."""
    return unlike(sorted(arcs, key=lambda a: len(a.held)), _same)


def _same(a: PathArc, b: PathArc) -> bool:
    """Return whether two paths are the same curve."""
    if abs(a.length - b.length) > 10.0 * MEETING.same:
        return False
    marks = np.array([a.at(*a.halfway(part)) for part in (0.25, 0.5, 0.8)])
    return None not in footpoints(b, marks)


def _at_ends(arcs: Sequence[PathArc]) -> list[list[Cut]]:
    """Return for each path the cuts at which another path ends."""
    ends = _ends(arcs)
    return [[cut for cut in footpoints(arc, ends) if cut and _inner(arc, cut)] for arc in arcs]


def _at_crossings(arcs: Sequence[PathArc]) -> list[list[Cut]]:
    cuts: list[list[Cut]] = [[] for _ in arcs]
    for k, cut in PathIndex(arcs).crossings() if arcs else ():
        if _inner(arcs[k], cut):
            cuts[k].append(cut)
    return cuts


def _ends(arcs: Sequence[PathArc]) -> FloatArray:
    """Return the ends (rows, 2) of the open paths, without duplicates."""
    ends = (z for arc in arcs if not arc.closed for z in (arc.y[0], arc.y[-1]))
    kept = unlike(ends, lambda z, other: bool(np.linalg.norm(z - other) < 0.1 * MEETING.same))
    return np.reshape(kept, (-1, 2))


def _inner(arc: PathArc, cut: Cut) -> bool:
    """Return whether a cut is not at an end of the path."""
    if arc.closed:
        return True
    z = arc.at(*cut)
    return float(min(np.linalg.norm(z - arc.y[0]), np.linalg.norm(z - arc.y[-1]))) > 5.0 * MEETING.same


def _cut(arcs: Sequence[PathArc], cuts: Sequence[list[Cut]]) -> list[PathArc]:
    return [piece for arc, at in zip(arcs, cuts, strict=True) for piece in (arc.cut(at) if at else [arc])]


ROUNDS = 3
"""Most attempts, each with twice the starts, while the boundary is not closed or does not enclose a reached point."""

MANY = 200
"""Number of curves above which there is only one attempt: the next would take twice and four times as long."""

SINGLE = 1e-3
"""Extent of the reached points, relative to the size, below which they are one point (ranges that only touch)."""

LOOKED_AT = 16
"""Number of positions used to determine in which directions the point can move."""

RANK = 1e-9
"""Velocity of the point relative to the greatest below which it is 0."""

INPUTS = 5
"""Most inputs with ranges: all combinations of their ends are searched."""


@dataclass(frozen=True, eq=False)
class Workspace:
    """The region that a point reaches in any configuration, in the normal frame."""

    task: WorkspaceTask = field(repr=False)
    loops: tuple[Loop, ...]  # outer boundaries by decreasing area, then holes
    inner: tuple[Edge, ...]  # singular curves inside the region
    open: tuple[Edge, ...]  # curves that could not be sorted, and reached curves with no region beside them
    missed: int  # number of reached points outside the boundary, and of curves that violate a constraint
    positions: FloatArray = field(repr=False)  # (rows, 2) reached points
    limited: bool = False  # whether the search ended at its bound on work

    @property
    def single(self) -> FloatArray | None:
        """The reached point (2,) if it is only one, else None."""
        alone = not self.edges and np.ptp(self.positions, axis=0).max() <= SINGLE
        return self.positions.mean(axis=0) if alone else None

    @property
    def complete(self) -> bool:
        """Return whether every loop is closed, every curve sorted and every reached point enclosed.

        A single reached point is complete too.
        """
        if self.limited or not self.loops:
            return self.single is not None and not self.limited
        sorted_ = all(edge.kind == ALONE for edge in self.open)
        return all(loop.closed for loop in self.loops) and sorted_ and not self.missed

    @property
    def area(self) -> float:
        """Area; NaN if no boundary is known."""
        if not self.loops:
            return float("nan") if self.single is None else 0.0
        return sum(loop.area for loop in self.loops)

    @property
    def area_error(self) -> float:
        """Error estimate of the area, from the area with half as many points, for fourth order."""
        return sum(abs(edge.arc.moment - edge.arc.coarse.moment) for loop in self.loops for edge in loop.edges) / 15.0

    @property
    def perimeter(self) -> float:
        """Length of the boundary, including that of holes."""
        return sum(edge.arc.length for loop in self.loops for edge in loop.edges)

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corner (2,) of the region, or of the reached points if no boundary is known."""
        if not self.loops:
            found = self.positions if self.single is None else self.single[None, :]
            return found.min(axis=0), found.max(axis=0)
        points = np.concatenate([edge.arc.extremes for loop in self.loops for edge in loop.edges])
        return points.min(axis=0), points.max(axis=0)

    @property
    def edges(self) -> tuple[Edge, ...]:
        """All curves: of the outer boundary, of holes, inside, and those not sorted."""
        return (*(edge for loop in self.loops for edge in loop.edges), *self.inner, *self.open)


def survey(
    mechanism: Mechanism, point: str, orientation: Mapping[str, float] | None = None, progress: Progress = no_progress
) -> Workspace:
    """Return the workspace of a node or point that two or more inputs move, over all configurations.

    `orientation` fixes the directions [rad] of members. Raises UsageError if less than two or too many inputs remain,
    UnassembledError if there is no position within the ranges of the inputs.
    """
    task = task_of(mechanism, point, orientation or {})
    if task.freedoms < 2:
        raise UsageError(f"'{point}' moves along curves, with one degree of freedom; see `reach`")
    found: Workspace | None = None
    for attempt in range(ROUNDS):
        bank = Bank(task, SamplingConstants(seed=attempt).more(2**attempt))
        if not len(bank.x):
            continue
        fresh = _surveyed(task, bank, progress)
        found = fresh if found is None or fresh.missed <= found.missed else found
        if found.complete or len(found.edges) > MANY or spend():
            break
    if found is None:
        raise UnassembledError(unreached(task))
    return found


def task_of(mechanism: Mechanism, point: str, orientation: Mapping[str, float]) -> WorkspaceTask:
    """Return the task of a point; raise UsageError if it cannot move, or is not driven by the inputs alone."""
    task = (CoupledTask if mechanism.couplings else WorkspaceTask)(mechanism, point, orientation)
    require_driven(task.mechanism)
    if task.freedoms < 1:
        what = "with the orientations held and the inputs without a range" if task.orientation else "within its inputs"
        raise UsageError(f"'{task.point}' cannot move {what}: give the inputs laws with `from` and `to`")
    if len(task.limited) > INPUTS:
        raise UsageError(
            f"{len(task.limited)} inputs have ranges, at most {INPUTS} are possible: give the others constant laws"
        )
    return task


def strata(task: WorkspaceTask) -> list[Stratum]:
    """Return all strata that have a degree of freedom, for all combinations of inputs at an end of their ranges."""
    found = []
    for ends in product((0.0, 1.0, -1.0), repeat=len(task.limited)):
        held = tuple((r.actuator, end) for r, end in zip(task.limited, ends, strict=True) if end)
        if len(held) < task.freedoms:
            drives = [
                task.drive(r.actuator, r.low if end > 0.0 else r.high)
                for r, end in zip(task.limited, ends, strict=True)
                if end
            ]
            found.append(Stratum(task.free.joined(*drives), task.output[0], held))
    return found


def _confined(stratum: Stratum, x: FloatArray) -> bool:
    """Return whether the point can only move along a curve, although the stratum has several degrees of freedom.

    All such positions are critical; the ends of the curve belong to strata with one degree of freedom.
    """
    if stratum.freedoms == 1:
        return False
    few = x[:: max(1, len(x) // LOOKED_AT)]
    directions = np.linalg.svd(stratum.form.slope(few))[2][:, -stratum.freedoms :]
    moved = np.linalg.svd(stratum.table @ np.swapaxes(directions, -1, -2), compute_uv=False)
    return bool(np.all(moved[:, 1] <= RANK * moved[:, 0]))


def _surveyed(task: WorkspaceTask, bank: Bank, progress: Progress) -> Workspace:
    arcs: list[PathArc] = []
    every = [stratum for stratum in strata(task) if not _confined(stratum, bank.x)]
    for k, stratum in enumerate(every):
        curve = critical(stratum)
        for branch in _walked(task, curve, bank):
            arcs += _one_sided(task, stratum, curve, branch)
        progress(k + 1, len(every) + 1)
    pieces = arranged(arcs)
    good = [piece for piece in pieces if task.fulfilled(piece.branch.x).all()]
    edges = sorted_edges(good, bank)
    around = loops(edges)
    progress(len(every) + 1, len(every) + 1)
    inner = tuple(e for e in edges if e.kind == INNER)
    unsorted = tuple(e for e in edges if e.kind in (OPEN, ALONE))
    missed = outside(around, unsorted, bank.y) + len(pieces) - len(good)
    return Workspace(task, tuple(around), inner, unsorted, missed, bank.y, spend())


def _walked(task: WorkspaceTask, curve: Critical, bank: Bank) -> list[CriticalCurve]:
    """Return the curves of critical positions; seeds are tried until they give no new curve."""
    walker = CriticalWalker(task, curve)
    for seeds in bank.seeds(curve):
        if (not walker.take(seeds) and walker.found) or spend():
            break
    return walker.found


def _one_sided(task: WorkspaceTask, stratum: Stratum, curve: Critical, branch: CriticalCurve) -> list[PathArc]:
    """Return the paths along a branch on which the point can only move to one side."""

    def tests(knot: CriticalPoint) -> FloatArray:
        signs = sides(curve, knot.p, knot.tangent)
        return signs if isinstance(curve, CriticalPath) else np.append(signs, _speed(curve, knot))

    found = []
    for piece in split(branch, tests):
        middle = PathArc(piece, *task.output).middle
        signs = np.sign(sides(curve, middle.p, middle.tangent))
        signs = signs[signs != 0.0]
        if _rests(task, stratum, middle):
            found.append(PathArc(piece, *task.output, alone=True, held=stratum.held))
        elif len(signs) and np.all(signs == signs[0]):
            left = 1.0 if isinstance(curve, CriticalPath) else float(np.sign(_speed(curve, middle)))
            found.append(PathArc(piece, *task.output, inside=float(signs[0]) * left, held=stratum.held))
    return found


def _rests(task: WorkspaceTask, stratum: Stratum, knot: CriticalPoint) -> bool:
    """Return whether another input is at an end of its range along the path; it may limit both sides."""
    held = {actuator for actuator, _ in stratum.held}
    free = np.tile([r.actuator not in held for r in task.limited], 2).astype(bool)
    return bool(np.any(task.margins(knot.p[: stratum.n])[free] <= SLACK))


def _speed(curve: Critical, knot: CriticalPoint) -> float:
    """Return the speed of the point along its path, positive if alpha is to its left; 0 where it reverses."""
    alpha = curve.multipliers(knot.p, knot.tangent)[-2:]
    velocity = curve.stratum.table @ knot.tangent[: curve.stratum.n]
    return float(velocity[0] * alpha[1] - velocity[1] * alpha[0])
