"""A plan as flat tables for the kernels, and the lanes (arrays) in which its rows are solved."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.kernels import jit, plan_steps as kernels
from gimcli.kernels.circular import cos_sin
from gimcli.kernels.lanes import aligned
from gimcli.kernels.march import Groups, Rows, march
from gimcli.kernels.newton import RowPosition, room
from gimcli.mechanism import FRAME, HEIGHT, ComplexArray, FloatArray, Mechanism
from gimcli.positions.newton import Accuracy, NewtonConstants, Packed
from gimcli.positions.position import Row
from gimcli.structure.derived import derived
from gimcli.structure.residual import checks
from gimcli.structure.steps import (
    NONE,
    Constraint,
    Coupled,
    Orient,
    Place,
    Plan,
    Step,
    Tilt,
    Vector,
)

RESTART_ROWS = 80
"""Number of solved rows that `Marcher.go` saves as restart points."""


@dataclass
class _ProgramWriter:
    """Collects the vectors, loci and groups, to which steps refer by number."""

    vectors: list[Vector] = field(default_factory=list)
    loci: list[Constraint] = field(default_factory=list)
    groups: list[Packed] = field(default_factory=list)

    def vector(self, vector: Vector | None) -> int:
        return NONE if vector is None else _add(self.vectors, vector)

    def locus(self, locus: Constraint) -> int:
        return _add(self.loci, locus)

    def step(self, step: Step) -> tuple[int, ...]:
        """Return a row of `Program.steps`: kind, node or register, three operands and branch."""
        if isinstance(step, Place):
            return kernels.PLACE, step.node, step.anchor, self.vector(step.vector), NONE, NONE
        if isinstance(step, Orient):
            return kernels.ORIENT, step.register, NONE, self.vector(step.vector), NONE, NONE
        if isinstance(step, Tilt):
            return kernels.TILT, step.register, step.a, step.b, self.vector(step.along), step.branch
        if isinstance(step, Coupled):
            return kernels.COUPLED, NONE, _add(self.groups, Packed(step)), NONE, NONE, NONE
        first, second = step.first, step.second
        lines = (first.kind == HEIGHT) + (second.kind == HEIGHT)
        if lines == 1 and first.kind == HEIGHT:
            first, second = second, first
        kind = (kernels.TWO_CIRCLES, kernels.CIRCLE_AND_LINE, kernels.TWO_LINES)[lines]
        return kind, step.node, self.locus(first), self.locus(second), NONE, step.branch

    def loci_tables(self) -> tuple[list[Any], list[Any]]:
        heads, values = [], []
        for locus in self.loci:
            normal = self.vector(locus.vector)
            heads.append((locus.q, self.vector(locus.offset), normal, locus.value.actuator))
            values.append((locus.value.constant, locus.value.gain))
        return heads, values


def _add(items: list[Any], item: Any) -> int:
    items.append(item)
    return len(items) - 1


def _array(rows: Sequence[Any], width: int, kind: type) -> Any:
    return np.array(rows, dtype=kind).reshape(-1, width)


@derived
def plan_program(mechanism: Mechanism, plan: Plan) -> PlanProgram:
    """Return the tables of a plan for the kernels."""
    writer = _ProgramWriter()
    steps = [writer.step(step) for step in plan.steps]
    reach = [step.distance if isinstance(step, Tilt) else 0.0 for step in plan.steps]
    heads, values = [], []
    for check in checks(mechanism):
        first, second = writer.vector(check.first), writer.vector(check.second)
        heads.append((check.kind, check.p, check.q, first, second, check.value.actuator))
        values.append((check.value.constant, check.value.gain))
    loci, lengths = writer.loci_tables()
    vectors = [(v.u, v.v, v.register, v.actuator, v.turn) for v in writer.vectors]
    factors = [(v.z.real, v.z.imag) for v in writer.vectors]
    tables = kernels.Program(steps, reach, vectors, factors, loci, lengths, heads, values, mechanism.size)
    return PlanProgram(mechanism, plan, tables, tuple(writer.groups))


class PlanProgram:
    """A plan as flat tables, and the numbers of its lanes."""

    def __init__(self, mechanism: Mechanism, plan: Plan, tables: kernels.Program, groups: tuple[Packed, ...]) -> None:
        self.tables, self.groups = tables, groups
        counts = [len(mechanism.nodes)] * 2 + [plan.registers] * 2 + [len(mechanism.actuators)] * 3 + [plan.branches]
        firsts = np.cumsum([kernels.FIXED, *counts]).tolist()
        self.at, self.count = kernels.Lanes(*firsts[:-1]), firsts[-1]
        self.registers, self.actuators = plan.registers, len(mechanism.actuators)
        self.frame = mechanism.members[FRAME]

    @property
    def variant(self) -> str:
        """The variant of compiled kernels for this plan."""
        return "" if self.groups else "dyads"

    @cached_property
    def packed(self) -> dict[int, Packed]:
        """{number of step: coupled group}."""
        return {k: self.groups[step[2]] for k, step in enumerate(self.tables.steps) if step[0] == kernels.COUPLED}

    @cached_property
    def arrays(self) -> kernels.Program:
        """The tables as arrays."""
        q = self.tables
        return kernels.Program(
            _array(q.steps, 6, int), np.array(q.reach), _array(q.vi, 5, int), _array(q.vz, 2, float),
            _array(q.li, 4, int), _array(q.lv, 2, float), _array(q.ci, 6, int), _array(q.cv, 2, float), q.size,
        )  # fmt: skip

    @cached_property
    def group_arrays(self) -> Groups:
        """The coupled groups as arrays."""
        heads, groups = [], [packed.arrays for packed in self.groups]
        parts = [[g.nodes, g.vi, g.vz, g.pi, g.ei, g.ev] for g in groups]
        ends = [np.cumsum([0, *(len(part[k]) for part in parts)]) for k in (0, 1, 3, 4)]
        for n, group in enumerate(groups):
            spans = [end[n + k] for end in ends for k in (0, 1)]
            heads.append((group.base, group.rows, int(group.turning), *spans))
        shapes: list[tuple[tuple[int, ...], type]] = [
            ((0,), int), ((0, 5), int), ((0, 2), float), ((0, 3), int), ((0, 5), int), ((0, 2), float),
        ]  # fmt: skip
        joined = [
            np.concatenate([np.zeros(shape, dtype=kind), *(part[k] for part in parts)])
            for k, (shape, kind) in enumerate(shapes)
        ]
        return Groups(_array(heads, 11, int), *joined)

    def room(self) -> RowPosition:
        """Return scratch arrays for one row, large enough for any of its groups."""
        return room([packed.arrays for packed in self.groups], self.registers, self.actuators)

    def lanes(self, width: int) -> FloatArray:
        """Return new lanes (lanes, width); only the frame's nodes are set."""
        lanes = aligned(self.count * width).reshape(self.count, width)
        lanes[kernels.TIME :] = self.blank
        return lanes

    @cached_property
    def blank(self) -> FloatArray:
        """Initial values (lanes, 1) of the lanes from TIME on."""
        blank, nodes = np.full((self.count, 1), np.nan), list(self.frame.nodes)
        blank[kernels.TIME : kernels.FIXED], blank[kernels.TIME] = 0.0, -math.inf
        blank[self.at.x : self.at.y][nodes] = self.frame.shape.real[:, None]
        blank[self.at.y : self.at.rx][nodes] = self.frame.shape.imag[:, None]
        return blank[kernels.TIME :]

    def recall(self, lanes: FloatArray, history: Sequence[Row]) -> None:
        """Copy solved rows to the history of the lanes; missing rows are set to the first one."""
        at, missing = self.at, kernels.HISTORY - len(history)
        for k, row in enumerate(history, start=missing):
            to = slice(k if k > missing else 0, k + 1)
            lanes[kernels.TIME, k] = row.time
            lanes[at.x : at.y, to], lanes[at.y : at.rx, to] = row.x[:, None], row.y[:, None]
            lanes[at.g :, to] = row.g[:, None]


