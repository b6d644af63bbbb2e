"""What the curve of a motion says where rows are doubtful: limits, meetings of branches, and the ways out of them.

Rows are solved one by one at given inputs, which decides nothing where the inputs do not determine the position. There
the curve of positions and input is followed instead, the same by which circuits, singular positions and branches are
found.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from gimcli.continuation.arc import NODES, ArcPassage, Gap, SingularArc, make_arc
from gimcli.continuation.arclength import place
from gimcli.continuation.bifurcation import crossing
from gimcli.continuation.branches import Departure, departure
from gimcli.continuation.circuit import CIRCUIT, RESTS, Circuit, CircuitWalker, Ended
from gimcli.continuation.curve import PositionCurve
from gimcli.continuation.folds import between, fold_beside
from gimcli.errors import GimError, UsageError
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.motion.assemble import Assembler, Assembly
from gimcli.positions.inputs import InputLine
from gimcli.positions.row import Row
from gimcli.status import Status

LARGEST = 120
"""Coordinates up to which the curve is followed: its equations are kept as full tables."""

MOST = 400
"""Places that are walked from a row to what is doubtful."""

ASTERN = 1e-3
"""Part of a turn before what is doubtful from which it is approached."""

ABOUT = 1e-2
"""Distance of a start from the singular position that it stands for, or is taken from."""

NEAR = 1e-6
"""Distance of an assembled row from the position of the curve, relative to the size."""


class Guide:
    """The curve of a motion along a line of the inputs, or along the laws' time."""

    def __init__(self, line: InputLine | None, assembler: Assembler) -> None:
        self.mechanism, self.line, self.assembler = assembler.mechanism, line, assembler

    @cached_property
    def curve(self) -> PositionCurve | None:
        """The curve, if the mechanism is not too large for it."""
        if 2 * len(self.mechanism.nodes) > LARGEST:
            return None
        return PositionCurve(self.mechanism, self.line)

    def ahead(self, rows: Sequence[Row], sense: float, until: float, turn: float) -> ArcPassage | float | None:
        """Return the way through the first singular position after solved rows, up to a place; None where none is met.

        A number is the place that the motion approaches as it runs to infinity.
        """
        curve, last = self.curve, rows[-1].time
        if curve is None:
            return None
        start = next((row for row in reversed(rows) if row.time <= last - ASTERN * turn), rows[0])
        way = np.append(np.zeros(curve.system.n), sense)
        p = curve.point(start.x + 1j * start.y, sense * start.time * curve.span)
        walker = CircuitWalker(curve, place(curve, p, way))
        for _ in range(MOST):
            known = len(walker.places)
            if not walker.go():
                return None
            for k in range(known, len(walker.places)):
                arc = self._arc(walker, k)
                passage = arc and ArcPassage(arc, sense, self.assembled, -1.0)
                if passage and passage.ends[1] > last:
                    return passage
            if sense * walker.places[-1].p[-1] > (until + ASTERN * turn) * curve.span:
                return None
            if walker.escaped:
                end = walker.at_infinity()
                return None if end is None else sense * end / curve.span
        return None

    def around(
        self, z: ComplexArray, at: float, sense: float, branch: int = 1, along: FloatArray | None = None
    ) -> ArcPassage | None:
        """Return the way through a singular position z (nodes,) at a place, on one of its branches; None without one.

        `along`: the direction (n + 1,) of a motion that came there. Raises UsageError where there is no such branch.
        """
        curve = self.curve
        if curve is None:
            return None
        q = sense * at * curve.span
        try:
            start = departure(curve, z, q, along)
        except GimError:
            return None
        if start.first is None:
            return None
        if branch > 1 and branch > len(start.directions):
            raise UsageError(f"--branch {branch}: {len(start.directions)} branches meet at the first change point")
        if start.met is not None:
            return self._through(curve, start, sense, branch)
        fold = fold_beside(curve, start.place, ABOUT)
        if fold is None:
            return self._beside(curve, start, sense)
        arc = make_arc(curve, fold.p, fold.tangent)
        if arc is None or not arc.limit:
            return None
        stands = arc.distance(q, 1.0) == 0.0
        way = start.directions[branch - 1] if stands else start.place.p - fold.p
        return ArcPassage(arc, sense, self.assembled, float(np.copysign(1.0, way @ fold.tangent)))

    def other_end(self, passage: ArcPassage) -> ArcPassage | None:
        """Return the way in at the other limit of the arc that a limit ends; None where it has no other."""
        arc, curve = passage.arc, passage.arc.curve
        outer = arc.p[:, -1 if passage.side > 0.0 else 0]
        walker = CircuitWalker(curve, place(curve, outer, outer - arc.p[:, NODES]))
        for k in range(1, MOST):
            if len(walker.places) <= k and not walker.go():
                return None
            found = self._arc(walker, k)
            if found is not None and found.limit:
                side = -1.0
                return ArcPassage(found, -found.outwards(side), self.assembled, side)
        return None

    def _beside(self, curve: PositionCurve, start: Departure, sense: float) -> ArcPassage | None:
        """Return the way through a meeting of branches beside a regular place, on the branch that it is on."""
        here = start.place.p
        met = crossing(curve, here)
        if met is None or met.miss > CIRCUIT.exact or not 0.0 < np.linalg.norm(met.p - here) <= ABOUT:
            return None
        way = met.near(here - met.p)
        arc = None if way is None else make_arc(curve, met.p, way, met)
        return None if arc is None or arc.limit else ArcPassage(arc, sense, self.assembled)

    def _through(self, curve: PositionCurve, start: Departure, sense: float, branch: int) -> ArcPassage | None:
        """Return the way through a meeting of branches; branch 1 is the first that an input can drive."""
        assert start.met is not None
        assert start.first is not None
        only = (start.first,) if branch == 1 and abs(start.first[-1]) > RESTS else start.directions
        for way in only[branch - 1 : None if branch == 1 else branch]:
            if branch > 1 and abs(way[-1]) <= RESTS:
                raise UsageError(
                    f"--branch {branch}: the input rests on this branch at the change point and cannot drive it;"
                    " `gim trace --circuit --branch` follows it"
                )
            arc = make_arc(curve, start.met.p, way, start.met) if abs(way[-1]) > RESTS else None
            if arc is not None:
                return ArcPassage(arc, sense, self.assembled)
        if branch > 1:
            raise UsageError(f"--branch {branch}: the branch cannot be followed from the change point")
        return None

    def _arc(self, walker: CircuitWalker, k: int) -> SingularArc | None:
        """Return the arc through the singular position at, or just before, a place; None where there is none."""
        here, curve = walker.places[k], walker.curve
        if k in walker.crossings:
            return make_arc(curve, here.p, here.tangent, walker.crossings[k])
        before = walker.places[k - 1]
        if not before.tangent[-1] * here.tangent[-1] < 0.0 or k - 1 in walker.crossings:
            return None
        circuit = Circuit(curve, tuple(walker.places), walker.crossings, Ended.LONG)
        fold = between(circuit, k - 1, k, lambda at: float(at.tangent[-1]))
        return None if fold is None else make_arc(curve, fold.p, fold.tangent)

    def exact(self, gap: Gap, sense: float) -> float:
        """Return the place of the meeting of branches that a gap is about, to the last digits."""
        curve, row = self.curve, gap.at(gap.centre)
        if curve is None:
            return gap.centre
        found = crossing(curve, curve.point(row.x + 1j * row.y, sense * gap.centre * curve.span))
        return gap.centre if found is None else sense * float(found.p[-1]) / curve.span

    def assembled(self, p: FloatArray, at: float) -> Row | None:
        """Return the regular row of a position and parameter (n + 1,) at a place; None where the plan has none."""
        curve = self.curve
        assert curve is not None
        z = curve.nodes(p)
        found = self.assembler.assemble(curve.inputs(float(p[-1])), z, at)
        far = np.abs(found.row.x + 1j * found.row.y - z)
        return found.row if found.status is Status.OK and np.all(far <= NEAR * self.mechanism.size) else None


def direction(curve: PositionCurve, gap: Gap, sense: float = 1.0) -> FloatArray:
    """Return the direction (n + 1,) of a curve on the way through a singular position, or to a limit.

    sense: of the parameter as the gap's times grow; of several inputs 0, if they came there on another line.
    """
    low, high = gap.ends
    if gap.limit:  # from the end that is not the limit
        low, high = (low if gap.centre - low > high - gap.centre else high), gap.centre
    ends = [(curve.point(row.x + 1j * row.y, sense * row.time * curve.span)) for row in (gap.at(low), gap.at(high))]
    return np.asarray((ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0]))


def arrival(curve: PositionCurve, start: Assembly, single: bool) -> FloatArray | None:
    """Return the direction (n + 1,) in which a motion came to a singular start; None where none did."""
    return direction(curve, start.gap, float(single)) if start.gap is not None and start.came else None
