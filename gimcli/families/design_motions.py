"""The motions of designs that are solved together, each also as the motion of a mechanism of its own.

They also say where an input has a given value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.dual import variables
from gimcli.errors import ModelError
from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.families.float_tables import FloatTables
from gimcli.mechanism import FloatArray, IntArray, Mechanism
from gimcli.motion.motion import Motion, stream
from gimcli.numerics.along import bisected
from gimcli.positions.dispatch import choose
from gimcli.positions.inputs import law_inputs
from gimcli.positions.options import Options
from gimcli.quantities.state import ApartError
from gimcli.status import Status

EXACT = 1e-9
"""Share of a step within which a row has the value."""

TOGETHER = 64
"""Number of designs whose laws are evaluated together, if they differ."""


class InputCrossing(NamedTuple):
    """The step of each design in which an input first reaches a value, and the share of the step before it."""

    step: IntArray  # (designs,), -1: the value is not reached
    share: FloatArray  # (designs,) 0..1

    @property
    def between(self) -> IntArray:
        """The designs in which the value lies between two rows."""
        inside = (self.step >= 0) & (np.minimum(self.share, 1.0 - self.share) > EXACT)
        return np.flatnonzero(inside)

    @property
    def row(self) -> IntArray:
        """The row that has the value, if the row after the step is moved there; -1 if there is none."""
        return np.where(self.step < 0, -1, self.step + (self.share > EXACT))


def first_crossing(values: FloatArray, value: float) -> InputCrossing:
    """Return where values (designs, rows) first reach a value."""
    first, second = values[:, :-1] - value, values[:, 1:] - value
    reach = EXACT * np.abs(second - first)
    inside = (np.minimum(first, second) <= reach) & (np.maximum(first, second) >= -reach) & (first != second)
    step = np.where(inside.any(axis=1), inside.argmax(axis=1), -1)
    one, two = (np.take_along_axis(part, np.maximum(step, 0)[:, None], axis=1)[:, 0] for part in (first, second))
    with np.errstate(all="ignore"):
        return InputCrossing(step, np.clip(np.where(one == two, 0.0, one / (one - two)), 0.0, 1.0))


class DesignMotions:
    """The solved positions of designs, and single designs of them."""

    def __init__(
        self, family: Family, solved: Designs, options: dict[str, Any], time: FloatArray | None = None
    ) -> None:
        self.family, self.solved, self.mechanism = family, solved, family.mechanism
        self.options = options  # of Family.solve
        self.time = solved.time[None] if time is None else time  # (designs or 1, rows), normalised

    @property
    def compiled(self) -> bool:
        """Whether designs are solved together in compiled code."""
        return bool(self.options.get("jit") != "off")

    @cached_property
    def tables(self) -> FloatTables:
        """The numbers of the plan of each design."""
        return self.family.tables(self.solved.designs)

    @cached_property
    def durations(self) -> Any:
        """The duration of the motion of each design (designs or 1,) [s]."""
        return self.family.durations(np.moveaxis(self.solved.designs, 1, 0))

    def with_slopes(self) -> DesignMotions:
        """Return the motions in dual numbers, whose tangents are the dimensions.

        Raises ApartError for redundant constraints, with which one dimension alone cannot change, for inputs that
        follow the linkage, and for laws that change from design to design, in rows that were moved.
        """
        family, solved = self.family, self.solved
        if family.linked or family.plan.surplus or (family.drawn_laws and np.any(self.time != solved.time)):
            raise ApartError
        designs = variables(solved.designs)
        tables = family.tables(designs)
        inputs = family.law_inputs(solved.time, tables) if family.drawn_laws else solved.inputs
        run = choose("on" if self.compiled else "off", 0.0)
        dual: dict[str, Any] = {"designs": designs, "inputs": inputs}
        dual["z"], _ = family.slopes.moving(solved.designs, solved.z, inputs, run)
        found = copy(self)
        found.solved = replace(solved, **dual)
        vars(found).pop("durations", None)
        vars(found)["tables"] = tables
        return found

    def input_rates(self, order: int) -> FloatArray:
        """Return the inputs and their derivatives by the real time (designs or 1, order + 1, actuators, rows).

        Raises ApartError for laws whose changes from design to design are not known.
        """
        if self.family.linked:
            raise ApartError
        actuators, orders = self.mechanism.actuators, range(1, order + 1)
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
        inputs = np.broadcast_to(
            self.solved.inputs[:, None], (max(len(found), len(self.solved.inputs)), 1, *found.shape[2:])
        )
        return np.concatenate([inputs, np.broadcast_to(found, (len(inputs), *found.shape[1:]))], axis=1)

    def alone(self, k: int) -> Mechanism | None:
        """Return a design as a mechanism of its own; None if its dimensions are not possible."""
        try:
            return self.mechanism.with_(dict(zip(self.family.names, self.solved.designs[k].tolist(), strict=True)))
        except ModelError:
            return None

    def motion(self, k: int) -> Motion | None:
        """Return the motion of a design as a mechanism of its own; None if its dimensions are not possible."""
        own = self.alone(k)
        if own is None:
            return None
        solved, nominal = self.solved, self.mechanism
        z = (nominal.to_file(solved.z[k]) - own.origin) / own.scale
        inputs = solved.inputs[k % len(solved.inputs)].copy()
        for number, actuator in enumerate(own.actuators):
            inputs[number] *= 1.0 if actuator.rotary else nominal.scale / own.scale
        time = self.time[k % len(self.time)]
        return Motion(own, time, inputs, z, solved.codes[k], solved.residual[k], np.zeros(len(time)), z[:, 0])

    def again(self, own: Mechanism) -> partial[Iterator[Motion]]:
        """Return the function that solves the motion of one design by itself, with rows between."""
        rows = self.solved.codes.shape[1]
        return partial(stream, own, rows - 1, Options(tolerance=self.family.tolerance, jit="off"), rows=rows)

    def chosen(self, designs: IntArray) -> DesignMotions:
        """Return some of the designs."""
        s = self.solved
        inputs, time = (part if len(part) == 1 else part[designs] for part in (s.inputs, self.time))
        parts = s.z[designs], s.codes[designs], s.residual[designs]
        return DesignMotions(self.family, Designs(s.designs[designs], s.time, inputs, *parts, 0), self.options, time)

    def at_input(self, actuator: int, value: float) -> tuple[DesignMotions, IntArray]:
        """Return motions with a row in which an input first has a value [normal frame], and this row (designs,).

        A row that has no such row beside it is moved there, by the laws. The row is -1 where the value is not reached.
        """
        count = len(self.solved.designs)
        inputs = np.broadcast_to(self.solved.inputs, (count, *self.solved.inputs.shape[1:])).copy()
        found = first_crossing(inputs[:, actuator], value)
        between = found.between
        if not len(between):
            return self, found.row
        row, time = found.row[between], np.broadcast_to(self.time, (count, self.time.shape[1])).copy()
        laws = self._laws(between)
        low, high = time[between, row - 1], time[between, row]
        start = laws(low)[:, actuator] - value
        time[between, row] = bisected(lambda t: (laws(t)[:, actuator] - value) * start <= 0.0, low, high)[1]
        inputs[between, :, row] = laws(time[between, row])
        inputs[between, actuator, row] = value
        return self._with_rows(inputs, time, between, row), found.row

    def _laws(self, chosen: IntArray) -> Callable[[FloatArray], FloatArray]:
        """Return the function of the inputs (designs, actuators) of some designs at a time of each (designs,)."""
        family, parts = self.family, np.array_split(np.arange(len(chosen)), -(-len(chosen) // TOGETHER))

        def inputs(time: FloatArray) -> FloatArray:
            if family.linked:
                own = [self.alone(k) or self.mechanism for k in chosen.tolist()]
                return np.concatenate([law_inputs(m)(time[k : k + 1]) for k, m in enumerate(own)], axis=1).T
            if not family.drawn_laws:
                return law_inputs(self.mechanism)(time).T
            found = []
            for part in parts:
                tables = FloatTables(*(table[chosen[part]] for table in self.tables))
                found.append(np.einsum("dad->da", family.law_inputs(time[part], tables)))
            return np.concatenate(found)

        return inputs

    def _with_rows(self, inputs: FloatArray, time: FloatArray, chosen: IntArray, row: IntArray) -> DesignMotions:
        """Return the motions with one row of some designs at other inputs (designs, actuators, rows) and times."""
        before = self.solved
        solved = self.family.solve(before.designs, inputs=inputs, **self.options) if self.compiled else before
        z, codes, residual = solved.z.copy(), solved.codes.copy(), solved.residual.copy()
        for d, k in zip(chosen.tolist(), row.tolist(), strict=True):
            done = self.compiled and codes[d, k] <= Status.TANGENT
            own = None if done or before.codes[d, k - 1] > Status.TANGENT else self.alone(d)
            if own is not None:
                motion = next(self.again(own)(between=lambda _, d=d: time[d]))
                z[d] = (own.to_file(motion.z) - self.mechanism.origin) / self.mechanism.scale
                codes[d], residual[d] = motion.codes, motion.residual
        moved = Designs(before.designs, before.time, inputs, z, codes, residual, 0)
        return DesignMotions(self.family, moved, self.options, time)
