"""The independent machines of a model: sets of moving nodes that members, pairs, inputs and gears join.

Each machine is compiled as if it were alone in the file: with its own nodes, and in a normal frame of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from gimcli.mechanism import Machine, Mechanism
from gimcli.model.compile import compile_model
from gimcli.model.kept_assembly import in_assembly_of
from gimcli.model.laws import Scaled
from gimcli.model.pairs import PAIRS, fixed_nodes, measured_nodes, used_nodes
from gimcli.model.schema import Model
from gimcli.model.substitution import without_dynamics


def machines(own: Any, mechanism: Mechanism) -> tuple[Machine, ...]:
    """Return the machines of a mechanism whose model as written is `own`; one only if nothing can be separated."""
    model = own.model
    whole = mechanism.complete is None
    parts = [part for part in _separated(model) if whole and part <= set(mechanism.nodes)]  # others were cut out
    if len(parts) < 2:
        return (mechanism.as_machine,)
    found = tuple(_machine(own, mechanism, part, k == 0) for k, part in enumerate(parts))
    rows = sum(len(one.mechanism.pairs) + len(one.mechanism.actuators) for one in found)
    if rows != len(mechanism.pairs) + len(mechanism.actuators):
        return (mechanism.as_machine,)  # it was changed after it was compiled: a row may join the machines
    return found


def _separated(model: Model) -> list[set[str]]:
    """Return the moving nodes of each machine, in the order of the file."""
    fixed = fixed_nodes(model)
    groups: list[set[str]] = []
    for names in _joints(model):
        joined = set(names) - fixed
        if joined:
            apart = [group for group in groups if group.isdisjoint(joined)]
            groups = [*apart, joined.union(*(group for group in groups if not group.isdisjoint(joined)))]
    order = list(model.nodes)
    return sorted(groups, key=lambda group: min(map(order.index, group)))


def _joints(model: Model) -> Iterator[Iterable[str]]:
    """Yield the nodes of each part of the model that joins nodes."""
    yield from (part.nodes for part in model.members.values())
    for section, kind in PAIRS.items():
        yield from ([*kind.nodes(pair), *pair.guide] for pair in getattr(model, section).values())
    for name, actuator in model.actuators.items():
        leader = [] if actuator.follows is None else measured_nodes(model.actuators[actuator.follows])
        yield [*measured_nodes(model.actuators[name]), *leader]
    for gear in model.gears.values():
        named = [*gear.members, *([gear.carrier] if gear.carrier else [])]
        yield [*gear.pivots, *(node for name in named if name in model.members for node in model.members[name].nodes)]


def _part(model: Model, moving: set[str], first: bool) -> Model:
    """Return the model of the machine with some moving nodes; the first also has members of the ground only."""
    fixed = fixed_nodes(model)

    def belongs(names: Iterable[str]) -> bool:
        return bool(moving & set(names)) or (first and fixed >= set(names))

    held = model.ground.member
    members = {k for k, part in model.members.items() if k == held or belongs(part.nodes)}

    def kept(section: str, keep: Any) -> None:
        nonlocal model
        model = model.with_value(section, lambda old: {k: v for k, v in old.items() if keep(k, v)})

    kept("links", lambda name, _: name in members)
    kept("elements", lambda name, _: name in members)
    for section, kind in PAIRS.items():
        kept(section, lambda _, pair, nodes=kind.nodes: belongs([*nodes(pair), *pair.guide]))
    kept("actuators", lambda _, actuator: belongs(measured_nodes(actuator)))
    kept("gears", lambda _, gear: any(name in members for name in gear.members))
    kept("points", lambda _, point: point.on in members or (first and point.on == "ground"))
    model = without_dynamics(model)
    named = used_nodes(model.with_value("ground", lambda old: old.with_value("nodes", lambda _: [])))
    guides = [n for section in PAIRS for pair in getattr(model, section).values() for n in pair.guide]
    named = {*named, *guides, *(n for actuator in model.actuators.values() for n in measured_nodes(actuator))}
    named |= {n for gear in model.gears.values() for n in gear.pivots}
    if held is None:
        ground = [n for n in model.ground.nodes if n in named] or model.ground.nodes[:1]
        model = model.with_value("ground", lambda old: old.with_value("nodes", lambda _: ground))
        named |= set(ground)
    kept("nodes", lambda name, _: name in named)
    points = {*model.nodes, *model.points}
    return model.with_value("trace", lambda old: [name for name in old if name in points])


def _machine(own: Any, mechanism: Mechanism, moving: set[str], first: bool) -> Machine:
    model = _part(own.model, moving, first)
    compiled = in_assembly_of(compile_model(model, own.source.folder), mechanism, own.model)
    nodes = tuple(mechanism.nodes.index(name) for name in compiled.nodes)
    names = [a.name for a in mechanism.actuators]
    numbers = tuple(names.index(a.name) for a in compiled.actuators)
    ratio = mechanism.scale / compiled.scale
    laws = [mechanism.actuators[k].law for k in numbers]
    actuators = tuple(
        replace(one, law=law if one.rotary else Scaled(law, ratio))
        for one, law in zip(compiled.actuators, laws, strict=True)
    )
    alone = replace(
        compiled, actuators=actuators, duration=mechanism.duration, files=mechanism.files, path=mechanism.path,
        written=replace(own, model=model),
    )  # fmt: skip
    inputs = [alone.actuators[k].name for k in alone.drivers]
    return Machine("+".join(inputs) or ", ".join(sorted(moving)), alone, nodes, numbers)