def by_numbers(lanes: FloatArray) -> dict[int, Any]:
    """Return lanes as interpreted kernels need them: {WIDTH * number: lane}."""
    return dict(zip(range(0, len(lanes) * kernels.WIDTH, kernels.WIDTH), lanes, strict=True))


class Marcher:
    """Solves many rows of a motion in one call of the compiled kernel `march`."""

    def __init__(self, program: PlanProgram, accuracy: Accuracy) -> None:
        self.program, self.room = program, program.room()
        self.lanes = program.lanes(kernels.WIDTH)
        constants = NewtonConstants()
        self.limits = constants.limits(accuracy, constants.iterations, near=True)
        self.tolerance = accuracy.tolerance * accuracy.size

    def recall(self, inputs: FloatArray, history: Sequence[Row]) -> None:
        """Set the solved rows, and their inputs (actuators, rows), from which the motion continues."""
        at, past = self.program.at, slice(0, kernels.HISTORY)
        self.lanes[kernels.TIME, past] = -math.inf
        self.program.recall(self.lanes, history)
        inputs = inputs[:, np.maximum(np.arange(-kernels.HISTORY, 0), -len(history))]
        self.lanes[at.values : at.cos, past] = inputs
        self.lanes[at.cos : at.sin, past], self.lanes[at.sin : at.g, past] = cos_sin(inputs)

    def go(
        self, first: int, time: FloatArray, inputs: FloatArray, z: ComplexArray, residual: FloatArray,
        work: FloatArray, sign: FloatArray, determinant: FloatArray,
    ) -> tuple[int, Iterator[Row]]:  # fmt: skip
        """Solve rows from `first` on until one is doubtful; return their number, and restart rows.

        time (rows,), inputs (actuators, rows). Results: z (nodes, rows), residual and work (rows,); determinant
        (groups,) is updated.
        """
        kept, mark = np.zeros((RESTART_ROWS, len(self.lanes))), np.zeros(2, dtype=np.int64)
        pairs = z.view(float).reshape(*z.shape, 2)
        rows = Rows(time, inputs, pairs, residual, work, kept, mark)
        with np.errstate(all="ignore"):
            done = jit.compiled(march, self.program.variant)(
                self.lanes.reshape(-1), self.lanes, self.program.arrays, self.program.group_arrays, self.program.at,
                rows, first, sign, determinant, self.room, self.limits, self.tolerance,
            )  # fmt: skip
        written = int(mark[0])
        return int(done), self._rows(kept[np.arange(max(0, written - RESTART_ROWS), written) % RESTART_ROWS])

    def _rows(self, kept: FloatArray) -> Iterator[Row]:
        at = self.program.at
        for row in kept:
            error = float(row[kernels.ERROR])
            yield Row(float(row[kernels.TIME]), row[at.x : at.y], row[at.y : at.rx], row[at.g :], error)
