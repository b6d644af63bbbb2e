"""A family of designs as its plan: one mechanism, some of whose dimensions vary, and the numbers of each design."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.calculus.recorded import Recorded
from gimcli.errors import ModelError, StructureError
from gimcli.families.coupling_slopes import CouplingSlopes
from gimcli.families.design_rates import DesignRates, PositionSlopes
from gimcli.families.float_tables import FloatTables, TableMaker, listed
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.positions.inputs import law_inputs
from gimcli.positions.program import plan_program
from gimcli.quantities.state import ApartError
from gimcli.structure.plan import make_plan

if TYPE_CHECKING:
    from gimcli.families.design_forces import DesignForces
    from gimcli.families.linked_slopes import LinkedSlopes

KEPT = 64
"""Number of designs that are kept as mechanisms of their own: their curves are not followed again."""


class PlannedFamily:
    """The designs of a mechanism that differ in the named dimensions.

    What the dimensions decide about the structure (the order of solution, the loci of each step) is that of the
    nominal design; every solved row is checked against all constraints of its own design.
    """

    def __init__(self, mechanism: Mechanism, names: Sequence[str], tolerance: float = 1e-10) -> None:
        """Plan a family.

        Args:
            mechanism: the nominal design, from `load` or `loads`.
            names: the dimensions that vary.
            tolerance: largest accepted error of a constraint, relative to the mechanism's size.

        Raises:
            UsageError: an unknown name.
            StructureError: the mechanism is not fully driven.
        """
        self.mechanism, self.names, self.tolerance = mechanism, tuple(names), tolerance
        self.recorded = recorded, recording = mechanism.written.recorded(mechanism, self.names)
        self.nominal: FloatArray = np.array([variable.value for variable in recording.variables])
        self.plan = make_plan(mechanism)
        self.program = plan_program(mechanism, self.plan)
        own = plan_program(recorded, make_plan(recorded))
        self.maker = TableMaker(recording, listed(recorded, own))
        self.drawn_laws = bool(self.maker.slots[-1][1])
        self._rates: dict[int, DesignRates] = {}
        self._alone = lru_cache(KEPT)(lambda own: mechanism.with_(dict(zip(self.names, own, strict=True))))
        self.couplings, self.linked = CouplingSlopes(recorded, recording), mechanism.complete is not None
        if self.couplings.varied and not self.linked and not all(hasattr(law, "start") for law in self.couplings.laws):
            raise StructureError(
                f"{mechanism.name}: these dimensions change how inputs follow others, whose laws are tables or"
                " polynomials; choose other dimensions, or laws with `to`, `by` or `turns`"
            )

    # -- numbers ------------------------------------------------------------------------------

    def tables(self, designs: Any) -> FloatTables:
        """Return the numbers of the plan for designs (designs, dimensions) in the file's units, plain or dual."""
        return self.maker.tables(designs)

    def alone(self, design: FloatArray) -> Mechanism:
        """Return a design (dimensions,) as a mechanism of its own; raise ModelError if it is not possible."""
        return self._alone(tuple(design.tolist()))

    def without_effect(self, *designs: FloatArray, forces: bool = False) -> list[str]:
        """Return the dimensions whose values in designs (designs, dimensions) change neither positions nor time.

        Such as initial coordinates of nodes whose distances are given, and masses. With `forces` those that change no
        forces either.
        """
        found, values, acting = [], np.concatenate(designs), set[str]()
        if forces:
            from gimcli.families.design_forces import dynamic_dimensions  # imported late: few ask for forces

            acting = dynamic_dimensions(self.mechanism, self.names)
        for k, name in enumerate(self.names):
            tried = np.tile(self.nominal, (len(values) + 1, 1))
            tried[1:, k] = values[:, k]
            same = (np.array_equal(t, np.broadcast_to(t[:1], t.shape), equal_nan=True) for t in self.tables(tried))
            changed = tried[:, k] != tried[0, k]
            still = name not in acting and changed.any() and all(same)
            if still and not self._changes_time(name, float(tried[changed, k][0])):
                found.append(name)
        return found

    def _changes_time(self, name: str, value: float) -> bool:
        """Return whether another value of a dimension changes the duration or a coupling, or is not possible."""
        try:
            own, nominal = self.mechanism.with_({name: value}), self.mechanism
            return own.duration != nominal.duration or own.couplings != nominal.couplings
        except ModelError:
            return True

    def law_inputs(self, time: FloatArray, tables: FloatTables) -> Any:
        """Return the inputs (designs or 1, actuators, rows) at times (rows,), in dual numbers if the tables are.

        The times may also be one for each design (designs, 1).
        """
        values = law_inputs(self.mechanism)(time.ravel())
        shared = values[None] if time.ndim == 1 else values.T[..., None]
        if not self.drawn_laws:
            return shared
        inputs = list(np.broadcast_to(shared, (len(tables.laws), *shared.shape[1:])).swapaxes(0, 1))
        for k, actuator in enumerate(self.mechanism.actuators):
            law: Any = actuator.law
            first, last = tables.laws[:, k, :1], tables.laws[:, k, 1:]
            if not np.isnan(first[0, 0]):
                profile = law.profile(time.ravel()).reshape(time.shape)
                inputs[k] = np.where(time == 1.0, last, first + (last - first) * profile)
        return np.stack(inputs, axis=1)

    def durations(self, dimensions: Any) -> Any:
        """Return the durations of motions [s] (designs or 1,) of values of the dimensions (dimensions, designs)."""
        mechanism, recording = self.recorded
        duration = mechanism.duration
        if not isinstance(duration, Recorded):
            return np.array([duration])
        return recording.evaluate(dimensions, [duration.place])[duration.place]

    def rates(self, order: int) -> DesignRates:
        """Return what computes the derivatives of nodes and members by the time up to an order."""
        if order not in self._rates:
            self._rates[order] = DesignRates(order, *self.recorded)
        return self._rates[order]

    @cached_property
    def slopes(self) -> PositionSlopes:
        """What computes the derivatives of nodes by the dimensions and by the inputs."""
        return PositionSlopes(*self.recorded)

    @cached_property
    def linked_slopes(self) -> LinkedSlopes:
        """What computes the derivatives of inputs that follow the linkage."""
        from gimcli.families.linked_slopes import LinkedSlopes  # imported late: few mechanisms have such inputs

        return LinkedSlopes(self.mechanism, self.names, self.slopes, self.rates)

    @cached_property
    def forces(self) -> DesignForces | None:
        """What computes forces of designs together; None for mechanisms for which that is not possible."""
        from gimcli.families.design_forces import DesignForces  # imported late: few sweeps have forces

        with suppress(ApartError):
            return DesignForces(self.mechanism, self.names)
        return None
