"""Remarks on a valid model: parts of the file that have no effect, and what they were probably meant for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from gimcli.model.pairs import fixed, used_nodes
from gimcli.model.schema import DYNAMIC, Model
from gimcli.model.source import Where

Remark = tuple[Where, str]
"""The part of the file that a remark is about, and a statement with its remedy."""


class _Facts(NamedTuple):
    """What the tests of parts ask of a model."""

    model: Model
    nodes: set[str]
    """Those that members, pairs and inputs use."""
    parameters: set[str]
    """Those that formulas use."""


Test = Callable[[_Facts, str, Any], Any]
"""Whether something is true of a part, from its name and itself."""

IDLE: Mapping[str, Sequence[tuple[Test, str]]] = {
    "nodes": [
        (lambda facts, name, _: name not in facts.nodes,
         "node {} is used by no member, pair or actuator: remove it, or add it to a member"),
    ],
    "parameters": [
        (lambda facts, name, _: name not in facts.parameters,
         "parameter {} is used by no formula: remove it, or write it in place of a number"),
    ],
    "masses": [
        (lambda facts, name, _: fixed(facts.model, name),
         "the mass of {} has no effect: the frame does not move; remove it"),
        (lambda facts, name, mass: not mass.mass and not mass.inertia,
         "the mass of {} is 0 and has no effect: give a mass, or remove it"),
    ],
    "loads": [
        (lambda facts, name, load: fixed(facts.model, load.on),
         "load {} has no effect: it acts on the frame; name a moving member"),
        (lambda facts, name, load: not any([*(load.force or ()), *(load.follower or ()), load.torque or 0.0]),
         "load {} is 0 and has no effect: give a force or a torque, or remove it"),
    ],
    "dampers": [
        (lambda facts, name, damper: damper.damping == 0.0, "damper {} has the damping 0 and no effect: remove it"),
    ],
    "friction": [
        (lambda facts, name, part: not part.viscous and not part.mu,
         "friction at {} is 0 and has no effect: remove it"),
    ],
}  # fmt: skip
"""By section, when a part of it has no effect, and the remark with its name; the first one holds."""


def remarks(model: Model) -> list[Remark]:
    """Return the remarks on a model, in the order of its sections."""
    facts = _Facts(model, used_nodes(model), {name for formula in model.formulas.values() for name in formula.names})
    return [
        *_of(facts, "nodes"), *_sides(model), *_of(facts, "parameters"), *_repeated_members(model), *_dynamics(model),
        *_of(facts, "masses", "loads", "dampers", "friction"),
    ]  # fmt: skip


def _of(facts: _Facts, *sections: str) -> Iterator[Remark]:
    """Yield the remarks on the parts of some sections."""
    for section in sections:
        for name, part in getattr(facts.model, section).items():
            text = next((text for holds, text in IDLE[section] if holds(facts, name, part)), None)
            if text is not None:
                yield (section, name), text.format(name)


def missing_duration(model: Model) -> list[Remark]:
    """Return a remark if the file gives no time for its motion."""
    laws = [a.law for a in model.actuators.values() if a.law is not None]
    if not laws or model.duration is not None or any(law.profile.table or law.rate is not None for law in laws):
        return []
    text = (
        "no `duration` is given: velocities and accelerations are those of a motion of 1 s; add `duration:` [s], or a"
        " `rate:` to a law"
    )
    return [(("actuators",), text)]


def _sides(model: Model) -> Iterator[Remark]:
    paired = {name for pair in model.prismatic.values() for name in pair.nodes or []}
    return (
        _idle(("nodes", name), f"`side` of {name}", "its position does not depend on a side; remove it")
        for name, part in model.open.parts.items()
        if part.side is not None and name not in model.open.sides and name not in paired
    )


def _repeated_members(model: Model) -> Iterator[Remark]:
    members = {name: set(part.nodes) for name, part in model.members.items()}
    for k, (name, nodes) in enumerate(members.items()):
        others = [n for m, (n, other) in enumerate(members.items()) if nodes < other or (nodes == other and m < k)]
        if others:
            where = ("links" if name in model.links else "elements", name)
            yield _idle(where, name, f"{others[0]} joins its nodes already; remove it")


# -- dynamics -----------------------------------------------------------------------------------


def _dynamics(model: Model) -> Iterator[Remark]:
    parts = [section for section in DYNAMIC if getattr(model, section)]
    unit = "the length has no physical unit; add `units: {length: mm}` or another"
    lone = "has no effect without masses: add `masses:`, or remove it"
    cases = (
        (parts and model.units.length == "unit", _idle((*parts[:1],), f"`{''.join(parts[:1])}`", unit)),
        (model.gravity is not None and not any(mass.mass for mass in model.masses.values()),
         (("gravity",), f"`gravity` {lone}")),
        ("mass" in model.units.given and not model.masses, (("units", "mass"), f"`mass` {lone}")),
    )  # fmt: skip
    yield from (remark for holds, remark in cases if holds)
    yield from (
        (("actuators", name, "free"),
         f"`free` of {name} has no effect without masses and forces: add `masses:`, or remove it")
        for name, actuator in model.actuators.items() if actuator.free and not parts
    )  # fmt: skip


def _idle(where: Where, what: str, why: str) -> Remark:
    return where, f"{what} has no effect: {why}"
