"""Columns of many designs at once, from their positions: the same numbers as those of a trace of each design.

Columns of coordinates, inputs, angles and velocities of members, and transmission angles are computed for all designs
together. Columns of accelerations, and other measures, are computed design by design, which takes about a millisecond
each; so are velocities in small sweeps, which are not compiled.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.families.column_names import REACHABLE, SOLVED, TYPE, ColumnNames, ColumnNeed
from gimcli.families.design_angles import counted_angles, filled
from gimcli.families.design_motions import DesignMotions
from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.families.float_tables import FloatTables, spans
from gimcli.families.four_bar_type import four_bar_types
from gimcli.families.sensitivity import position_derivatives
from gimcli.measures.angle import RelativeAngle
from gimcli.measures.measure import Measure, angle_to_file
from gimcli.measures.record import derivatives_of
from gimcli.measures.transmission import ForceLine, Transmission
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, IntArray
from gimcli.motion.motion import Motion
from gimcli.positions.dispatch import choose
from gimcli.rates.member_angles import full_turn
from gimcli.rates.motion_table import motion_table


class DesignColumns:
    """The columns of some designs along the laws."""

    def __init__(self, motions: DesignMotions, names: ColumnNames, together: bool = False) -> None:
        """Take solved designs; `together`: velocities are computed for all of them together, in compiled code."""
        self.motions, self.names, self._together = motions, names, together
        self.solved, self.mechanism, self.designs = motions.solved, motions.mechanism, motions.solved.designs
        self._found: dict[str, Any] = {}
        self._angles: dict[int, FloatArray] = {}

    def __getitem__(self, name: str) -> Any:
        """Return a column (designs, rows), or the columns of a measure (columns, designs, rows); NaN if not solved.

        All are in the file's units. A dimension or a word has one value for each design (designs, 1).
        """
        if name not in self._found:
            self._found[name] = self._new(name)
        return self._found[name]

    def _new(self, name: str) -> Any:
        need = self.names.needs.get(name)
        if need is not None:
            return np.where(self.solved.good, self._column(name, need), np.nan)
        if name in self.names.dimensions:
            return self.designs[:, self.names.dimensions.index(name), None]
        if name == TYPE:
            return four_bar_types(self.mechanism, self.motions.tables, self.solved.z[:, :, 0])[:, None]
        if name in (SOLVED, REACHABLE):
            return (self.solved.solved.astype(float) if name == SOLVED else self.solved.reachable)[:, None]
        found = np.where(self.solved.good, np.stack(self._measured(name)), np.nan)
        return found if len(found) > 1 else found[0]

    def at(self, actuator: str, value: float) -> DesignColumns | ColumnsAtRow:
        """Return the columns at the first position at which an input has a value [file's unit]."""
        k = [a.name for a in self.mechanism.actuators].index(actuator)
        motions, row = self.motions.at_input(k, self.mechanism.value_from_file(k, value))
        same = motions is self.motions
        return ColumnsAtRow(self if same else DesignColumns(motions, self.names, self._together), row)

    def angle(self, member: int) -> FloatArray:
        """Return the direction of a member (designs, rows) in the file's angle unit, full turns counted."""
        if member not in self._angles:
            self._angles[member] = counted_angles(self.motions, member)
        return self._angles[member]

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
            return np.broadcast_to(self.motions.time * (shape[1] - 1), shape)
        return np.broadcast_to(self.motions.time * self.motions.durations[:, None], shape)

    @cached_property
    def _velocities(self) -> ComplexArray | None:
        """Velocities of all nodes (designs, nodes, rows), normal frame; None if they are not computed together."""
        if not self._together:
            return None
        found = node_velocities(self.motions.family, self.solved, self.motions.tables, self.motions.time)
        return None if found is None else found * (self.mechanism.duration / self.motions.durations)[:, None, None]

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
        point, local = mechanism.points[number], _complex(self.motions.tables.points[:, number])
        if point.member == FRAME:
            return np.where(np.isfinite(z[:, 0]), fixed * local[:, None], np.nan)
        member, first = mechanism.members[point.member], spans(mechanism)[point.member]
        far = member.base
        start, end = (_complex(self.motions.tables.shapes[:, first + k]) for k in (0, far))
        factor = (local - start) / (end - start)
        base = z[:, member.nodes[0]]
        return np.asarray(base + (z[:, member.nodes[far]] - base) * factor[:, None])

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
            return [angle - turn * np.ceil(filled(angle)[:, :1] / turn - 0.5)]
        return None

    def _line(self, line: ForceLine, joint: int) -> ComplexArray:
        """Return the direction of a line at a joint (designs, rows)."""
        z, mechanism = self.solved.z, self.mechanism
        if line.slide is None:
            return np.asarray(z[:, line.node] - z[:, joint])
        number = next(k for k, slide in enumerate(mechanism.slides) if slide is line.slide)
        normal, guide = _complex(self.motions.tables.normals[:, number])[:, None], mechanism.members[line.slide.guide]
        if line.slide.guide == FRAME:
            return np.where(np.isfinite(z[:, joint]), normal, np.nan)
        first, far = spans(mechanism)[line.slide.guide], guide.base
        own = _complex(self.motions.tables.shapes[:, first + far] - self.motions.tables.shapes[:, first])[:, None]
        unit = (z[:, guide.nodes[far]] - z[:, guide.nodes[0]]) / own
        return np.asarray(normal * unit / np.abs(unit))

    def _measure(self, spec: str, own: str, head: str) -> Callable[[Motion, Any], FloatArray]:
        """Return the function that computes one column of a measure for one design."""
        from gimcli.measures import measures_of

        def of(motion: Motion, angles: Any) -> FloatArray:
            measure = next(m for m in measures_of(motion.mechanism, spec) if m.spec == own)
            number = [h.name for h in measure.heads].index(head)
            return measure.values(derivatives_of(motion, angles))[number]

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
            motion = self.motions.motion(k)
            if motion is not None:
                with np.errstate(all="ignore"):
                    found[k] = of(motion, lambda _, member, k=k: self.angle(member)[k])
        return found


class ColumnsAtRow:
    """The columns at one row of each design; NaN for rows below 0."""

    def __init__(self, columns: DesignColumns, row: IntArray) -> None:
        self._columns, self._row = columns, row

    def __getitem__(self, name: str) -> Any:
        """Return a column (designs, 1), the columns of a measure (columns, designs, 1), or a number (designs, 1)."""
        values = self._columns[name]
        if self._columns.names.kind(name).what != "rows":
            return values
        places = np.broadcast_to(np.maximum(self._row, 0)[:, None], (*values.shape[:-1], 1))
        return np.where(self._row[:, None] >= 0, np.take_along_axis(values, places, -1), np.nan)

    def at(self, actuator: str, value: float) -> DesignColumns | ColumnsAtRow:
        """Return the columns at another value."""
        return self._columns.at(actuator, value)


def _complex(pairs: FloatArray) -> ComplexArray:
    return np.asarray(pairs[..., 0] + 1j * pairs[..., 1])


def node_velocities(family: Family, solved: Designs, tables: FloatTables, time: FloatArray) -> ComplexArray | None:
    """Return the velocities of the nodes (designs, nodes, rows) by the real time, normal frame of the nominal design.

    `time` (designs or 1, rows) is normalised. None if the laws of the designs have no rates that are known together.
    NaN in rows that are not solved or singular.
    """
    rates = _input_rates(family, tables, time)
    if rates is None:
        return None
    none: Any = (table[:, None][:, :0] for table in tables)
    run = choose("on", 0.0, None, ("differentiate_all",))
    by, good = position_derivatives(family.mechanism, tables, FloatTables(*none), solved.z, solved.inputs, run)
    found = np.einsum("dknr,dkr->dnr", by, np.broadcast_to(rates, (len(by), *rates.shape[1:])))
    return np.where(good[:, None], found, np.nan)


def _input_rates(family: Family, tables: FloatTables, time: FloatArray) -> FloatArray | None:
    """Return the rates of the inputs (designs or 1, actuators, rows) by the real time."""
    mechanism = family.mechanism
    laws = [np.stack([actuator.law(row, 1) for row in time]) for actuator in mechanism.actuators]
    rates = np.stack(laws, axis=1) / mechanism.duration
    if not family.drawn_laws:
        return rates
    spans = tables.laws[:, :, 1] - tables.laws[:, :, 0]
    nominal = family.tables(family.nominal[None]).laws[0]
    with np.errstate(all="ignore"):
        share = np.where(np.isfinite(spans), spans / (nominal[:, 1] - nominal[:, 0]), 1.0)
    return rates * share[:, :, None] if np.isfinite(share).all() else None
