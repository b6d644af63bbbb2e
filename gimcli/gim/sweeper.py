"""Positions and motions by the Geometrical-Iterative Method alone, and the convergence of the sweeps.

All free nodes are moved by one sequence. Known nodes (of the frame, or carried by an input; by the rules of the paper
only its arm) are placed before the sweeps, carried nodes after them. Each row of a motion starts from the row before.
The errors of the sweeps follow eq. (3) of Petuya et al. 2004, E_n = C1 exp(-C2 n).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimcli.errors import StructureError, UsageError
from gimcli.gim import sweeps
from gimcli.gim.sequence import INCOMPLETE, Sequence, find_sequence, known_nodes, radius_of
from gimcli.gim.sweeps import SweptPosition
from gimcli.kernels import sweep as kernels
from gimcli.kernels.plan_steps import ORIENT, PLACE
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.positions.block import NEW, RowBlock
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run
from gimcli.positions.options import Options
from gimcli.positions.position import Position
from gimcli.positions.program import plan_program
from gimcli.status import Status
from gimcli.structure.derived import derived
from gimcli.structure.kinematic_nodes import carry, free_nodes
from gimcli.structure.plan import make_plan
from gimcli.structure.restrictions import Move, Restriction, distance, member_angle, member_distance
from gimcli.structure.steps import Value

PERTURBATION = 1e-2
"""Perturbation, relative to the size, of a start from which the sweeps do not converge."""


@derived
def first_sequence(mechanism: Mechanism, strategy: str) -> Sequence:
    """Return the best sequence at the drawn position (cached, because a comparison of methods uses it often)."""
    return find_sequence(mechanism, mechanism.drawn, strategy)


class Sweeper:
    """Solves positions and motions of a mechanism by sweeps.

    Raises UsageError if `options.moves` is not a valid sequence, StructureError if there is no complete one.
    """

    def __init__(self, mechanism: Mechanism, options: Options, run: Run) -> None:
        self.mechanism, self.options, self.run, self.plan = mechanism, options, run, make_plan(mechanism)
        self.sequence: Sequence | None = None  # given by the user
        if options.moves:
            self.moves, carried = parse_moves(mechanism, options.moves), known_nodes(mechanism)[1]
        else:
            self.sequence = first_sequence(mechanism, options.strategy)
            self.moves, carried = self.sequence.moves, self.sequence.carried_by_input
            missing = [mechanism.nodes[n] for group in self.sequence.groups for n in group.missing]
            if missing:
                cure = f" (spectral radius {self.sequence.radius:.4f}): use the strategy spectral"
                raise StructureError(INCOMPLETE + ", ".join(missing) + cure)
        self.known = carried | set(mechanism.members[FRAME].nodes)
        self.free = [n for n in free_nodes(mechanism) if n not in self.known]

    def known_positions(self, inputs: FloatArray) -> RowBlock:
        """Return a block for inputs (actuators, rows) in which only the known nodes are placed."""
        program = plan_program(self.mechanism, self.plan)
        block = RowBlock(program, np.arange(inputs.shape[1], dtype=float), inputs)
        with np.errstate(all="ignore"):
            for k, (kind, to, *_) in enumerate(program.tables.steps):
                if kind == ORIENT or (kind == PLACE and to in self.known):
                    block.step(k, np.ones(self.plan.branches), 0.0)
        return block

    def settle(self, inputs: FloatArray, guess: ComplexArray, record: int = 0) -> SweptPosition:
        """Solve one position at inputs (actuators,) from a guess (nodes,); record: number of errors in the history."""
        block = self.known_positions(inputs[:, None])
        z = guess.copy()
        known = sorted(self.known)
        z[known] = block.x[known, NEW] + 1j * block.y[known, NEW]
        constants = sweeps.SweepConstants(sweeps=self.options.sweeps)
        size, tolerance = self.mechanism.size, self.options.tolerance
        done = sweeps.settle(self.moves, z, inputs, size, tolerance, self.run, constants, record)
        if not done.good:  # sweeps do not move nodes out of a line: perturb them (fixed seed)
            noise = np.random.default_rng(0).standard_normal((2, len(self.free))) * PERTURBATION * size
            z[self.free] += noise[0] + 1j * noise[1]
            again = sweeps.settle(self.moves, z, inputs, size, tolerance, self.run, constants, record)
            done = again if again.good else done
        return SweptPosition(
            done.status, carry(self.mechanism, done.z), done.sweeps, done.length_error, done.angle_error,
            done.history,
        )  # fmt: skip

    def follow(
        self, inputs: FloatArray, start: ComplexArray, slow: float
    ) -> tuple[ComplexArray, FloatArray, int, Status]:
        """Solve a motion at inputs (actuators, rows) from a solved first row, up to one with more sweeps than `slow`.

        Returns z (nodes, rows), the sweeps (rows,), the number of solved rows, and the status of the last one tried.
        """
        block = self.known_positions(inputs)
        fixed = sorted(self.known)
        x, y = np.zeros((2, inputs.shape[1], len(start)))
        x[:, fixed], y[:, fixed] = block.x[fixed, NEW:].T, block.y[fixed, NEW:].T
        x[0], y[0] = start.real, start.imag
        mi, mz = sweeps.pack(self.moves)
        spent, mark, out = np.zeros(inputs.shape[1]), np.zeros((2, x.shape[1])), np.zeros(4)
        limits = sweeps.limits(self.options.tolerance, sweeps.SweepConstants(sweeps=self.options.sweeps))
        values, cos, sin = (np.ascontiguousarray(a.T) for a in (inputs, block.cos[:, NEW:], block.sin[:, NEW:]))
        with np.errstate(all="ignore"):
            stop = self.run(kernels.settle_rows)(
                x, y, values, cos, sin, np.array(self.free, dtype=np.int64), mi, mz, self.mechanism.size, 1,
                float(slow), limits, mark, np.zeros((0, 2)), spent, out,
            )  # fmt: skip
        z = np.full((len(start), inputs.shape[1]), complex(np.nan, np.nan))
        z[:, :stop] = carry(self.mechanism, (x[:stop] + 1j * y[:stop]).T)
        return z, spent, stop, sweeps.ENDS[int(out[3])]

    def exchange(self, z: ComplexArray, gain: float) -> bool:
        """Use the best sequence at z (nodes,), if it needs `gain` times fewer sweeps; return whether it does.

        A sequence given by the user is not exchanged, nor that by the rules of the paper, which is the same everywhere.
        """
        if self.sequence is None or not np.all(np.isfinite(z)):
            return False
        found = find_sequence(self.mechanism, z, self.options.strategy, self.plan)
        old = self.sequence.radius_at(z)
        better = found.radius < 1.0 and (old >= 1.0 or found.radius < old**gain)
        if found.moves == self.moves or not better:
            return False
        self.sequence, self.moves = found, found.moves
        return True


def parse_moves(mechanism: Mechanism, text: str) -> tuple[Move, ...]:
    """Parse a sequence such as "T>X S>V C^B>A": move X to its distance from T, A to its angle from C about B.

    Raises UsageError for unknown nodes, or if no member or linear actuator has the distance or angle.
    """
    moves = []
    for word in text.replace(",", " ").split():
        source, _, target = word.partition(">")
        names = [*source.split("^"), target]
        if len(names) not in (2, 3) or any(n not in mechanism.nodes for n in names):
            raise UsageError(f"sequence: expected FROM>TO or ARM^VERTEX>TO with nodes of the file, got '{word}'")
        numbers = [mechanism.nodes.index(n) for n in names]
        find = _distance_between if len(numbers) == 2 else _angle_between
        moves.append(Move(find(mechanism, word, *numbers), numbers[-1], "given"))
    return tuple(moves)


def _angle_between(mechanism: Mechanism, word: str, arm: int, vertex: int, b: int) -> Restriction:
    for index, member in enumerate(mechanism.members[1:], start=1):
        if {arm, vertex, b} <= set(member.nodes):
            return member_angle(mechanism, index, vertex, arm, b)
    raise UsageError(f"sequence: no member contains the angle of '{word}'")


def _distance_between(mechanism: Mechanism, word: str, a: int, b: int) -> Restriction:
    for index, member in enumerate(mechanism.members[1:], start=1):
        if a in member.nodes and b in member.nodes:
            return member_distance(mechanism, index, a, b, alone=False)
    for number, actuator in enumerate(mechanism.actuators):
        if set(actuator.nodes) == {a, b}:
            return distance(actuator.name, a, b, Value(0.0, number))
    raise UsageError(f"sequence: no member or linear actuator has the distance of '{word}'")


FLOOR = 1e-13
"""Errors below this are rounding errors and are not used in the fit."""


@dataclass(frozen=True)
class ErrorLaw:
    """Errors of the sweeps, and the exponential function fitted to the later half of them."""

    errors: FloatArray  # (sweeps + 1, 2) eqs (1) and (2) [rad]
    c1: float
    c2: float
    radius: float  # spectral radius of the sweep at the solution

    @property
    def rate(self) -> float:
        """Factor by which one sweep reduces the error."""
        return math.exp(-self.c2)


def fit_history(position: Position) -> ErrorLaw:
    """Fit eq. (3) to the errors of a position that was found by sweeps with a history."""
    assert position.history is not None
    errors = position.history.copy()
    errors[:, 1] = in_radians(errors[:, 1])
    c1, c2 = fit(errors.max(axis=1))
    return ErrorLaw(errors, c1, c2, radius_at(position))


def in_radians(sines: FloatArray) -> FloatArray:
    """Return angles [rad] from the measure of the kernel: |sine|, or 2 - |sine| for angles above 90 deg."""
    near = np.arcsin(np.clip(sines, 0.0, 1.0))
    far = math.pi - np.arcsin(np.clip(2.0 - sines, 0.0, 1.0))
    return np.asarray(np.where(sines <= 1.0, near, far))


def fit(worst: FloatArray) -> tuple[float, float]:
    """Return C1 and C2 by linear regression of the logarithms of the later half of the errors (NaN if too few)."""
    use = np.flatnonzero((worst > FLOOR) & np.isfinite(worst))
    use = use[len(use) // 2 :] if len(use) > 4 else use[1:]
    if len(use) < 2:
        return float("nan"), float("nan")
    slope, height = np.polyfit(use, np.log(worst[use]), 1)
    return float(math.exp(height)), float(-slope)


def radius_at(position: Position) -> float:
    """Return the spectral radius, at a position, of the sequence by which it was found."""
    sweeper = Sweeper(position.mechanism, position.options or Options(method="gim"), plain)
    return radius_of(sweeper.moves, tuple(sweeper.free), position.z)
