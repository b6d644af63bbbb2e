"""All equilibria of a mechanism with one released input, along the whole circuit of its start position."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property

import numpy as np

from gimcli.branching.singular_positions import drawn_circuit
from gimcli.canonical import ROUNDING, first_greatest, whole_turns
from gimcli.continuation.circuit import Circuit
from gimcli.continuation.curve import PositionCurve
from gimcli.dynamic_data import TIME
from gimcli.dynamics.equilibria_balance import StaticBalance, released_inputs_line
from gimcli.dynamics.equilibria_curve import (
    BALANCE,
    STABLE,
    UNDECIDED,
    UNSTABLE,
    BalanceCurve,
    BalanceHistory,
    BalancePoint,
    CurveStop,
    Equilibria,
    Equilibrium,
    Push,
    joined,
)
from gimcli.dynamics.equilibria_roots import CurveRoot, curve_roots
from gimcli.dynamics.physical import input_units
from gimcli.input_laws import ConstantLaw
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.positions.inputs import InputLine
from gimcli.progress import Progress, no_progress
from gimcli.status import Status

NO_GAIN = 1e-9
"""Change of the potential in one round, relative to its range, that is an error of the integral."""

MEETING = 1e-6
"""Distance below which an equilibrium is at a change point; such points are known to half the digits."""

RESTING = 1e-9
"""Component of a unit tangent below which the input is at a limit."""


def released_circuit(mechanism: Mechanism, released: int, inputs: FloatArray, tolerance: float) -> Circuit:
    """Return the circuit through the start inputs (actuators,) on which one input moves and the others are held."""
    base, along = released_inputs_line(mechanism, [released], inputs)
    values = base + along[:, 0] * inputs[released]
    own = tuple(replace(a, law=ConstantLaw(float(u))) for a, u in zip(mechanism.actuators, values, strict=True))
    held = replace(mechanism, actuators=own)
    return drawn_circuit(held, tolerance, PositionCurve(held, InputLine(base, along[:, 0], released)))


class CircuitEquilibria:
    """The search for all equilibria on a circuit."""

    def __init__(
        self, circuit: Circuit, balance: StaticBalance, middle: float, progress: Progress = no_progress
    ) -> None:  # fmt: skip
        """Take a circuit; middle: value of the released input [rad] from which a full turn extends to both sides."""
        assert circuit.curve.line is not None
        self.curve, self.circuit, self.mechanism = BalanceCurve(circuit, balance), circuit, circuit.mechanism
        self.main, self.middle, self.progress = circuit.curve.line.main, middle, progress
        self.metre = float(input_units(self.mechanism)[self.main])
        self.points: list[BalancePoint] = []
        self.roots: list[CurveRoot] = []
        self.cut = False
        self.along = self.circuit.lengths / self.circuit.lengths[-1]

    def run(self) -> Equilibria:
        """Return all equilibria, in the order of the circuit."""
        self.points = self.curve.resolved(0)
        sizes = [at.size for at in self.points]
        everywhere = max(abs(at.force) for at in self.points) <= BALANCE.nothing * max(sizes)
        if not everywhere:
            self.roots = curve_roots(self.curve, self.points)
            if self.curve.winds:
                self._wind()
        self.potential = np.array([at.potential for at in self.points]) - self._work()
        self.heights = [self._potential(root.at) for root in self.roots]
        listed = [self._equilibrium(root, height) for root, height in zip(self.roots, self.heights, strict=True)]
        listed = [replace(one, pushes=self._pushes(k, listed)) for k, one in enumerate(listed)]
        listed = self._turned(listed)
        curve, start = self.circuit.curve, self.curve.places[self.circuit.start]
        return Equilibria(
            tuple(listed), (self.main,), curve.nodes(start.p), curve.inputs(start.p),
            np.array([start.effort / self.metre]), self.curve.balance.conservative, everywhere, max(sizes),
            self._history(), self.circuit.closed, self.circuit.ended, len(self.circuit.crossings), self._gain(),
            self.curve.winds, self.cut, limited=self.curve.ended(),
        )  # fmt: skip

    # -- rounds ---------------------------------------------------------------------------------------

    def _add_round(self, number: int) -> list[BalancePoint]:
        """Add the points and the roots of a round; return its points."""
        points = self.curve.resolved(number)
        self.progress(abs(number), BALANCE.rounds)
        if number < 0:
            points[-1] = joined(points[-1], self.points[0])
        else:
            points[0] = joined(points[0], self.points[-1])
        fresh, before, after = curve_roots(self.curve, points, self.roots), points[:-1], points[1:]
        self.points = [*before, *self.points] if number < 0 else [*self.points, *after]
        self.roots = [*fresh, *self.roots] if number < 0 else [*self.roots, *fresh]
        return points

    def _wind(self) -> None:
        """Examine further rounds, in both senses, until a torsion spring exceeds all other forces."""
        for sense in (1, -1):
            for number in range(1, BALANCE.rounds + 1):
                if self.curve.ended():
                    return
                before = len(self.roots)
                points = self._add_round(sense * number)
                if len(self.roots) == before and all(sense * at.force < 0.0 for at in points):
                    break
            else:
                self.cut = True

    def _work(self) -> FloatArray:
        """Return the work of the forces without a potential since the start [J]."""
        work = self.curve.work(self.points)
        first = next(k for k, at in enumerate(self.points) if at.mark >= self.circuit.start)
        return np.asarray(work - work[first])

    def _gain(self) -> float:
        """Return the change of the potential in one round of a closed circuit [J]; 0 if it is rounding."""
        change = float(self.potential[-1] - self.potential[0])
        if not self.circuit.closed or self.curve.winds or abs(change) <= NO_GAIN * float(np.ptp(self.potential)):
            return 0.0
        return change

    # -- equilibria -----------------------------------------------------------------------------------

    def _equilibrium(self, root: CurveRoot, height: float) -> Equilibrium:
        """Return an equilibrium, with input and potential of the turn around the middle."""
        at, curve = root.at, self.circuit.curve
        inputs = curve.inputs(at.p)
        potential = height + self._turns(float(inputs[self.main])) * self._gain()
        open_one = (
            root.multiplicity % 2 == 0
            or any(  # the forces along other branches that meet there do not count
                np.linalg.norm(at.p[:-1] - met.p[:-1]) <= MEETING for met in self.circuit.crossings.values()
            )
        )
        stability = UNDECIDED if open_one else UNSTABLE if root.rises else STABLE
        stiffness = None
        if abs(at.rate) > RESTING and root.smooth:
            own = -at.slope if root.multiplicity == 1 else 0.0
            stiffness = np.array([[own / (at.rate * self.metre) ** 2]])
        return Equilibrium(
            curve.nodes(at.p), self._rolled(inputs), potential, stability,
            int(stability == UNSTABLE), root.multiplicity, stiffness, root.residual,
            Status.OK if root.converged else Status.NOT_CONVERGED, self._fraction(at.stop),
        )  # fmt: skip

    def _fraction(self, stop: CurveStop) -> float:
        low, high = self.along[stop.index], self.along[min(stop.index + 1, self.curve.count)]
        return stop.round + float(low + stop.part * (high - low))

    def _potential(self, at: BalancePoint) -> float:
        """Return the potential of a point, less the work of the forces without a potential since the start."""
        if self.curve.balance.conservative:
            return at.potential
        k = max(k for k, own in enumerate(self.points) if own.mark <= at.mark)
        before = self.points[k]
        return at.potential - before.potential + float(self.potential[k]) - float(self.curve.work([before, at])[1])

    # -- pushes ---------------------------------------------------------------------------------------

    def _pushes(self, number: int, listed: list[Equilibrium]) -> tuple[Push, ...]:
        if listed[number].stability != STABLE:
            return ()
        found = (self._push(number, sense, listed) for sense in (1, -1))
        return tuple(push for push in found if push is not None)

    def _push(self, number: int, sense: int, listed: list[Equilibrium]) -> Push | None:
        """Return what it takes to reach the next equilibrium in a sense of the circuit; None if there is none."""
        target, wraps = number + sense, False
        if not 0 <= target < len(listed):
            if not self.circuit.closed or self.curve.winds or len(listed) < 2:
                return None
            target, wraps = target % len(listed), True
        path = self._path(number, target, sense, wraps)
        barrier = self.heights[target] - self.heights[number] + sense * wraps * self._gain()
        direction = sense if path[0].rate >= 0.0 else -sense
        effort, at = self._greatest(path)
        inputs = self._rolled(self.circuit.curve.inputs(at.p))
        return Push(direction, None if effort is None else effort / self.metre, inputs, barrier, target)

    def _path(self, number: int, target: int, sense: int, wraps: bool) -> list[BalancePoint]:
        """Return the points from one root to another, in a sense of the circuit."""
        one, other = self.roots[number].at, self.roots[target].at
        points = self.points[:-1] if wraps else self.points
        low, high = (one, other) if sense > 0 else (other, one)
        if wraps:
            between = [at for at in points if at.mark > low.mark] + [at for at in points if at.mark < high.mark]
        else:
            between = [at for at in points if low.mark < at.mark < high.mark]
        path = [low, *(between or self.curve.middles([(low, high, 0.5)])), high]
        return path if sense > 0 else path[::-1]

    def _greatest(self, path: list[BalancePoint]) -> tuple[float | None, BalancePoint]:
        """Return the effort of greatest magnitude on a path between two roots, and its point."""
        for at in path:
            if at.rate * path[0].rate <= RESTING**2 or abs(at.rate) <= RESTING:
                return None, at
        k = first_greatest(np.abs([at.effort for at in path]))
        best = path[k]
        for one, other in ((path[k - 1], best), (best, path[k + 1])) if 0 < k < len(path) - 1 else ():
            found = self._extreme(one, other)
            if found is not None and abs(found.effort) > (1.0 + ROUNDING) * abs(best.effort):
                best = found
        return best.effort, best

    def _extreme(self, one: BalancePoint, other: BalancePoint) -> BalancePoint | None:
        """Return the point between two points at which the effort is greatest; None if there is none."""
        if one.mark > other.mark:
            one, other = other, one
        if one.effort_slope * other.effort_slope >= 0.0 or one.stop.round != other.stop.round:
            return None
        if other.mark > math.floor(one.mark) + 1.0:
            return None
        return self.curve.between([(one, other)], "effort_slope")[0]

    def _history(self) -> BalanceHistory:
        curve, p = self.circuit.curve, np.array([at.p for at in self.points]).T
        turns = np.array([self._turns(q) for q in p[-1].tolist()])
        p[-1] += turns * self.curve.turn
        potential = self.potential + turns * self._gain()
        fraction = np.array([self._fraction(at.stop) for at in self.points])
        effort = np.array([at.effort if abs(at.rate) > RESTING else math.inf for at in self.points]) / self.metre
        first = int(np.argmax(turns != turns[0]))  # the row at which the turn around the middle begins
        if first:
            order = [*range(first, len(turns) - 1), *range(first + 1)]
            p, potential, fraction, effort = p[:, order], potential[order], fraction[order], effort[order]
            p[-1, -1], potential[-1] = p[-1, 0] + self.curve.turn, potential[0] + self._gain()
        inputs = curve.inputs(p)
        return BalanceHistory(curve.nodes(p), inputs, fraction, potential, effort)

    # -- turns ----------------------------------------------------------------------------------------

    @cached_property
    def _single(self) -> bool:
        """Whether the released input makes full turns in one sense, so that they may begin anywhere."""
        q = np.array([at.p[-1] for at in self.points])
        steady = bool(np.all(np.diff(q) * np.sign(self.curve.turn) > 0.0))
        balance = self.curve.balance
        tabled = any(load.over != TIME for load in balance.loads if load.curve is not None)
        tabled |= any(e.effort.curve is not None and e.effort.over == "value" for e in balance.efforts)
        return steady and abs(self.curve.turn) > 0.0 and not self.curve.winds and not tabled

    def _turns(self, q: float) -> int:
        """Return the number of rounds by which a value of the input is moved to be next to the middle.

        Of the two ends of the turn, which are the same position, the one closer to 0 is taken, 180 before -180 degrees.
        """
        if not self._single:
            return 0
        turn = self.curve.turn
        sense = math.copysign(1.0, turn) * (1.0 if self.middle <= ROUNDING * abs(turn) else -1.0)
        return -round(sense * float(whole_turns(sense * (q - self.middle), turn)))

    def _turned(self, listed: list[Equilibrium]) -> list[Equilibrium]:
        """Return equilibria in the order of the turn around the middle."""
        if not self._single:
            return listed
        sense = math.copysign(1.0, self.curve.turn)
        order = sorted(range(len(listed)), key=lambda k: sense * listed[k].inputs[self.main])
        places = {old: new for new, old in enumerate(order)}
        renumbered = [tuple(replace(p, target=places[p.target]) for p in one.pushes) for one in listed]
        return [replace(listed[k], pushes=renumbered[k]) for k in order]

    def _rolled(self, inputs: FloatArray) -> FloatArray:
        """Return inputs (actuators,) in the turn around the middle."""
        line = self.circuit.curve.line
        assert line is not None
        return np.asarray(inputs + line.along * (self._turns(float(inputs[self.main])) * self.curve.turn))
