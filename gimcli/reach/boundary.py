"""The workspace of a point: all its curves found, cut, sorted and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from gimcli.errors import UnassembledError, UsageError
from gimcli.mechanism import FRAME, FloatArray, Mechanism
from gimcli.progress import Progress, no_progress
from gimcli.reach.arcs import PathArc
from gimcli.reach.arrangement import arranged
from gimcli.reach.critical_curves import CriticalCurve, CriticalPoint, CriticalWalker, split
from gimcli.reach.critical_positions import Critical, CriticalPath, Stratum, critical, sides
from gimcli.reach.floating_chain import chains
from gimcli.reach.region import ALONE, INNER, OPEN, Edge, Loop, loops, outside, sorted_edges
from gimcli.reach.sampling import Bank, SamplingConstants
from gimcli.reach.task import SLACK, WorkspaceTask
from gimcli.structure.mobility import refuse_unfit

ROUNDS = 3
"""Times that more starts are made where the boundary is not closed or leaves reached places out."""

MANY = 200
"""Curves beyond which one pass is made only: the next ones would take twice and four times as long."""

SINGLE = 1e-3
"""Width of reached places, relative to the size, below which they are one: ranges that touch hold it to a root only."""

ANYWHERE = SamplingConstants(starts=200, enough=1)
"""To find one position."""

LOOKED_AT = 16
"""Positions by which it is seen what inputs leave free."""

RANK = 1e-9
"""Part of the point's greatest velocity that is none."""

INPUTS = 5
"""Inputs with ranges, at most: their ends are tried in all combinations."""


