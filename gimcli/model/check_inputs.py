"""Checks of the actuators: nodes that fit the type, values that the law can reach."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Sequence

import numpy as np

from gimcli.mechanism import MOST_TURNS
from gimcli.model.laws import PolynomialLaw
from gimcli.model.nearest import near
from gimcli.model.references import References
from gimcli.model.schema import LONGEST, PROFILES, SHORTEST, Actuator, Law, Profile
from gimcli.model.source import Where
from gimcli.model.tables import read_table

ROTARY, LINEAR = ("pivot", "arm", "reference"), ("nodes", "node", "guide")
KEYS = (*ROTARY, *LINEAR)


SAMPLES = 1001
"""Times at which a polynomial is evaluated besides its stationary points, of which rounding may hide one."""

Times = tuple[str, float]  # name of a table and its duration [s]


def check_inputs(refs: References) -> None:
    """Record the errors in the actuators."""
    tables: list[Times] = []
    for name, actuator in refs.model.actuators.items():
        where: Where = ("actuators", name)
        check_nodes(refs, where, actuator)
        if actuator.law is not None:
            _check_law(refs, where, actuator, actuator.law, tables)


def check_span(refs: References, where: Where, guide: Sequence[str], sliding: Sequence[str]) -> None:
    """Record the errors in a guide and in the nodes that slide on it."""
    if not refs.nodes((*where, "guide"), guide):
        return
    carriers = refs.carriers(*guide)
    if not carriers:
        if refs.sure:
            nodes = f"guide nodes {guide[0]} and {guide[1]}"
            text = f"{nodes} belong to no common member; name two nodes of one member, or of the ground"
            refs.fault((*where, "guide"), text)
        return
    if not refs.apart(*guide):
        text = f"guide nodes {guide[0]} and {guide[1]} coincide and define no direction; move one"
        refs.fault((*where, "guide"), text)
    held = refs.ground if carriers[0] == "ground" else set(refs.members[carriers[0]])
    for node in sliding:
        if node in held:
            text = f"node {node} belongs to '{carriers[0]}', which carries the guide; name a node of another member"
            refs.fault(where, text)


# -- nodes ----------------------------------------------------------------------------------


def check_nodes(refs: References, where: Where, actuator: Actuator, what: str = "actuator") -> None:
    """Record the errors in the nodes of an actuator, spring or damper (`what`)."""
    given = {key for key in KEYS if getattr(actuator, key) is not None}
    kind = actuator.type or ("rotary" if given & set(ROTARY) else "linear")
    if not _one_kind(refs, where, actuator, given):
        return
    needed, optional = {"node", "guide"}, set[str]()
    if kind == "rotary":
        needed, optional = {"pivot", "arm"}, {"reference"}
    elif "nodes" in given:
        needed = {"nodes"}
    for key in sorted(given - needed - optional):
        text = f"`{key}` does not belong to this {kind} {what}; remove it"
        refs.fault((*where, key), text, key=True)
    if needed - given:
        either = "`nodes`, or " if kind == "linear" else ""
        missing = " and ".join(f"`{key}`" for key in sorted(needed - given, reverse=kind == "rotary"))
        added = "one of the two" if either else "it" if len(needed - given) == 1 else "both"
        refs.lack(where, KEYS, f"{what} '{where[1]}' needs {either}{missing}; add {added}")
    elif kind == "rotary":
        _check_rotary(refs, where, str(actuator.pivot), str(actuator.arm), actuator.reference)
    elif actuator.nodes is not None:
        _check_telescope(refs, where, actuator.nodes)
    elif refs.node((*where, "node"), str(actuator.node)):
        check_span(refs, where, actuator.guide or [], [str(actuator.node)])


def _one_kind(refs: References, where: Where, actuator: Actuator, given: set[str]) -> bool:
    """Return whether the keys of an actuator, and its type if it is given, are of one kind; record an error if not."""
    turning, sliding = (_listed(key for key in keys if key in given) for keys in (ROTARY, LINEAR))
    own, other = (turning, sliding) if actuator.type == "rotary" else (sliding, turning)
    if actuator.type is not None and other and not own:
        kind = "linear" if actuator.type == "rotary" else "rotary"
        text = f"`type: {actuator.type}` contradicts {other} of a {kind} actuator; remove `type`: it follows from these"
        refs.fault((*where, "type"), text)
    elif actuator.type is None and turning and sliding:
        text = f"{turning} of a rotary actuator and {sliding} of a linear one exclude each other; remove one of the two"
        refs.fault(where, text)
    elif actuator.type is None and not given:
        text = f"actuator '{where[1]}' needs `pivot` and `arm` (rotary), `nodes`, or `node` and `guide` (linear)"
        refs.lack(where, KEYS, text)
    else:
        return True
    return False


def _listed(keys: Iterable[str]) -> str:
    return " and ".join(f"`{key}`" for key in keys)


def _check_rotary(refs: References, where: Where, pivot: str, arm: str, reference: str | None) -> None:
    known = [refs.node((*where, "pivot"), pivot), refs.node((*where, "arm"), arm)]
    if reference is not None:
        known.append(refs.node((*where, "reference"), reference))
    if not all(known):
        return
    arms = [m for m in refs.carriers(pivot, arm) if m != "ground"] if pivot != arm else []
    if not arms:
        if refs.sure or pivot == arm:
            text = f"pivot {pivot} and arm {arm} belong to no common moving member; name two nodes of one member"
            refs.fault((*where, "arm"), text)
    elif reference is not None:
        _check_reference(refs, (*where, "reference"), pivot, reference, arms[0])
    elif pivot not in refs.ground and refs.sure:
        others = [m for m in refs.carriers(pivot) if m != arms[0]]
        if others:
            text = f"pivot {pivot} joins '{arms[0]}' and '{others[0]}', which both move; add a `reference` node on one"
            refs.fault((*where, "pivot"), text)


def _check_reference(refs: References, where: Where, pivot: str, reference: str, arm: str) -> None:
    if reference == pivot:
        refs.fault(where, f"reference {reference} is the pivot itself and defines no direction; name another node")
    elif not [m for m in refs.carriers(pivot, reference) if m != arm]:
        if refs.sure:
            joint = f"pivot {pivot} and reference {reference} belong to no common member other than '{arm}'"
            refs.fault(where, f"{joint}; name a node of the member on which '{arm}' turns")
    elif not refs.apart(pivot, reference):
        refs.fault(where, f"pivot {pivot} and reference {reference} coincide and define no direction; move one")


def _check_telescope(refs: References, where: Where, nodes: Sequence[str]) -> None:
    if refs.nodes((*where, "nodes"), nodes):
        holders = refs.carriers(*nodes)
        if holders:
            text = (
                f"nodes {nodes[0]} and {nodes[1]} belong to the same member '{holders[0]}': their distance is constant"
            )
            refs.fault((*where, "nodes"), f"{text}; name nodes of two members")


# -- laws -----------------------------------------------------------------------------------


def _check_law(refs: References, where: Where, actuator: Actuator, law: Law, tables: list[Times]) -> None:
    at: Where = (*where, "law")
    profile = law.profile
    if len(profile.given) > 1:
        keys = " and ".join(f"`{key}`" for key in sorted(profile.given))
        refs.fault((*at, "profile"), f"expected one of `name`, `polynomial` and `table`, got {keys}")
        return
    if profile.name not in PROFILES:
        choice = f"expected one of {', '.join(PROFILES)}, got '{profile.name}'{near(profile.name, PROFILES)}"
        refs.fault((*at, "profile"), f"profile: {choice}")
    values = _check_ends(refs, at, law)
    by = law.by or 0.0
    if profile.table is not None:
        values = _check_table(refs, (*at, "profile", "table"), profile.table, tables)
    elif profile.polynomial is not None and law.by is None and law.from_ is None:
        values = _course(profile.polynomial)
    elif len(values) == 2:
        values += _between(values[0], values[1], profile)
    elif not values and (drawn := _drawn(refs, actuator)) is not None:
        values = [drawn, drawn + by, *_between(drawn, drawn + by, profile)]
    _check_values(refs, at, actuator, values, by)


def _drawn(refs: References, actuator: Actuator) -> float | None:
    """Return the initial value of an input in the file's unit; None if its nodes are not declared."""
    names = [*(actuator.nodes or []), *(actuator.guide or [])]
    names += [n for n in (actuator.pivot, actuator.arm, actuator.reference, actuator.node) if n is not None]
    if not set(names) <= set(refs.model.nodes):
        return None
    place = {name: complex(*refs.model.nodes[name]) for name in names}
    if actuator.nodes is not None:
        return abs(place[actuator.nodes[1]] - place[actuator.nodes[0]])
    if actuator.pivot is not None and actuator.arm is not None:
        ray = place[actuator.arm] - place[actuator.pivot]
        if actuator.reference is not None:
            ray *= (place[actuator.reference] - place[actuator.pivot]).conjugate()
        angle = cmath.phase(ray)
        return math.degrees(angle) if refs.model.units.angle == "deg" else angle
    if actuator.node is not None and actuator.guide is not None:
        first, second = (place[name] for name in actuator.guide)
        along = second - first
        return ((place[actuator.node] - first) * along.conjugate()).real / (abs(along) or 1.0)
    return None


