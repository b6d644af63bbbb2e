"""What a formula of a quantity may ask of: rows of a motion, or designs x rows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from gimcli.calculus.numbers import nominal
from gimcli.canonical import TURN, whole_turns
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism, PairRow
from gimcli.rates.member_angles import Angles, direction, in_rows
from gimcli.status import Status
from gimcli.structure.carried import carried_point

if TYPE_CHECKING:
    from gimcli.dynamics.forces import Forces
    from gimcli.dynamics.kinematic_history import Turns
    from gimcli.motion.motion import Motion
    from gimcli.rates.derivatives import MotionRates, TracedRates
    from gimcli.rates.path_derivatives import PathDerivatives


@dataclass(frozen=True)
class ForceLine:
    """The line of a part at a joint: to another node, or the left normal of a guide."""

    name: str
    node: int = -1
    slide: PairRow | None = None


class ApartError(Exception):
    """A state does not have what a formula asks for; each of its motions may have it. The text says who has it."""


NO_LAW = "velocities and accelerations need a motion along the laws: `gim trace` that follows no circuit nor turns back"
"""Why rows along a curve have no rates."""

AT_REST = "a mechanism at rest has no velocities: `gim solve` and `gim trace` have them"
NO_JERK = "jerks need a motion along the laws: `gim trace` and `gim forces` have them"
NO_MOTION = "it belongs to a motion: `gim trace` has it"


class Valued(Protocol):
    """Columns that are computed together."""

    spec: str

    def values(self, state: Any) -> Sequence[Any]:
        """Return the columns."""


class State(ABC):
    """Positions and their derivatives by the time [s]; arrays (..., rows) in the normal frame, angles in rad."""

    made_again = True
    """Whether a result is pickled without it."""

    mechanism: Mechanism

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.memory: dict[str, Any] = {}  # of quantities that continue from piece to piece
        self._found: dict[str, Any] = {}

    @abstractmethod
    def node(self, node: int, order: int = 0) -> Any:
        """Return the place of a node, or a derivative of it."""

    def local(self, table: str, row: int) -> Any:
        """Return a complex number that is constant along the rows, of designs of each (designs, 1).

        "points" and "normals" have one for each point and guide, "shapes" for each node of all members.
        """
        own = self.mechanism
        if table == "shapes":
            return [z for member in own.members for z in member.shape][row]
        return own.points[row].local if table == "points" else own.slides[row].normal

    def turning(self, member: int, order: int) -> Any:
        """Return omega, alpha or angular jerk of a member (order 1 to 3); raise ApartError without rates."""
        raise ApartError

    @abstractmethod
    def counted(self, member: int) -> Any:
        """Return the direction of a member in the file's unit, full turns counted."""

    def row(self, name: str) -> Any:
        """Return the step, the time [s], the residual, or an input in the file's unit; raise ApartError if unknown."""
        raise ApartError

    @cached_property
    def path(self) -> PathDerivatives:
        """The derivatives along the path of one motion."""
        raise ApartError(NO_MOTION)

    @cached_property
    def forces(self) -> Forces:
        """The forces of one motion."""
        raise ApartError(NO_MOTION)

    def swept(self) -> PathDerivatives:
        """Return the derivatives along the path of a motion, for what is summed up from row to row."""
        raise ApartError(NO_MOTION)

    def of_forces(self, find: Callable[[Forces], Any]) -> Any:
        """Return a formula of the forces (..., rows)."""
        return find(self.forces)

    def failures(self) -> Any:
        """Return the status of solved rows (..., rows) whose rates or forces are not determined; 0 in others.

        Only rates and forces that were asked for count.
        """
        return 0

    def lacks(self, rows: Any) -> Any:
        """Return whether values (..., rows) are missing in a row with a status in `failures` (..., 1)."""
        return np.any(np.isnan(rows) & (self.failures() > 0), axis=-1, keepdims=True)

    def value(self, quantity: Valued, column: int) -> Any:
        """Return a column of a quantity (..., rows) in the file's units."""
        if quantity.spec not in self._found:
            with np.errstate(all="ignore"):  # what is not determined is NaN
                self._found[quantity.spec] = quantity.values(self)
        return self._found[quantity.spec][column]

    def first(self, key: str, rows: Any) -> Any:
        """Return the first value of some rows that is defined, of the whole motion if the rows are a piece of it."""
        from gimcli.language.arrays import first

        return first(rows)

    def point(self, name: str, order: int = 0) -> Any:
        """Return the place of a node or point, or a derivative of it: first + (far - first) times a constant ratio."""
        mechanism = self.mechanism
        if name in mechanism.nodes:
            return self.node(mechanism.nodes.index(name), order)
        row = next(k for k, p in enumerate(mechanism.points) if p.name == name)
        index, local = mechanism.points[row].member, self.local("points", row)
        if index == FRAME:
            return self.node(mechanism.members[FRAME].nodes[0], order) * 0.0 + (local if order == 0 else 0.0)
        member, begin = mechanism.members[index], first_row(mechanism, index)
        start, end = (self.local("shapes", begin + k) for k in (0, member.base))
        base = self.node(member.nodes[0], order)
        return base + (self.node(member.nodes[member.base], order) - base) * ((local - start) / (end - start))

    def line(self, line: ForceLine, joint: int) -> Any:
        """Return the direction of a line at a joint: to another node, or the normal of a guide."""
        if line.slide is None:
            return self.node(line.node) - self.node(joint)
        return self.normal(next(k for k, one in enumerate(self.mechanism.slides) if one is line.slide))

    def normal(self, slide: int) -> Any:
        """Return the left normal of a guide, a unit vector."""
        row = self.mechanism.slides[slide]
        normal, member = self.local("normals", slide), self.mechanism.members[row.guide]
        if row.guide == FRAME:
            return self.node(row.node) * 0.0 + normal
        begin = first_row(self.mechanism, row.guide)
        own = self.local("shapes", begin + member.base) - self.local("shapes", begin)
        unit = (self.node(member.nodes[member.base]) - self.node(member.nodes[0])) / own
        return normal * (unit / abs(unit))

    def travel(self, slide: int) -> Any:
        """Return the position of a slider along its guide [normal length]."""
        row = self.mechanism.slides[slide]
        place, along = self.node(row.node), -1j * self.normal(slide)
        if row.guide != FRAME:
            place = place - self.node(self.mechanism.members[row.guide].nodes[0])
        return (np.conj(along) * place).real


