"""Checks of the actuators: keys of one kind, nodes that fit it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from gimcli.model.check_laws import check_laws
from gimcli.model.references import PartFault, References
from gimcli.model.schema import Actuator, Gauge, Prismatic
from gimcli.model.source import Where
from gimcli.nearest import guess

ROTARY, LINEAR = ("pivot", "arm", "reference"), ("nodes", "node", "guide")
KEYS = (*ROTARY, *LINEAR)
FOLLOWING = {"follows", "ratio", "phase"}
"""Keys of an actuator that follows another."""
GREATEST = 1e6
"""Greatest ratio of two inputs."""
OWN = ("law", "free", "start", "speed", "effort")
"""Keys of an actuator that follows no other."""


def check_inputs(refs: References) -> None:
    """Record the errors in the actuators."""
    for name, actuator in refs.model.actuators.items():
        check_nodes(refs, ("actuators", name), actuator, actuator.type)
        if FOLLOWING & actuator.given:
            _check_following(refs, ("actuators", name), actuator)
    check_laws(refs)


def _check_following(refs: References, where: Where, actuator: Actuator) -> None:
    """Record the errors of an actuator that follows another."""
    known, leader = refs.model.actuators, actuator.follows
    if leader is None:
        key = min(FOLLOWING & actuator.given)
        refs.lack(where, ("follows",), f"`{key}` belongs to an actuator that follows another; add `follows: NAME`")
    elif leader not in known:
        if not {("actuators",), ("actuators", leader)} & set(refs.doubtful):
            others = [name for name in known if name != where[1]]
            refs.fault((*where, "follows"), f"no actuator '{leader}'; {guess(leader, others, 'actuators')}")
    elif _leaders(refs, str(where[1]))[-1] == where[1]:
        chain = " -> ".join(f"'{name}'" for name in _leaders(refs, str(where[1])))
        refs.fault((*where, "follows"), f"'{where[1]}' follows itself: {chain}; one of them must have a law of its own")
    elif own := [key for key in OWN if key in actuator.given]:
        text = f"`{own[0]}` does not belong to an actuator that follows '{leader}'; remove it"
        refs.fault((*where, own[0]), text, key=True)
    elif actuator.ratio == 0.0:
        refs.fault((*where, "ratio"), "the ratio 0 holds the input constant; use a `law` instead of `follows`")
    elif not 1.0 / GREATEST <= abs(actuator.ratio or 1.0) <= GREATEST:
        refs.fault((*where, "ratio"), f"expected a ratio of {1.0 / GREATEST:g} to {GREATEST:g}, got {actuator.ratio:g}")


def _leaders(refs: References, name: str) -> list[str]:
    """Return an actuator that follows another, that other, and so on; the last name is repeated if they follow it."""
    known, found = refs.model.actuators, [name]
    while found[-1] in known and known[found[-1]].follows is not None and found.count(found[-1]) < 2:
        found.append(str(known[found[-1]].follows))
    return found


def check_span(refs: References, where: Where, guide: Sequence[str], sliding: Sequence[str]) -> None:
    """Record the errors in a guide and in the nodes that slide on it."""
    if not refs.nodes((*where, "guide"), guide):
        return
    carriers = refs.carriers(*guide)
    nodes = f"guide nodes {guide[0]} and {guide[1]}"
    if not carriers and refs.sure:
        text = f"{nodes} belong to no common member; name two nodes of one member, or of the ground"
        refs.fault((*where, "guide"), text)
    elif carriers and not refs.apart(*guide):
        refs.fault((*where, "guide"), f"{nodes} coincide and define no direction; move one")
    held = refs.having(carriers[0]) if carriers else ()
    for node in (node for node in sliding if node in held):
        text = f"node {node} belongs to '{carriers[0]}', which carries the guide; name a node of another member"
        refs.fault(where, text)


def check_pair(refs: References, where: Where, pair: Prismatic) -> None:
    """Record the errors in a sliding pair."""
    if (pair.node is None) == (pair.nodes is None):
        text = f"'{where[1]}' needs either `node` (pin in a slot) or `nodes` (no relative rotation)"
        refs.lack(where, ("node", "nodes"), text)
    elif pair.node is not None and refs.node((*where, "node"), pair.node):
        check_span(refs, where, pair.guide, [pair.node])
    elif pair.nodes is not None and refs.nodes((*where, "nodes"), pair.nodes):
        check_span(refs, where, pair.guide, pair.nodes)
        if refs.sure and not refs.carriers(*pair.nodes):
            text = f"nodes {' and '.join(pair.nodes)} belong to no common member; name two nodes of the sliding member"
            refs.fault((*where, "nodes"), text)


# -- nodes ----------------------------------------------------------------------------------


def check_nodes(refs: References, where: Where, gauge: Gauge, stated: str | None, what: str = "actuator") -> None:
    """Record the errors in the nodes of an actuator, spring or damper (`what`); `stated`: its type, if given."""
    given = {key for key in KEYS if getattr(gauge, key) is not None}
    kind = stated or ("rotary" if given & set(ROTARY) else "linear")
    if not refs.sound(where, _of_kind(where[1], stated, given)):
        return
    needed, optional = {"node", "guide"}, set[str]()
    if kind == "rotary":
        needed, optional = {"pivot", "arm"}, {"reference"}
    elif "nodes" in given:
        needed = {"nodes"}
    for key in sorted(given - needed - optional):
        refs.fault((*where, key), f"`{key}` does not belong to this {kind} {what}; remove it", key=True)
    if needed - given:
        either = "`nodes`, or " if kind == "linear" else ""
        missing = " and ".join(f"`{key}`" for key in sorted(needed - given, reverse=kind == "rotary"))
        added = "one of the two" if either else "it" if len(needed - given) == 1 else "both"
        refs.lack(where, KEYS, f"{what} '{where[1]}' needs {either}{missing}; add {added}")
    elif kind == "rotary":
        _check_rotary(refs, where, gauge)
    elif gauge.nodes is not None:
        _check_telescope(refs, where, gauge.nodes)
    elif refs.node((*where, "node"), str(gauge.node)):
        check_span(refs, where, gauge.guide or [], [str(gauge.node)])


def _of_kind(name: Any, stated: str | None, given: set[str]) -> Iterator[PartFault]:
    """Yield the error where the keys of an actuator, and its type if it is given, are of two kinds or none."""
    turning, sliding = (" and ".join(f"`{key}`" for key in keys if key in given) for keys in (ROTARY, LINEAR))
    own, other = (turning, sliding) if stated == "rotary" else (sliding, turning)
    if stated is not None and other and not own:
        kind = "linear" if stated == "rotary" else "rotary"
        text = f"`type: {stated}` contradicts {other} of a {kind} actuator; remove `type`: it follows from these"
        yield PartFault(("type",), text)
    if stated is None and turning and sliding:
        text = f"{turning} of a rotary actuator and {sliding} of a linear one exclude each other; remove one of the two"
        yield PartFault((), text)
    if stated is None and not given:
        text = f"actuator '{name}' needs `pivot` and `arm` (rotary), `nodes`, or `node` and `guide` (linear)"
        yield PartFault((), text, lacking=KEYS)


def _check_rotary(refs: References, where: Where, gauge: Gauge) -> None:
    if not all([refs.node((*where, key), name) for key, name in gauge.keyed if key in ROTARY]):
        return
    pivot, arm, reference = str(gauge.pivot), str(gauge.arm), gauge.reference
    arms = [m for m in refs.carriers(pivot, arm) if m != "ground"] if pivot != arm else []
    others = [m for m in refs.carriers(pivot) if m not in (*arms[:1], "ground")]
    if not arms and (refs.sure or pivot == arm):
        text = f"pivot {pivot} and arm {arm} belong to no common moving member; name two nodes of one member"
        refs.fault((*where, "arm"), text)
    elif arms and reference is not None:
        _check_reference(refs, (*where, "reference"), pivot, reference, arms[0])
    elif arms and pivot not in refs.ground and refs.sure and others:
        text = f"pivot {pivot} joins '{arms[0]}' and '{others[0]}', which both move; add a `reference` node on one"
        refs.fault((*where, "pivot"), text)


def _check_reference(refs: References, where: Where, pivot: str, reference: str, arm: str) -> None:
    if reference == pivot:
        refs.fault(where, f"reference {reference} is the pivot itself and defines no direction; name another node")
    elif not [m for m in refs.carriers(pivot, reference) if m != arm] and refs.sure:
        joint = f"pivot {pivot} and reference {reference} belong to no common member other than '{arm}'"
        refs.fault(where, f"{joint}; name a node of the member on which '{arm}' turns")
    elif [m for m in refs.carriers(pivot, reference) if m != arm] and not refs.apart(pivot, reference):
        refs.fault(where, f"pivot {pivot} and reference {reference} coincide and define no direction; move one")


def _check_telescope(refs: References, where: Where, nodes: Sequence[str]) -> None:
    holders = refs.carriers(*nodes) if refs.nodes((*where, "nodes"), nodes) else []
    if holders:
        text = f"nodes {nodes[0]} and {nodes[1]} belong to the same member '{holders[0]}': their distance is constant"
        refs.fault((*where, "nodes"), f"{text}; name nodes of two members")
