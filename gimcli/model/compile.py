"""Compiler from the model as written (names, file units) to the mechanism as solved (arrays, integer ids)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.input_laws import ConstantLaw, InputLaw, SummedLaw
from gimcli.mechanism import FRAME, Coupling, Dynamics, Input, Mechanism, PairRow
from gimcli.model.compile_geometry import GeometryCompiler
from gimcli.model.laws import PROFILES, PolynomialLaw, RunLaw, TableLaw, increment, run_times, scaled
from gimcli.model.pairs import sized_nodes, used_nodes
from gimcli.model.schema import Actuator, Law, Model
from gimcli.model.tables import read_table
from gimcli.model.units import TURN

if TYPE_CHECKING:
    from gimcli.coupling_data import GearPair


def compile_model(model: Model, folder: Path = Path(), frame: tuple[complex, float] | None = None) -> Mechanism:
    """Return the mechanism of a validated model; the paths of tables start at `folder`.

    frame: origin and scale of the normal frame, by default chosen from the model.
    """
    own = GeometryCompiler(model, folder, used_nodes(model), sized_nodes(model), frame)
    points = [own.point(name, point) for name, point in model.points.items()]
    held = set(own.members[FRAME].nodes)
    moving = [n for k, n in enumerate(own.names) if k not in held]
    traced = model.trace or list(model.points) or moving
    pairs = tuple(row for name, pair in model.prismatic.items() for row in own.rows(name, pair))
    driven = tuple(own.quantity(name, a) for name, a in model.actuators.items())
    actuators, duration = _with_own_laws(own, driven)
    actuators, couplings, gears = _coupled(own, pairs, actuators)
    dynamics, gauges = _dynamics(own, pairs, actuators)
    return Mechanism(
        name=model.name or "mechanism", nodes=tuple(own.names), drawn=own.drawn, members=tuple(own.members),
        pairs=pairs, actuators=actuators, dynamics=dynamics, gauges=gauges, couplings=couplings, gears=gears,
        points=tuple(points), traced=tuple(traced), size=own.size / own.scale, scale=own.scale,
        origin=own.origin, length_unit=model.units.length, angle_unit=model.units.angle,
        duration=duration, floating=model.ground.member is not None, quantities=model.quantities,
    )  # fmt: skip


def _coupled(
    own: GeometryCompiler, pairs: tuple[PairRow, ...], actuators: tuple[Input, ...]
) -> tuple[tuple[Input, ...], tuple[Coupling, ...], tuple[GearPair, ...]]:
    """Return the actuators with those that gears add, the couplings of their inputs, and the gears."""
    gears: tuple[GearPair, ...] = ()
    couplings = _couplings(own.model, actuators, own.units)
    if own.model.gears:
        from gimcli.model.compile_gears import GearCompiler  # imported late: few models have gears

        actuators, couplings, gears = GearCompiler(own, pairs, actuators, couplings).compile()
    return _with_laws(actuators, couplings), couplings, gears


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


# -- laws -----------------------------------------------------------------------------------


def _with_own_laws(own: GeometryCompiler, inputs: tuple[Input, ...]) -> tuple[tuple[Input, ...], float]:
    """Return inputs, whose initial values are known, with their laws, and the duration of the motion [s].

    Followers have no law of their own.
    """
    duration, drawn = _duration(own), {one.name: one.drawn / own.units[one.rotary] for one in inputs}
    times = run_times(own.model, lambda name, _: drawn[name], duration is not None)
    duration = times[0].seconds if duration is None and times else duration
    timed = tuple(replace(one, law=_law(own, one, own.model.actuators[one.name], duration)) for one in inputs)
    return timed, 1.0 if duration is None else duration


def _duration(own: GeometryCompiler) -> Any | None:
    """Return the duration that the file or a table gives [s]."""
    laws = (a.law for a in own.model.actuators.values() if a.law is not None)
    table = next((law.profile.table for law in laws if law.profile.table is not None), None)
    if own.model.duration is not None or table is None:
        return own.model.duration
    time, _ = read_table(own.folder / table)
    return time[-1] - time[0]


def _law(own: GeometryCompiler, one: Input, actuator: Actuator, duration: Any | None) -> InputLaw:
    law, unit = actuator.law or Law(), own.units[one.rotary]
    if actuator.follows is not None:
        return one.law
    if law.profile.table is not None:
        return scaled(TableLaw(*read_table(own.folder / law.profile.table)), unit)
    shape: InputLaw = PROFILES.get(law.profile.name, PROFILES["uniform"])
    change = increment(law, TURN[own.model.units.angle] * one.rotary, duration)
    if law.profile.polynomial is not None:
        shape = PolynomialLaw(tuple(law.profile.polynomial))
        if change is None and law.to is None:
            return scaled(shape, unit)
    start = one.drawn if law.from_ is None else law.from_ * unit
    if law.to is not None:
        return RunLaw(start, law.to * unit, shape)
    whole = 2.0 * math.pi if one.rotary else 0.0
    return RunLaw(start, start + (whole if change is None else change * unit), shape)


# -- followers ------------------------------------------------------------------------------


def _couplings(model: Model, inputs: Sequence[Input], units: Mapping[bool, Any]) -> tuple[Coupling, ...]:
    """Return the couplings of the actuators that follow others, in the order of the file.

    inputs: the actuators with their drawn values. units: one unit of the file in the normal frame, for rotary (True)
    and linear inputs.
    """
    following = {k: one for k, one in enumerate(model.actuators.values()) if one.follows is not None}
    leaders = {k: [*model.actuators].index(str(one.follows)) for k, one in following.items()}
    found, waiting = dict[int, Coupling](), list(following)
    while waiting:
        from gimcli.model.linear_relations import coupling_to  # imported late: few models have followers

        k = next(k for k in waiting if leaders[k] not in waiting)
        waiting.remove(k)
        one, leader, unit = following[k], inputs[leaders[k]], units[inputs[k].rotary]
        ratio = (1.0 if one.ratio is None else one.ratio) * (unit / units[leader.rotary])
        phase, drawn = (inputs[k].drawn, leader.drawn) if one.phase is None else (one.phase * unit, 0.0)
        found[k] = coupling_to(k, phase, {leaders[k]: (ratio, drawn)}, found)
    return tuple(found[k] for k in following)


def _with_laws(inputs: Sequence[Input], couplings: Sequence[Coupling]) -> tuple[Input, ...]:
    """Return the actuators; the laws of followers are those of their leaders, times the ratios.

    Inputs that follow a quantity that is read from the position have a constant law: their values must be solved for.
    """
    timed = list(inputs)
    for coupling in couplings:
        own, laws = timed[coupling.follower], [timed[k].law for k, _ in coupling.terms]
        law = ConstantLaw(own.drawn) if coupling.reads else _followed(coupling, laws)
        timed[coupling.follower] = replace(own, law=law)
    return tuple(timed)


def _followed(coupling: Coupling, laws: Sequence[InputLaw]) -> InputLaw:
    ratios = [ratio for _, ratio in coupling.terms]
    runs = [law for law in laws if isinstance(law, RunLaw)]
    if 0 < len(runs) == len(laws) and all(law.profile == runs[0].profile for law in runs):
        start, end = (
            coupling.phase + sum(r * getattr(law, at) for r, law in zip(ratios, laws, strict=True))
            for at in ("start", "end")
        )
        return RunLaw(start, end, runs[0].profile)
    return SummedLaw(tuple(zip(ratios, laws, strict=True)), coupling.phase)


# -- another initial configuration ----------------------------------------------------------


def in_assembly_of(mechanism: Mechanism, old: Mechanism, model: Model) -> Mechanism:
    """Return a mechanism in the initial configuration of `old`, the same with other dimensions or other parts, too.

    `model` is the model of `old`. Where the initial configuration is not that of its coordinates, each node is
    displaced from its own coordinates as it is in `old`; nodes of the frame are not.
    """
    places = dict(zip(old.nodes, old.drawn.tolist(), strict=True))
    written = np.array([complex(*model.nodes[name]) for name in mechanism.nodes])
    before = np.array([places[name] for name in mechanism.nodes])
    if np.array_equal((written - old.origin) / old.scale, before):
        return mechanism
    drawn = mechanism.drawn + (old.to_file(before) - written) / mechanism.scale
    frame = mechanism.members[FRAME]
    drawn[list(frame.nodes)] = frame.shape
    ratio = old.scale / mechanism.scale
    actuators = _drawn_as(mechanism.actuators, old.actuators, ratio)
    return replace(mechanism, drawn=drawn, actuators=actuators, gauges=_drawn_as(mechanism.gauges, old.gauges, ratio))


def _drawn_as(inputs: Iterable[Input], old: Iterable[Input], ratio: float) -> tuple[Input, ...]:
    """Return inputs with the initial values of those of the same names; lengths are multiplied by a ratio."""
    drawn = {one.name: one.drawn for one in old}
    return tuple(replace(one, drawn=drawn[one.name] * (1.0 if one.rotary else ratio)) for one in inputs)