class Positions(State):
    """Positions z (..., nodes, rows) alone, plain or dual: no rates, and directions that are not counted."""

    def __init__(self, mechanism: Mechanism, z: Any) -> None:
        super().__init__(mechanism)
        self.z = z

    def node(self, node: int, order: int = 0) -> Any:
        """Return the place of a node (..., rows)."""
        if order:
            raise ApartError
        return self.z[..., node, :]

    def counted(self, member: int) -> Any:
        """Return the direction of a member (..., rows) in the file's unit, in (-180, 180] degrees."""
        if member == FRAME:
            return self.node(0).real * 0.0
        first, second = self.mechanism.members[member].nodes[:2]
        angle = np.angle(self.node(second) - self.node(first))
        angle = angle - TURN * whole_turns(nominal(angle))
        return np.degrees(angle) if self.mechanism.angle_unit == "deg" else angle

    def first(self, key: str, rows: Any) -> Any:
        """Return the values themselves: each row is a position of its own."""
        return nominal(rows)


def first_row(mechanism: Mechanism, member: int) -> int:
    """Return the first row of a member in a table of the nodes of all members, one after another."""
    return sum(len(one.nodes) for one in mechanism.members[:member])


class MotionState(State):
    """The rows of one motion, or of the next piece of it; `memory` is shared by its pieces."""

    def __init__(
        self, motion: Motion, angles: Angles = in_rows, memory: dict[str, Any] | None = None,
        traced: TracedRates | None = None, forces: Callable[[], Forces] | None = None,
        given: FloatArray | None = None, rest: str = "", rates: MotionRates | None = None,
    ) -> None:  # fmt: skip
        """Take a motion; `traced` computes the derivatives of some points and all members in one call.

        `forces` returns those of the motion, if they are known. `given` are the inputs and their derivatives by the
        time (orders, actuators, rows); by default those of the laws. `rest`: why there are no rates, of positions at
        rest and of curves that are followed instead of the laws; the forces are then those at rest. `rates` are those
        of the motion, if they are known.
        """
        super().__init__(motion.mechanism)
        self.motion, self.angles, self._traced, self._known, self.given = motion, angles, traced, forces, given
        self.memory = {} if memory is None else memory
        self.rest = rest or NO_LAW * (motion.parameter is not None or bool(motion.turned_back))
        self._rates, self._failed = rates, np.zeros(len(motion.time), dtype=np.int64)

    @cached_property
    def path(self) -> PathDerivatives:
        """The derivatives along the path of the motion: by its parameter, or by the arc length of a circuit."""
        return derivatives_of(self.motion, self.given)

    @cached_property
    def forces(self) -> Forces:
        """The forces of the motion along its laws, or at rest, in rows in which they are well determined."""
        from gimcli.dynamics.force_motion import failures

        found = self._forces_found() if self._known is None else self._known()
        self._failed = failures(self.motion, found)
        return found

    def _forces_found(self) -> Forces:
        from gimcli.dynamics.forces import piece_forces
        from gimcli.dynamics.kinematic_history import Courses
        from gimcli.dynamics.statics import statics

        motion, given = self.motion, self.given
        if self.rest:
            given = np.concatenate([motion.inputs[None], np.zeros((2, *motion.inputs.shape))])
        courses = Courses(self.mechanism, given=given)
        return piece_forces(statics(self.mechanism), courses, motion, turns=self._turns)

    def failures(self) -> Any:
        """Return the status of solved rows (rows,) whose rates or forces are not determined; 0 in others."""
        if self._rates is None:
            return self._failed
        missing = self.motion.good & ~np.isfinite(self._rates.nodes).all(axis=(0, 1))
        return np.maximum(self._failed, np.where(missing, int(Status.SINGULAR), 0))

    @property
    def _turns(self) -> Turns:
        from gimcli.dynamics.kinematic_history import Turns

        turns: Turns = self.memory.setdefault("turns of springs", Turns())
        return turns

    def node(self, node: int, order: int = 0) -> Any:
        """Return the place of a node (rows,), or a derivative of it."""
        return self.rates(order).nodes[order, node] if order else self.motion.z[node]

    def point(self, name: str, order: int = 0) -> Any:
        """Return the place of a node or point (rows,), or a derivative of it."""
        if not order:
            return carried_point(self.mechanism, name, self.motion.z)
        if self._traced is not None and name in self._traced.names and order <= self._traced.order:
            return self._bulk[0][order - 1, self._traced.names.index(name)]
        return self.rates(order).point(name)[order]

    def rates(self, order: int) -> MotionRates:
        """Return the derivatives of all nodes up to an order; raise ApartError where they are not known."""
        if self.rest:
            raise ApartError(self.rest)
        if self._rates is None or self._rates.order < order:
            from gimcli.rates.derivatives import law_rates, rates_of_inputs

            given = law_rates(self.mechanism, self.motion.time, order) if self.given is None else self.given
            if len(given) <= order:
                raise ApartError(NO_JERK)
            self._rates = rates_of_inputs(self.mechanism, self.motion.z, given[: order + 1])
        return self._rates

    def turning(self, member: int, order: int) -> Any:
        """Return omega, alpha or angular jerk of a member (rows,)."""
        if self._traced is not None and order <= self._traced.order and member != FRAME:
            return self._bulk[1][order - 1, member - 1]
        return self.rates(order).angular(member)[order - 1]

    @cached_property
    def _bulk(self) -> tuple[ComplexArray, FloatArray]:
        """Derivatives of some points (order, points, rows) and of all members (order, members, rows)."""
        assert self._traced is not None
        return self._traced(self.motion)

    def counted(self, member: int) -> Any:
        """Return the direction of a member (rows,)."""
        return self.angles(self.motion, member)

    def row(self, name: str) -> Any:
        """Return the step, the time [s], the residual, or an input (rows,)."""
        motion, own = self.motion, self.mechanism
        if name in (names := [a.name for a in own.actuators]):
            return own.value_to_file(names.index(name), motion.inputs[names.index(name)])
        if name == "step":
            return np.arange(len(motion.time))
        return motion.residual if name == "residual" else motion.time * own.duration

    def swept(self) -> PathDerivatives:
        """Return the derivatives along the path of a motion, for what is summed up from row to row."""
        return self.path

    def first(self, key: str, rows: Any) -> Any:
        """Return the first value that is defined, of this piece or one before it (1,)."""
        if not np.isfinite(self.memory.get(key, np.nan)).all():
            self.memory[key] = super().first(key, rows)
        return self.memory[key]


