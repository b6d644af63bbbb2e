"""All configurations of a mechanism, from the roots of its Assur groups, one group after the other.

A partial configuration fixes the nodes to which the next group is attached; the leaves of this tree are the
configurations of the mechanism. Redundant constraints are left out of the equations; afterwards the residual of all
constraints shows which configurations satisfy them.

Multiple roots cannot be proved, so they are corrected as far as possible and the list is not complete.

The order of configurations: it depends on the mechanism and its inputs alone.

Configurations are sorted by the signs of their groups in the order of solution, + before -. The solutions of a coupled
group, for the same signs before it, are numbered by the coordinates of its nodes: by x, then y, of the first node in
the order of the file, then of the next nodes. Differences below SAME do not count, so that rounding errors, which
depend on the machine and on the way to a root, change no number.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import prod

import numpy as np

from gimcli.assemblies.assur_loops import LoopGroup, LoopState, group_of, independent, parts
from gimcli.assemblies.certificate import (
    Proven,
    distances,
    mirror_distance,
    real_equations,
    real_form,
    size_of,
    without_image,
)
from gimcli.assemblies.constants import FITS, SEARCH
from gimcli.assemblies.link_joints import NONE, BodyJoint, Linkage, linkage
from gimcli.assemblies.loops import LoopFamily, values_and_jacobian
from gimcli.assemblies.roots import OPEN, REACHED, REALS, DyadRoots, Roots, all_roots, dyad_roots
from gimcli.assemblies.start_cache import known_count
from gimcli.canonical import principal, ranks
from gimcli.errors import StructureError
from gimcli.mechanism import FRAME, BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.progress import Progress, no_progress, spend
from gimcli.structure.residual import holds, residual

CUT = 1e-9
"""Singular value relative to the largest below which a direction is not corrected (double root or curve)."""

TIMES = 60
"""Number of corrections; each halves the error of a double root."""


def doubtful_real(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> list[ComplexArray]:
    """Return the real points among candidates for multiple roots (candidates, n + q), without duplicates."""
    w = w[np.isfinite(w).all(axis=1)]
    w = w[mirror_distance(family, w) < SEARCH.real] if len(w) else w
    found: list[ComplexArray] = []
    for point in w:
        settled = _settled(family, H, point)
        value, _ = values_and_jacobian(family, H, settled[None])
        if not np.max(np.abs(value), initial=0.0) <= SEARCH.residual * np.max(np.abs(H)):
            continue
        if all(float(distances(family, settled[None], other[None])[0, 0]) > SEARCH.near for other in found):
            found.append(settled)
    return found


def _settled(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> ComplexArray:
    """Return the real point near a candidate, from least-squares corrections."""
    w, unit = without_image(family, w)
    for _ in range(TIMES):
        table, error = real_equations(family, H, w)
        if not np.max(np.abs(error), initial=0.0) > np.finfo(float).eps * np.max(np.abs(H)):
            break
        w = w - unit * np.linalg.lstsq(table, error, rcond=CUT)[0]
    return w


def kept_apart(family: LoopFamily, proven: Proven, each: int) -> BoolArray:
    """Return for every group of `each` consecutive roots whether they are proved to be different."""
    if each == 1:
        return np.ones(len(proven.w), dtype=bool)
    far = size_of(family, proven.w[0::each] - proven.w[1::each])
    return np.asarray(far > proven.small[0::each] + proven.small[1::each])


DIGITS = 7
"""Decimal places of the angles by which roots are sorted; rounding errors are smaller."""

Solver = Callable[[int, tuple[int, ...], LoopGroup, ComplexArray], Roots]
"""Function that returns the roots of a group from its number, the branches of earlier groups, and its coefficients."""


@dataclass(frozen=True)
class RootReport:
    """Result of one Assur group over all partial configurations on which it was solved."""

    nodes: tuple[str, ...]  # names of the nodes that it positions
    loops: int  # number of independent loops
    count: int | None  # complex roots of a generic group; None if the count takes too long
    solved: int = 0  # number of partial configurations on which it was solved
    roots: int = 0  # number of proved complex roots
    real: int = 0  # number of proved real roots
    infinite: int = 0  # number of roots at infinity
    doubtful: int = 0  # multiple roots, or points of a curve of roots
    missing: int = 0  # number of roots of the generic group that were not found
    level: int = REACHED  # level of completeness: REACHED, REALS, AGREED or OPEN of `roots`
    free: bool = False  # whether it is a folded dyad, which can rotate freely


@dataclass(frozen=True)
class Configurations:
    """The configurations of a mechanism at given inputs that were found, and how complete they are."""

    mechanism: Mechanism = field(repr=False)
    inputs: FloatArray  # (actuators,) [rad, normal frame]
    z: ComplexArray = field(repr=False)  # (configurations, nodes) normal frame
    residual: FloatArray  # (configurations,) recomputed from the members as written
    radius: FloatArray  # (configurations,) radius that encloses the root [rad, normal frame]; infinite: not proved
    branches: tuple[tuple[int, ...], ...]  # (configurations,) number of the root of each of `groups`
    groups: tuple[RootReport, ...]  # groups that have loops
    surplus: tuple[str, ...]  # redundant constraints that were left out and then checked
    unfit: int = 0  # number of roots that violate a constraint although none was left out
    limited: bool = False  # whether the search ended at its bound on work
    searched: int = REACHED  # level of completeness of the search for inputs that follow the linkage

    def __len__(self) -> int:
        return len(self.z)

    @property
    def level(self) -> int:
        """1: all complex roots found, 2: the real roots are proved complete, 3: two searches agree, 4: undecided."""
        return OPEN if self.unfit or self.limited else max((self.searched, *(g.level for g in self.groups)))

    @property
    def complete(self) -> bool:
        """Return whether it is proved that there is no other configuration."""
        return self.level <= REALS

    @property
    def bound(self) -> int:
        """Number of complex configurations of a generic mechanism of this structure; if unknown, of those found."""
        return prod(g.count if g.count is not None else -(-g.roots // max(g.solved, 1)) for g in self.groups)

    @property
    def missing(self) -> int:
        """Number of roots of the groups that were not found."""
        return sum(g.missing for g in self.groups)

    @property
    def signs(self) -> tuple[str, ...]:
        """Short names of the configurations: + or - for a dyad, a number for a coupled group."""
        return tuple(
            "".join(("+-"[b] if g.loops == 1 else f"({b + 1})") for b, g in zip(branch, self.groups, strict=True))
            for branch in self.branches
        )


@dataclass
class _Leaves:
    """The partial configurations found so far."""

    state: LoopState
    branches: list[tuple[int, ...]]  # of each partial configuration, the number of the root of each group
    radius: FloatArray  # (partial configurations,) largest radius that encloses a root


class ConfigurationFinder:
    """Finds configurations at any inputs; keeps the groups of the mechanism in the order of solution."""

    def __init__(self, mechanism: Mechanism, tolerance: float = FITS, progress: Progress = no_progress) -> None:
        self.mechanism, self.tolerance, self.progress = mechanism, tolerance, progress
        whole = linkage(mechanism)
        self.linkage = independent(whole)
        self.surplus = _left_out(whole, self.linkage)
        loose = [mechanism.nodes[node] for node in self.linkage.loose]
        if loose:
            raise StructureError(
                f"nothing drives node {', '.join(loose)}: it can move along its guide; add an actuator"
            )
        self.groups = [group_of(self.linkage, part) for part in parts(self.linkage)]

    def at(self, inputs: FloatArray, solver: Solver | None = None) -> Configurations:
        """Return all configurations at inputs (actuators,)."""
        leaves = _Leaves(self._ground(inputs), [()], np.zeros(1))
        reports: list[RootReport] = []
        chosen = solver or self.afresh
        for group in self.groups:
            if not group.family.loops:
                group.put(leaves.state, np.zeros((len(leaves.branches), 0), dtype=complex))
                continue
            report, leaves = self._branched(len(reports), group, leaves, chosen)
            reports.append(report)
        return self._finished(inputs, leaves, reports)

    def afresh(
        self, number: int, branch: tuple[int, ...], group: LoopGroup, H: ComplexArray, near: Roots | None = None
    ) -> Roots:
        """Return the roots of a group in a reproducible order; `near` are the roots of almost the same H."""
        roots = all_roots(group.family, H, self.progress, near)
        return replace(roots, proven=roots.proven.take(_order(group, roots.proven)))

    def _ground(self, inputs: FloatArray) -> LoopState:
        linkage = self.linkage
        points, rails, phases = linkage.numbers(inputs[:, None])
        place = np.full((linkage.vertices, 1), np.nan + 0.0j)
        place[FRAME] = 0.0
        still = np.array([c == NONE for c in linkage.classes])
        turn = np.where(still[:, None], phases, np.nan + 0.0j)
        return LoopState(place, turn, np.zeros((len(linkage.joints), 1), dtype=complex), points, rails, phases)

    def _branched(self, number: int, group: LoopGroup, leaves: _Leaves, solver: Solver) -> tuple[RootReport, _Leaves]:
        """Solve a group for each partial configuration."""
        H = group.family.real(group.values(leaves.state))
        report = RootReport(self._names(group), group.family.loops, known_count(group.family))
        if group.family.loops == 1:
            report, found = _dyads(report, group, H)
        else:
            report, found = self._coupled(report, number, group, H, leaves, solver)
        parents = np.array([f[0] for f in found], dtype=int)
        most = SEARCH.positions
        if len(found) > most:
            raise StructureError(
                f"{self.mechanism.name} has more than {most} configurations; use `gim trace` to follow one of them"
            )
        state = leaves.state.take(parents)
        w = np.array([f[2] for f in found], dtype=complex).reshape(
            len(found), group.family.angles + group.family.slides
        )
        group.put(state, w)
        radius = np.maximum(leaves.radius[parents], np.array([f[3] for f in found], dtype=float))
        return report, _Leaves(state, [(*leaves.branches[f[0]], f[1]) for f in found], radius)

    def _coupled(
        self, report: RootReport, number: int, group: LoopGroup, H: ComplexArray, leaves: _Leaves, solver: Solver
    ) -> tuple[RootReport, list[_Root]]:
        found: list[_Root] = []
        for parent, own in enumerate(H):
            if spend(1):
                break
            roots = solver(number, leaves.branches[parent], group, own)
            report = _counted(report, roots)
            real = np.flatnonzero(roots.proven.real).tolist()
            placed = real_form(group.family, own, roots.proven.w[real])
            found += [(parent, k, w, float(roots.proven.small[k])) for k, w in zip(real, placed, strict=True)]
            maybe = doubtful_real(group.family, own, roots.doubtful)
            found += [(parent, len(roots.proven.w) + k, w, np.inf) for k, w in enumerate(maybe)]
        return report, found

    def _names(self, group: LoopGroup) -> tuple[str, ...]:
        nodes = [v - self.linkage.bodies for v in group.part.vertices if v >= self.linkage.bodies]
        return tuple(self.mechanism.nodes[n] for n in nodes)

    def _finished(self, inputs: FloatArray, leaves: _Leaves, reports: list[RootReport]) -> Configurations:
        z = self._places(leaves.state, inputs)
        rows = np.broadcast_to(inputs[:, None], (len(inputs), len(leaves.branches)))
        check = residual(self.mechanism, z, np.ascontiguousarray(rows)).total if z.shape[1] else np.zeros(0)
        fits = holds(self.mechanism, z, rows, self.tolerance, error=check)
        chosen = np.flatnonzero(fits)
        return Configurations(
            self.mechanism, inputs, z.T[chosen], check[chosen], leaves.radius[chosen],
            tuple(leaves.branches[k] for k in chosen), tuple(reports), self.surplus,
            0 if self.surplus else int((~fits).sum()), limited=spend(),
        )  # fmt: skip

    def _places(self, state: LoopState, inputs: FloatArray) -> ComplexArray:
        """Return the positions of all nodes (nodes, configurations)."""
        linkage = self.linkage
        z = state.place[linkage.bodies :].copy()
        place, turn = state.place[: linkage.bodies].copy(), state.turn.copy()
        self._carry(z, place, turn, inputs, lambda joint: joint.body not in linkage.dropped)
        for body in linkage.dropped:
            member = self.mechanism.members[body]
            a, b = [k for k, n in enumerate(member.nodes) if np.isfinite(z[n]).all()][:2]
            with np.errstate(all="ignore"):
                ratio = (z[member.nodes[b]] - z[member.nodes[a]]) / (member.shape[b] - member.shape[a])
                turn[body] = ratio / np.abs(ratio)
            place[body] = z[member.nodes[a]] - turn[body] * member.shape[a]
        self._carry(z, place, turn, inputs, lambda joint: joint.body in linkage.dropped)
        return z

    def _carry(
        self, z: ComplexArray, place: ComplexArray, turn: ComplexArray, inputs: FloatArray,
        which: Callable[[BodyJoint], bool],
    ) -> None:  # fmt: skip
        for joint in self.linkage.carried:
            if which(joint) and np.isnan(z[joint.node]).any():
                reach = joint.point + (joint.along * inputs[joint.actuator] if joint.actuator != NONE else 0.0)
                z[joint.node] = place[joint.body] + turn[joint.body] * reach


_Root = tuple[int, int, ComplexArray, float]
"""Index of the partial configuration, number of the root, w, radius."""


def _left_out(whole: Linkage, kept: Linkage) -> tuple[str, ...]:
    """Return the names of the redundant constraints that were left out."""
    names = [whole.mechanism.members[b].name for b in sorted(kept.dropped)]
    left = {(j.body, j.node, j.name) for j in (*kept.joints, *kept.carried)}
    names += [j.name for j in whole.joints if j.direction is not None and (j.body, j.node, j.name) not in left]
    nodes = whole.mechanism.nodes
    names += [f"{j.name} at {nodes[j.node]}" for j in kept.joints if j.slack]
    return tuple(dict.fromkeys(names))


def _dyads(report: RootReport, group: LoopGroup, H: ComplexArray) -> tuple[RootReport, list[_Root]]:
    """Solve a dyad for all partial configurations together."""
    roots: DyadRoots = dyad_roots(group.family, H)
    proven, each = roots.proven, roots.each
    sure = proven.sure.reshape(-1, each)
    decided = (proven.real | proven.complex).reshape(-1, each)
    whole = (sure & decided).all(axis=1) & kept_apart(group.family, proven, each)
    open_ = ~(whole | roots.apart)
    real = np.flatnonzero(proven.real & np.repeat(whole, each))
    placed = real_form(group.family, H[real // each], proven.w[real])
    found: list[_Root] = [
        (k // each, k % each, w, float(proven.small[k])) for k, w in zip(real.tolist(), placed, strict=True)
    ]
    doubtful = 0
    for dyad in np.flatnonzero(open_):
        maybe = doubtful_real(group.family, H[dyad], proven.w[dyad * each : (dyad + 1) * each])
        found += [(int(dyad), k, w, np.inf) for k, w in enumerate(maybe)]
        doubtful += len(maybe)
    found.sort(key=lambda f: f[:2])
    level = OPEN if open_.any() else REALS if (~whole).any() else REACHED
    missing = int(each * open_.sum()) - doubtful
    report = replace(
        report, count=each, solved=len(H), roots=int(sure[whole].sum()), real=len(real), doubtful=doubtful,
        missing=missing, level=level, free=bool((roots.free & open_).any()),
    )  # fmt: skip
    return report, found


def _counted(report: RootReport, roots: Roots) -> RootReport:
    """Return the report with the roots for one more partial configuration added."""
    proven = roots.proven
    return replace(
        report, count=roots.count, solved=report.solved + 1, roots=report.roots + len(proven.w),
        real=report.real + int(proven.real.sum()), infinite=report.infinite + roots.infinite,
        doubtful=report.doubtful + len(roots.doubtful), missing=report.missing + roots.missing,
        level=max(report.level, roots.level),
    )  # fmt: skip


def _order(group: LoopGroup, proven: Proven) -> IntArray:
    """Return a reproducible order of roots: the real ones first, sorted by angles."""
    n = group.family.angles
    keys = [~proven.real[:, None], principal(proven.w[:, :n].imag), proven.w[:, n:].real, proven.w[:, :n].real]
    table = np.round(np.concatenate([*keys, proven.w[:, n:].imag], axis=1), DIGITS)
    return np.asarray(np.lexsort(table.T[::-1]))


SAME = 1e-6
"""Difference of coordinates, relative to the size, below which they count as equal."""


def in_order(found: Configurations) -> Configurations:
    """Return the configurations in their order, with the solutions of coupled groups numbered by coordinates."""
    if not len(found):
        return found
    branches = np.array(found.branches, dtype=int).reshape(len(found), len(found.groups))
    keys = [ranks(part, SAME * found.mechanism.size) for z in found.z.T for part in (z.real, z.imag)]
    table = np.array(keys).T  # (configurations, 2 nodes)
    for k, group in enumerate(found.groups):
        if group.loops > 1:
            own = [found.mechanism.nodes.index(name) for name in group.nodes]
            branches[:, k] = _numbered(branches[:, : k + 1], table, sorted(own))
    order = np.lexsort((*table.T[::-1], *branches.T[::-1]))
    return replace(
        found, z=found.z[order], residual=found.residual[order], radius=found.radius[order],
        branches=tuple(tuple(row) for row in branches[order].tolist()),
    )  # fmt: skip


def _numbered(branches: IntArray, table: IntArray, nodes: list[int]) -> IntArray:
    """Return the last of `branches` (configurations, groups), numbered from 0 by the ranks of coordinates."""
    result = branches[:, -1].copy()
    columns = [2 * n + part for n in nodes for part in (0, 1)]
    columns += [c for c in range(table.shape[1]) if c not in columns]  # a group may turn members about known nodes only
    for before in np.unique(branches[:, :-1], axis=0):
        here = np.flatnonzero((branches[:, :-1] == before).all(axis=1))
        roots, first = np.unique(branches[here, -1], return_index=True)
        order = np.lexsort(table[here[first]][:, columns].T[::-1])
        for number, root in enumerate(roots[order].tolist()):
            result[here[branches[here, -1] == root]] = number
    return result
