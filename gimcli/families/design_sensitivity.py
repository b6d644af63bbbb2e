"""Values and exact derivatives of quantities by dimensions and inputs, along the positions of one mechanism.

Dimensions that redundant constraints fix have none: a change of one of them alone contradicts the other dimensions.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.dual import Dual, variables
from gimcli.errors import UsageError
from gimcli.families.design_state import DesignState
from gimcli.families.family import Family
from gimcli.families.float_tables import FloatTables
from gimcli.kernels.plan_steps import Program
from gimcli.mechanism import ANGLE, SPAN, BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run
from gimcli.positions.program import plan_program
from gimcli.quantities.quantity import Item
from gimcli.quantities.state import Needs
from gimcli.structure.plan import make_plan

FIXED = 1e-6
"""Derivative of a constraint's error, relative to the largest one of a node, above which the constraint is violated."""


def contradicting(at: DesignState) -> BoolArray:
    """Return for each dimension whether, to first order, its change violates a constraint in a row.

    `at` has one design in dual numbers, with the derivatives by the dimensions.
    """
    most = np.maximum(np.abs(at.z.slopes).max(axis=(2, 3))[:, 0], 1.0 / at.mechanism.scale)
    tables = plan_program(at.mechanism, make_plan(at.mechanism)).tables
    worst = np.zeros(len(most))
    for number in range(len(tables.ci)):
        worst = np.maximum(worst, np.abs(_error(tables, number, at).slopes).max(axis=(1, 2)))
    return np.asarray(worst > FIXED * most)


def _error(tables: Program, number: int, at: DesignState) -> Any:
    """Return the error of a constraint (1, rows) as a length, up to a constant."""
    kind, p, q, first, second, _ = tables.ci[number]
    if kind == ANGLE:
        return at.mechanism.size * np.angle(_vector(tables, first, at) / _vector(tables, second, at))
    arm = at.z[:, p] - (at.z[:, q] if q >= 0 else 0.0)
    value = at.tables.cv[:, number, :1]
    if kind == SPAN:
        return abs(arm) - value
    normal = _vector(tables, first, at)
    return (np.conj(normal / abs(normal)) * arm).real - value


def _vector(tables: Program, number: int, at: DesignState) -> Any:
    """Return a vector of the plan (1, rows): a factor times the vector between two nodes, or times 1 on the frame."""
    u, v = tables.vi[number][:2]
    factor = at.tables.vz[:, number, 0] + 1j * at.tables.vz[:, number, 1]
    return factor[:, None] * (at.z[:, int(v)] - at.z[:, int(u)] if u >= 0 else np.ones(at.z.shape[-1]))


BLOCK = 1 << 22
"""Numbers of an array of derivatives that are computed in one call."""

ROWS = 12
"""Rows in which constraints are compared with derivatives, if there are redundant constraints."""


class QuantitySlopes(NamedTuple):
    """Quantities in rows, in the file's units; NaN where they are not defined."""

    values: FloatArray  # (quantities, rows)
    slopes: FloatArray  # (quantities, dimensions, rows)
    good: BoolArray  # (rows,) the derivatives exist


