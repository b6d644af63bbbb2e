"""Forces of many designs: the equations of the nominal mechanism for the rows of all designs, one after another.

Masses, centres, lengths, springs and the like are numbers of each row. What decides the equations (bodies, unknowns,
blocks) is that of the nominal design.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, is_dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import RuleNumber
from gimcli.calculus.recorded import Recorded, Recording
from gimcli.dynamic_data import TIME
from gimcli.dynamics.equilibrium_equations import TapeBalance, right_side
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.kinematic_history import Course, Turns
from gimcli.dynamics.loading import Loading
from gimcli.dynamics.statics import Statics, statics
from gimcli.families.design_rates import DesignFormulas
from gimcli.kernels import tape as kernels
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.positions.dispatch import choose
from gimcli.quantities.state import ApartError
from gimcli.rates.derivatives import ORDERS, PLAIN
from gimcli.rates.plan_rates import Differentiated
from gimcli.rates.slots import POSITION
from gimcli.rates.tape import ComplexLanes, Lane
from gimcli.rates.tape_numbers import GivenNumber, TapeNumber, lanes, number
from gimcli.structure.plan import make_plan

Formula = Callable[[Forces], Any]
"""A formula of forces in any numbers; x + iy of a vector."""


class DesignForces:
    """Computes formulas of the forces of designs along their motions.

    Each formula is recorded once, with the derivatives of the positions that it needs, and executed for all designs.
    """

    def __init__(self, mechanism: Mechanism, names: Sequence[str]) -> None:
        """Record the numbers of the equations; raise ApartError for mechanisms whose designs are computed singly.

        They have dry friction, gears, inputs that follow others, or redundant constraints.
        """
        recorded, self.recording = mechanism.written.recorded(mechanism, names, True)
        dry = any(_given(friction.mu) for friction in recorded.dynamics.frictions)
        if dry or recorded.gears or recorded.couplings or mechanism.complete:
            raise ApartError
        self.statics = statics(recorded)
        if self.statics.surplus:
            raise ApartError
        self.used = _used(recorded, self.recording, names)
        self.amounts, self.free = (
            [x.place for x in some if isinstance(x, Recorded)]
            for some in (_amounts(recorded), [spring.free for spring in recorded.dynamics.springs])
        )
        self._tapes: dict[tuple[Formula, ...], ForceTape] = {}

    def __call__(
        self, formulas: Iterable[Formula], designs: FloatArray, z: Any, given: Any, time: FloatArray,
        jit: str = "auto", notify: Any = None,
    ) -> dict[Formula, Any]:  # fmt: skip
        """Return formulas of forces (designs, rows) of designs in positions z (designs, nodes, rows).

        given (designs or 1, 3, actuators, rows): inputs and their derivatives at times [s] (designs or 1, rows). z and
        given may be dual numbers whose first tangents are the dimensions; the results are dual numbers then.
        """
        key = tuple(formulas)
        if key not in self._tapes:
            self._tapes[key] = ForceTape(self.statics, self.recording, key)
        known = self.recording.evaluate(designs.T, [*self.amounts, *self.free])
        if not isinstance(z, Dual) and any(np.any(known[place] == 0.0) for place in self.free):
            raise ApartError  # the ends of such a spring may meet
        found = self._tapes[key](designs, z, given, time, jit, notify)
        refused = np.any([np.zeros(len(designs)), *(known[place] < 0.0 for place in self.amounts)], axis=0)
        if refused.any():
            found = {own: np.where(refused[:, None], np.nan * values, values) for own, values in found.items()}
        return found


class ForceTape:
    """Formulas of forces on a tape, with recorded numbers of the designs."""

    def __init__(self, statics: Statics, recording: Recording, formulas: Sequence[Formula]) -> None:
        mechanism, self.functions = statics.mechanism, list[tuple[int, Callable[[FloatArray], FloatArray]]]()
        values = Differentiated(mechanism, make_plan(mechanism), [POSITION, *ORDERS[:2]])
        tape, nodes = values.tape, range(len(mechanism.nodes))
        places: Any = np.empty((3, len(nodes)), dtype=object)
        for order in range(3):
            places[order] = [number(tape, values.nodes[node][order]) for node in nodes]
        inputs: Any = [
            GivenNumber(tape, values.input(k, 0), k, self.functions) for k in range(len(mechanism.actuators))
        ]
        time: Any = GivenNumber(tape, None, TIME, self.functions)
        course = Course(time, inputs, places)
        loads = Loading(statics, course, TapeTurns())
        solved: Any = TapeBalance(statics, tape, places[0], right_side(statics, loads))
        forces = TapeForces(statics, course, loads, solved, np.zeros((0, len(statics.reactions))), np.ones(1))
        self.formulas: tuple[list[Formula], list[Formula]] = [], []  # of complex and of real numbers
        for formula in formulas:
            found = lanes(formula(forces))
            real = not isinstance(found, ComplexLanes)
            op = kernels.WRITE_ANGLE if real else kernels.WRITE_POINT
            tape.emit(op, tape.lane(found), 0, len(self.formulas[real]))
            self.formulas[real].append(formula)
        numbers = ((1, len(some)) for some in self.formulas)
        self.results, self.operations = DesignFormulas(tape, recording, *numbers), len(tape.heads)

    def __call__(
        self, designs: FloatArray, z: Any, given: Any, time: FloatArray, jit: str, notify: Any
    ) -> dict[Formula, Any]:
        """Return the formulas (designs, rows)."""
        count, _, actuators, rows = given.shape
        shape = max(count, len(time)), 1, actuators, rows
        more = [np.broadcast_to(given, (shape[0], *given.shape[1:]))]
        for over, function in self.functions:
            at = time if over == TIME else given[:, 0, over]
            found: Any = at.through(function) if isinstance(at, RuleNumber) else function(at)
            more.append(np.broadcast_to(found[:, None, None], shape))
        run = choose(jit, PLAIN * self.operations * len(z) * rows, notify, ("play_designs",))
        pairs = zip(self.formulas, self.results(designs, z, np.concatenate(more, axis=1), run), strict=True)
        return {formula: own[:, 0, k] for some, own in pairs for k, formula in enumerate(some)}


@dataclass(frozen=True)
class TapeForces(Forces):
    """Forces in numbers of a tape."""

    @cached_property
    def _solutions(self) -> Any:
        return self.unknowns

    def _in_one(self, force: Any) -> Any:
        return force

    def only(self, values: Any) -> Any:
        """Return values, NaN in rows without determined forces."""
        return values + self._gaps

    @cached_property
    def _gaps(self) -> TapeNumber:
        """0, or NaN in rows without determined forces."""
        tape = self.unknowns[0].tape
        lane = tape.constant(0.0)
        for k in range(len(self.statics.reactions)):
            lane = tape.real(kernels.COMBINE, lane, self.unknowns[k].own.lane, f=1.0, g=0.0).lane
        return TapeNumber(tape, Lane(lane))


class TapeTurns(Turns):
    """Continues the angles of springs on a tape, from the initial ones of each design."""

    def followed(self, key: int, angle: Any, drawn: Any) -> Any:
        """Return an angle [rad] without jumps (rows,)."""
        return TapeNumber(angle.tape, angle.tape.real(kernels.FOLLOW, angle.lanes.lane, f=drawn))


def dynamic_dimensions(mechanism: Mechanism, names: Sequence[str]) -> set[str]:
    """Return the dimensions of masses, loads, springs, dampers, friction and rotors among the names."""
    recorded, recording = mechanism.written.recorded(mechanism, names, True)
    return _used(recorded, recording, names)


def _used(recorded: Mechanism, recording: Recording, names: Sequence[str]) -> set[str]:
    used = recording.variables_of(list(_places(recorded.dynamics)))
    return {name for k, name in enumerate(names) if k in used}


def _amounts(mechanism: Mechanism) -> Iterator[Any]:
    """Yield the numbers that a file may not give as negative."""
    dynamics = mechanism.dynamics
    yield from (x for inertia in dynamics.inertias for x in (inertia.mass, inertia.moment))
    yield from (spring.stiffness for spring in dynamics.springs)
    yield from (damper.damping for damper in dynamics.dampers)
    yield from (friction.damping for friction in dynamics.frictions)
    yield from (rotor.inertia for rotor in dynamics.rotors)


def _given(number: Any) -> bool:
    """Return whether a number is not 0 in some design."""
    return isinstance(number, RuleNumber) or number != 0.0


def _places(part: Any) -> Iterator[int]:
    """Yield the places of the recorded numbers in a part of a mechanism."""
    if isinstance(part, Recorded):
        yield part.place
    elif isinstance(part, tuple) or (isinstance(part, np.ndarray) and part.dtype == object):
        for one in part:
            yield from _places(one)
    elif is_dataclass(part):
        yield from _places(tuple(own for name, own in vars(part).items() if name != "_derived"))
