"""Why a position cannot be assembled: what is too short or too long, by how much, and at which inputs it closes."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator

import numpy as np

from gimcli.canonical import first_least, ranks
from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembler
from gimcli.motion.motion import Motion
from gimcli.motion.side_by_side import machine_inputs
from gimcli.motion.solve import solve
from gimcli.numerics.along import bisected
from gimcli.positions.dispatch import plain
from gimcli.positions.options import TOLERANCE, Options
from gimcli.rounding import input_value, interval, length_with_unit, number
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import Check, checks, errors
from gimcli.structure.steps import NONE, Constraint, Dyad, Place, Plan, Vector

SAMPLES = 180
"""Values of an input at which the mechanism is assembled."""

FAR = 3.0
"""Greatest length of a linear input that is tried, relative to the size of the mechanism."""

NAMED = 3
"""Number of constraints that are named with their errors."""

NEGLIGIBLE = 1e-6
"""Relative error, or angle [rad], of a constraint that is not named."""

CORRECT = "correct these dimensions, or use initial coordinates closer to an assembled position"
OTHERS = {
    "all": "`gim solve --all` searches all configurations",
    "random": "`gim solve --start random` tries random coordinates",
}
"""Commands that may find another configuration."""


def reason(
    mechanism: Mechanism,
    status: Status,
    inputs: FloatArray,
    tried: Collection[str] = (),
    options: Options | None = None,
) -> str:
    """Return the cause of a status, with numbers where a position at inputs (actuators,) cannot be assembled.

    tried: what need not be advised any more, "all" (configurations) and "random" (coordinates). Of several machines
    each that cannot be assembled has its cause. options: by which the position was not found.
    """
    if len(mechanism.machines) > 1:
        return "; ".join(_of_machines(mechanism, inputs, tried)) or status.text
    if status is Status.LIMIT and (gap := Unassembled(mechanism, inputs).certain_gap()):
        return f"{gap}; {status.text}"
    if status is not Status.NOT_ASSEMBLED:
        if options is None or (options.method, options.strategy, options.moves) != ("gim", "classic", ""):
            return status.text
        from gimcli.gim.sweeper import first_sequence

        radius = first_sequence(mechanism, "classic").radius_at(solve(mechanism, inputs, Options()).z)
        return f"{status.text}; the sequence by the rules of the paper has the spectral radius {radius:.4f} there"
    return "; ".join(Unassembled(mechanism, inputs).sentences(tried))


def _of_machines(mechanism: Mechanism, inputs: FloatArray, tried: Collection[str]) -> Iterator[str]:
    for one in mechanism.machines:
        own = machine_inputs(mechanism, one, inputs)
        status = solve(one.mechanism, own, Options()).status
        if status is not Status.OK:
            yield f"{one.name}: {reason(one.mechanism, status, own, tried)}"


def motion_reason(motion: Motion) -> str:
    """Return the cause of the status of the first row of a motion, or of each of its machines, that is not solved."""
    if motion.parts:
        unsolved = [part for part in motion.parts if not part.good.all()]
        return "; ".join(f"{part.mechanism.as_machine.name}: {motion_reason(part)}" for part in unsolved)
    first = int(np.argmin(motion.good))
    return reason(motion.mechanism, motion.overall, motion.inputs[:, first], options=motion.options)


class Unassembled:
    """A mechanism at inputs (actuators,) at which it cannot be assembled on the drawn branch."""

    def __init__(self, mechanism: Mechanism, inputs: FloatArray) -> None:
        self.mechanism, self.inputs = mechanism, inputs
        self.plan: Plan = make_plan(mechanism)
        self.assembler = Assembler(mechanism, self.plan, plain, TOLERANCE)
        row = self.assembler.assemble(inputs, mechanism.drawn).row
        self.z: ComplexArray = row.x + 1j * row.y
        self.failed = self.assembler.failed

    def sentences(self, tried: Collection[str] = ()) -> Iterator[str]:
        """Yield the cause, the inputs at which the mechanism can be assembled, and what to do."""
        gap = self._gap()
        none = "no position was found that satisfies all constraints"
        yield none + self._largest_errors() if gap is None else gap
        yield from self._late_start()
        yield from [CORRECT] if gap is None else self._where_it_closes()
        if gap is None or self._after_a_choice:
            yield from (text for what, text in OTHERS.items() if what not in tried)

    def certain_gap(self) -> str:
        """Return what cannot meet in every configuration, and by how much; "" if that is not known."""
        return "" if self._after_a_choice else self._gap() or ""

    @property
    def _after_a_choice(self) -> bool:
        """Whether a node that was placed before has two places, of which the other one has not been tried."""
        return any(isinstance(step, Dyad) and step.branch != NONE for step in self.plan.steps[: self.failed])

    # -- the step that fails --------------------------------------------------------------------

    def _gap(self) -> str | None:
        """Return what cannot meet and by how much, if the step that fails is a dyad of two loci."""
        step = self.plan.steps[self.failed] if self.failed != NONE else None
        if not isinstance(step, Dyad):
            return None
        loci = step.first, step.second
        vectors = (v for one in loci for v in (one.offset, one.vector))
        if any(v is not None and v.register != NONE for v in vectors):
            return None
        first, second = loci
        if first.kind == second.kind == SPAN:
            return self._of_circles(first, second)
        for circle, line in (loci, loci[::-1]):
            if circle.kind == SPAN and line.vector is not None:
                return self._of_line(circle, line, self._value(line.vector))
        return None

    def _of_circles(self, first: Constraint, second: Constraint) -> str | None:
        centres = self._centre(first), self._centre(second)
        a, b = (abs(float(one.value.at(self.inputs))) for one in (first, second))
        apart = abs(centres[0] - centres[1])
        base = f"{self.mechanism.nodes[first.q]}-{self.mechanism.nodes[second.q]}"
        own = [(first.name, a), (second.name, b)]
        if apart > a + b:
            return self._at_every_input(first, second, a + b) or (
                f"{_and(map(self._sized, own))} cannot span {base} ({self._length(apart)}):"
                f" {self._length(apart - a - b)} too short{self._at()}"
            )
        if apart < abs(a - b):
            long, short = sorted(own, key=lambda one: -one[1])
            return (
                f"{self._sized(long)} is too long for {self._sized(short)} and {base} ({self._length(apart)}): by"
                f" {self._length(long[1] - short[1] - apart)}{self._at()}"
            )
        return None

    def _of_line(self, circle: Constraint, line: Constraint, normal: complex) -> str:
        radius = abs(float(circle.value.at(self.inputs)))
        apart = self._centre(circle) - self._centre(line)
        distance = (apart * normal.conjugate()).real - float(line.value.at(self.inputs))
        away = abs(distance) / (abs(normal) or 1.0)
        where = f"which is {self._length(away)} from {self.mechanism.nodes[circle.q]}"
        return (
            f"{self._sized((circle.name, radius))} does not reach the line of {line.name}, {where}:"
            f" {self._length(away - radius)} too short{self._at()}"
        )

    def _at_every_input(self, first: Constraint, second: Constraint, reach: float) -> str:
        """Return the sentence for a loop with a crank that is too short at every angle of the crank; else ""."""
        frame = self.mechanism.members[FRAME].nodes
        for moved, fixed in ((first, second), (second, first)):
            place = next((s for s in self.plan.steps if isinstance(s, Place) and s.node == moved.q), None)
            whole = place is not None and place.anchor in frame and fixed.q in frame
            if place is None or not whole or place.vector.actuator == NONE or moved.offset or fixed.offset:
                continue
            crank = abs(self._value(place.vector))
            base = abs(self.z[place.anchor] - self.z[fixed.q])
            if base > crank + reach:
                names = [self._between(place.anchor, place.node), moved.name, fixed.name]
                sizes = [crank, *(abs(float(one.value.at(self.inputs))) for one in (moved, fixed))]
                parts = " + ".join(self._sized(one) for one in zip(names, sizes, strict=True))
                ends = f"{self.mechanism.nodes[place.anchor]}-{self.mechanism.nodes[fixed.q]} ({self._length(base)})"
                return f"{parts} cannot span {ends}: {self._length(base - crank - reach)} too short at every input"
        return ""

    # -- inputs at which it closes --------------------------------------------------------------

    def _late_start(self) -> Iterator[str]:
        """Yield where the law should start, if the mechanism can be assembled as drawn."""
        mechanism, drawn = self.mechanism, self.mechanism.drawn_inputs
        if not np.array_equal(self.inputs, mechanism.start_inputs) or not self._assembles(drawn):
            return
        for k, actuator in enumerate(mechanism.actuators):
            if abs(self.inputs[k] - drawn[k]) > NEGLIGIBLE:
                kind = {ANGLE: "angle", SPAN: "length", HEIGHT: "travel"}[actuator.kind]
                start, own = (self._input(k, value) for value in (self.inputs[k], drawn[k]))
                late = f"the law of {actuator.name} starts at {start}, the drawn {kind} is {own}"
                yield f"{late}: start it there with `by:`"

    def _where_it_closes(self) -> Iterator[str]:
        """Yield for each input the interval in which the mechanism can be assembled with the other inputs as given."""
        if self.plan.coupled or "every input" in (self._gap() or ""):
            return
        for k, actuator in enumerate(self.mechanism.actuators):
            found = self._interval(k)
            fixed = " (other inputs as given)" if len(self.inputs) > 1 else ""
            if found is None:
                yield f"it closes at no value of {actuator.name} that was tried{fixed}"
            else:
                low, high = self.mechanism.value_to_file(k, np.array(found)).tolist()
                yield f"it closes for {actuator.name} = {interval(self.mechanism, actuator.name, low, high)}{fixed}"

    def _interval(self, k: int) -> tuple[float, float] | None:
        """Return the interval of an input with assembled positions that is nearest to its given value."""
        given, actuator = float(self.inputs[k]), self.mechanism.actuators[k]

        def closes(value: float) -> bool:
            return self._assembles(np.where(np.arange(len(self.inputs)) == k, value, self.inputs))

        if actuator.rotary:
            return _nearest(closes, [given + math.tau * n / SAMPLES for n in range(-SAMPLES, SAMPLES + 1)], given)
        far = FAR * self.mechanism.size
        tried = np.linspace(-far if actuator.kind == HEIGHT else far / SAMPLES, far, SAMPLES)
        return _nearest(closes, sorted([*tried.tolist(), actuator.drawn]), given)

    def _assembles(self, inputs: FloatArray) -> bool:
        return self.assembler.assemble(inputs, self.mechanism.drawn).regular

    # -- the largest errors ---------------------------------------------------------------------

    def _largest_errors(self) -> str:
        """Return the constraints with the largest errors in the position that satisfies all of them best."""
        z = self._closest()
        found = [
            (error, self._wrong(check, error, z))
            for check, error in zip(checks(self.mechanism), self._errors(z), strict=True)
            if error > NEGLIGIBLE
        ]
        sizes = np.array([error for error, _ in found])
        order = np.argsort(
            -ranks(sizes, NEGLIGIBLE * np.max(sizes, initial=0.0)), kind="stable"
        )  # equal: as in the file
        named = [found[k][1] for k in order[:NAMED].tolist()]
        return f"; in the closest one, {_and(named)}" if named else ""

    def _closest(self) -> ComplexArray:
        """Return the positions (nodes,) with the least sum of squared errors, from the drawn ones."""
        from scipy.optimize import least_squares

        mechanism = self.mechanism
        free = [k for k in range(len(mechanism.nodes)) if k not in mechanism.members[FRAME].nodes]
        z = mechanism.drawn.copy()

        def all_errors(x: FloatArray) -> FloatArray:
            z[free] = x[: len(free)] + 1j * x[len(free) :]
            return np.asarray(np.nan_to_num(self._errors(z), nan=1e3, posinf=1e3))

        start = np.concatenate([z[free].real, z[free].imag])
        all_errors(least_squares(all_errors, start, max_nfev=200).x)
        return z

    def _errors(self, z: ComplexArray) -> list[float]:
        """Return the errors of all constraints in positions (nodes,)."""
        return [float(error[0]) for _, _, error in errors(self.mechanism, z[:, None], self.inputs[:, None])]

    def _wrong(self, check: Check, error: float, z: ComplexArray) -> str:
        """Return the error of one constraint with numbers."""
        if check.kind == ANGLE:
            angle = np.degrees(error) if self.mechanism.angle_unit == "deg" else error
            return f"{check.name} is {number(float(angle))} {self.mechanism.angle_unit} off"
        if check.kind == HEIGHT:
            return f"{check.name} is {self._length(error * self.mechanism.size)} off its line or travel"
        wanted = abs(float(check.value.at(self.inputs)))
        return f"{check.name} is {self._length(abs(z[check.p] - z[check.q]))} instead of {self._length(wanted)}"

    # -- words ----------------------------------------------------------------------------------

    def _centre(self, locus: Constraint) -> complex:
        offset = self._value(locus.offset) if locus.offset is not None else 0.0
        return complex(self.z[locus.q] + offset)

    def _value(self, vector: Vector) -> complex:
        base = self.z[vector.v] - self.z[vector.u] if vector.u != NONE else 1.0
        angle = vector.turn * self.inputs[vector.actuator] if vector.actuator != NONE else 0.0
        return complex(vector.z * base * np.exp(1j * angle))

    def _between(self, a: int, b: int) -> str:
        """Return the name of the moving member that has two nodes, else the names of the nodes."""
        members = self.mechanism.members[FRAME + 1 :]
        return next(
            (m.name for m in members if {a, b} <= set(m.nodes)), f"{self.mechanism.nodes[a]}-{self.mechanism.nodes[b]}"
        )

    def _sized(self, one: tuple[str, float]) -> str:
        return f"{one[0]} ({self._length(one[1])})"

    def _length(self, value: float) -> str:
        return length_with_unit(self.mechanism, float(value) * self.mechanism.scale)

    def _input(self, k: int, value: float) -> str:
        own = float(self.mechanism.value_to_file(k, np.array([value]))[0])
        name = self.mechanism.actuators[k].name
        return f"{input_value(self.mechanism, name, own)} {self.mechanism.unit_of(self.mechanism.actuators[k])}"

    def _at(self) -> str:
        named = [f"{a.name} = {self._input(k, float(self.inputs[k]))}" for k, a in enumerate(self.mechanism.actuators)]
        return f" at {', '.join(named)}" if named else ""


def _nearest(closes: Callable[[float], bool], values: list[float], given: float) -> tuple[float, float] | None:
    """Return the interval around the value nearest to `given` at which something closes; None if it never does."""
    good = np.array([closes(value) for value in values])
    if not good.any():
        return None
    known, bad = np.flatnonzero(good)[::-1], np.flatnonzero(~good)  # of two that are equally near the upper one
    near = int(known[first_least(np.abs(np.array(values)[known] - given), NEGLIGIBLE * (values[-1] - values[0]))])
    below, above = np.max(bad[bad < near], initial=0), np.min(bad[bad > near], initial=len(values) - 1)
    low, high = (
        bisected(lambda value: not closes(value), values[n if good[n] else n + step], values[n])[0]
        for n, step in ((below, 1), (above, -1))
    )
    return low, high


def _and(texts: Iterator[str] | list[str]) -> str:
    words = list(texts)
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else "".join(words)
