"""Positions of a mechanism whose inputs are set by hand, each continuous with the one before.

The motion from the last regular position to the new inputs is followed with linearly changing inputs. So the mechanism
stays on its branch, however far the inputs change at once. Where the inputs cannot be reached, it stops at the limit.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.errors import UsageError
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembler
from gimcli.motion.follow import BranchFollower, FollowedPath
from gimcli.motion.legs import Leg, dense, straight
from gimcli.motion.solve import follower_of
from gimcli.positions.dispatch import choose, plan_work
from gimcli.positions.inputs import scales
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import holds

FARTHEST = 20.0
"""Greatest change of an input in one step, in turns or 2 pi sizes: it takes some seconds."""

ROWS = 400
"""Number of rows for which loading compiled kernels must be worth while: those of some hundred steps."""

LEAST, FEWEST = 8, 2
"""Least number of rows of a step that begins a new leg, and of one that continues a leg."""

CLOSE = 1e-9
"""Greatest change of the inputs, in rad or sizes, in one step without rows in between."""

STRAIGHT, BEHIND = 1e-12, 1e-9
"""Inputs are behind a known limit if they are this close to the line to it, and this much farther (relative)."""

TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class DraggedPosition:
    """The position after a step, in the normal frame: at the new inputs, or at the limit before them."""

    status: Status  # of the new inputs; LIMIT: they cannot be reached
    inputs: FloatArray  # (actuators,) at which the mechanism is
    z: ComplexArray = field(repr=False)  # (nodes,)


class InputDrag:
    """A mechanism that follows inputs which are set by hand; `last` is its position."""

    def __init__(
        self, mechanism: Mechanism, starts: Iterable[tuple[FloatArray, ComplexArray]], tolerance: float = 1e-10
    ) -> None:
        """Begin at the first regular one of some assembled positions: inputs (actuators,) and nodes (nodes,).

        Raises UsageError if none of them is regular.
        """
        self.mechanism, self.tolerance = mechanism, tolerance
        self.plan = make_plan(mechanism)
        self.run = choose("auto", plan_work(self.plan, ROWS), kernels=("solve_group",))
        self.assembler = Assembler(mechanism, self.plan, self.run, tolerance)
        pairs = ((inputs, z, self.assembler.assemble(inputs, z)) for inputs, z in starts)
        found = next(((inputs, z, start) for inputs, z, start in pairs if start.regular), None)
        if found is None:
            raise UsageError("no regular position to start from: choose another row of the motion")
        self.base = self.last = DraggedPosition(Status.OK, *found[:2])
        self._row, self._signs = found[2].row, found[2].signs  # of the base
        self._course: tuple[Leg, BranchFollower] | None = None  # on which the base was reached

    def to(self, inputs: FloatArray) -> DraggedPosition:
        """Change the inputs (actuators,) linearly to new values, as far as the mechanism can follow.

        Raises UsageError if they change by more than FARTHEST turns.
        """
        if self._known(inputs) or self._beside(inputs):
            return self.last
        leg, follower = self._continued(inputs) or self._begun(inputs)
        place, goal = follower.log[-1].time, np.array([leg.goal])
        path = follower.run_to(dense(place, goal, leg.turn, LEAST if len(follower.log) == 1 else FEWEST)[0])
        self._course = None
        self._keep_regular(follower, path)
        if path.codes[-1] == Status.OK and self._holds(path.z[:, -1], inputs):
            self.last = DraggedPosition(Status.OK, inputs, path.z[:, -1])
            if follower.log and self._row is follower.log[-1]:
                self.base, self._course = self.last, (leg, follower)
        else:
            self.last = self._at_limit(follower, path, leg)
        return self.last

    def _beside(self, inputs: FloatArray) -> bool:
        """Assemble at inputs (actuators,) that are too close to those of the base for a motion; return the success."""
        if np.max(np.abs(inputs - self.base.inputs) / scales(self.mechanism)) > CLOSE:
            return False
        found = self.assembler.assemble(inputs, self.base.z)
        z = found.row.x + 1j * found.row.y
        if not found.regular or not self._holds(z, inputs):
            return False
        self.base = self.last = DraggedPosition(Status.OK, inputs, z)
        self._row, self._signs, self._course = found.row, found.signs, None
        return True

    def _begun(self, inputs: FloatArray) -> tuple[Leg, BranchFollower]:
        """Return the leg from the base to inputs (actuators,), and its follower."""
        leg = straight(self.mechanism, self.base.inputs, inputs)
        if abs(leg.end - leg.begin) > FARTHEST * leg.turn:
            raise UsageError(f"expected a change of an input by at most {FARTHEST:g} turns (or sizes x 2 pi) at once")
        follower = follower_of(self.mechanism, self.plan, leg, self.run, self.tolerance)
        follower.begin(replace(self._row, time=leg.sense * leg.begin), self._signs)
        return leg, follower

    def _continued(self, inputs: FloatArray) -> tuple[Leg, BranchFollower] | None:
        """Return the last leg, prolonged to inputs (actuators,), and its follower; None if they are not ahead on it."""
        if self._course is None:
            return None
        leg, follower = self._course
        assert leg.line is not None
        q, place = float(inputs[leg.line.main]), follower.log[-1].time
        beside = np.max(np.abs(leg.line.at(np.array([q]))[:, 0] - inputs))
        ahead = leg.sense * q - place
        if not 0.0 < ahead <= FARTHEST * leg.turn or beside > STRAIGHT * abs(q - leg.begin):
            return None
        return replace(leg, end=q), follower

    def _known(self, inputs: FloatArray) -> bool:
        """Return whether `last` is the position at inputs (actuators,), or the limit before them."""
        if np.array_equal(inputs, self.base.inputs):
            self.last = self.base
        if self.last.status is not Status.LIMIT:
            return self.last.status is Status.OK and np.array_equal(inputs, self.last.inputs)
        ahead, wanted = self.last.inputs - self.base.inputs, inputs - self.base.inputs
        farther = float(wanted @ ahead) / max(float(ahead @ ahead), TINY)
        beside = np.max(np.abs(wanted - farther * ahead), initial=0.0)
        return farther > 1.0 + BEHIND and bool(beside <= STRAIGHT * np.max(np.abs(wanted)))

    def _holds(self, z: ComplexArray, inputs: FloatArray) -> bool:
        return bool(holds(self.mechanism, z[:, None], inputs[:, None], self.tolerance)[0])

    def _keep_regular(self, follower: BranchFollower, path: FollowedPath) -> None:
        """Keep the last regular row of a path as the position from which the next step starts."""
        for k in np.flatnonzero(path.codes == Status.OK)[::-1].tolist():
            z, inputs = path.z[:, k], path.inputs[:, k]
            time = float(path.time[k])
            if follower.gap_at(time) is not None or not self._holds(z, inputs):
                continue
            row, signs = next((row for row in follower.log if row.time == time), None), follower.sign.copy()
            if row is None:  # at a limit the rows before it are not kept
                found = self.assembler.assemble(inputs, z, time)
                row, signs = found.row if found.regular else None, found.signs
            if row is not None:
                self.base, self._row, self._signs = DraggedPosition(Status.OK, inputs, z), row, signs
                return

    def _at_limit(self, follower: BranchFollower, path: FollowedPath, leg: Leg) -> DraggedPosition:
        """Return the position at the limit of a path, or the last regular one if that position is not accurate."""
        status = Status.LIMIT if path.limit is not None else Status(int(path.codes[-1]) or Status.NOT_CONVERGED)
        if path.limit is not None and follower.limit_ahead is not None:
            row, inputs = follower.limit_ahead.at(path.limit), leg.inputs(np.array([path.limit]))[:, 0]
            z = np.asarray(row.x + 1j * row.y)
            if self._holds(z, inputs):
                return DraggedPosition(status, inputs, z)
        return DraggedPosition(status, self.base.inputs, self.base.z)
