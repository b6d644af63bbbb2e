"""The curve of a motion near doubtful rows: it shows limits, meetings of branches, and how the motion continues.

Rows are solved at given inputs; this fails if the inputs do not determine the position. Then the curve of positions and
input is followed instead, as in the search for circuits, singular positions and branches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from operator import attrgetter

import numpy as np

from gimcli.continuation.arc import NODES, ArcPassage, Gap, make_arc
from gimcli.continuation.arclength import CurvePoint, between, correct, place
from gimcli.continuation.bifurcation import crossing
from gimcli.continuation.branches import Departure, departure
from gimcli.continuation.circuit import CIRCUIT, RESTS, STEPS, CircuitWalker
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import GimError, UsageError
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.motion.assemble import Assembler, Assembly
from gimcli.positions.inputs import InputLine
from gimcli.positions.position import Row
from gimcli.status import Status

LARGEST = 120
"""Greatest number of coordinates for which the curve is followed, because its matrices are dense."""

MOST = 400
"""Greatest number of points of the curve from a solved row to a singular position."""

BEHIND = 1e-3
"""Distance before a doubtful row, in turns, at which the curve is started."""

ABOUT = 1e-2
"""Greatest distance of a start position from a singular position that is used in its place."""

NEARER = (1.0, 0.7, 0.4)
"""Parts of this distance in which the limit is searched: the curve may turn before."""

NEAR = 1e-6
"""Greatest distance of a row of the plan from the position of the curve, relative to the size."""


class MotionCurve:
    """The curve of a motion along a line of the inputs, or along the time of the laws.

    "Coordinate" is that of a leg: s = sense * parameter / span, which increases with the time.
    """

    def __init__(self, line: InputLine | None, assembler: Assembler) -> None:
        self.mechanism, self.line, self.assembler = assembler.mechanism, line, assembler

    @cached_property
    def curve(self) -> PositionCurve | None:
        """The curve; None if the mechanism is too large."""
        return None if 2 * len(self.mechanism.nodes) > LARGEST else PositionCurve(self.mechanism, self.line)

    def ahead(self, rows: Sequence[Row], sense: float, until: float, turn: float) -> ArcPassage | float | None:
        """Return the passage of the first singular position after solved rows, up to coordinate `until`; None if none.

        If the motion goes to infinity instead, the result is the coordinate that it approaches.
        """
        curve, last = self.curve, rows[-1].time
        if curve is None:
            return None
        start = next((row for row in reversed(rows) if row.time <= last - BEHIND * turn), rows[0])
        along = np.append(np.zeros(curve.system.n), sense)
        p = curve.point(start.x + 1j * start.y, sense * start.time * curve.span)
        walker = CircuitWalker(curve, place(curve, p, along))
        for k in range(1, MOST):
            if len(walker.places) <= k and not walker.go():
                return None
            arc = self._arc(walker, k)
            if arc and (passage := replace(arc, sense=sense, assembled=self.assembled, side=-1.0)).ends[1] > last:
                return passage
            if sense * walker.places[k].p[-1] > (until + BEHIND * turn) * curve.span:
                return None
            if walker.escaped:
                end = walker.at_infinity()
                return None if end is None else sense * end / curve.span
        return None

    def around(
        self, z: ComplexArray, at: float, sense: float, branch: int = 1, along: FloatArray | None = None
    ) -> ArcPassage | None:
        """Return the passage of a singular position z (nodes,) at coordinate `at` on a branch; None if there is none.

        branch: number of the branch, from 1. along: the direction (n + 1,) of a motion that arrived there. Raises
        UsageError if there is no such branch or the input cannot drive it.
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
            raise UsageError(
                f"branch: expected a number from 1 to {len(start.directions)}, got {branch}: the number of"
                " branches at the first change point"
            )
        if start.met is not None:
            return self._through(curve, start, sense, branch)
        fold = fold_beside(curve, start.place, ABOUT)
        if fold is None:
            return self._beside(curve, start, sense)
        arc = make_arc(curve, fold.p, fold.tangent)
        if arc is None or not arc.limit:
            return None
        exact = arc.distance(q, 1.0) == 0.0
        direction = start.directions[branch - 1] if exact else start.place.p - fold.p
        side = float(np.copysign(1.0, direction @ fold.tangent))
        return replace(arc, sense=sense, assembled=self.assembled, side=side)

    def other_end(self, passage: ArcPassage) -> ArcPassage | None:
        """Return the passage towards the other limit of the circuit's interval; None if there is no other limit."""
        curve, outer = passage.curve, passage.end(passage.side)
        walker = CircuitWalker(curve, place(curve, outer, outer - passage.p[:, NODES]))
        for k in range(1, MOST):
            if len(walker.places) <= k and not walker.go():
                return None
            found = self._arc(walker, k)
            if found is not None and found.limit:
                return replace(found, sense=-found.outwards(-1.0), assembled=self.assembled, side=-1.0)
        return None

    def _beside(self, curve: PositionCurve, start: Departure, sense: float) -> ArcPassage | None:
        """Return the passage of a meeting of branches near a regular point, on the branch of this point; or None."""
        here = start.place.p
        met = crossing(curve, here)
        if met is None or met.miss > CIRCUIT.exact or not 0.0 < np.linalg.norm(met.p - here) <= ABOUT:
            return None
        tangent = met.near(here - met.p)
        arc = None if tangent is None else make_arc(curve, met.p, tangent, met)
        return None if arc is None or arc.limit else replace(arc, sense=sense, assembled=self.assembled)

    def _through(self, curve: PositionCurve, start: Departure, sense: float, branch: int) -> ArcPassage | None:
        """Return the passage of a meeting of branches; branch 1 is the first one that the input can drive."""
        assert start.met is not None
        assert start.first is not None
        only = (start.first,) if branch == 1 and abs(start.first[-1]) > RESTS else start.directions
        for tangent in only[branch - 1 : None if branch == 1 else branch]:
            if branch > 1 and abs(tangent[-1]) <= RESTS:
                raise UsageError(
                    f"branch {branch}: the input rate is zero on this branch at the change point, so that the input"
                    " cannot drive it; use `gim trace --circuit --branch`"
                )
            arc = make_arc(curve, start.met.p, tangent, start.met) if abs(tangent[-1]) > RESTS else None
            if arc is not None:
                return replace(arc, sense=sense, assembled=self.assembled)
        if branch > 1:
            raise UsageError(f"branch {branch}: the branch cannot be followed from the change point")
        return None

    def _arc(self, walker: CircuitWalker, k: int) -> ArcPassage | None:
        """Return the arc through the singular position at point k, or between it and the one before; None if none."""
        here, curve = walker.places[k], walker.curve
        if k in walker.crossings:
            return make_arc(curve, here.p, here.tangent, walker.crossings[k])
        before = walker.places[k - 1]
        if not before.rate * here.rate < 0.0 or k - 1 in walker.crossings:
            return None
        fold = between(curve, before, here, attrgetter("rate"), STEPS)
        return None if fold is None else make_arc(curve, fold.p, fold.tangent)

    def assembled(self, p: FloatArray, at: float) -> Row | None:
        """Return the row of the plan for a position and parameter (n + 1,); None if the plan cannot assemble it."""
        curve = self.curve
        assert curve is not None
        z = curve.nodes(p)
        found = self.assembler.assemble(curve.inputs(p), z, at)
        far = self.mechanism.apart(found.row.x + 1j * found.row.y, z)
        return found.row if found.status is Status.OK and np.all(far <= NEAR * self.mechanism.size) else None


