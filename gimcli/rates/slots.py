"""A position and its derivatives by slots: values of nodes, directions, inputs and rotations.

Slot 0 is the position, every other slot a derivative along the rates of the inputs. With f_k for slot k of f and
(i, j, c) its cross terms, Leibniz's rule is

    (f g)_k = f g_k + f_k g + c (f_i g_j + f_j g_i)

with no cross terms for a first derivative, (i, i, 1) for a second one, (s, t, 1) for the mixed one along s and t, and
(1, 2, 3) for a third one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gimcli.calculus.numbers import scalar
from gimcli.calculus.recorded import Recorded
from gimcli.kernels import tape as kernels
from gimcli.mechanism import FRAME, Mechanism
from gimcli.rates.tape import ComplexLanes, Lane, Number, Real, Tape, Term, vanishes
from gimcli.structure.steps import NONE, Value, Vector


@dataclass(frozen=True)
class Slot:
    """A requested derivative.

    The derivative of the inputs is row `given` of the given derivatives, or 1 for the actuator `unit`, otherwise 0.
    That of the mechanism's own numbers is the one by the variable `dimension` of their recording, otherwise 0.
    """

    cross: tuple[int, int, int] | None = None
    given: int | None = None
    unit: int | None = None
    dimension: int | None = None
    order: int = 1


POSITION = Slot(given=0, order=0)


class Nodes(dict[int, list[Number]]):
    """Nodes by slots; the position of each is known, its derivatives are 0 until they are computed."""

    def __init__(self, tape: Tape, slots: int) -> None:
        super().__init__()
        self.tape, self.slots = tape, slots

    def __missing__(self, node: int) -> list[Number]:
        to = self.tape.keep(2)
        self.tape.emit(kernels.NODE, to, node)
        self[node] = [ComplexLanes(to), *[0j] * (self.slots - 1)]
        return self[node]


class SlotValues:
    """The values computed so far, by slots."""

    def __init__(self, mechanism: Mechanism, slots: Sequence[Slot]) -> None:
        self.mechanism, self.slots, self.tape = mechanism, slots, Tape()
        fixed = mechanism.members[FRAME]
        self.nodes = Nodes(self.tape, len(slots))
        for node, z in zip(fixed.nodes, fixed.shape, strict=True):
            self.nodes[node] = [scalar(self.number(z, k)) for k in range(len(slots))]
        self.registers: dict[int, list[Number]] = {}
        self.inputs: dict[tuple[int, int], Real] = {}
        self.turns: dict[tuple[int, int], Number] = {}

    def number(self, number: Any, k: int) -> Any:
        """Return slot k of a number of the mechanism."""
        variable = self.slots[k].dimension
        if k and (variable is None or not isinstance(number, Recorded)):
            return 0.0
        return number.recording.slope(number, variable) if k else number

    # -- inputs --------------------------------------------------------------------------------

    def input(self, actuator: int, k: int) -> Real:
        """Return slot k of an input."""
        key = actuator, k
        if key not in self.inputs:
            slot, tape = self.slots[k], self.tape
            if slot.given is not None:
                to = tape.keep(1)
                tape.emit(kernels.VALUE, to, slot.given, actuator)
                self.inputs[key] = Lane(to)
            else:
                self.inputs[key] = 1.0 if slot.unit == actuator else 0.0
        return self.inputs[key]

    def turn(self, actuator: int, k: int) -> Number:
        """Return slot k of e = exp(i theta), from the derivatives of e' = i theta' e."""
        if (actuator, k) not in self.turns:
            self.turns[actuator, k] = self._turn(actuator, k)
        return self.turns[actuator, k]

    def _turn(self, actuator: int, k: int) -> Number:
        tape = self.tape
        if k == 0:
            to = tape.keep(2)
            tape.emit(kernels.COS_SIN, to, tape.lane(self.input(actuator, 0)))
            return ComplexLanes(to)
        i, j, c = self.slots[k].cross or (0, 0, 0)
        terms = [(k, 0, 1.0)] if c == 0 else [(k, 0, 1.0), (i, j, 1.0), (j, i, c - 1.0)]
        parts = [(f, self.input(actuator, p), self.turn(actuator, n)) for p, n, f in terms if f != 0.0]
        parts = [(f, rate, e) for f, rate, e in parts if not vanishes(rate) and not vanishes(e)]
        to = tape.keep(2) if parts else 0
        for n, (f, rate, e) in enumerate(parts):
            tape.emit(kernels.ADD_TURN if n else kernels.TURN, to, tape.lane(rate), tape.lane(e), f=f)
        return ComplexLanes(to) if parts else 0j

    # -- vectors and equations -----------------------------------------------------------------

    def leibniz(self, f: Mapping[int, Number], g: Mapping[int, Number], k: int) -> list[Term]:
        """Return the terms of slot k of a product."""
        if k == 0:
            return [(1.0, f[0], g[0])]
        i, j, c = self.slots[k].cross or (0, 0, 0)
        cross: list[Term] = [(2.0 * c, f[i], g[i])] if i == j else [(1.0 * c, f[i], g[j]), (1.0 * c, f[j], g[i])]
        return [(1.0, f[0], g[k]), (1.0, f[k], g[0]), *(cross if c else [])]

    def base(self, vector: Vector, k: int) -> Number:
        """Return slot k of the difference of nodes to which a vector is fixed."""
        if vector.u != NONE:
            return self.tape.plus(self.nodes[vector.v][k], self.nodes[vector.u][k], -1.0)
        if vector.register != NONE:
            return self.registers[vector.register][k]
        return 1.0 + 0j if k == 0 else 0j

    def e(self, vector: Vector, k: int) -> Number:
        """Return slot k of the rotation of a vector by an actuator."""
        if vector.actuator == NONE:
            return 1.0 + 0j if k == 0 else 0j
        return self.turn(vector.actuator, k)

    def total(self, vector: Vector, terms: list[Term]) -> Number:
        """Return a sum of products, conjugated or not, as the sense of rotation of a vector requires."""
        return self.tape.products(terms, conjugate=vector.turn < 0)

    def vector(self, vector: Vector, k: int) -> Number:
        """Return slot k of a vector that moves with nodes."""
        return self.stretched(self.tape.scaled(self.turned(vector, k), vector.z), vector, k)

    def turned(self, vector: Vector, k: int) -> Number:
        """Return slot k of a vector without its constant factor z."""
        if vector.actuator == NONE:
            return self.base(vector, k)
        turns, bases = ({n: part(vector, n) for n in self.needed(k)} for part in (self.e, self.base))
        return self.total(vector, self.leibniz(turns, bases, k))

    def stretched(self, found: Number, vector: Vector, k: int) -> Number:
        """Return slot k of a vector from that at a constant factor z."""
        z = self.number(vector.z, k) if k else 0.0
        return found if vanishes(z) else self.tape.plus(found, self.turned(vector, 0), z)

    def needed(self, k: int) -> set[int]:
        """Return the slots of the factors that are needed for slot k of a product."""
        return {0, k, *(self.slots[k].cross or (0, 0))[:2]}

    def value(self, value: Value, k: int) -> Real:
        """Return slot k of a length, which is constant or a linear function of an input."""
        constant: float = self.number(value.constant, k)
        gain: float = self.number(value.gain, k)
        if value.actuator == NONE:
            return constant
        given = self.input(value.actuator, k if vanishes(gain) else 0)  # an input does not depend on a dimension
        gain = value.gain if vanishes(gain) else gain
        if isinstance(given, Lane):
            return self.tape.real(kernels.AFFINE, given.lane, f=constant, g=gain)
        return constant + gain * given
