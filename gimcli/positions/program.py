"""A plan in the flat arrays of the kernel that follows a whole motion in one call."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gimcli.kernels import jit, newton
from gimcli.kernels import march as kernels
from gimcli.kernels.circular import cos_sin
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.positions.newton import Accuracy, NewtonConstants, Packed
from gimcli.structure.checks import checks
from gimcli.structure.steps import (
    NONE,
    Circle,
    Coupled,
    Line,
    Locus,
    Orient,
    Place,
    Plan,
    Step,
    Tilt,
    Vector,
)

RING = 80
"""Rows kept to continue from."""

LINE = 64
"""Bytes of a line of the cache."""

Kept = tuple[float, FloatArray, FloatArray, FloatArray, float]
"""Time, x, y (nodes,), g (branches,) and error of a row."""


@dataclass
class _ProgramWriter:
    """Collects the vectors, loci and groups that steps refer to by number."""

    vectors: list[Vector] = field(default_factory=list)
    loci: list[Locus] = field(default_factory=list)
    groups: list[newton.GroupArrays] = field(default_factory=list)

    def vector(self, vector: Vector | None) -> int:
        return NONE if vector is None else _add(self.vectors, vector)

    def locus(self, locus: Locus) -> int:
        return _add(self.loci, locus)

    def step(self, step: Step) -> tuple[int, ...]:
        """Return kind, node or register, three operands and branch."""
        if isinstance(step, Place):
            return kernels.PLACE, step.node, step.anchor, self.vector(step.vector), NONE, NONE
        if isinstance(step, Orient):
            return kernels.ORIENT, step.register, NONE, self.vector(step.vector), NONE, NONE
        if isinstance(step, Tilt):
            return kernels.TILT, step.register, step.a, step.b, NONE, step.branch
        if isinstance(step, Coupled):
            return kernels.COUPLED, NONE, _add(self.groups, Packed(step).arrays), NONE, NONE, NONE
        first, second = step.first, step.second
        if isinstance(first, Line) and isinstance(second, Circle):
            first, second = second, first
        kind = kernels.TWO_CIRCLES
        if isinstance(second, Line):
            kind = kernels.CIRCLE_AND_LINE if isinstance(first, Circle) else kernels.TWO_LINES
        return kind, step.node, self.locus(first), self.locus(second), NONE, step.branch

    def loci_arrays(self) -> tuple[IntArray, FloatArray]:
        heads, values = [], []
        for locus in self.loci:
            value = locus.radius if isinstance(locus, Circle) else locus.distance
            normal = NONE if isinstance(locus, Circle) else self.vector(locus.normal)
            node = locus.centre if isinstance(locus, Circle) else locus.anchor
            heads.append((node, self.vector(locus.offset), normal, value.actuator))
            values.append((value.constant, value.gain))
        return _ints(heads, 4), _floats(values, 2)

    def vector_arrays(self) -> tuple[IntArray, FloatArray]:
        heads = [(v.u, v.v, v.register, v.actuator, v.turn) for v in self.vectors]
        return _ints(heads, 5), _floats([(v.z.real, v.z.imag) for v in self.vectors], 2)

    def group_arrays(self) -> tuple[Any, ...]:
        heads, parts = [], [[g.nodes, g.vi, g.vz, g.pi, g.ei, g.ev] for g in self.groups]
        ends = [np.cumsum([0, *(len(part[k]) for part in parts)]) for k in (0, 1, 3, 4)]
        for n, group in enumerate(self.groups):
            spans = [end[n + k] for end in ends for k in (0, 1)]
            heads.append((group.base, group.rows, int(group.turning), *spans, 0))
        shapes: list[tuple[tuple[int, ...], Any]] = [
            ((0,), np.int64), ((0, 5), np.int64), ((0, 2), float),
            ((0, 3), np.int64), ((0, 5), np.int64), ((0, 2), float),
        ]  # fmt: skip
        joined = [
            np.concatenate([np.zeros(shape, dtype=kind), *(part[k] for part in parts)])
            for k, (shape, kind) in enumerate(shapes)
        ]
        return _ints(heads, 12), *joined


def _add(items: list[Any], item: Any) -> int:
    items.append(item)
    return len(items) - 1


def _ints(rows: Sequence[Sequence[int]], width: int) -> IntArray:
    return np.array(rows, dtype=np.int64).reshape(-1, width)


def _floats(rows: Sequence[Sequence[float]], width: int) -> FloatArray:
    return np.array(rows, dtype=float).reshape(-1, width)


class Marcher:
    """A plan ready to be followed over many rows in one call."""

    def __init__(self, mechanism: Mechanism, plan: Plan, accuracy: Accuracy) -> None:
        self.program, groups = _program(mechanism, plan)
        counts = [len(mechanism.nodes)] * 2 + [plan.registers] * 2 + [len(mechanism.actuators)] * 3 + [plan.branches]
        firsts = kernels.FIXED + np.concatenate([[0], np.cumsum(counts)])
        self.at = kernels.Lanes(*(int(f) for f in firsts[:-1]))
        self.lanes = _aligned(int(firsts[-1]), kernels.WIDTH)
        self.room = newton.room(groups, plan.registers, len(mechanism.actuators))
        constants = NewtonConstants()
        self.limits = constants.limits(accuracy, constants.iterations, near=True)
        self.tolerance = accuracy.tolerance * accuracy.size
        fixed = mechanism.members[0]
        for node, z in zip(fixed.nodes, fixed.shape, strict=True):
            self.lanes[self.at.x + node], self.lanes[self.at.y + node] = z.real, z.imag

    def recall(self, times: FloatArray, inputs: FloatArray, xs: FloatArray, ys: FloatArray, gs: FloatArray) -> None:
        """Begin from solved rows: inputs (actuators, rows), xs, ys (rows, nodes), gs (rows, branches)."""
        lanes, at = self.lanes, self.at
        cos, sin = cos_sin(inputs)
        for k in range(kernels.HISTORY):
            n = len(times) - kernels.HISTORY + k
            lanes[kernels.TIME, k] = times[n] if n >= 0 else -math.inf
            n = max(n, 0)
            lanes[at.x : at.y, k], lanes[at.y : at.rx, k], lanes[at.g :, k] = xs[n], ys[n], gs[n]
            lanes[at.values : at.cos, k], lanes[at.cos : at.sin, k] = inputs[:, n], cos[:, n]
            lanes[at.sin : at.g, k] = sin[:, n]
        lanes[at.rx : at.values, : kernels.HISTORY] = 0.0  # directions are found from the nodes

    def go(
        self, first: int, time: FloatArray, inputs: FloatArray, z: ComplexArray, residual: FloatArray,
        work: FloatArray, sign: FloatArray, determinant: FloatArray,
    ) -> tuple[int, Iterator[Kept]]:  # fmt: skip
        """Solve rows from `first` on until one is doubtful; return how many, and rows to continue from.

        time (rows,), inputs (actuators, rows); z (nodes, rows), residual and work (rows,) are filled,
        determinant (groups,) is brought up to date.
        """
        kept, mark = np.zeros((RING, len(self.lanes))), np.zeros(2, dtype=np.int64)
        pairs = z.view(float).reshape(*z.shape, 2)
        rows = kernels.Rows(time, inputs, pairs, residual, work, kept, mark)
        with np.errstate(all="ignore"):
            done = jit.compiled(kernels.march)(
                self.lanes.reshape(-1), self.lanes, self.program, self.at, rows, first, sign, determinant, self.room,
                self.limits, self.tolerance,
            )  # fmt: skip
        written = int(mark[0])
        return int(done), self._rows(kept[np.arange(max(0, written - RING), written) % RING])

    def _rows(self, kept: FloatArray) -> Iterator[Kept]:
        at = self.at
        for row in kept:
            error = float(row[kernels.ERROR])
            yield float(row[kernels.TIME]), row[at.x : at.y], row[at.y : at.rx], row[at.g :], error


def _aligned(lanes: int, width: int) -> FloatArray:
    """Return zeros whose rows begin where a line of the cache does."""
    room = np.zeros(lanes * width + LINE // 8)
    skip = (-room.ctypes.data % LINE) // 8
    return room[skip : skip + lanes * width].reshape(lanes, width)


def _program(mechanism: Mechanism, plan: Plan) -> tuple[kernels.Program, list[newton.GroupArrays]]:
    writer = _ProgramWriter()
    steps = _ints([writer.step(step) for step in plan.steps], 6)
    reach = np.array([step.distance if isinstance(step, Tilt) else 0.0 for step in plan.steps])
    heads, values = [], []
    for check in checks(mechanism):
        vectors = writer.vector(check.first), writer.vector(check.second)
        heads.append((check.kind, check.p, check.q, *vectors, check.value.actuator))
        values.append((check.value.constant, check.value.gain))
    loci = writer.loci_arrays()
    parts = [steps, reach, *writer.vector_arrays(), *loci, *writer.group_arrays(), _ints(heads, 6), _floats(values, 2)]
    program = kernels.Program._make([*parts, mechanism.size])
    return program, writer.groups