def fold_beside(curve: PositionCurve, here: CurvePoint, reach: float) -> CurvePoint | None:
    """Return the limit of the parameter within a distance `reach` of a point, on either side; None if there is none."""

    def at(side: float) -> CurvePoint | None:
        tried = (correct(curve, here.p + side * part * here.tangent, STEPS, here.tangent) for part in NEARER)
        return next((place(curve, p, here.tangent) for p in tried if p is not None), None)

    behind, ahead = at(-reach), at(reach)
    return behind and ahead and between(curve, behind, ahead, attrgetter("rate"), STEPS)


def direction(curve: PositionCurve, gap: Gap, sense: float = 1.0) -> FloatArray:
    """Return the direction (n + 1,) of a curve through a singular position, or towards a limit.

    sense: of the parameter with increasing times of the gap; 0 for several inputs that arrived along another line.
    """
    low, high = gap.ends
    if gap.limit:  # start at the end that is not the limit
        low, high = (low if gap.centre - low > high - gap.centre else high), gap.centre
    ends = [(curve.point(row.x + 1j * row.y, sense * row.time * curve.span)) for row in (gap.at(low), gap.at(high))]
    return np.asarray((ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0]))


def arrival(curve: PositionCurve, start: Assembly, single: bool) -> FloatArray | None:
    """Return the direction (n + 1,) in which a motion arrived at a singular start; None if none did."""
    return direction(curve, start.gap, float(single)) if start.gap is not None and start.came else None