def _between(start: float, end: float, profile: Profile) -> list[float]:
    """Return the extreme values of a polynomial law between two ends; the other profiles stay between the ends."""
    values = [start * (1.0 - s) + end * s for s in _course(profile.polynomial or [])]
    return [v if math.isfinite(v) else math.inf for v in values]


def _course(coefficients: Sequence[float]) -> list[float]:
    """Return the values of a polynomial at 0 and 1, its least and its greatest value in 0..1."""
    law = PolynomialLaw(tuple(coefficients or (0.0,)))
    with np.errstate(over="ignore", invalid="ignore"):
        values = law(np.concatenate([[0.0, 1.0], law.stops(), np.linspace(0.0, 1.0, SAMPLES)]))
    values = np.where(np.isnan(values), np.inf, values)
    return [float(v) for v in (values[0], values[1], values.min(), values.max())]


def check_reach(refs: References, at: Where, actuator: Actuator, value: float) -> None:
    """Record an error if an input cannot have a value (the file's unit)."""
    _check_values(refs, at, actuator, [value], 0.0, "the start")


def _check_values(
    refs: References, at: Where, actuator: Actuator, values: list[float], by: float, what: str = "the law"
) -> None:
    """Record an error for distances not above 0, and for values beyond MOST_TURNS turns or sizes."""
    if actuator.nodes is not None and min(values, default=1.0) <= 0.0:
        refs.fault(at, f"expected a distance above 0, got {min(values):g}; correct {what}")
    turn = 360.0 if refs.model.units.angle == "deg" else 2.0 * math.pi
    most = MOST_TURNS * (turn if actuator.rotary else refs.size)
    farthest = max([*values, by], key=abs)
    if abs(farthest) > most > 0.0:
        refs.fault(at, f"{what} reaches {farthest:g}, more than the limit {most:g}; shorten it")


