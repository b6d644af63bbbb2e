"""The independent machines of a model: sets of moving nodes that members, pairs, inputs and gears join.

Each machine is compiled as if it were alone in the file: with its own nodes, and in a normal frame of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any

from gimcli.connected import connected
from gimcli.mechanism import Machine, Mechanism
from gimcli.model.compile import compile_model, in_assembly_of
from gimcli.model.laws import scaled
from gimcli.model.pairs import fixed_nodes, node_of, used_nodes
from gimcli.model.schema import Model
from gimcli.model.source import Where


def machines(own: Any, mechanism: Mechanism, structures: bool, loaded: bool) -> tuple[Machine, ...]:
    """Return the machines of a mechanism whose model as written is `own`; one only if nothing can be separated.

    Parts that no input moves belong to the first machine with inputs, unless `structures` are apart. The machines have
    the masses and forces if `loaded`; springs and dampers then join machines, and loads over an input.
    """
    model, whole = own.model, mechanism.complete is None
    kept = set(mechanism.nodes)  # others were cut out
    ties = chain(_joints(model), _loads(model) if loaded else ())
    order = {name: k for k, name in enumerate(model.nodes)}
    groups = sorted(connected(ties, fixed_nodes(model)), key=lambda group: min(order[name] for name in group))
    parts = [part for part in groups if whole and part <= kept]
    parts = parts if structures else _with_structures(model, parts)
    single = (mechanism.as_machine,)
    found = [_machine(own, mechanism, part, k == 0, loaded) for k, part in enumerate(parts)] if len(parts) > 1 else []
    rows = sum(len(one.mechanism.pairs) + len(one.mechanism.actuators) for one in found)
    same = rows == len(mechanism.pairs) + len(mechanism.actuators)  # else it was changed: a row may join the machines
    return tuple(found) if found and same else single


def _with_structures(model: Model, parts: list[set[str]]) -> list[set[str]]:
    """Return the parts that inputs move; the first one has the others too."""
    moved = {name for actuator in model.actuators.values() for name in actuator.named}
    driven = [part for part in parts if part & moved]
    held = [part for part in parts if not part & moved]
    return [driven[0].union(*held), *driven[1:]] if driven else []


def _joints(model: Model) -> Iterator[Iterable[str]]:
    """Yield the nodes of each part of the model that joins nodes."""
    yield from (part.nodes for part in model.members.values())
    yield from ([*pair.sliding, *pair.guide] for pair in model.prismatic.values())
    for actuator in model.actuators.values():
        leader = [] if actuator.follows is None else model.actuators[actuator.follows].named
        yield [*actuator.named, *leader]
    for gear in model.gears.values():
        named = [*gear.members, *([gear.carrier] if gear.carrier else [])]
        yield [*gear.pivots, *(node for name in named if name in model.members for node in model.members[name].nodes)]


def _loads(model: Model) -> Iterator[Iterable[str]]:
    """Yield the nodes that a spring, a damper or the table of a load over an input joins."""
    yield from (part.named for part in (*model.springs.values(), *model.dampers.values()))
    for load in model.loads.values():
        if load.table is not None and load.over in model.actuators:
            yield [*_borne(model, load.on), *model.actuators[load.over].named]


def _borne(model: Model, name: str) -> Iterable[str]:
    """Return the nodes of a member or node with a mass or a load."""
    node = node_of(model, name)
    if node is not None:
        return [node]
    return model.members[name].nodes if name in model.members else fixed_nodes(model)


def _part(model: Model, moving: set[str], first: bool, loaded: bool) -> Model:
    """Return the model of the machine with some moving nodes; the first also has members of the ground only."""
    whole, fixed = model, fixed_nodes(model)

    def belongs(names: Iterable[str]) -> bool:
        return bool(moving & set(names)) or (first and fixed >= set(names))

    held = model.ground.member
    members = {k for k, part in model.members.items() if k == held or belongs(part.nodes)}
    model = _kept(model, {
        "links": lambda name, _: name in members,
        "elements": lambda name, _: name in members,
        "prismatic": lambda _, pair: belongs([*pair.sliding, *pair.guide]),
        "actuators": lambda _, actuator: belongs(actuator.named),
        "gears": lambda _, gear: any(name in members for name in gear.members),
        "points": lambda _, point: point.on in members or (first and point.on == "ground"),
    })  # fmt: skip
    from gimcli.model.dimensions import dimensions_of  # imported late: few files have several machines

    model = model.without_dynamics() if not loaded else _kept(model, {
        "masses": lambda name, _: belongs(_borne(whole, name)),
        "loads": lambda _, load: belongs(_borne(whole, load.on)),
        "springs": lambda _, spring: belongs(spring.named),
        "dampers": lambda _, damper: belongs(damper.named),
    })  # fmt: skip
    springs = [part.named for part in (*whole.springs.values(), *whole.dampers.values())]
    named = {
        *used_nodes(model.with_value("ground", lambda old: old.with_value("nodes", lambda _: []))),
        *(n for pair in model.prismatic.values() for n in pair.guide),
        *(n for actuator in model.actuators.values() for n in actuator.named),
        *(n for gear in model.gears.values() for n in gear.pivots),
        *(n for nodes in springs if belongs(nodes) for n in nodes if loaded or n in fixed),
        *(n for name in (*model.masses, *(load.on for load in model.loads.values())) for n in _borne(model, name)),
    }
    if held is None:
        ground = [n for n in model.ground.nodes if n in named] or model.ground.nodes[:1]
        model = model.with_value("ground", lambda old: old.with_value("nodes", lambda _: ground))
        named |= set(ground)
    slides = model.prismatic
    model = _kept(model, {
        "friction": lambda name, _: name in named or name in slides, "nodes": lambda name, _: name in named,
    })  # fmt: skip
    points = {*model.nodes, *model.points}
    model = model.with_value("trace", lambda old: [name for name in old if name in points])
    model.formulas = {where: formula for where, formula in model.formulas.items() if _has(model, where)}
    dimensions = dimensions_of(model)
    return _kept(
        model, {"tolerances": lambda name, _: not dimensions.keys().isdisjoint((name, f"{name}.length"))}
    )  # fmt: skip


def _kept(model: Model, tests: Mapping[str, Callable[[str, Any], bool]]) -> Model:
    """Return a model with the parts of some sections for which a test of name and part holds."""
    for section, test in tests.items():
        parts = {name: part for name, part in getattr(model, section).items() if test(name, part)}
        model = model.with_value(section, lambda _, parts=parts: parts)  # type: ignore[misc]  # of its own section
    return model


def _has(model: Model, where: Where) -> bool:
    """Return whether a model has the part with a number."""
    section = getattr(model, str(where[0]))
    return not isinstance(section, dict) or where[1] in section


def _machine(own: Any, mechanism: Mechanism, moving: set[str], first: bool, loaded: bool) -> Machine:
    model = _part(own.model, moving, first, loaded)
    compiled = in_assembly_of(compile_model(model, own.source.folder), mechanism, own.model)
    nodes = tuple(mechanism.nodes.index(name) for name in compiled.nodes)
    names = [a.name for a in mechanism.actuators]
    numbers = tuple(names.index(a.name) for a in compiled.actuators)
    ratio = mechanism.scale / compiled.scale
    laws = [mechanism.actuators[k].law for k in numbers]
    actuators = tuple(
        replace(one, law=law if one.rotary else scaled(law, ratio))
        for one, law in zip(compiled.actuators, laws, strict=True)
    )
    alone = replace(
        compiled, actuators=actuators, duration=mechanism.duration, files=mechanism.files, path=mechanism.path,
        written=replace(own, model=model),
    )  # fmt: skip
    inputs = [alone.actuators[k].name for k in alone.drivers]
    return Machine("+".join(inputs) or ", ".join(sorted(moving)), alone, nodes, numbers)