@dataclass(frozen=True, eq=False)
class Workspace:
    """The region that a point reaches in some configuration, in the normal frame."""

    task: WorkspaceTask = field(repr=False)
    loops: tuple[Loop, ...]  # outer ones by falling area, then holes
    inner: tuple[Edge, ...]  # curves within, where some configuration holds the point back
    open: tuple[Edge, ...]  # curves that could not be sorted, and those that are reached with nothing beside them
    missed: int  # reached places that the boundary leaves out, and curves that do not fulfil every constraint
    positions: FloatArray = field(repr=False)  # (rows, 2) reached places

    @property
    def single(self) -> FloatArray | None:
        """The only place (2,) that is reached, where it is one alone."""
        alone = not self.edges and np.ptp(self.positions, axis=0).max() <= SINGLE
        return self.positions.mean(axis=0) if alone else None

    @property
    def complete(self) -> bool:
        """Return whether every loop is closed, every curve sorted and every reached place enclosed; or it is one."""
        if not self.loops:
            return self.single is not None
        sorted_ = all(edge.kind == ALONE for edge in self.open)
        return all(loop.closed for loop in self.loops) and sorted_ and not self.missed

    @property
    def area(self) -> float:
        """Area; NaN where no boundary is known."""
        if not self.loops:
            return float("nan") if self.single is None else 0.0
        return sum(loop.area for loop in self.loops)

    @property
    def area_error(self) -> float:
        """Estimated error of the area: what half as many points would change it by, in fourth order."""
        return sum(abs(edge.arc.moment - edge.arc.coarse.moment) for loop in self.loops for edge in loop.edges) / 15.0

    @property
    def perimeter(self) -> float:
        """Length of the boundary, around holes too."""
        return sum(edge.arc.length for loop in self.loops for edge in loop.edges)

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corner (2,) of what is reached; of the places found where no boundary is known."""
        if not self.loops:
            found = self.positions if self.single is None else self.single[None, :]
            return found.min(axis=0), found.max(axis=0)
        points = np.concatenate([edge.arc.extremes for loop in self.loops for edge in loop.edges])
        return points.min(axis=0), points.max(axis=0)

    @property
    def edges(self) -> tuple[Edge, ...]:
        """All curves: around the region, around holes, within, and those not sorted."""
        return (*(edge for loop in self.loops for edge in loop.edges), *self.inner, *self.open)


def survey(
    mechanism: Mechanism, point: str, orientation: Mapping[str, float] | None = None, progress: Progress = no_progress
) -> Workspace:
    """Return the workspace of a node or point that two or more inputs move; all configurations count.

    `orientation` (rad) holds members' directions. Raises UsageError where fewer or too many inputs remain,
    StructureError where no position within the inputs' ranges exists.
    """
    task = task_of(mechanism, point, orientation or {})
    if task.freedoms < 2:
        raise UsageError(f"'{point}' runs along curves: {task.freedoms} freedom is left; see `reach`")
    found: Workspace | None = None
    for attempt in range(ROUNDS):
        bank = Bank(task, SamplingConstants(seed=attempt).more(2**attempt))
        if not len(bank.x):
            continue
        fresh = _surveyed(task, bank, progress)
        found = fresh if found is None or fresh.missed <= found.missed else found
        if found.complete or len(found.edges) > MANY:
            break
    if found is None:
        raise UnassembledError(unreached(task))
    return found


def task_of(mechanism: Mechanism, point: str, orientation: Mapping[str, float]) -> WorkspaceTask:
    """Return what is asked of the chain that moves a point; refuse what has no workspace.

    Raises UnassembledError where another chain cannot be assembled within the ranges of its inputs.
    """
    own, others = chains(mechanism, point, orientation)
    for other in others:
        moved = next(n for k, n in enumerate(other.nodes) if k not in other.members[FRAME].nodes)
        if not len(Bank(WorkspaceTask(other, moved), ANYWHERE).x):
            raise UnassembledError(unreached(WorkspaceTask(mechanism, point)))
    return checked(WorkspaceTask(own, point, orientation))


def checked(task: WorkspaceTask) -> WorkspaceTask:
    """Refuse what has no workspace, or is not driven by its inputs alone."""
    refuse_unfit(task.mechanism)
    if task.freedoms < 1:
        what = "with the orientations held and the inputs without a range" if task.orientation else "within its inputs"
        raise UsageError(f"'{task.point}' cannot move {what}: give the inputs laws with a from and a to")
    if len(task.limited) > INPUTS:
        raise UsageError(f"{len(task.limited)} inputs have ranges, {INPUTS} at most are combined: hold some by a law")
    return task


def unreached(task: WorkspaceTask) -> str:
    """Say that no position exists, and the cure."""
    held = f" with {', '.join(task.orientation)} held" if task.orientation else ""
    return (
        f"{task.mechanism.name}{held} has no position within the ranges of its inputs: widen their laws, or check"
        " the lengths by `gim solve`"
    )


def strata(task: WorkspaceTask) -> list[Stratum]:
    """Return all ways of holding inputs at an end of their ranges that leave a freedom."""
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
    """Return whether the inputs held leave the point on a curve, though they leave several freedoms.

    All such positions are critical; the ends of what they reach are on strata with one freedom.
    """
    if stratum.freedoms == 1:
        return False
    few = x[:: max(1, len(x) // LOOKED_AT)]
    ways = np.linalg.svd(stratum.form.slope(few))[2][:, -stratum.freedoms :]
    moved = np.linalg.svd(stratum.table @ np.swapaxes(ways, -1, -2), compute_uv=False)
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
    return Workspace(task, tuple(around), inner, unsorted, missed, bank.y)


def _walked(task: WorkspaceTask, curve: Critical, bank: Bank) -> list[CriticalCurve]:
    """Return the curves of critical positions; no more seeds are tried than lead to new ones."""
    walker = CriticalWalker(task, curve)
    for seeds in bank.seeds(curve):
        if not walker.take(seeds) and walker.found:
            break
    return walker.found


def _one_sided(task: WorkspaceTask, stratum: Stratum, curve: Critical, branch: CriticalCurve) -> list[PathArc]:
    """Return the paths along a branch that hold the point back: all ways on lead to one side."""

    def tests(knot: CriticalPoint) -> FloatArray:
        signs = sides(curve, knot.p, knot.tangent)
        return signs if isinstance(curve, CriticalPath) else np.append(signs, _speed(curve, knot))

    found = []
    for piece in split(branch, tests):
        middle = piece.knots[len(piece.knots) // 2]
        if len(piece.knots) == 2:
            middle = PathArc(piece, *task.output).knot((0, 0.5))
        signs = np.sign(sides(curve, middle.p, middle.tangent))
        signs = signs[signs != 0.0]
        if _rests(task, stratum, middle):
            found.append(PathArc(piece, *task.output, alone=True, held=stratum.held))
        elif len(signs) and np.all(signs == signs[0]):
            left = 1.0 if isinstance(curve, CriticalPath) else float(np.sign(_speed(curve, middle)))
            found.append(PathArc(piece, *task.output, inside=float(signs[0]) * left, held=stratum.held))
    return found


def _rests(task: WorkspaceTask, stratum: Stratum, knot: CriticalPoint) -> bool:
    """Return whether an input that is not held stands at an end of its range: it may bar the way to either side."""
    held = {actuator for actuator, _ in stratum.held}
    free = np.tile([r.actuator not in held for r in task.limited], 2).astype(bool)
    return bool(np.any(task.margins(knot.p[: stratum.n])[free] <= SLACK))


def _speed(curve: Critical, knot: CriticalPoint) -> float:
    """Return the point's speed along its path, + where alpha lies to its left: 0 where it turns back."""
    alpha = curve.multipliers(knot.p, knot.tangent)[-2:]
    velocity = curve.stratum.table @ knot.tangent[: curve.stratum.n]
    return float(velocity[0] * alpha[1] - velocity[1] * alpha[0])
