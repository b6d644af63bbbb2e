"""Tangents of a tape: after each operation, those that carry the derivatives of its result along some tangents.

Only derivatives that can differ from 0 are recorded. A tangent is one of the variables of the recording of the tape's
constants, or another direction in which the given numbers change.

Source: Griewank & Walther, Evaluating Derivatives, 2008, chapter 3 (forward mode).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from gimcli.calculus.recorded import Recorded, Recording
from gimcli.kernels import tape as kernels
from gimcli.mechanism import BoolArray
from gimcli.rates.tape import STEP, ComplexLanes, Lane, Tape
from gimcli.rates.tape_numbers import TapeNumber, lanes


class Varying(NamedTuple):
    """Which of the given numbers change along each tangent."""

    nodes: BoolArray  # (tangents, nodes)
    given: BoolArray  # (tangents, slots, actuators)


class Tangents:
    """Records a tape again, with some of its tangents, as the tape `made`."""

    def __init__(
        self, tape: Tape, recording: Recording, varying: Varying, along: Iterable[int], results: tuple[int, int]
    ) -> None:  # fmt: skip
        """Take the tape, and the numbers of slots of points and of angles that it writes.

        Slots of tangent k are written and read k + 1 times their number after those of the values; nodes likewise.
        """
        self.tape, self.recording, self.varying, self.results = tape, recording, varying, results
        self.along, self.made, self.size = list(along), Tape(), tape.kept + tape.most
        made = self.made
        made.kept, made.most, made.used, made.constants = tape.kept, tape.most, tape.most, tape.constants.copy()
        self.first = made.keep(self.size * len(self.along))
        self.fixed = dict(tape.constants.values())
        self.varied: dict[int, set[int]] = defaultdict(set)  # the tangents along which a lane changes
        self.varied |= {lane: self.variables(value) for lane, value in self.fixed.items()}
        for head, factors in zip(tape.heads, tape.factors, strict=True):
            made.heads.append(list(head))
            made.factors.append(factors)
            if head[0] in FOLLOWED:
                FOLLOWED[head[0]](self, head, *factors)

    # -- numbers -------------------------------------------------------------------------------

    def variables(self, *numbers: Any) -> set[int]:
        """Return the tangents along which some constants change."""
        places = [number.place for number in numbers if isinstance(number, Recorded)]
        return set(self.recording.variables_of(places).intersection(self.along)) if places else set()

    def moving(self, lane: int, count: int = 1) -> set[int]:
        """Return the tangents along which a real (1) or complex number (2) in lanes changes."""
        return self.varied[lane] | self.varied[lane + 1] if count > 1 else self.varied[lane]

    def image(self, lane: int, k: int) -> int:
        """Return the lane for the derivative of a lane along tangent k."""
        own = lane if lane < STEP else self.tape.kept + lane - STEP
        return self.first + (k - self.along[0]) * self.size + own

    def change(self, lane: int, k: int) -> list[int]:
        """Return the lane with the derivative of a number along tangent k; none if it is 0."""
        if k not in self.varied[lane]:
            return []
        known = lane in self.fixed
        return [self.made.constant(self.recording.slope(self.fixed[lane], k)) if known else self.image(lane, k)]

    def note(self, to: int, count: int, moved: set[int]) -> None:
        """Note along which tangents the result of an operation changes."""
        for n in range(count):
            self.varied[to + n] = moved

    # -- operations ----------------------------------------------------------------------------

    def read(self, head: list[int], *_: Any) -> None:
        """Read the derivatives of a node or of an input."""
        op, to, a, b = head[:4]
        node = op == kernels.NODE
        table = self.varying.nodes[:, :, None] if node else self.varying.given
        moved = {k for k in self.along if table[k, a, b]}
        for k in moved:
            self.made.emit(op, self.image(to, k), (k + 1) * table.shape[1] + a, b)
        self.note(to, 1 + node, moved)

    def write(self, head: list[int], *_: Any) -> None:
        """Write the derivatives of a result."""
        op, lane, slot, number = head[:4]
        for k in self.along:
            for own in self.change(lane, k):
                self.made.emit(op, own, (k + 1) * self.results[op == kernels.WRITE_ANGLE] + slot, number)

    def product(self, head: list[int], f: Any, _: Any) -> None:
        """Record the derivatives of a product of numbers and of the factor f, which may be added to the result."""
        op, to = head[:2]
        first, more, count, widths = PRODUCTS[op]
        used, varying = head[2 : 2 + len(widths)], self.variables(f)
        before = self.moving(to, count) if op == more else set[int]()
        moved = varying.union(*map(self.moving, used, widths))
        for k in moved:
            terms = [([*used[:n], x, *used[n + 1 :]], f) for n, lane in enumerate(used) for x in self.change(lane, k)]
            for own, factor in terms + [(used, self.recording.slope(f, k))] * (k in varying):
                self.made.emit(more if k in before else first, self.image(to, k), *own, f=factor)
                before = before | {k}
        self.note(to, count, moved | before)

    def sum(self, head: list[int], f: Any, g: Any) -> None:
        """Record the derivatives of a sum of constant factors times numbers, and of a real constant."""
        op, to, *operands = head
        if op == kernels.FOLLOW:
            op, f, g = kernels.AFFINE, 0.0, 1.0
        count, used, own = SUMS[op][0], operands[: SUMS[op][1]], self.variables(f, g)
        moved = own.union(*(self.moving(lane, count) for lane in used))
        for k in moved:
            lane, emit, zero = self.image(to, k), self.made.emit, [self.made.constant(0.0)]
            df, dg = (self.recording.slope(x, k) if k in own else 0.0 for x in (f, g))
            changes = (x for one in used for x in self.change(one, k) or zero)
            emit(op, lane, *changes, f=df if op == kernels.AFFINE else f, g=g)
            if k in own and count == 2:
                again = kernels.CARRY if op == kernels.CARRY else kernels.LINEAR
                emit(again, lane, lane, *(used[1:] or used), f=df, g=dg)
            elif k in own:
                for one, factor in zip(used, (dg,) if op == kernels.AFFINE else (df, dg), strict=True):
                    emit(kernels.COMBINE, lane, lane, one, f=1.0, g=factor)
        self.note(to, count, moved)

    def formula(self, head: list[int], *_: Any) -> None:
        """Record the derivatives of an operation by their formula."""
        op, to, *operands = head
        count, widths, slope = FORMULAS[op]
        own = list(zip(operands, widths, strict=False))
        moved = set[int]().union(*(self.moving(*one) for one in own))
        for k in moved:
            with self.made.step():
                both = [self.number(x, n) for lane, n in own for x in ([lane], self.change(lane, k))]
                found = self.made.lane(lanes(slope(self.number([to], count), *both)))
                put = kernels.AFFINE if count == 1 else kernels.SCALE
                self.made.emit(put, self.image(to, k), found, f=count - 1.0, g=2.0 - count)
        self.note(to, count, moved)

    def number(self, own: list[int], count: int) -> Any:
        """Return a number in lanes; 0 if there are none."""
        return TapeNumber(self.made, Lane(own[0]) if count == 1 else ComplexLanes(own[0])) if own else 0.0

    def meet(self, head: list[int], *_: Any) -> None:
        """Solve a.r' = -p' - a'.r and b.r' = -q' - b'.r; p and q are in the lanes from c on."""
        to, a, b, c, determinant = head[1:]
        moved = self.moving(a, 2) | self.moving(b, 2) | self.moving(c, 2)
        for k in moved:
            with self.made.step():
                right = self.made.take(2)
                for n, row in enumerate((a, b)):
                    terms = [(1.0, ComplexLanes(x), ComplexLanes(to)) for x in self.change(row, k)]
                    self.made.dots(right + n, terms, [(1.0, Lane(x), 1.0) for x in self.change(c + n, k)])
                self.made.emit(kernels.MEET, self.image(to, k), a, b, right, determinant)
        self.note(to, 2, moved)

    def solve(self, head: list[int], f: Any, g: Any) -> None:
        """Solve A x' = b' - A' x by the factors of A, for the solution x in place of b."""
        op, to, *operands = head
        again, rows, columns = (op, f, g) if op == kernels.SOLVE else (kernels.RESOLVE, f, f)
        entries = [(i, j, operands[0] + i * columns + j) for i in range(rows) for j in range(columns)]
        moved = set[int]().union(*(self.varied[lane] for *_, lane in entries), *map(self.moving, range(to, to + rows)))
        for k in moved:
            for i in range(to, to + rows):
                if k not in self.varied[i]:
                    self.made.emit(kernels.AFFINE, self.image(i, k), self.made.constant(0.0), g=0.0, f=0.0)
            for i, j, lane in entries:
                for own in self.change(lane, k):
                    self.made.emit(kernels.ADD_PRODUCT, self.image(to + i, k), own, to + j, f=-1.0)
            self.made.emit(again, self.image(to, k), *operands, f=f, g=g)
        self.note(to, rows, moved)


