"""Checks of masses, loads, springs, dampers and friction, and of the keys of free inputs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gimcli.model.check_inputs import check_nodes, check_values
from gimcli.model.pairs import used_nodes
from gimcli.model.references import PartFault, References, those
from gimcli.model.schema import LARGEST, Actuator, Damper, Effort, Load, Mass, PairFriction, Rotor, Spring
from gimcli.model.source import Where
from gimcli.nearest import guess


def check_dynamics(refs: References) -> None:
    """Record the errors in the dynamic sections of the model."""
    for section, check in CHECKS.items():
        for name, part in getattr(refs.model, section).items():
            check(refs, (section, name), part)


def _check_mass(refs: References, where: Where, mass: Mass) -> None:
    name = str(where[1])
    node = refs.bearer(where, name, key=True)
    refs.record(where, (
        PartFault((key,), f"`{key}` is of a member, '{name}' is a node with a point mass; "
                          f"remove `{key}`, or name a member", key=True)
        for key in {"inertia", "centre"} & mass.given if node is not None
    ))  # fmt: skip


def _check_load(refs: References, where: Where, load: Load) -> None:
    kinds = ("force", "follower", "torque")
    given = [kind for kind in kinds if getattr(load, kind) is not None]
    node, known = refs.bearer((*where, "on"), load.on), ("time", *refs.model.actuators)
    if len(given) == 1 and node is None and given != ["torque"] and load.on in ("ground", *refs.every):
        refs.place(where, load, "force", known=True)
    of_member = [key for key in (*kinds[1:], "at", "local") if getattr(load, key) is not None]
    doubted = {("actuators",), ("actuators", load.over)} & set(refs.doubtful)
    refs.record(where, those(
        len(given) != 1 and PartFault(
            (), f"load '{where[1]}' needs either `force` or `torque` (or `follower`)", lacking=kinds
        ),
        *(len(given) == 1 and node is not None and PartFault(
            (key,),
            f"`{key}` is of a member, '{load.on}' is a node, which takes a `force`; remove it, or name a member",
            key=True,
        ) for key in of_member),
        load.table is not None and load.over not in known and not doubted and PartFault(
            ("over",), f"'{load.over}' is neither `time` nor an actuator; {guess(load.over, known, most=8)}"
        ),
    ))  # fmt: skip
    _check_table(refs, where, load, f"load '{where[1]}'", "time" if load.over == "time" else "input")


def _check_table(refs: References, where: Where, part: Load | Effort, what: str, over: str) -> None:
    if part.table is not None:
        refs.table((*where, "table"), part.table, over)
    elif part.over != "time":
        refs.lack(where, ("table",), f"{what} has `over: {part.over}` but no `table`; add one")


def _check_gauge(refs: References, where: Where, part: Spring | Damper) -> None:
    check_nodes(refs, where, part, "rotary" if part.rotary else "linear", type(part).__name__.lower())
    alone = refs.model.nodes.keys() - used_nodes(refs.model) if refs.sure else ()
    free = part.free if isinstance(part, Spring) and part.nodes is not None else None
    refs.record(where, those(
        *(node in alone and PartFault((key,), f"node '{node}' belongs to no member; add it to one")
          for key, node in part.keyed),
        free is not None and free < 0.0 and PartFault(
            ("free",), f"expected a free length of at least 0, got {free:g}"
        ),
    ))  # fmt: skip


def _check_friction(refs: References, where: Where, part: PairFriction) -> None:
    """Check a pair and its keys of dry friction: `radius` is of a node, `length` of a sliding pair with two nodes."""
    name, model = str(where[1]), refs.model
    pair, node = model.prismatic.get(name), name in model.nodes
    none = pair is None and {("prismatic", name), ("nodes", name)}.isdisjoint(refs.doubtful)
    known = ("prismatic", name) not in refs.doubtful and (pair is not None or node)
    size = "radius" if pair is None else "length" if pair.nodes is not None else None
    owners = {"radius": "a node", "length": "a sliding pair with two nodes"}
    sizes = {"radius": "the radius of the pin", "length": "the distance of the two contacts in the guide"}
    kind = "a node" if pair is None else "a pin in a slot" if size is None else "a sliding pair"
    refs.record(where, those(
        none and not node and PartFault(
            (),
            f"'{name}' is neither a node nor a sliding pair; {guess(name, [*model.prismatic, *model.nodes], most=8)}",
            key=True,
        ),
        none and node and refs.sure and len(refs.carriers(name)) < 2 and PartFault(
            (), f"node {name} is not a pair: fewer than two members have this node; name another", key=True
        ),
        not part.given and PartFault((), f"friction at '{name}' needs `mu` or `viscous`", lacking=("mu", "viscous")),
        *(known and key in part.given and key != size and PartFault(
            (key,), f"`{key}` is of {owner}, '{name}' is {kind}; remove `{key}`", key=True
        ) for key, owner in owners.items()),
        known and part.mu is not None and size is not None and getattr(part, size) is None and PartFault(
            (), f"`{size}` is missing: dry friction at '{name}' needs {sizes.get(size or '')}", lacking=(str(size),)
        ),
        known and size in part.given and part.mu is None and PartFault(
            (), f"`mu` is missing: '{name}' has a `{size}`, but no coefficient of dry friction", lacking=("mu",)
        ),
    ))  # fmt: skip


# -- free inputs -------------------------------------------------------------------------------


def _check_input(refs: References, where: Where, actuator: Actuator) -> None:
    """Check the keys of a free input, and the rotor."""
    bound = not actuator.free and (*where, "free") not in refs.doubtful
    refs.record(where, (
        PartFault((key,), f"`{key}` is for a free input, this one follows its law; add `free: true`, or remove `{key}`",
                  key=True)
        for key in ("start", "speed", "effort") if bound and key in actuator.given
    ))  # fmt: skip
    if actuator.start is not None:
        check_values(refs, (*where, "start"), actuator, [actuator.start], what="the start")
    if actuator.effort is not None:
        _check_effort(refs, (*where, "effort"), actuator.effort)
    if actuator.rotor is not None:
        _check_rotor(refs, (*where, "rotor"), actuator.rotary, actuator.rotor)


def _check_rotor(refs: References, where: Where, rotary: bool, rotor: Rotor) -> None:
    key, other, kind = ("ratio", "lead", "rotary") if rotary else ("lead", "ratio", "linear")
    given = getattr(rotor, key)
    refs.sound(where, those(
        other in rotor.given and PartFault(
            (other,), f"`{other}` is not of a {kind} input; write `{key}`", key=True
        ),
        given is None and PartFault(
            (), "`lead` is missing: the travel of the linear input per turn of the rotor", lacking=("lead",)
        ),
        _too_large(key, f"a {key}", given),
    ))  # fmt: skip


def _too_large(key: str, what: str, value: float | None) -> object:
    """Return the error of a number that is too large or too small, if there is one."""
    wanted = f"of {1.0 / LARGEST:g} to {LARGEST:g}" if value else "other than 0"
    fits = value is None or 1.0 / LARGEST <= abs(value) <= LARGEST
    return not fits and PartFault((key,), f"expected {what} {wanted}, got {value:g}")


def _check_effort(refs: References, where: Where, effort: Effort) -> None:
    lacking = [key for key in ("stall", "idle") if getattr(effort, key) is None]
    kinds = (effort.constant is not None) + (effort.table is not None) + (len(lacking) < 2)
    refs.sound(where, those(
        kinds != 1 and PartFault(
            (), f"the effort of '{where[1]}' needs one of: a number, `table`, `stall` with `idle`",
            lacking=("table", "stall", "idle"),
        ),
        len(lacking) == 1 and PartFault(
            (), f"`{''.join(lacking)}` is missing; a torque-speed line needs `stall` and `idle`", lacking=lacking
        ),
        _too_large("idle", "an idle speed", effort.idle),
    ))  # fmt: skip
    _check_table(refs, where, effort, f"the effort of '{where[1]}'", effort.over)


CHECKS: dict[str, Callable[[References, Where, Any], None]] = {
    "masses": _check_mass, "loads": _check_load, "springs": _check_gauge, "dampers": _check_gauge,
    "friction": _check_friction, "actuators": _check_input,
}  # fmt: skip
"""The checks of a part of each section."""
