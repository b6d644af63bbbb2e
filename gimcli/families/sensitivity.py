"""Exact derivatives of positions by dimensions and inputs, for many designs and rows in one call."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gimcli.families.float_tables import FloatTables, with_inputs
from gimcli.kernels import sensitivity as kernels
from gimcli.kernels.lanes import WIDTH, aligned
from gimcli.kernels.march import Groups
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.positions.newton import Run
from gimcli.positions.program import PlanProgram, plan_program
from gimcli.rates.derivatives import parts
from gimcli.structure.derived import derived
from gimcli.structure.plan import make_plan
from gimcli.structure.steps import NONE

BoolArray = NDArray[np.bool_]


@derived
def plan_structure(mechanism: Mechanism) -> PlanStructure:
    """Return the steps of a mechanism's plan in the arrays of the kernel."""
    return PlanStructure(mechanism, plan_program(mechanism, make_plan(mechanism)))


class PlanStructure:
    """The steps of a plan in the arrays of the kernel, and the numbers of its lanes."""

    def __init__(self, mechanism: Mechanism, program: PlanProgram) -> None:
        self.actuators, self.vectors = len(mechanism.actuators), len(program.arrays.vi)
        self.structure = self._structure(mechanism, program)
        s, pairs = self.structure, len(mechanism.nodes) + program.registers
        vectors, arms, most = len(s.vi), len(s.li) + len(s.ei), max((int(g[6]) for g in s.gi), default=2)
        counts = (
            2 * pairs, 2 * pairs, 2 * self.actuators, self.actuators, 2 * vectors, 2 * vectors, 2 * arms, len(s.steps),
            most,
        )  # fmt: skip
        firsts = np.cumsum([kernels.SENSITIVITY_LANES, *counts]).tolist()
        self.at, self.pairs = kernels.SensitivityLanes(*firsts[:-1]), pairs
        self.lanes = self._number_group_lanes(firsts[-1])

    def _structure(self, mechanism: Mechanism, program: PlanProgram) -> kernels.Structure:
        q, groups = program.arrays, program.group_arrays
        vi, places, equations, bases, heads = [q.vi], [_table(3)], [_table(5)], [_table(1)[:, 0]], []
        for g in groups.gi:
            part = _renumbered(groups, g, self.vectors)
            ends = [sum(map(len, some)) for some in (bases, places, equations)]
            for some, new in zip((vi, bases, places, equations), part, strict=True):
                some.append(new)
            spans = [k for first, new in zip(ends, part[1:], strict=True) for k in (first, first + len(new))]
            heads.append((*spans, g[1], 0, 0, 0, 0))
        return kernels.Structure(
            len(mechanism.nodes), np.array(program.frame.nodes, dtype=np.int64), q.steps, np.concatenate(vi), q.li,
            np.array(heads, dtype=np.int64).reshape(-1, 11), np.concatenate(bases), np.concatenate(places),
            np.concatenate(equations),
        )  # fmt: skip

    def _number_group_lanes(self, first: int) -> int:
        """Set the first lanes of gains, factors, scales and scratch of each group; return the number of all lanes."""
        for g in self.structure.gi:
            bases, places, rows = g[1] - g[0], g[3] - g[2], g[6]
            sizes = (2 * places * bases, 2 * rows * bases, rows, 6 * bases)
            g[7:] = first + np.cumsum([0, *sizes[:-1]])
            first += sum(sizes)
        return int(first)


def _table(width: int) -> IntArray:
    return np.zeros((0, width), dtype=np.int64)


def _renumbered(groups: Groups, head: IntArray, vectors: int) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Return vectors, base nodes, places and equations of a group, with the numbers of nodes and vectors of all."""
    local = np.append(groups.nodes[head[3] : head[4]], NONE)
    vi, pi, ei = (
        table[head[k] : head[k + 1]].copy() for table, k in ((groups.vi, 5), (groups.pi, 7), (groups.ei, 9))
    )  # fmt: skip
    offset = vectors + head[5]
    vi[:, :2], pi[:, :2], ei[:, 1:3] = local[vi[:, :2]], local[pi[:, :2]], local[ei[:, 1:3]]
    pi[:, 2] += offset
    ei[:, 3] = np.where(ei[:, 3] == NONE, NONE, ei[:, 3] + offset)
    return vi, local[: head[0]], pi, ei


def position_derivatives(
    mechanism: Mechanism, numbers: FloatTables, tangents: FloatTables, z: ComplexArray, inputs: FloatArray, run: Run,
    nodes: Sequence[int] | None = None, by_inputs: bool = True,
) -> tuple[ComplexArray, BoolArray]:  # fmt: skip
    """Return the derivatives of nodes (designs, dimensions + actuators, nodes, rows), and where they are defined.

    numbers: of each design, axes (designs, ...); tangents: their derivatives, axes (designs, dimensions, ...). z
    (designs, nodes, rows), inputs (1 or designs, actuators, rows) in the normal frame. The derivatives by dimensions
    are at constant inputs; after them come those by the inputs [rad or lengths of the normal frame], if `by_inputs`.
    The mask (designs, rows) is false in rows without a position and at singular positions: the derivatives are NaN.
    """
    plan, (designs, _, rows) = plan_structure(mechanism), z.shape
    actuators = plan.actuators if by_inputs else 0
    wanted = np.arange(z.shape[1]) if nodes is None else np.array(nodes, dtype=np.int64)
    table = _kernel_tangents(tangents, plan.actuators, actuators)
    out = np.zeros((designs, table.vz.shape[1], len(wanted), rows), dtype=complex)
    own = kernels.Numbers(_joined(numbers.vz, numbers.gvz), _joined(numbers.lv, numbers.gev))
    given = np.array(np.broadcast_to(inputs, (designs, *inputs.shape[1:])), order="C")  # read-only: compiled again
    w, live, mark = aligned(plan.lanes * WIDTH), np.zeros(plan.pairs, dtype=np.int64), np.zeros((designs, rows))
    with np.errstate(all="ignore"):
        run(kernels.differentiate_all)(
            w, plan.structure, plan.at, own, table, parts(np.ascontiguousarray(z)), given, live, wanted, parts(out),
            mark,
        )  # fmt: skip
    good = np.isfinite(mark)
    if not good.all():
        out.transpose(0, 3, 1, 2)[~good] = np.nan
    return out, good


def _kernel_tangents(tangents: FloatTables, inputs: int, by_inputs: int) -> kernels.Tangents:
    """Return derivatives with those by the inputs appended to the axis of the dimensions; they change no number."""
    vz, lv, reach, gvz, gev, frame = (
        with_inputs(table, by_inputs)
        for table in (tangents.vz, tangents.lv, tangents.reach, tangents.gvz, tangents.gev, tangents.frame)
    )
    moved = np.zeros((vz.shape[1], inputs))
    moved[vz.shape[1] - by_inputs :] = np.eye(by_inputs, inputs)
    return kernels.Tangents(_joined(vz, gvz), _joined(lv, gev), reach, frame, moved)


def _joined(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.concatenate([one, other], axis=-2)