FORMULAS: dict[int, tuple[int, tuple[int, ...], Callable[..., Any]]] = {
    kernels.COS_SIN: (2, (1,), lambda v, p, dp: 1j * v * dp),
    kernels.UNIT: (2, (2,), lambda v, a, da: 1j * v * ((v.conjugate() * da).imag / (v.conjugate() * a).real)),
    kernels.INVERSE: (1, (2,), lambda v, a, da: -2.0 * v * v * (a.conjugate() * da).real),
    kernels.PHASE: (1, (2,), lambda v, a, da: (da / a).imag),
    kernels.QUOTIENT: (1, (1, 1), lambda v, p, dp, q, dq: (dp - v * dq) / q),
    kernels.ROOT: (1, (1,), lambda v, p, dp: 0.5 * dp / v),
}  # fmt: skip
"""The lanes of the result and of the operands, and the derivative from the result v and each operand with its own."""

SUMS = {
    kernels.SCALE: (2, 1), kernels.LINEAR: (2, 2), kernels.CARRY: (2, 3),
    kernels.AFFINE: (1, 1), kernels.COMBINE: (1, 2), kernels.FOLLOW: (1, 1),
}  # fmt: skip
"""The lanes of a number, and how many numbers there are."""

PRODUCTS: dict[int, tuple[int, int, int, tuple[int, ...]]] = {
    op: (first, more, count, operands)
    for first, more, count, operands in (
        (kernels.TIMES, kernels.ADD_TIMES, 2, (2, 2)), (kernels.CONJUGATE, kernels.ADD_CONJUGATE, 2, (2, 2)),
        (kernels.TURN, kernels.ADD_TURN, 2, (1, 2)), (kernels.DOT, kernels.ADD_DOT, 1, (2, 2)),
        (kernels.PRODUCT, kernels.ADD_PRODUCT, 1, (1, 1)), (kernels.ACROSS, kernels.ADD_ACROSS, 1, (2, 2, 1)),
    )
    for op in (first, more)
}  # fmt: skip
"""The operation, the one that adds, the lanes of the result and of the operands."""

FOLLOWED: dict[int, Callable[..., None]] = {
    **dict.fromkeys(FORMULAS, Tangents.formula), **dict.fromkeys(SUMS, Tangents.sum),
    **dict.fromkeys(PRODUCTS, Tangents.product),
    kernels.NODE: Tangents.read, kernels.VALUE: Tangents.read, kernels.MEET: Tangents.meet,
    kernels.WRITE_POINT: Tangents.write, kernels.WRITE_ANGLE: Tangents.write,
    kernels.SOLVE: Tangents.solve, kernels.ELIMINATE: Tangents.solve,
}  # fmt: skip
"""What records the derivatives of each operation; those of determinants and factors are not needed."""