class SeparateState(MotionState):
    """Positions that are no motion, each with the rates of its inputs (see `MotionState`), or at rest."""

    def __init__(self, motion: Motion, given: FloatArray | None = None, rest: str = "") -> None:
        super().__init__(motion, lambda own, member: direction(own.mechanism, member, own.z), given=given, rest=rest)

    @property
    def _turns(self) -> Turns:
        from gimcli.dynamics.kinematic_history import SeparateTurns

        return SeparateTurns()

    def swept(self) -> PathDerivatives:
        """Raise ApartError: nothing moves."""
        raise ApartError(NO_MOTION)

    def row(self, name: str) -> Any:
        """Return the time [s], the residual, or an input (rows,); raise ApartError for the step."""
        if name == "step":
            raise ApartError(NO_MOTION)
        return super().row(name)

    def first(self, key: str, rows: Any) -> Any:
        """Return the values themselves."""
        return rows


class Needs(State):
    """A state of made-up numbers, which notes what the formulas of quantities ask for."""

    def __init__(self, mechanism: Mechanism, asked: Iterable[Valued]) -> None:
        super().__init__(mechanism)
        self.order = 0  # of derivatives
        self.points, self.members = list[str](), list[int]()  # members whose direction is counted
        self.rows = list[str]()  # values of rows, such as the time
        self.forced = False  # whether there are forces
        try:
            for one in asked:
                self.value(one, 0)
        except ApartError:
            self.rows.append("path")

    def node(self, node: int, order: int = 0) -> Any:
        """Note an order."""
        self.order = max(self.order, order)
        return np.ones(1, dtype=complex)

    def point(self, name: str, order: int = 0) -> Any:
        """Note a point."""
        self.points += [name] * (name not in self.points)
        return self.node(0, order)

    def turning(self, member: int, order: int) -> Any:
        """Note an order."""
        return self.node(0, order).real

    def counted(self, member: int) -> Any:
        """Note a member."""
        self.members += [member] * (member not in self.members)
        return np.ones(1)

    def of_forces(self, find: Callable[[Forces], Any]) -> Any:
        """Note forces."""
        self.forced = True
        return np.ones(1, dtype=complex)

    def row(self, name: str) -> Any:
        """Note a value of rows."""
        self.rows.append(name)
        return np.ones(1)


def derivatives_of(motion: Motion, given: FloatArray | None = None) -> PathDerivatives:
    """Return the derivatives of a motion along its laws, or along the arc length of its curve if it is a circuit.

    `given` are derivatives of the inputs (orders, actuators, rows) that replace those of the laws.
    """
    from gimcli.rates.path_derivatives import ArclengthDerivatives, PathDerivatives

    if motion.parameter is None:
        return PathDerivatives(motion, given)
    return ArclengthDerivatives(motion)
