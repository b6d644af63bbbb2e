"""Find natural frequencies and mode shapes about a position of equilibrium."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from typing import Any

import numpy as np

from gimcli import output
from gimcli.assemblies import all_configurations
from gimcli.dynamics.modes import Mode, ModeShape, mode_shape, natural_modes
from gimcli.dynamics.physical import require_masses
from gimcli.dynamics.reducer import release_of
from gimcli.dynamics.small_motions import Linearisation, Linearised, Settling, linearised
from gimcli.errors import GimError, UsageError
from gimcli.library.inputs import ROUND, Time, Tolerance, in_file_units, inputs_of
from gimcli.library.machines import for_each_machine, released_inputs, released_machines
from gimcli.library.record import Records, RowField
from gimcli.library.result import Result
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.linked_inputs import followed
from gimcli.motion.solve import solve as solve_position
from gimcli.positions.options import Options
from gimcli.rounding import number, titled
from gimcli.status import Status
from gimcli.structure.drive_check import require_consistent

BALANCED = 1e-5
"""Greatest remaining effort, relative to the forces that act, of a position that is taken as an equilibrium."""

ALMOST = 1e-3
"""The same of another assembly that a message names: inputs are printed with few digits."""

KINDS = {
    "vibration": ("vibration", "vibrations"), "decay": ("decaying mode", "decaying modes"),
    "rigid body": ("mode without stiffness", "modes without stiffness"),
    "unstable": ("unstable mode", "unstable modes"),
}  # fmt: skip
"""Words for one mode and for several of a kind."""


@for_each_machine(released_machines)
def modes(
    mechanism: Mechanism, at: Mapping[str, float | str] | None = None, free: str | Sequence[str] = (), *,
    time: Time = 0.0, settle: bool = False, tolerance: Tolerance = 1e-10, **inputs: float,
) -> ModesResult:  # fmt: skip
    """Find the natural modes of small vibrations about an equilibrium, for example `modes(m, angle=-90)`.

    Args:
        mechanism: from `load` or `loads`; it needs masses.
        at: dict of inputs by name, for names that are not Python names or are names of arguments.
        free: names of inputs that are released besides those with `free: true`; a single input needs no name.
        time: time of tables over the time [s].
        settle: follow the forces from this position to an equilibrium first.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        inputs: inputs by name, in the file's units. Inputs that are not given have the value of `start`, or that at the
            start of their law.

    Returns:
        A ModesResult: one row for each mode. Its `status` is not "ok" if the position is not solved, or if no
        equilibrium was reached with `settle`.

    Raises:
        UsageError: the position is no equilibrium, an unknown name, an invalid argument, or several inputs of which
            none is released.
        ModelError: no masses are defined, or a direction of motion has none; or the unit of length is not physical.
        StructureError: the position is singular; or the mechanism has no actuator, or is not fully driven, over-driven
            or contradictory.
    """
    require_masses(mechanism)
    released = released_inputs(mechanism, free)
    values = _start(mechanism, released, inputs_of(mechanism, at, inputs), {**(at or {}), **inputs})
    position = solve_position(mechanism, values, Options(tolerance=tolerance, jit="off"))
    require_consistent(mechanism, position.z, values, position.status, tolerance)
    if position.status.value:
        return ModesResult(mechanism, released, values, position.status, None, time)
    if settle:
        end = Settling(Linearisation(mechanism, released, time), position.z, values)
        return ModesResult(mechanism, released, end.found.inputs, end.status, end.found, time)
    found = linearised(mechanism, position.z, values, released, time)
    if np.max(found.unbalance) > BALANCED:
        raise UsageError(_refusal(found, time))
    return ModesResult(mechanism, released, values, Status.OK, found, time)


def _start(
    mechanism: Mechanism, released: Sequence[int], values: FloatArray, given: Mapping[str, float | str]
) -> FloatArray:
    """Return the inputs, the released ones that are not given at their `start` in the file, if there is one."""
    for k in released:
        start = release_of(mechanism, k).start
        if start is not None and mechanism.actuators[k].name not in given:
            values[k] = start
    return followed(mechanism, values)


def _refusal(found: Linearised, time: float) -> str:
    """Return the message for a position that is no equilibrium, with what remains."""
    mechanism = found.mechanism
    where = titled(mechanism, in_file_units(mechanism, found.inputs, ROUND))
    others = [str(k) for k in _balanced(found, time)]
    remedy = (
        f"assembly {' and '.join(others)} of `gim solve --all` is in equilibrium at these inputs: choose it"
        if others
        else "give the inputs of a position of `gim equilibrium`, or settle: go to an equilibrium first"
    )
    return f"{where}: not in equilibrium: {remaining(found)}; {remedy}"


def _balanced(found: Linearised, time: float) -> Iterator[int]:
    """Yield the numbers of the assemblies at the same inputs that are in equilibrium."""
    with suppress(GimError):  # a mechanism whose configurations cannot be listed
        for k, z in enumerate(all_configurations(found.mechanism, found.inputs).z):
            with suppress(GimError):  # a singular position
                other = linearised(found.mechanism, z, found.inputs, found.released, time)
                if np.max(other.unbalance) <= ALMOST < np.max(found.unbalance):
                    yield k + 1


def remaining(found: Linearised) -> str:
    """Return the efforts that remain on the coordinates, absolute and relative, as a text."""
    texts = []
    for name, unit, effort, part in zip(found.names, found.units, found.effort, found.unbalance, strict=True):
        if part > BALANCED:
            share = f"{100 * part:.2g} % of the forces that act on it"
            texts.append(f"{number(float(effort))} {'N m' if unit == 'rad' else 'N'} remain on {name} ({share})")
    return ", ".join(texts)


class ModesResult(Result):
    """The natural modes of a position, one row each; `modes` are the modes as objects.

    `report()` also has the matrices M, K and C. Everything is in SI units, by rad or m; inputs are in the file's units.
    """

    KIND = "modes"

    def __init__(
        self, mechanism: Mechanism, released: tuple[int, ...], values: FloatArray, status: Status,
        found: Linearised | None, time: float,
    ) -> None:  # fmt: skip
        self.mechanism, self._inputs, self._found = mechanism, values, found
        self._code, self.time, self.status = status, time, status.word
        self.inputs = in_file_units(mechanism, values, ROUND)
        self.released = tuple(mechanism.actuators[k].name for k in released)
        solved = found if found is not None and status is Status.OK else None
        self.modes: tuple[Mode, ...] = natural_modes(solved) if solved is not None else ()
        self._shapes: tuple[ModeShape, ...] = tuple(mode_shape(solved, m) for m in self.modes) if solved else ()

    # -- what was found -------------------------------------------------------------------------------

    @property
    def complete(self) -> bool:
        """Whether the modes were found."""
        return self._code is Status.OK

    @property
    def unbalance(self) -> float:
        """The greatest remaining effort, relative to the forces that act; NaN if the position is not solved."""
        return math.nan if self._found is None else float(np.max(self._found.unbalance))

    @property
    def stable(self) -> bool:
        """Whether no mode grows or has no stiffness."""
        return bool(self.modes) and all(mode.kind in ("vibration", "decay") for mode in self.modes)

    def _rough(self, k: int) -> float:
        """Return the modal stiffness of mode k (from 0) if all contributions had the same sign."""
        size = np.abs(self.modes[k].shape)
        return float(size @ self._found.stiffness_scale @ size) if self._found is not None else 0.0

    @property
    def left_out(self) -> tuple[str, ...]:
        """The pairs whose dry friction is left out: it would hold the mechanism."""
        return tuple(f.name for f in self.mechanism.dynamics.frictions if f.mu > 0.0)

    @property
    def reason(self) -> str:
        """Why there are no modes; "" if there are."""
        if self.complete:
            return ""
        if self._found is None:
            from gimcli.motion.unassembled import reason

            return reason(self.mechanism, self._code, self._inputs)
        rest = remaining(self._found) or "the steps became too short"
        if self._code is Status.LIMIT:
            cure = "give the inputs of a position there, or release another input"
            return f"the forces push a released input to its limit: {rest}; {cure}"
        return f"no equilibrium was reached: {rest}; start from another position, or check the loads"

    def headline(self) -> str:
        """Return the result in one line."""
        where = titled(self.mechanism, self.inputs)
        if not self.complete:
            return f"{where}: {self.status}"
        counts = Counter(mode.kind for mode in self.modes)
        words = ", ".join(f"{count} {KINDS[kind][count > 1]}" for kind, count in counts.items())
        return f"{where}: {words}"

    # -- tables ---------------------------------------------------------------------------------------

    @cached_property
    def _records(self) -> Records:
        """The modes, one row each: frequencies, damping, modal mass and stiffness, and the shape."""
        found, shapes, numbers = self.modes, self._shapes, range(1, len(self.modes) + 1)
        leads = [] if self._found is None else [self._found.units[mode.lead] for mode in found]  # of participation 1
        units = [("kg m^2", "N m/rad") if lead == "rad" else ("kg", "N/m") for lead in leads]
        masses = [f"{number(m.mass)} {unit}" for m, (unit, _) in zip(found, units, strict=True)]
        stiff = [f"{number(found[k].stiffness, self._rough(k))} {unit}" for k, (_, unit) in enumerate(units)]
        damping = ("damping ratio", "damped", "decay") if any(m.decay for m in found) else (None, None, None)
        return Records(
            RowField("mode", numbers, int, key=False),
            RowField("number", numbers, head="mode", key=False),
            RowField("kind", [m.kind for m in found], str, head="kind"),
            RowField("omega", [m.omega for m in found], float, "rad/s", head="omega"),
            RowField("frequency", [m.omega / (2 * math.pi) for m in found], float, "Hz", head="frequency"),
            RowField("period", [m.period for m in found], float, "s", head="period"),
            RowField("damping_ratio", [m.damping_ratio for m in found], float, head=damping[0]),
            RowField("damped_omega", [m.damped for m in found], float, "rad/s", head=damping[1]),
            RowField("decay", [m.decay for m in found], float, "1/s", head=damping[2]),
            RowField("modal_mass", [m.mass for m in found], float, head="modal mass", text=masses),
            RowField("modal_stiffness", [m.stiffness for m in found], float, head="modal stiffness", text=stiff),
            RowField("modal_damping", [m.damping for m in found], float),
            RowField("scale", [shape.scale for shape in shapes], str),
            RowField("shape", [shape.report() for shape in shapes]),
            *self._shape_fields(),
        )

    def _shape_fields(self) -> Iterator[RowField]:
        """Yield the participations: real parts, and imaginary parts if a shape has phases."""
        phases = any(shape.has_phases for shape in self._shapes)
        for k, (name, unit) in enumerate(self._shapes[0].columns if self._shapes else ()):
            values = np.array([shape.values[k] for shape in self._shapes])
            yield RowField(name, values.real.copy(), float, unit, key=False)
            if phases:
                yield RowField(f"{name}.imaginary", values.imag.copy(), float, unit, key=False)

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found = self._found
        return {
            "status": self.status, "inputs": self.inputs, "released": list(self.released), "time": self.time,
            "unbalance": self.unbalance, "modes": self._records.report(), "left_out": list(self.left_out),
            **({} if found is None else {
                "coordinates": list(found.names), "effort": found.effort.tolist(), "potential": found.potential,
                "M": found.mass.tolist(), "K": found.stiffness.tolist(), "C": found.damping.tolist(),
            }),
            **({} if self.complete else {"reason": self.reason}),
        }  # fmt: skip

    # -- pictures -------------------------------------------------------------------------------------

    def picture(self) -> output.picture.Content | None:
        """Return the shapes, each in both extreme positions; None without modes."""
        return (
            output.modes.modes_picture(self._found, self.modes, self.time, self.headline())
            if self._found and self.modes
            else None
        )

    def animation(self) -> output.animation.Animation | None:
        """Return one clip for each mode; None without modes."""
        return output.modes.modes_animation(self._found, self.modes, self.time) if self._found and self.modes else None
