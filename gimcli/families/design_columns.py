"""Columns of many designs at once, from their positions: the same numbers as those of a trace of each design.

Columns of coordinates, inputs, angles and velocities of members, and transmission angles are computed for all designs
together. Columns of accelerations, and other measures, are computed design by design, which takes about a millisecond
each; so are velocities in small sweeps, which are not compiled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property, partial
from typing import Any

import numpy as np

from gimcli.errors import ModelError
from gimcli.families.column_names import SOLVED, TYPE, ColumnNames, ColumnNeed
from gimcli.families.design_velocities import node_velocities
from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.families.float_tables import FloatTables, spans
from gimcli.families.four_bar_type import four_bar_types
from gimcli.families.input_value import first_crossing, times_of
from gimcli.measures.angle import RelativeAngle
from gimcli.measures.measure import Measure, angle_to_file
from gimcli.measures.record import derivatives_of
from gimcli.measures.transmission import ForceLine, Transmission
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.motion import Motion, stream
from gimcli.positions.inputs import law_inputs, scales
from gimcli.positions.options import Options
from gimcli.rates.member_angles import CLEAR, COUNTED, LawAngles, full_turn
from gimcli.rates.motion_table import motion_table
from gimcli.rates.path_derivatives import PathDerivatives
from gimcli.status import Status
from gimcli.structure.checks import farthest

FINEST = 64
"""Largest number of parts of a step in which an angle is followed to count its turns."""

TOGETHER = 64
"""Number of designs whose laws are evaluated together, if they differ."""


class DesignColumns:
    """The columns of some designs along the laws."""

    def __init__(
        self, family: Family, names: ColumnNames, solved: Designs, options: dict[str, Any], together: bool = False
    ) -> None:
        self.family, self.names, self.solved = family, names, solved
        self.designs, self.mechanism = solved.designs, family.mechanism
        self._options = options  # of Family.solve
        self._together = together  # whether velocities are computed for all designs together
        self._found: dict[str, FloatArray] = {}

    @cached_property
    def tables(self) -> FloatTables:
        """The numbers of the plan of each design."""
        return self.family.tables(self.designs)

    @cached_property
    def time(self) -> FloatArray:
        """The normalised time of the rows (designs or 1, rows)."""
        return self.solved.time[None]

    def rows(self, name: str) -> FloatArray:
        """Return a column, or the columns of a measure (designs, rows, columns) in the file's units."""
        if name not in self._found:
            need = self.names.needs.get(name)
            found = self._measured(name) if need is None else [self._column(name, need)]
            self._found[name] = np.stack(found, axis=2)
        return self._found[name]

    def number(self, name: str) -> Any:
        """Return a varied dimension, the number or share of solved rows, or the Grashof type (designs,)."""
        if name in self.names.dimensions:
            return self.designs[:, self.names.dimensions.index(name)]
        if name == TYPE:
            return four_bar_types(self.mechanism, self.tables, self.solved.z[:, :, 0])
        return self.solved.solved.astype(float) if name == SOLVED else self.solved.reachable

    def at(self, actuator: str, value: float) -> DesignColumns | ColumnsAtRow:
        """Return the columns at the first position at which an input has a value [file's unit]."""
        k, count = [a.name for a in self.mechanism.actuators].index(actuator), len(self.designs)
        wanted = self.mechanism.value_from_file(k, value)
        inputs = np.broadcast_to(self.solved.inputs, (count, *self.solved.inputs.shape[1:])).copy()
        found = first_crossing(inputs[:, k], wanted)
        between = found.between
        if not len(between):
            return ColumnsAtRow(self, found.row)
        row, time = found.row[between], np.broadcast_to(self.time, (count, self.time.shape[1])).copy()
        laws = self._laws(between)
        time[between, row] = times_of(lambda t: laws(t)[:, k], time[between, row - 1], time[between, row], wanted)
        inputs[between, :, row] = laws(time[between, row])
        inputs[between, k, row] = wanted
        return ColumnsAtRow(self._with_rows(inputs, time, between, row), found.row)

    def _laws(self, chosen: IntArray) -> Callable[[FloatArray], FloatArray]:
        """Return the function of the inputs (designs, actuators) of some designs at a time of each (designs,)."""
        family, parts = self.family, np.array_split(np.arange(len(chosen)), -(-len(chosen) // TOGETHER))

        def inputs(time: FloatArray) -> FloatArray:
            if not family.drawn_laws:
                return law_inputs(self.mechanism)(time).T
            found = []
            for part in parts:
                tables = FloatTables(*(table[chosen[part]] for table in self.tables))
                found.append(np.einsum("dad->da", family.law_inputs(time[part], tables)))
            return np.concatenate(found)

        return inputs

    def _with_rows(self, inputs: FloatArray, time: FloatArray, chosen: IntArray, row: IntArray) -> DesignColumns:
        """Return the columns with one row of some designs at other inputs (designs, actuators, rows) and times."""
        compiled = self._options.get("jit") != "off"
        solved = self.family.solve(self.designs, inputs=inputs, **self._options) if compiled else self.solved
        z, codes, residual = solved.z.copy(), solved.codes.copy(), solved.residual.copy()
        for d, k in zip(chosen.tolist(), row.tolist(), strict=True):
            if (compiled and codes[d, k] == Status.OK) or self.solved.codes[d, k - 1] != Status.OK:
                continue
            own = self._own(d)
            if own is not None:
                motion = next(self._stream(own)(between=lambda _, d=d: time[d]))
                z[d] = (own.to_file(motion.z) - self.mechanism.origin) / self.mechanism.scale
                codes[d], residual[d] = motion.codes, motion.residual
        moved = Designs(self.designs, solved.time, inputs, z, codes, residual, 0)
        found = DesignColumns(self.family, self.names, moved, self._options, self._together)
        found.__dict__["time"] = time
        return found

    def _stream(self, own: Mechanism) -> partial[Iterator[Motion]]:
        """Return the function that solves the motion of one design by itself."""
        rows = self.solved.codes.shape[1]
        return partial(stream, own, rows - 1, Options(tolerance=self.family.tolerance, jit="off"), rows=rows)

    def _column(self, name: str, need: ColumnNeed) -> FloatArray:
        if need.order == 1 and self._velocities is not None:
            return self._velocity(need, self._velocities)
        if need.order:
            return self._one_by_one(lambda motion, angles: self._rates(motion, need, angles)[name])
        if need.point:
            path = self.mechanism.to_file(self.path(need.point))
            return np.asarray(path.real if need.part == "x" else path.imag)
        if need.member != FRAME:
            return self.angle(need.member)
        return self._of_row(name, need)

    def _of_row(self, name: str, need: ColumnNeed) -> FloatArray:
        shape = self.solved.codes.shape
        if need.actuator >= 0:
            values = self.mechanism.value_to_file(need.actuator, self.solved.inputs[:, need.actuator])
            return np.broadcast_to(values, shape)
        if name == "residual":
            return self.solved.residual
        if name == "step":
            return np.broadcast_to(self.time * (shape[1] - 1), shape)
        return np.broadcast_to(self.time * self._durations[:, None], shape)

    @cached_property
    def _durations(self) -> FloatArray:
        """The duration of the motion of each design (designs or 1,) [s]."""
        nominal = np.array([self.mechanism.duration])
        ends = [self._own(k) for k in (0, len(self.designs) - 1)]
        if all(own is None or own.duration == nominal[0] for own in ends):
            return nominal
        return np.array(
            [nominal[0] if own is None else own.duration for own in map(self._own, range(len(self.designs)))]
        )

    @cached_property
    def _velocities(self) -> ComplexArray | None:
        """Velocities of all nodes (designs, nodes, rows), normal frame; None if they are not computed together."""
        if not self._together:
            return None
        found = node_velocities(self.family, self.solved, self.tables, self.time)
        return None if found is None else found * (self.mechanism.duration / self._durations)[:, None, None]

    def _velocity(self, need: ColumnNeed, nodes: ComplexArray) -> FloatArray:
        """Return a velocity of a point or a member in the file's units."""
        if need.point:
            found = self.path(need.point, nodes, 0.0) * self.mechanism.scale
            return np.asarray(found.real if need.part == "x" else found.imag)
        first, second = self.mechanism.members[need.member].nodes[:2]
        z = self.solved.z
        with np.errstate(all="ignore"):
            turning = ((nodes[:, second] - nodes[:, first]) / (z[:, second] - z[:, first])).imag
        return angle_to_file(self.mechanism, turning)

    def path(self, name: str, z: ComplexArray | None = None, fixed: float = 1.0) -> ComplexArray:
        """Return the path of a node or point (designs, rows), normal frame of the nominal mechanism.

        z (designs, nodes, rows) are the nodes, or their velocities; then points of the frame are multiplied by 0.
        """
        mechanism, z = self.mechanism, self.solved.z if z is None else z
        if name in mechanism.nodes:
            return z[:, mechanism.nodes.index(name)]
        number = next(k for k, p in enumerate(mechanism.points) if p.name == name)
        point, local = mechanism.points[number], _complex(self.tables.points[:, number])
        if point.member == FRAME:
            return np.where(np.isfinite(z[:, 0]), fixed * local[:, None], np.nan)
        member, first = mechanism.members[point.member], spans(mechanism)[point.member]
        far = farthest(member)
        start, end = (_complex(self.tables.shapes[:, first + k]) for k in (0, far))
        factor = (local - start) / (end - start)
        base = z[:, member.nodes[0]]
        return np.asarray(base + (z[:, member.nodes[far]] - base) * factor[:, None])

    # -- angles, full turns counted ---------------------------------------------------------------------

    def angle(self, member: int) -> FloatArray:
        """Return the direction of a member (designs, rows) in the file's angle unit, full turns counted."""
        key = f"\0{member}"
        if key not in self._found:
            self._found[key] = self._turns(member)
        return self._found[key]

    def _turns(self, member: int) -> FloatArray:
        if member == FRAME:
            return np.where(np.isfinite(self.solved.z[:, 0]), 0.0, np.nan)
        found = np.full(self.solved.codes.shape, np.nan)
        if self._options.get("jit") != "off":
            found = self._turns_together(member) * (full_turn(self.mechanism) / (2.0 * np.pi))
        for k in np.flatnonzero(np.any(self.solved.good & ~np.isfinite(found), axis=1)).tolist():
            motion = self.motion(k)
            if motion is not None:
                found[k] = LawAngles(motion.mechanism, len(motion.time) - 1, self._stream(motion.mechanism))(
                    motion, member
                )
        return found

    def _turns_together(self, member: int) -> FloatArray:
        """Return the directions of a member [rad] with full turns counted, of all designs together."""
        inputs = self.solved.inputs
        change = np.abs(np.diff(inputs, axis=2)) / scales(self.mechanism)[:, None]
        parts = int(np.ceil(np.max(change, initial=0.0) / COUNTED * (1.0 - 1e-12))) or 1
        found, wide = self._counted(self, member, min(parts, FINEST))
        while len(wide) and parts < FINEST:
            parts = min(4 * parts, FINEST)
            own = DesignColumns(self.family, self.names, _chosen(self.solved, wide), self._options)
            finer, still = self._counted(own, member, parts)
            found[wide], wide = finer, wide[still]
        return found

    def _counted(self, own: DesignColumns, member: int, parts: int) -> tuple[FloatArray, IntArray]:
        """Return angles [rad], and the designs in which the member turns far from one row to the next.

        Each step is divided into `parts`, which are solved too if there are several.
        """
        z = own.solved.z
        if parts > 1:
            inputs = _divided(own.solved.inputs, parts)
            z = own.family.solve(own.designs, inputs=inputs, **own._options).z
        first, second = self.mechanism.members[member].nodes[:2]
        angle = np.angle(z[:, second] - z[:, first])
        exact = np.angle(own.solved.z[:, second] - own.solved.z[:, first])
        angle[:, ::parts] = np.where(np.isfinite(exact), exact, angle[:, ::parts])
        filled = _filled(angle)
        change = np.diff(filled, axis=1)
        change -= 2.0 * np.pi * np.round(change / (2.0 * np.pi))
        wide = np.flatnonzero(np.any(np.abs(change) > CLEAR, axis=1))
        total = filled[:, :1] + np.concatenate([np.zeros((len(z), 1)), np.cumsum(change, axis=1)], axis=1)
        exact_turns = exact + 2.0 * np.pi * np.round((total[:, ::parts] - exact) / (2.0 * np.pi))
        return exact_turns, wide

    # -- measures ---------------------------------------------------------------------------------------

    def _measured(self, name: str) -> list[FloatArray]:
        """Return the columns of a measure, or the one with this name."""
        spec, wanted = self.names.spec(name), [head.name for head in self.names.heads(name)]
        found: list[FloatArray] = []
        for measure in self.names.measures(spec):
            heads = [head.name for head in measure.heads]
            if not set(wanted) & set(heads):
                continue
            columns = self._of_all(measure)
            if columns is None:
                heads = [head for head in heads if head in wanted]
                columns = [self._one_by_one(self._measure(spec, measure.spec, head)) for head in heads]
            found += [values for head, values in zip(heads, columns, strict=True) if head in wanted]
        return found

    def _of_all(self, measure: Measure) -> list[FloatArray] | None:
        """Return the columns of a measure for all designs together; None where that is not possible."""
        if isinstance(measure, Transmission):
            joint = measure.joint
            with np.errstate(all="ignore"):
                first, second = (self._line(line, joint.node) for line in (joint.first, joint.second))
                product = np.conj(first) * second
                angle = np.where(product == 0.0, np.nan, np.arctan2(np.abs(product.imag), product.real))
            return [angle_to_file(self.mechanism, angle)]
        if isinstance(measure, RelativeAngle):
            angle = self.angle(measure.pair[0]) - self.angle(measure.pair[1])
            turn = full_turn(self.mechanism)
            return [angle - turn * np.ceil(_filled(angle)[:, :1] / turn - 0.5)]
        return None

    def _line(self, line: ForceLine, joint: int) -> ComplexArray:
        """Return the direction of a line at a joint (designs, rows)."""
        z, mechanism = self.solved.z, self.mechanism
        if line.slide is None:
            return np.asarray(z[:, line.node] - z[:, joint])
        number = next(k for k, slide in enumerate(mechanism.slides) if slide is line.slide)
        normal, guide = _complex(self.tables.normals[:, number])[:, None], mechanism.members[line.slide.guide]
        if line.slide.guide == FRAME:
            return np.where(np.isfinite(z[:, joint]), normal, np.nan)
        first, far = spans(mechanism)[line.slide.guide], farthest(guide)
        own = _complex(self.tables.shapes[:, first + far] - self.tables.shapes[:, first])[:, None]
        unit = (z[:, guide.nodes[far]] - z[:, guide.nodes[0]]) / own
        return np.asarray(normal * unit / np.abs(unit))

    def _measure(self, spec: str, own: str, head: str) -> Callable[[Motion, Any], FloatArray]:
        """Return the function that computes one column of a measure for one design."""
        from gimcli.measures import measures_of

        def of(motion: Motion, angles: Any) -> FloatArray:
            measure = next(m for m in measures_of(motion.mechanism, spec) if m.spec == own)
            number = [h.name for h in measure.heads].index(head)
            return measure.values(_derivatives(motion, angles))[number]

        return of

    # -- design by design -------------------------------------------------------------------------------

    def _rates(self, motion: Motion, need: ColumnNeed, angles: Any) -> dict[str, FloatArray]:
        names = (need.point,) if need.point else ()
        table = motion_table(motion, names or motion.mechanism.traced[:1], order=need.order, angles=angles)
        return {column.name: column.values for column in table.columns}

    def _one_by_one(self, of: Callable[[Motion, Any], FloatArray]) -> FloatArray:
        """Return a column that is computed for one design after the other."""
        found = np.full(self.solved.codes.shape, np.nan)
        for k in np.flatnonzero(np.any(self.solved.good, axis=1)).tolist():
            motion = self.motion(k)
            if motion is not None:
                with np.errstate(all="ignore"):
                    found[k] = of(motion, lambda _, member, k=k: self.angle(member)[k])
        return np.where(self.solved.good, found, np.nan)

    def _own(self, k: int) -> Mechanism | None:
        """Return a design as a mechanism of its own; None if its dimensions are not possible."""
        try:
            return self.mechanism.with_(dict(zip(self.names.dimensions, self.designs[k].tolist(), strict=True)))
        except ModelError:
            return None

    def motion(self, k: int) -> Motion | None:
        """Return the motion of a design as a mechanism of its own; None if its dimensions are not possible."""
        own = self._own(k)
        if own is None:
            return None
        solved, nominal = self.solved, self.mechanism
        z = (nominal.to_file(solved.z[k]) - own.origin) / own.scale
        inputs = solved.inputs[k % len(solved.inputs)].copy()
        for number, actuator in enumerate(own.actuators):
            inputs[number] *= 1.0 if actuator.rotary else nominal.scale / own.scale
        time = self.time[k % len(self.time)]
        work = np.zeros(len(time))
        return Motion(own, time, inputs, z, solved.codes[k], solved.residual[k], work, z[:, 0])


class ColumnsAtRow:
    """The columns at one row of each design; NaN for rows below 0."""

    def __init__(self, columns: DesignColumns, row: IntArray) -> None:
        self._columns, self._row = columns, row

    def rows(self, name: str) -> FloatArray:
        """Return a column (designs, 1, columns)."""
        values = self._columns.rows(name)
        found = values[np.arange(len(values)), np.maximum(self._row, 0)]
        return np.where(self._row[:, None] >= 0, found, np.nan)[:, None]

    def number(self, name: str) -> Any:
        """Return a number of each design (designs,)."""
        return self._columns.number(name)

    def at(self, actuator: str, value: float) -> DesignColumns | ColumnsAtRow:
        """Return the columns at another value."""
        return self._columns.at(actuator, value)


def _derivatives(motion: Motion, angles: Any) -> PathDerivatives:
    return derivatives_of(motion, angles)


def _complex(pairs: FloatArray) -> ComplexArray:
    return np.asarray(pairs[..., 0] + 1j * pairs[..., 1])


def _chosen(solved: Designs, chosen: IntArray) -> Designs:
    """Return some of the solved designs."""
    inputs = solved.inputs if len(solved.inputs) == 1 else solved.inputs[chosen]
    return Designs(
        solved.designs[chosen], solved.time, inputs, solved.z[chosen], solved.codes[chosen], solved.residual[chosen], 0
    )


def _divided(inputs: FloatArray, parts: int) -> FloatArray:
    """Return inputs (·, actuators, rows) with each step divided into equal parts; the given rows are kept exactly."""
    share = np.arange(parts) / parts
    steps = inputs[:, :, :-1, None] + np.diff(inputs, axis=2)[..., None] * share
    return np.concatenate([steps.reshape(*inputs.shape[:2], -1), inputs[:, :, -1:]], axis=2)


def _filled(values: FloatArray) -> FloatArray:
    """Return values (designs, rows) with the last known value in rows without one, at the start the first."""
    known = np.isfinite(values)
    rows = np.where(known, np.arange(values.shape[1]), -1)
    last = np.maximum.accumulate(rows, axis=1)
    last = np.where(last >= 0, last, np.argmax(known, axis=1)[:, None])
    return np.take_along_axis(values, last, axis=1)
