"""Checks of the actuators: keys of one kind, nodes that fit it, and their laws of motion.

Ends and rates of laws fit together, durations agree, values can be reached.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gimcli.mechanism import MOST_TURNS
from gimcli.model.compile_geometry import measured
from gimcli.model.laws import PROFILES, PolynomialLaw, ended, increment, run_times
from gimcli.model.references import PartFault, References, those
from gimcli.model.schema import ENDS, LONGEST, SHORTEST, Actuator, Gauge, Law, Prismatic, Profile
from gimcli.model.source import Where
from gimcli.model.units import TURN
from gimcli.nearest import guess, near

ROTARY, LINEAR = ("pivot", "arm", "reference"), ("nodes", "node", "guide")
KEYS = (*ROTARY, *LINEAR)
FOLLOWING = {"follows", "ratio", "phase"}
"""Keys of an actuator that follows another."""
GREATEST = 1e6
"""Greatest ratio of two inputs."""
OWN = ("law", "free", "start", "speed", "effort")
"""Keys of an actuator that follows no other."""
SAMPLES = 1001
"""Times at which a polynomial is evaluated besides its stationary points, of which rounding may hide one."""

Times = tuple[str, float]  # name of a table and its duration [s]


def check_inputs(refs: References) -> None:
    """Record the errors in the actuators."""
    for name, actuator in refs.model.actuators.items():
        check_nodes(refs, ("actuators", name), actuator, actuator.type)
        if FOLLOWING & actuator.given:
            _check_following(refs, ("actuators", name), actuator)
    _check_laws(refs)


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
    else:
        names, own = _leaders(refs, str(where[1])), [key for key in OWN if key in actuator.given][:1]
        chain, ratio = " -> ".join(f"'{name}'" for name in names), actuator.ratio
        limits = f"expected a ratio of {1.0 / GREATEST:g} to {GREATEST:g}, got {ratio or 0.0:g}"
        cases = (
            (names[-1] == where[1], PartFault(
                ("follows",), f"'{where[1]}' follows itself: {chain}; one of them must have a law of its own"
            )),
            (own, PartFault(
                (*own,), f"`{''.join(own)}` does not belong to an actuator that follows '{leader}'; remove it", key=True
            )),
            (ratio == 0.0, PartFault(
                ("ratio",), "the ratio 0 holds the input constant; use a `law` instead of `follows`"
            )),
            (not 1.0 / GREATEST <= abs(ratio or 1.0) <= GREATEST, PartFault(("ratio",), limits)),
        )  # fmt: skip
        refs.sound(where, those(*cases))


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
    cases = (
        (not carriers and refs.sure, PartFault(
            ("guide",), f"{nodes} belong to no common member; name two nodes of one member, or of the ground"
        )),
        (carriers and not refs.apart(*guide), PartFault(
            ("guide",), f"{nodes} coincide and define no direction; move one"
        )),
    )  # fmt: skip
    refs.sound(where, those(*cases))
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
    """Return the error where the keys of an actuator, and its type if it is given, are of two kinds or none."""
    turning, sliding = (" and ".join(f"`{key}`" for key in keys if key in given) for keys in (ROTARY, LINEAR))
    own, other, kind = (turning, sliding, "linear") if stated == "rotary" else (sliding, turning, "rotary")
    return those(
        (stated is not None and other and not own, PartFault(
            ("type",),
            f"`type: {stated}` contradicts {other} of a {kind} actuator; remove `type`: it follows from these",
        )),
        (stated is None and turning and sliding, PartFault(
            (),
            f"{turning} of a rotary actuator and {sliding} of a linear one exclude each other; remove one of the two",
        )),
        (stated is None and not given, PartFault(
            (), f"actuator '{name}' needs `pivot` and `arm` (rotary), `nodes`, or `node` and `guide` (linear)",
            lacking=KEYS,
        )),
    )  # fmt: skip


def _check_rotary(refs: References, where: Where, gauge: Gauge) -> None:
    if not all([refs.node((*where, key), name) for key, name in gauge.keyed if key in ROTARY]):
        return
    pivot, arm, reference = str(gauge.pivot), str(gauge.arm), gauge.reference
    arms = [m for m in refs.carriers(pivot, arm) if m != "ground"] if pivot != arm else []
    others = [m for m in refs.carriers(pivot) if m not in (*arms[:1], "ground")]
    if arms and reference is not None:
        _check_reference(refs, (*where, "reference"), pivot, reference, arms[0])
        return
    both = " and ".join(f"'{member}'" for member in (*arms[:1], *others[:1]))
    cases = (
        (not arms and (refs.sure or pivot == arm), PartFault(
            ("arm",),
            f"pivot {pivot} and arm {arm} belong to no common moving member; name two nodes of one member",
        )),
        (arms and pivot not in refs.ground and refs.sure and others, PartFault(
            ("pivot",), f"pivot {pivot} joins {both}, which both move; add a `reference` node on one"
        )),
    )  # fmt: skip
    refs.sound(where, those(*cases))


def _check_reference(refs: References, where: Where, pivot: str, reference: str, arm: str) -> None:
    others, joint = [m for m in refs.carriers(pivot, reference) if m != arm], f"pivot {pivot} and reference {reference}"
    cases = (
        (reference == pivot, PartFault(
            (), f"reference {reference} is the pivot itself and defines no direction; name another node"
        )),
        (not others and refs.sure, PartFault(
            (),
            f"{joint} belong to no common member other than '{arm}'; name a node of the member on which '{arm}' turns",
        )),
        (others and not refs.apart(pivot, reference), PartFault(
            (), f"{joint} coincide and define no direction; move one"
        )),
    )  # fmt: skip
    refs.sound(where, those(*cases))


def _check_telescope(refs: References, where: Where, nodes: Sequence[str]) -> None:
    holders = refs.carriers(*nodes) if refs.nodes((*where, "nodes"), nodes) else []
    if holders:
        text = f"nodes {nodes[0]} and {nodes[1]} belong to the same member '{holders[0]}': their distance is constant"
        refs.fault((*where, "nodes"), f"{text}; name nodes of two members")


# -- laws -----------------------------------------------------------------------------------


def _check_laws(refs: References) -> None:
    """Record the errors in the laws of all actuators."""
    tables, values, sound = list[Times](), dict[str, list[float]](), set[str]()
    for name, actuator in refs.model.actuators.items():
        law, at = actuator.law, ("actuators", name, "law")
        if law is None or not refs.sound(at, _of_profile(law.profile)):
            continue
        profile = law.profile
        if profile.name not in PROFILES:
            choice = f"expected one of {', '.join(PROFILES)}, got '{profile.name}'{near(profile.name, PROFILES)}"
            refs.fault((*at, "profile"), f"profile: {choice}")
        if profile.table is not None:
            values[name] = _check_table(refs, (*at, "profile", "table"), profile.table, tables)
            if given := [f"`{key.rstrip('_')}`" for key in ("from_", *ENDS, "rate") if getattr(law, key) is not None]:
                refs.fault(at, f"a table gives times and absolute values; remove {' and '.join(given)}")
        if profile.table is not None or refs.sound(at, _of_ends(actuator, law)):
            sound.add(name)
    duration = _check_times(refs, tables, sound)
    for name in sound:
        actuator = refs.model.actuators[name]
        _check_course(refs, ("actuators", name, "law"), actuator, values.get(name), duration)


def _of_profile(profile: Profile) -> Iterator[PartFault]:
    """Yield the error of a law with several profiles."""
    if len(profile.given) > 1:
        keys = " and ".join(f"`{key}`" for key in sorted(profile.given))
        yield PartFault(("profile",), f"expected one of `name`, `polynomial` and `table`, got {keys}")


# -- ends -------------------------------------------------------------------------------------


def _of_ends(actuator: Actuator, law: Law) -> Iterator[PartFault]:
    """Return the errors of keys that do not fit together; those behind the first one may follow from it."""
    ends, shape = [key for key in ENDS if getattr(law, key) is not None], law.profile.polynomial
    first, last, *_ = _extremes(shape) if shape is not None and ended(law) else (0.0, 1.0)
    named = " and ".join(f"`{key}`" for key in ends)
    return those(
        (len(ends) > 1, PartFault(
            (*ends[-1:],), f"expected one of `to`, `by` and `turns`, got {named}; remove one", key=True
        )),
        (law.turns is not None and not actuator.rotary, PartFault(
            ("turns",), "`turns` are of a rotary input, this one is linear; write `by` or `to`", key=True
        )),
        (law.from_ is not None and not ended(law), PartFault(
            (), "`to` is missing beside `from`; add `to`, or `by`, `turns` or `rate`", lacking=(*ENDS, "rate")
        )),
        (law.rate == 0.0, PartFault(
            ("rate",), "the rate 0 does not move the input; give another rate, or the law `{by: 0}`"
        )),
        (not (abs(first) <= 1e-9 and abs(last - 1.0) <= 1e-9), PartFault(
            ("profile", "polynomial"),
            f"with given ends the polynomial must go from 0 to 1, got {first:g} to {last:g}; correct it",
        )),
    )  # fmt: skip


# -- durations ----------------------------------------------------------------------------------


def _check_table(refs: References, where: Where, name: str, tables: list[Times]) -> list[float]:
    """Check the table of a law and its duration; return its values, an empty list if it cannot be read."""
    found = refs.table(where, name)
    if found is None:
        return []
    time, values = found
    span = time[-1] - time[0]
    duration = refs.model.duration
    tables.append((name, span))
    if not SHORTEST <= span <= LONGEST:
        refs.fault(where, f"table {name}: expected a duration of {SHORTEST:g} to {LONGEST:g} s, got {span:g} s")
    other, wanted = tables[0] if duration is None else ("`duration`", duration)
    if abs(span - wanted) > 1e-9 * wanted:
        refs.fault(where, f"table {name} covers {span:g} s, {other} is {wanted:g} s; make them equal")
    return values


def _check_times(refs: References, tables: list[Times], sound: set[str]) -> float | None:
    """Return the duration that the file gives, None if it gives none; record an error where durations differ."""
    model = refs.model
    known: list[Times] = [] if model.duration is None else [("`duration`", model.duration)]
    known += [(f"table {name}", seconds) for name, seconds in tables]
    for name, seconds, text in run_times(model, lambda _, one: initial_value(refs, one), bool(known)):
        if name not in sound:
            continue
        other, wanted = known[0] if known else ("", seconds)
        cure = "remove one of them" if other == "`duration`" else "make them equal, or add `duration` and remove one"
        cases = (
            (seconds <= 0.0, PartFault(
                (), _wrong_way(model.actuators[name].law or Law(), seconds) if seconds <= 0.0 else ""
            )),
            (not SHORTEST <= seconds <= LONGEST, PartFault(
                (), f"expected a duration of {SHORTEST:g} to {LONGEST:g} s, {text} takes {seconds:g} s"
            )),
            (abs(seconds - wanted) > 1e-9 * wanted, PartFault(
                (), f"{text} takes {seconds:g} s, {other} is {wanted:g} s; {cure}"
            )),
        )  # fmt: skip
        if refs.sound(("actuators", name, "law", "rate"), those(*cases)) and not known:
            known.append((f"that of '{name}'", seconds))
    for name in sorted(sound if not known else ()):
        actuator = model.actuators[name]
        if (
            actuator.law is not None
            and actuator.law.rate is not None
            and {"pivot", "arm", "nodes", "node", "guide"} & actuator.given
            and actuator.law.end is None
            and not actuator.rotary
        ):
            text = "a rate needs an end or a time: add `to` or `by` to the law, or `duration` to the file"
            refs.fault(("actuators", name, "law", "rate"), text)
    return known[0][1] if known else None


def _wrong_way(law: Law, seconds: float) -> str:
    if seconds == 0.0:
        return f"the law does not move the input (`{law.end}`), so that a rate has no meaning; remove `rate`"
    end = f"`{law.end}`: {getattr(law, str(law.end)):g}"
    return f"the rate {law.rate:g} leads away from the end ({end}); write it as a positive number"


# -- values -----------------------------------------------------------------------------------


def _check_course(
    refs: References, at: Where, actuator: Actuator, table: list[float] | None, duration: float | None
) -> None:
    """Check the values that a law reaches; `table` has those of its table."""
    law = actuator.law or Law()
    change = increment(law, TURN[refs.model.units.angle] * actuator.rotary, duration)
    start = law.from_ if law.from_ is not None else initial_value(refs, actuator)
    values = table or []
    if law.profile.table is None and law.profile.polynomial is not None and change is None and law.to is None:
        values = _extremes(law.profile.polynomial)
    elif law.profile.table is None and start is not None:
        end = law.to if law.to is not None else start + (change or 0.0)
        between = [start * (1.0 - s) + end * s for s in _extremes(law.profile.polynomial or [])]
        values = [start, end, *(v if math.isfinite(v) else math.inf for v in between)]
    check_values(refs, at, actuator, values, change or 0.0)


def initial_value(refs: References, actuator: Actuator) -> float | None:
    """Return the initial value of an input in the file's unit; None if its nodes are not declared."""
    needed = {"pivot", "arm"} if actuator.rotary else {"node", "guide"}
    known = actuator.nodes is not None or needed <= {key for key, _ in actuator.keyed}
    if not known or not set(actuator.named) <= set(refs.model.nodes):
        return None
    value = measured(actuator, {name: complex(*refs.model.nodes[name]) for name in actuator.named})
    return math.degrees(value) if actuator.rotary and refs.model.units.angle == "deg" else value


def _extremes(coefficients: Sequence[float]) -> list[float]:
    """Return the values of a polynomial at 0 and 1, its least and its greatest value in 0..1."""
    law = PolynomialLaw(tuple(coefficients or (0.0,)))
    with np.errstate(over="ignore", invalid="ignore"):
        values = law(np.concatenate([[0.0, 1.0], law.stops(), np.linspace(0.0, 1.0, SAMPLES)]))
    values = np.where(np.isnan(values), np.inf, values)
    return [float(v) for v in (values[0], values[1], values.min(), values.max())]


def check_values(
    refs: References, at: Where, actuator: Actuator, values: list[float], by: float = 0.0, what: str = "the law"
) -> None:
    """Record an error for distances not above 0, and for values beyond MOST_TURNS turns or sizes (file's unit)."""
    if actuator.nodes is not None and min(values, default=1.0) <= 0.0:
        refs.fault(at, f"expected a distance above 0, got {min(values):g}; correct {what}")
    most = MOST_TURNS * (TURN[refs.model.units.angle] if actuator.rotary else refs.size)
    farthest = max([*values, by], key=abs)
    if abs(farthest) > most > 0.0:
        refs.fault(at, f"{what} reaches {farthest:g}, more than the limit {most:g}; shorten it")