class DesignSensitivity:
    """Derivatives of quantities by dimensions and inputs of a mechanism, at its own dimensions."""

    def __init__(
        self, mechanism: Mechanism, dimensions: Sequence[str], quantities: Sequence[Item], run: Run
    ) -> None:  # fmt: skip
        """Plan the derivatives; names of actuators among the dimensions stand for their inputs."""
        self.mechanism, self.quantities, self.run = mechanism, tuple(quantities), run
        actuators = [a.name for a in mechanism.actuators]
        own = [name for name in dimensions if name not in actuators]
        self.family = Family(mechanism, own)
        nominal = self.family.nominal[None]
        self.tables = self.family.tables(variables(nominal, len(actuators)))
        self.order = Needs(mechanism, (item.quantity for item in self.quantities)).order
        forced = [item.head.name for item in self.quantities if Needs(mechanism, [item.quantity]).forced]
        self.forces = self.family.forces if forced else None
        if self.forces is None and forced:
            raise UsageError(
                f"of '{forced[0]}': forces have exact derivatives without dry friction, gears, inputs that follow"
                " others and redundant constraints; `gim sweep --keep` has the values"
            )
        order = [*own, *actuators]
        self._chosen = [order.index(name) for name in dimensions]
        units = [mechanism.value_from_file(k, 1.0) - mechanism.value_from_file(k, 0.0) for k in range(len(actuators))]
        self._units = np.array([*[1.0] * len(own), *units])

    def __call__(
        self, z: ComplexArray, inputs: FloatArray, rates: FloatArray | None = None, time: FloatArray | None = None
    ) -> QuantitySlopes:
        """Return the quantities in solved rows z (nodes, rows) with inputs (actuators, rows).

        `rates` (3, actuators, rows) are the derivatives of the inputs by the time [s] (rows,), which the dimensions do
        not change.
        """
        given = inputs[None] if rates is None else np.concatenate([inputs[None], rates])
        width = max(1, BLOCK // max(1, len(self._units) * len(z)))
        if self.forces is not None and any(gauge.rotary for gauge in self.mechanism.gauges):
            width = z.shape[1]  # the turns of springs are counted from the first row on
        clock = np.zeros(z.shape[1]) if time is None else time
        starts = range(0, z.shape[1], width)
        parts = [self._block(z[:, k : k + width], given[..., k : k + width], clock[k : k + width]) for k in starts]
        values, slopes, good = (np.concatenate(some, axis=-1) for some in zip(*parts, strict=True))
        return QuantitySlopes(values, slopes, good)

    def fixed(self, z: ComplexArray, inputs: FloatArray) -> tuple[str, ...]:
        """Return the dimensions that redundant constraints fix, from some rows: one of them alone cannot change."""
        if not self.family.plan.surplus:
            return ()
        some = slice(None, None, max(1, z.shape[1] // ROWS))
        own, good = self._moving(z[:, some], Dual(inputs[:, some], np.zeros((len(self._units), 1, 1))))
        if not good.any():
            return ()
        found = contradicting(DesignState(self.family, self.family.nominal[None], own[..., good], self.tables))
        return tuple(name for name, fixed in zip(self.family.names, found.tolist(), strict=False) if fixed)

    def _moving(self, z: ComplexArray, inputs: Dual) -> tuple[Dual, BoolArray]:
        """Return positions in dual numbers (1, nodes, rows), and whether they have derivatives (rows,)."""
        found, good = self.family.slopes.moving(self.family.nominal[None], z[None], inputs[None], self.run)
        return found, good[0]

    def _block(self, z: ComplexArray, given: FloatArray, time: FloatArray) -> QuantitySlopes:
        nominal, own = self.family.nominal[None], self.family.couplings.moving(self.family.nominal, given)
        if self.family.linked:
            own = self.family.linked_slopes(self.family.nominal, z, own[: self.order + 1], self.run)
        (at, good), jit = self._moving(z, own[0]), "off" if self.run is plain else "on"
        state = DesignState(self.family, nominal, at, self.tables, own[None], time[None], self.quantities, jit=jit)
        values, slopes = state.values(self.quantities)[:, 0], state.slopes(self.quantities)[:, 0]
        with np.errstate(all="ignore"):
            slopes = (slopes * self._units[:, None])[:, self._chosen]
        solved = np.isfinite(z).all(axis=0)
        values[:, ~solved], slopes[..., ~good] = np.nan, np.nan
        return QuantitySlopes(values, slopes, good & np.isfinite(slopes).all(axis=(0, 1)))


def moves_nodes(tables: FloatTables) -> BoolArray:
    """Return which tangents (tangents,) of dual numbers change a length, an angle or a place of the mechanism."""
    every: Any = tables[:-1]  # without the laws
    changes = (table.slopes.reshape(len(table.slopes), -1) for table in every)
    return np.asarray(np.any([np.any(slopes != 0.0, axis=1) for slopes in changes], axis=0))
