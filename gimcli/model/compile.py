"""Compiler from the model as written (names, file units) to the mechanism as solved (arrays, integer ids)."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gimcli.mechanism import FRAME, Coupling, Dynamics, Input, InputLaw, Mechanism, PairRow
from gimcli.model import schema
from gimcli.model.compile_geometry import GeometryCompiler
from gimcli.model.law_ends import increment, run_times
from gimcli.model.laws import PROFILES, PolynomialLaw, RunLaw, Scaled, TableLaw
from gimcli.model.pairs import PAIRS, sized_nodes, used_nodes
from gimcli.model.schema import Actuator, Law, Model
from gimcli.model.tables import read_table
from gimcli.model.units import TURN

if TYPE_CHECKING:
    from gimcli.coupling_data import GearPair


class LawCompiler:
    """Compiles the laws of the inputs of a model, whose values at the initial coordinates are known."""

    def __init__(self, model: Model, folder: Path, scale: float) -> None:
        """`folder` is that of the tables, `scale` the length of the normal frame in the file's unit."""
        self.model, self.folder = model, folder
        self.turn = TURN[model.units.angle]
        self.units = {True: math.pi / 180.0 if model.units.angle == "deg" else 1.0, False: 1.0 / scale}

    def compile(self, inputs: tuple[Input, ...]) -> tuple[tuple[Input, ...], float]:
        """Return the inputs with their laws, and the duration of the motion [s]; followers have no law of their own."""
        known, drawn = self._duration(), {one.name: one.drawn / self.units[one.rotary] for one in inputs}
        times = run_times(self.model, lambda name, _: drawn[name], known is not None)
        duration = known if known is not None else times[0].seconds if times else None
        laws = [self._law(one, self.model.actuators[one.name], duration) for one in inputs]
        timed = tuple(replace(one, law=law) for one, law in zip(inputs, laws, strict=True))
        return timed, 1.0 if duration is None else duration

    def _duration(self) -> Any | None:
        """Return the duration that the file or a table gives [s]."""
        if self.model.duration is not None:
            return self.model.duration
        for actuator in self.model.actuators.values():
            if actuator.law is not None and actuator.law.profile.table is not None:
                time, _ = read_table(self.folder / actuator.law.profile.table)
                return time[-1] - time[0]
        return None

    def _law(self, one: Input, actuator: Actuator, duration: Any | None) -> InputLaw:
        law, drawn, unit = actuator.law or Law(), one.drawn, self.units[one.rotary]
        if actuator.follows is not None:
            return one.law
        if law.profile.table is not None:
            return Scaled(TableLaw(*read_table(self.folder / law.profile.table)), unit)
        shape: InputLaw = PROFILES.get(law.profile.name, PROFILES["uniform"])
        change = increment(law, self.turn * one.rotary, duration)
        if law.profile.polynomial is not None:
            shape = PolynomialLaw(tuple(law.profile.polynomial))
            if change is None and law.to is None:
                return Scaled(shape, unit)
        start = drawn if law.from_ is None else law.from_ * unit
        if law.to is not None:
            return RunLaw(start, law.to * unit, shape)
        whole = 2.0 * math.pi if one.rotary else 0.0
        return RunLaw(start, start + (whole if change is None else change * unit), shape)


def compile_model(model: schema.Model, folder: Path = Path(), frame: tuple[complex, float] | None = None) -> Mechanism:
    """Return the mechanism of a validated model; the paths of tables start at `folder`.

    frame: origin and scale of the normal frame, by default chosen from the model.
    """
    own = GeometryCompiler(model, folder, used_nodes(model), sized_nodes(model), frame)
    points = [own.point(name, point) for name, point in model.points.items()]
    held = set(own.members[FRAME].nodes)
    moving = [n for k, n in enumerate(own.names) if k not in held]
    traced = model.trace or list(model.points) or moving
    pairs = tuple(
        row
        for section, kind in PAIRS.items()
        for name, pair in getattr(model, section).items()
        for row in kind.rows(own, name, pair)
    )
    driven = tuple(own.quantity(name, a) for name, a in model.actuators.items())
    laws = LawCompiler(model, folder, own.scale)
    actuators, duration = laws.compile(driven)
    actuators, couplings, gears = _coupled(own, laws, pairs, actuators)
    dynamics, gauges = _dynamics(own, pairs, actuators)
    return Mechanism(
        name=model.name or "mechanism", nodes=tuple(own.names), drawn=own.drawn, members=tuple(own.members),
        pairs=pairs, actuators=actuators, dynamics=dynamics, gauges=gauges, couplings=couplings, gears=gears,
        points=tuple(points), traced=tuple(traced), size=own.size / own.scale, scale=own.scale,
        origin=own.origin, length_unit=model.units.length, angle_unit=model.units.angle,
        duration=duration, floating=model.ground.member is not None, quantities=model.quantities,
    )  # fmt: skip


def _coupled(
    own: GeometryCompiler, laws: LawCompiler, pairs: tuple[PairRow, ...], actuators: tuple[Input, ...]
) -> tuple[tuple[Input, ...], tuple[Coupling, ...], tuple[GearPair, ...]]:
    """Return the actuators with those that gears add, the couplings of their inputs, and the gears."""
    model = own.model
    gears: tuple[GearPair, ...] = ()
    if not model.gears and all(actuator.follows is None for actuator in model.actuators.values()):
        return actuators, (), ()
    from gimcli.model.compile_couplings import couplings_of, with_laws

    couplings = couplings_of(model, actuators, laws.units)
    if model.gears:
        from gimcli.model.compile_gears import GearCompiler

        actuators, couplings, gears = GearCompiler(own, pairs, actuators, couplings).compile()
    return with_laws(actuators, couplings), couplings, gears


def _dynamics(
    own: GeometryCompiler, pairs: tuple[PairRow, ...], actuators: tuple[Input, ...]
) -> tuple[Dynamics, tuple[Input, ...]]:
    """Return masses, loads and the like, and the gauges of springs and dampers; both empty if the file has none."""
    model = own.model
    rotors = any(actuator.rotor is not None for actuator in model.actuators.values())
    if not any((model.masses, model.loads, model.springs, model.dampers, model.friction, rotors)):
        return Dynamics(), ()
    from gimcli.model.compile_dynamics import DynamicsCompiler

    return DynamicsCompiler(own, pairs, actuators).compile()
