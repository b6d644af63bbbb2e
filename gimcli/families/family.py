"""A family of designs: one mechanism, some of whose dimensions vary; planned once and solved in compiled code."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.errors import GimError, UsageError
from gimcli.families.designs import Designs
from gimcli.families.float_tables import FloatTables
from gimcli.families.planned_family import PlannedFamily
from gimcli.input_laws import LaterLaw
from gimcli.kernels import family as kernels, jit, march as marching, plan_steps
from gimcli.mechanism import FRAME, BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.assemble import Assembler
from gimcli.motion.motion import motion_at, trace
from gimcli.motion.solve import moved, settled, start_position
from gimcli.positions.block import NEW, RowBlock
from gimcli.positions.dispatch import choose, plain
from gimcli.positions.inputs import divided, law_inputs, scales
from gimcli.positions.newton import Accuracy, NewtonConstants
from gimcli.positions.options import Options
from gimcli.positions.program import plan_program
from gimcli.quantities.state import first_row
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import allowed, residual as constraint_errors
from gimcli.structure.steps import Plan

if TYPE_CHECKING:
    pass

SHARE = 256
"""Greatest number of designs that one thread solves in one call."""

ONE = 5e-3
"""Seconds that one design takes if it is solved by itself."""


class Family(PlannedFamily):
    """The designs of a mechanism that differ in the named dimensions, solved in compiled code."""

    # -- positions ----------------------------------------------------------------------------

    def solve(
        self, designs: FloatArray, steps: int = 72, *, inputs: FloatArray | None = None, reachable: bool = False,
        threads: int | None = None, jit: str = "auto", notify: Callable[[str], None] | None = None,
    ) -> Designs:  # fmt: skip
        """Follow the motions of designs.

        Args:
            designs: (designs, dimensions) in the file's units.
            steps: number of steps of the laws; the result has steps + 1 rows.
            inputs: rows of inputs instead of the laws, (actuators, rows) or (designs, actuators, rows) in rad or
                lengths of the normal frame.
            reachable: a design without a position at the first row starts at the first row that has one.
            threads: number of threads, by default one for each core.
            jit: "auto" compiles the kernels where this saves time, and for plans with coupled groups; "on"; "off": the
                designs are solved one by one. The last digits may differ, and a coupled group may be assembled
                otherwise. Rows of `inputs`, and `reachable`, are always compiled.
            notify: called with a text before a compilation.

        Returns:
            Designs, with a status for each row.
        """
        again = partial(self.solve, reachable=reachable, threads=threads, jit=jit, notify=notify)
        designs = np.atleast_2d(np.asarray(designs, dtype=float))
        if designs.shape[1] != len(self.names):
            raise UsageError(f"designs: expected {len(self.names)} columns ({', '.join(self.names)})")
        tables = self.tables(designs)
        if inputs is None:
            time = np.arange(steps + 1) / steps
            values = self.law_inputs(time, tables)
        else:
            values = np.array(inputs if np.ndim(inputs) == 3 else np.asarray(inputs)[None], dtype=float, order="C")
            time = np.linspace(0.0, 1.0, values.shape[2]) if values.shape[2] > 1 else np.zeros(1)
        grid, between, own = self._refined(time, values)
        count, rows, place = len(designs), len(time), np.full(len(grid), -1)
        place[own] = np.arange(rows)
        jit = "on" if reachable or inputs is not None else mode_of(self.plan, jit)
        if self.linked:  # each design is followed by itself
            jit, values = "off", np.repeat(values, count // len(values), axis=0)
        run = choose(jit, count * ONE, notify, (kernel_name(self.plan),))
        outcome = np.full(count, kernels.CAREFUL)
        z = np.full((count, len(self.mechanism.nodes), rows), complex(math.nan, math.nan))
        residual = np.full((count, rows), math.nan)
        first, end = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
        finite = np.all([np.isfinite(t).reshape(count, -1).all(axis=1) for t in tables[:-1]], axis=0)
        if run is not plain and self.start is not None:
            found = kernels.FamilyRows(z.view(float).reshape(*z.shape, 2), residual, place, outcome, first, end)
            nominal = self._nominal_rows(time, values[0], reachable)
            self._compiled(tables, grid, between, found, nominal, own if reachable else own[:1], threads)
            outcome[~finite | self._reversed(tables)] = kernels.CAREFUL
        careful = np.flatnonzero((outcome == kernels.CAREFUL) & ((first == 0) | (inputs is None)))
        first, end = np.searchsorted(own, first), np.searchsorted(own, end)
        codes = self._codes(outcome, first, end, rows)
        for d in careful.tolist():
            if first[d]:
                self._from_row(designs[d], int(first[d]), z[d], residual[d], codes[d])
            elif inputs is not None and not self.linked:
                codes[d] = int(Status.NOT_CONVERGED)
            else:
                given = values[d] if self.linked else None
                self._by_itself(designs[d], z[d], residual[d], codes[d], given, inputs is None)
        bad = codes > Status.TANGENT
        z.transpose(0, 2, 1)[bad] = complex(math.nan, math.nan)
        residual[bad] = math.nan
        return Designs(self, again, designs, tables, time[None], values, z, codes, residual, len(careful))

    def _refined(self, time: FloatArray, inputs: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return times (rows,) and inputs (designs or 1, actuators, rows) with rows in between, none far from the next.

        Also the indices of the given rows. Inputs are linear in between.
        """
        step = np.abs(np.diff(inputs, axis=2)) / scales(self.mechanism)[:, None]
        parts = np.maximum(np.ceil(step.max(axis=(0, 1), initial=0.0) / kernels.LONGEST), 1.0).astype(np.int64)
        own = np.append(0, np.cumsum(parts))
        if own[-1] + 1 == len(time) or not np.isfinite(step).all():
            return time, inputs, np.arange(len(time))
        return divided(time, parts), np.ascontiguousarray(divided(inputs, parts)), own

    def _reversed(self, tables: FloatTables) -> BoolArray:
        """Return the designs (designs,) with a link whose length has not the sign of the nominal one.

        The equations of positions have the square of a length; a model file with such a length is refused.
        """
        found = np.zeros(len(tables.shapes), dtype=bool)
        for k, member in enumerate(self.mechanism.members):
            if k != FRAME and len(member.nodes) == 2:
                first, nominal = first_row(self.mechanism, k), np.diff(member.shape)[0]
                side = tables.shapes[:, first + 1] - tables.shapes[:, first]
                found |= side[:, 0] * nominal.real + side[:, 1] * nominal.imag <= 0.0
        return found

    def _codes(self, outcome: IntArray, first: IntArray, end: IntArray, rows: int) -> IntArray:
        """Return the status of every row (designs, rows)."""
        row = np.arange(rows)
        after = np.where(outcome == kernels.CAREFUL, int(Status.SINGULAR), int(Status.LIMIT))
        codes = np.where(row < end[:, None], int(Status.OK), after[:, None])
        codes = np.where(row < first[:, None], int(Status.NOT_ASSEMBLED), codes)
        codes[outcome == kernels.NO_START] = int(Status.NOT_ASSEMBLED)
        codes[outcome == kernels.CONTRADICTS] = int(Status.CONTRADICTORY)
        return codes

    def _by_itself(
        self, design: FloatArray, z: ComplexArray, residual: FloatArray, codes: IntArray, inputs: FloatArray | None,
        laws: bool,
    ) -> None:  # fmt: skip
        """Solve one design as a single motion into z (nodes, rows), residual and codes (rows,), and inputs if given.

        laws: along its laws, otherwise at the inputs.
        """
        codes[:] = int(Status.NOT_ASSEMBLED)
        with suppress(GimError):
            own, options = self.alone(design), Options(tolerance=self.tolerance)
            units = np.where([[a.rotary] for a in own.actuators], 1.0, own.scale / self.mechanism.scale)
            if laws or inputs is None:
                motion = trace(self._on_nominal_branch(own), len(codes) - 1, options)
            else:
                motion = motion_at(own, inputs / units, options)
            z[:], residual[:], codes[:] = self._here(own, motion.z), motion.residual, motion.codes
            if inputs is not None:
                inputs[:] = units * motion.inputs

    def _from_row(self, design: FloatArray, row: int, z: ComplexArray, residual: FloatArray, codes: IntArray) -> None:
        """Solve one design as a single motion from its first position in z (nodes, rows) on, and the row before it."""
        own, last = self.alone(design), z.shape[1] - 1
        inputs = law_inputs(own)(np.array([row - 1, row]) / last)
        drawn = (self.mechanism.to_file(z[:, row]) - own.origin) / own.scale
        actuators = (
            replace(a, drawn=float(u), law=LaterLaw(a.law, row / last))
            for a, u in zip(own.actuators, inputs[:, 1], strict=True)
        )
        own = replace(own, drawn=drawn, actuators=tuple(actuators))
        motion = trace(own, max(last - row, 1), Options(tolerance=self.tolerance))
        upto = last + 1 - row
        z[:, row:] = self._here(own, motion.z[:, :upto])
        residual[row:], codes[row:] = motion.residual[:upto], motion.codes[:upto]
        plan, (start, end) = make_plan(own), inputs.T
        near = Assembler(own, plan, plain, self.tolerance).assemble(start, drawn).status is not Status.NOT_ASSEMBLED
        before = moved(own, plan, drawn, end, start, plain, self.tolerance) if near else None
        if before is not None:  # a position so close to a limit that its branch was not determined
            z[:, row - 1], codes[row - 1] = self._here(own, before), int(Status.OK)
            residual[row - 1] = constraint_errors(own, before[:, None], inputs[:, :1]).total[0]

    def _here(self, own: Mechanism, z: ComplexArray) -> ComplexArray:
        """Return positions of a design in the normal frame of the nominal mechanism."""
        return np.asarray((own.to_file(z) - self.mechanism.origin) / self.mechanism.scale)

    def _on_nominal_branch(self, own: Mechanism) -> Mechanism:
        """Return a design with the start position on the branch of the nominal one as its initial configuration.

        It is unchanged if it cannot be assembled there, or if a coupled group has to be followed from the nominal one.
        """
        plan = make_plan(own)
        if (
            self.linked
            or self.start is None
            or plan.coupled
            or plan_program(own, plan).tables.steps != self.program.tables.steps
        ):
            return own
        inputs = own.start_inputs
        found = Assembler(own, plan, plain, self.tolerance).assemble(inputs, own.drawn, signs=self.start[1].copy())
        if not found.regular:
            return own
        actuators = (replace(a, drawn=float(u)) for a, u in zip(own.actuators, inputs, strict=True))
        return replace(own, drawn=settled(own, found), actuators=tuple(actuators))

    # -- the nominal design -------------------------------------------------------------------

    @cached_property
    def start(self) -> tuple[FloatArray, FloatArray] | None:
        """The lanes of the nominal start position (lanes,), and the branch signs; None if it is not regular.

        Without coupled groups the signs, those of the initial coordinates, are enough.
        """
        mechanism = self.mechanism
        found = start_position(mechanism, self.plan, mechanism.start_inputs, plain, self.tolerance)
        if not found.regular and self.plan.coupled:
            return None
        if not found.regular:
            drawn = Assembler(mechanism, self.plan, plain, self.tolerance).assemble(
                mechanism.start_inputs, mechanism.drawn
            )
            return np.zeros(self.program.count), drawn.signs
        z = (found.row.x + 1j * found.row.y)[:, None]
        return self._lanes(np.zeros(1), mechanism.start_inputs[:, None], z, found.signs)[0], found.signs

    def _lanes(self, time: FloatArray, inputs: FloatArray, z: ComplexArray, sign: FloatArray) -> FloatArray:
        """Return the lanes (rows, lanes) of solved rows z (nodes, rows) of the nominal design."""
        program, rows = self.program, len(time)
        block = RowBlock(program, time, inputs)
        block.x[:, NEW:], block.y[:, NEW:] = z.real, z.imag
        with np.errstate(all="ignore"):
            for k in range(len(self.plan.steps)):
                if k not in program.packed:
                    plan_steps.place(block.lanes, program.tables, program.at, k, sign, block.end)
        table = np.zeros((rows, program.count))
        at = program.at
        for first, part in (
            (at.x, block.x), (at.y, block.y), (at.rx, block.rx), (at.ry, block.ry), (at.values, block.inputs),
            (at.cos, block.cos), (at.sin, block.sin), (at.g, block.g),
        ):  # fmt: skip
            table[:, first : first + len(part)] = part[:, NEW : NEW + rows].T
        return table

    def _nominal_rows(self, time: FloatArray, inputs: FloatArray, reachable: bool) -> FloatArray:
        """Return the lanes (rows, lanes) of the nominal rows; only the first one unless `reachable`."""
        assert self.start is not None
        lanes, sign = self.start
        if not reachable or len(time) == 1 or not self.plan.coupled:
            return lanes[None]
        motion = trace(self.mechanism, len(time) - 1, Options(tolerance=self.tolerance))
        rows = self._lanes(time, inputs, motion.z, sign)
        rows[0] = lanes
        rows[~motion.good] = math.nan
        return rows

    # -- compiled -----------------------------------------------------------------------------

    @cached_property
    def _nominal_tables(self) -> kernels.Tables:
        return kernels.Tables(*self.tables(self.nominal[None])[:7])

    @cached_property
    def _solver(self) -> kernels.RowSolver:
        mechanism, constants = self.mechanism, NewtonConstants()
        accuracy = Accuracy(self.tolerance, mechanism.size, mechanism.shortest)
        limits = constants.limits(accuracy, constants.iterations, near=True)
        enough = allowed(mechanism, self.tolerance)
        return kernels.RowSolver(self.program.room(), limits, self.tolerance * mechanism.size, enough)

    def _compiled(
        self, tables: FloatTables, time: FloatArray, inputs: FloatArray,
        found: kernels.FamilyRows, rows: FloatArray, begins: IntArray, threads: int | None,
    ) -> None:  # fmt: skip
        """Solve all designs in compiled code, in several threads."""
        solve = jit.compiled(kernels.family, self.program.variant)
        _, sign = self.start or (np.empty(0), np.empty(0))
        groups = self.program.group_arrays
        nominal = kernels.Nominal(
            self.program.arrays, groups, self._nominal_tables,
            np.array(self.mechanism.members[FRAME].nodes, dtype=np.int64),
            rows, sign, np.zeros(len(groups.gi)), scales(self.mechanism),
            self.plan.surplus > 0,
        )  # fmt: skip
        own = kernels.Tables(*tables[:7])
        self._find_determinants(solve, nominal)
        count = len(found.outcome)
        starts = range(0, count, SHARE)
        workers = min(threads or os.cpu_count() or 1, len(starts))
        todo = iter(starts)

        def work(_: int) -> None:
            room, solver, one = self._scratch()
            for begin in todo:
                with np.errstate(all="ignore"):
                    solve(
                        nominal, self.program.at, own, time, inputs, room, solver, one, found, begin,
                        min(begin + SHARE, count), begins,
                    )  # fmt: skip

        if workers == 1:
            work(0)
            return
        with ThreadPoolExecutor(workers) as pool:
            list(pool.map(work, range(workers)))

    def _find_determinants(self, solve: Callable[..., Any], nominal: kernels.Nominal) -> None:
        """Fill the signs of the determinants of the coupled groups at the nominal start position."""
        if not len(nominal.determinant):
            return
        room, solver, one = self._scratch()
        nodes = len(self.mechanism.nodes)
        found = kernels.FamilyRows(
            np.empty((1, nodes, 1, 2)), np.empty((1, 1)), *(np.zeros(1, dtype=np.int64) for _ in range(4)),
        )  # fmt: skip
        inputs = np.ascontiguousarray(self.mechanism.start_inputs[None, :, None])
        solve(
            nominal, self.program.at, self._nominal_tables, np.zeros(1), inputs, room, solver, one, found, 0, 1,
            np.zeros(1, dtype=np.int64),
        )  # fmt: skip
        nominal.determinant[:] = room.determinant

    def _scratch(self) -> tuple[kernels.Room, kernels.RowSolver, marching.Rows]:
        """Return the scratch arrays of one thread."""
        lanes = self.program.lanes(plan_steps.WIDTH)
        room = kernels.Room(
            lanes.reshape(-1), lanes, kernels.Tables(*(table.copy() for table in self._nominal_tables)),
            np.zeros(len(self.program.groups)), np.zeros(2, dtype=np.int64),
        )  # fmt: skip
        actuators = len(self.mechanism.actuators)
        one = marching.Rows(
            np.zeros(1), np.zeros((actuators, 1)), np.zeros((1, 1, 2)), np.zeros(1), np.zeros(1), np.zeros((1, 1)),
            np.zeros(2, dtype=np.int64),
        )  # fmt: skip
        return room, self._solver._replace(room=self.program.room()), one


def mode_of(plan: Plan, jit: str) -> str:
    """Return the mode in which designs are solved: a coupled group is followed from the nominal design if compiled."""
    return "on" if jit == "auto" and plan.coupled else jit


def kernel_name(plan: Plan) -> str:
    """Return the name of the kernel that solves the designs of a plan."""
    return "family" if plan.coupled else "family_dyads"