def _check_ends(refs: References, at: Where, law: Law) -> list[float]:
    """Check the ends of a law and its profile; return the absolute ends, `from` and `to`."""
    absolute = [value for value in (law.from_, law.to) if value is not None]
    if law.by is not None and absolute:
        refs.fault((*at, "by"), "expected `by`, or `from` and `to`, got both `by` with `from` or `to`", key=True)
    elif law.profile.table is not None:
        if absolute or law.by is not None:
            refs.fault(at, "a table gives absolute values; remove `from`, `to` and `by`")
    elif len(absolute) == 1:
        missing = "to" if law.to is None else "from"
        refs.lack(at, (missing,), f"`{missing}` is missing; give both `from` and `to`, or `by`")
    if law.profile.polynomial is not None and (law.by is not None or absolute):
        first, last, *_ = _course(law.profile.polynomial)
        if abs(first) > 1e-9 or abs(last - 1.0) > 1e-9:
            text = f"with given ends the polynomial must go from 0 to 1, got {first:g} to {last:g}; correct it"
            refs.fault((*at, "profile", "polynomial"), text)
    return absolute


def _check_table(refs: References, where: Where, name: str, tables: list[Times]) -> list[float]:
    """Check the table of a law and its duration; return its values, an empty list if it cannot be read."""
    try:
        time, values = read_table(refs.source.folder / name)
    except ValueError as error:
        refs.fault(where, f"table {name}: {error}")
        return []
    span = time[-1] - time[0]
    duration = refs.model.duration
    tables.append((name, span))
    if not SHORTEST <= span <= LONGEST:
        refs.fault(where, f"table {name}: expected a duration of {SHORTEST:g} to {LONGEST:g} s, got {span:g} s")
    other, wanted = tables[0] if duration is None else ("`duration`", duration)
    if abs(span - wanted) > 1e-9 * wanted:
        refs.fault(where, f"table {name} covers {span:g} s, {other} is {wanted:g} s; make them equal")
    return values
