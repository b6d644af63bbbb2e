"""The solved positions of many designs, each also as the motion of a mechanism of its own.

They also say where an input has a given value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from gimcli.calculus.dual import variables
from gimcli.errors import ModelError
from gimcli.families.float_tables import FloatTables
from gimcli.families.planned_family import PlannedFamily
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.motion import Motion, stream
from gimcli.numerics.along import bisected
from gimcli.positions.dispatch import choose
from gimcli.positions.inputs import law_inputs
from gimcli.positions.options import Options
from gimcli.quantities.state import ApartError
from gimcli.status import Status

EXACT = 1e-9
"""Share of a step within which a row has the value."""


def first_crossing(values: FloatArray, value: float) -> tuple[IntArray, IntArray]:
    """Return where values (designs, rows) first reach a value, if the row after it is moved there (designs,).

    -1: in no row. Also the designs in which this is between two rows, so that a row has to be moved.
    """
    first, second = values[:, :-1] - value, values[:, 1:] - value
    reach = EXACT * np.abs(second - first)
    inside = (np.minimum(first, second) <= reach) & (np.maximum(first, second) >= -reach) & (first != second)
    step = np.where(inside.any(axis=1), inside.argmax(axis=1), -1)
    one, two = (np.take_along_axis(part, np.maximum(step, 0)[:, None], axis=1)[:, 0] for part in (first, second))
    with np.errstate(all="ignore"):
        share = np.clip(np.where(one == two, 0.0, one / (one - two)), 0.0, 1.0)  # of the step
    between = np.flatnonzero((step >= 0) & (np.minimum(share, 1.0 - share) > EXACT))
    return np.where(step < 0, -1, step + (share > EXACT)), between


@dataclass(frozen=True)
class Designs:
    """The positions of designs, in the normal frame of the nominal mechanism."""

    family: PlannedFamily = field(repr=False)
    solve: partial[Designs] = field(repr=False)  # Family.solve with the same options
    designs: FloatArray = field(repr=False)  # (designs, dimensions) in the file's units
    tables: FloatTables = field(repr=False)  # the numbers of the plan of each design
    time: FloatArray = field(repr=False)  # (designs or 1, rows) 0..1
    inputs: FloatArray = field(repr=False)  # (designs or 1, actuators, rows)
    z: ComplexArray = field(repr=False)  # (designs, nodes, rows), NaN where not solved
    codes: IntArray = field(repr=False)  # (designs, rows) of Status
    residual: FloatArray = field(repr=False)  # (designs, rows), NaN where not solved
    careful: int = 0  # number of designs that were solved one by one
    moved: bool = False  # whether rows were moved to a value of an input

    @cached_property
    def good(self) -> BoolArray:
        """(designs, rows) whether the row is solved."""
        return np.asarray(self.codes <= Status.TANGENT)

    @cached_property
    def solved(self) -> IntArray:
        """(designs,) number of rows that are ok."""
        return np.asarray(self.good.sum(axis=1))

    @property
    def reachable(self) -> FloatArray:
        """(designs,) share of the rows that are ok."""
        return np.asarray(self.solved / self.codes.shape[1])

    @cached_property
    def status(self) -> IntArray:
        """(designs,) OK if all rows are, else the code of the first row that is not."""
        return np.asarray(self.codes[np.arange(len(self.codes)), np.argmin(self.good, axis=1)])

    @property
    def compiled(self) -> bool:
        """Whether designs are solved together in compiled code."""
        return bool(self.solve.keywords["jit"] != "off")

    @cached_property
    def durations(self) -> Any:
        """The duration of the motion of each design (designs or 1,) [s]."""
        return self.family.durations(np.moveaxis(self.designs, 1, 0))

    def with_slopes(self) -> Designs:
        """Return the designs in dual numbers, whose tangents are the dimensions.

        Raises ApartError for redundant constraints, with which one dimension alone cannot change, for inputs that
        follow the linkage, and for laws that change from design to design, in rows that were moved.
        """
        family = self.family
        if family.linked or family.plan.surplus or (family.drawn_laws and self.moved):
            raise ApartError
        designs: Any = variables(self.designs)
        tables = family.tables(designs)
        inputs = family.law_inputs(self.time[0], tables) if family.drawn_laws else self.inputs
        run = choose("on" if self.compiled else "off", 0.0)
        z: Any = family.slopes.moving(self.designs, self.z, inputs, run)[0]
        return replace(self, designs=designs, inputs=inputs, z=z, tables=tables)

    def input_rates(self, order: int) -> FloatArray:
        """Return the inputs and their derivatives by the real time (designs or 1, order + 1, actuators, rows).

        Raises ApartError for laws whose changes from design to design are not known.
        """
        if self.family.linked:
            raise ApartError
        actuators, orders = self.family.mechanism.actuators, range(1, order + 1)
        by_time = [[np.stack([a.law(row, k) for a in actuators]) for k in orders] for row in self.time]
        found = np.array(by_time) / np.stack([self.durations**k for k in orders], axis=1)[..., None, None]
        if self.family.drawn_laws:
            spans, nominal = (
                np.diff(t.laws)[..., 0] for t in (self.tables, self.family.tables(self.family.nominal[None]))
            )
            with np.errstate(all="ignore"):
                share = np.where(np.isfinite(spans), spans / nominal, 1.0)
            if not np.isfinite(share).all():
                raise ApartError
            found = found * share[:, None, :, None]
        inputs = np.broadcast_to(self.inputs[:, None], (max(len(found), len(self.inputs)), 1, *found.shape[2:]))
        return np.concatenate([inputs, np.broadcast_to(found, (len(inputs), *found.shape[1:]))], axis=1)

    def alone(self, k: int) -> Mechanism | None:
        """Return a design as a mechanism of its own; None if its dimensions are not possible."""
        try:
            return self.family.alone(self.designs[k])
        except ModelError:
            return None

    def motion(self, k: int) -> Motion | None:
        """Return the motion of a design as a mechanism of its own; None if its dimensions are not possible."""
        own = self.alone(k)
        if own is None:
            return None
        nominal = self.family.mechanism
        z = (nominal.to_file(self.z[k]) - own.origin) / own.scale
        inputs = self.inputs[k % len(self.inputs)].copy()
        for number, actuator in enumerate(own.actuators):
            inputs[number] *= 1.0 if actuator.rotary else nominal.scale / own.scale
        time = self.time[k % len(self.time)]
        return Motion(own, time, inputs, z, self.codes[k], self.residual[k], np.zeros(len(time)), z[:, 0])

    def again(self, own: Mechanism) -> partial[Iterator[Motion]]:
        """Return the function that solves the motion of one design by itself, with rows between."""
        rows = self.codes.shape[1]
        return partial(stream, own, rows - 1, Options(tolerance=self.family.tolerance, jit="off"), rows=rows)

    def chosen(self, designs: IntArray) -> Designs:
        """Return some of the designs."""
        inputs, time = (part if len(part) == 1 else part[designs] for part in (self.inputs, self.time))
        tables = FloatTables(*(table[designs] for table in self.tables))
        parts = self.z[designs], self.codes[designs], self.residual[designs]
        return Designs(self.family, self.solve, self.designs[designs], tables, time, inputs, *parts)

    def at_input(self, actuator: int, value: float) -> tuple[Designs, IntArray]:
        """Return motions with a row in which an input first has a value [normal frame], and this row (designs,).

        A row that has no such row beside it is moved there, by the laws. The row is -1 where the value is not reached.
        """
        count = len(self.designs)
        inputs = np.broadcast_to(self.inputs, (count, *self.inputs.shape[1:])).copy()
        rows, between = first_crossing(inputs[:, actuator], value)
        if not len(between):
            return self, rows
        row, time = rows[between], np.broadcast_to(self.time, (count, self.time.shape[1])).copy()
        laws = self._laws(between)
        low, high = time[between, row - 1], time[between, row]
        start = laws(low)[:, actuator] - value
        time[between, row] = bisected(lambda t: (laws(t)[:, actuator] - value) * start <= 0.0, low, high)[1]
        inputs[between, :, row] = laws(time[between, row])
        inputs[between, actuator, row] = value
        return self._with_rows(inputs, time, between, row), rows

    def _laws(self, chosen: IntArray) -> Callable[[FloatArray], FloatArray]:
        """Return the function of the inputs (designs, actuators) of some designs at a time of each (designs,)."""
        family, tables = self.family, FloatTables(*(table[chosen] for table in self.tables))
        alone = [self.alone(k) or family.mechanism for k in chosen.tolist()] if family.linked else []

        def inputs(time: FloatArray) -> FloatArray:
            if alone:
                return np.concatenate([law_inputs(m)(time[k : k + 1]) for k, m in enumerate(alone)], axis=1).T
            return np.asarray(family.law_inputs(time[:, None], tables)[..., 0])

        return inputs

    def _with_rows(self, inputs: FloatArray, time: FloatArray, chosen: IntArray, row: IntArray) -> Designs:
        """Return the motions with one row of some designs at other inputs (designs, actuators, rows) and times."""
        mechanism, solved = self.family.mechanism, self
        if self.compiled:
            solved = self.solve(self.designs, inputs=inputs)
        z, codes, residual = solved.z.copy(), solved.codes.copy(), solved.residual.copy()
        for d, k in zip(chosen.tolist(), row.tolist(), strict=True):
            done = self.compiled and codes[d, k] <= Status.TANGENT
            own = None if done or self.codes[d, k - 1] > Status.TANGENT else self.alone(d)
            if own is not None:
                motion = next(self.again(own)(between=lambda _, d=d: time[d]))
                z[d] = (own.to_file(motion.z) - mechanism.origin) / mechanism.scale
                codes[d], residual[d] = motion.codes, motion.residual
        return replace(self, time=time, inputs=inputs, z=z, codes=codes, residual=residual, careful=0, moved=True)
