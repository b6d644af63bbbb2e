"""Remarks on a valid model: parts of the file that have no effect, and what they were probably meant for."""

from __future__ import annotations

from collections.abc import Iterator

from gimcli.model.pairs import fixed, used_nodes
from gimcli.model.schema import DYNAMIC, Model
from gimcli.model.source import Where

Remark = tuple[Where, str]
"""The part of the file that a remark is about, and a statement with its remedy."""


def remarks(model: Model) -> list[Remark]:
    """Return the remarks on a model, in the order of its sections."""
    kinds = (_unused_nodes, _sides, _unused_parameters, _repeated_members, _dynamics)
    return [remark for kind in kinds for remark in kind(model)]


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


def _unused_nodes(model: Model) -> Iterator[Remark]:
    used = used_nodes(model)
    for name in (name for name in model.nodes if name not in used):
        text = f"node {name} is used by no member, pair or actuator: remove it, or add it to a member"
        yield ("nodes", name), text


def _sides(model: Model) -> Iterator[Remark]:
    paired = {name for pair in model.prismatic.values() for name in pair.nodes or []}
    for name, part in model.open.parts.items():
        if part.side is not None and name not in model.open.sides and name not in paired:
            yield _idle(("nodes", name), f"`side` of {name}", "its position does not depend on a side; remove it")


def _unused_parameters(model: Model) -> Iterator[Remark]:
    used = {name for formula in model.formulas.values() for name in formula.names}
    for name in (name for name in model.parameters if name not in used):
        text = f"parameter {name} is used by no formula: remove it, or write it in place of a number"
        yield ("parameters", name), text


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
    if parts and model.units.length == "unit":
        cure = "add `units: {length: mm}` or another"
        yield _idle((parts[0],), f"`{parts[0]}`", f"the length has no physical unit; {cure}")
    if model.gravity is not None and not any(mass.mass for mass in model.masses.values()):
        yield ("gravity",), "`gravity` has no effect without masses: add `masses:`, or remove it"
    if "mass" in model.units.given and not model.masses:
        yield ("units", "mass"), "`mass` has no effect without masses: add `masses:`, or remove it"
    for name in () if parts else (name for name, actuator in model.actuators.items() if actuator.free):
        text = f"`free` of {name} has no effect without masses and forces: add `masses:`, or remove it"
        yield ("actuators", name, "free"), text
    yield from _masses(model)
    yield from _loads(model)
    for name, damper in model.dampers.items():
        if damper.damping == 0.0:
            yield ("dampers", name), f"damper {name} has the damping 0 and no effect: remove it"
    for name, part in model.friction.items():
        if not part.viscous and not part.mu:
            yield ("friction", name), f"friction at {name} is 0 and has no effect: remove it"


def _masses(model: Model) -> Iterator[Remark]:
    for name, mass in model.masses.items():
        if fixed(model, name):
            yield _idle(("masses", name), f"the mass of {name}", "the frame does not move; remove it")
        elif not mass.mass and not mass.inertia:
            yield ("masses", name), f"the mass of {name} is 0 and has no effect: give a mass, or remove it"


def _loads(model: Model) -> Iterator[Remark]:
    for name, load in model.loads.items():
        if fixed(model, load.on):
            yield _idle(("loads", name), f"load {name}", "it acts on the frame; name a moving member")
        elif not any([*(load.force or ()), *(load.follower or ()), load.torque or 0.0]):
            yield ("loads", name), f"load {name} is 0 and has no effect: give a force or a torque, or remove it"


def _idle(where: Where, what: str, why: str) -> Remark:
    return where, f"{what} has no effect: {why}"
