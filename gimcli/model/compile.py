"""Compiler from the model as written (names, file units) to the mechanism as solved (arrays, integer ids)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.mechanism import FRAME, Coupling, Dynamics, Input, Mechanism, PairRow
from gimcli.model import schema
from gimcli.model.compile_geometry import GeometryCompiler
from gimcli.model.compile_laws import LawCompiler
from gimcli.model.pairs import PAIRS, sized_nodes, used_nodes

if TYPE_CHECKING:
    from gimcli.coupling_data import GearPair


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
