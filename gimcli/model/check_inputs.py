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
    known, leader, ratio = refs.model.actuators, actuator.follows, actuator.ratio
    others, doubted = [name for name in known if name != where[1]], {("actuators",), ("actuators", leader)}
    names, own = _leaders(refs, str(where[1])), [key for key in OWN if key in actuator.given][:1]
    chain = " -> ".join(f"'{name}'" for name in names)
    refs.sound(where, those(
        leader is None and PartFault(
            (),
            f"`{min(FOLLOWING & actuator.given)}` belongs to an actuator that follows another; add `follows: NAME`",
            lacking=("follows",),
        ),
        leader is not None and leader not in known and PartFault(
            ("follows",),
            "" if doubted & set(refs.doubtful) else f"no actuator '{leader}'; {guess(leader, others, 'actuators')}",
        ),
        names[-1] == where[1] and PartFault(
            ("follows",), f"'{where[1]}' follows itself: {chain}; one of them must have a law of its own"
        ),
        own and PartFault(
            (*own,), f"`{''.join(own)}` does not belong to an actuator that follows '{leader}'; remove it", key=True
        ),
        ratio == 0.0 and PartFault(
            ("ratio",), "the ratio 0 holds the input constant; use a `law` instead of `follows`"
        ),
        not 1.0 / GREATEST <= abs(ratio or 1.0) <= GREATEST and PartFault(
            ("ratio",), f"expected a ratio of {1.0 / GREATEST:g} to {GREATEST:g}, got {ratio:g}"
        ),
    ))  # fmt: skip


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
    refs.record(where, those(
        not carriers and refs.sure and PartFault(
            ("guide",), f"{nodes} belong to no common member; name two nodes of one member, or of the ground"
        ),
        carriers and not refs.apart(*guide) and PartFault(
            ("guide",), f"{nodes} coincide and define no direction; move one"
        ),
        *(node in refs.having(carrier) and PartFault(
            (), f"node {node} belongs to '{carrier}', which carries the guide; name a node of another member"
        ) for carrier in carriers[:1] for node in sliding),
    ))  # fmt: skip


def check_pair(refs: References, where: Where, pair: Prismatic) -> None:
    """Record the errors in a sliding pair."""
    nodes = pair.nodes or []
    one = refs.sound(where, those((pair.node is None) == (pair.nodes is None) and PartFault(
        (), f"'{where[1]}' needs either `node` (pin in a slot) or `nodes` (no relative rotation)",
        lacking=("node", "nodes"),
    )))  # fmt: skip
    if one and refs.nodes((*where, "node" if pair.node is not None else "nodes"), pair.sliding):
        check_span(refs, where, pair.guide, pair.sliding)
        refs.record(where, those(nodes and refs.sure and not refs.carriers(*nodes) and PartFault(
            ("nodes",),
            f"nodes {' and '.join(nodes)} belong to no common member; name two nodes of the sliding member",
        )))  # fmt: skip


# -- nodes ----------------------------------------------------------------------------------


def check_nodes(refs: References, where: Where, gauge: Gauge, stated: str | None, what: str = "actuator") -> None:
    """Record the errors in the nodes of an actuator, spring or damper (`what`); `stated`: its type, if given."""
    given = {key for key in KEYS if getattr(gauge, key) is not None}
    kind = stated or ("rotary" if given & set(ROTARY) else "linear")
    if not refs.sound(where, _of_kind(where[1], stated, given)):
        return
    needed, optional = {"nodes"} if "nodes" in given else {"node", "guide"}, set[str]()
    if kind == "rotary":
        needed, optional = {"pivot", "arm"}, {"reference"}
    lacking, either = needed - given, "`nodes`, or " if kind == "linear" else ""
    missing = " and ".join(f"`{key}`" for key in sorted(lacking, reverse=kind == "rotary"))
    added = "one of the two" if either else "it" if len(lacking) == 1 else "both"
    refs.record(where, those(
        *(PartFault((key,), f"`{key}` does not belong to this {kind} {what}; remove it", key=True)
          for key in given - needed - optional),
        lacking and PartFault((), f"{what} '{where[1]}' needs {either}{missing}; add {added}", lacking=KEYS),
    ))  # fmt: skip
    if kind == "rotary" and not lacking:
        _check_rotary(refs, where, gauge)
    elif kind == "linear" and gauge.nodes is not None:
        _check_telescope(refs, where, gauge.nodes)
    elif not lacking and refs.node((*where, "node"), str(gauge.node)):
        check_span(refs, where, gauge.guide or [], [str(gauge.node)])


def _of_kind(name: Any, stated: str | None, given: set[str]) -> Iterator[PartFault]:
    """Return the error where the keys of an actuator, and its type if it is given, are of two kinds or none."""
    turning, sliding = (" and ".join(f"`{key}`" for key in keys if key in given) for keys in (ROTARY, LINEAR))
    own, other, kind = (turning, sliding, "linear") if stated == "rotary" else (sliding, turning, "rotary")
    return those(
        stated is not None and other and not own and PartFault(
            ("type",),
            f"`type: {stated}` contradicts {other} of a {kind} actuator; remove `type`: it follows from these",
        ),
        stated is None and turning and sliding and PartFault(
            (),
            f"{turning} of a rotary actuator and {sliding} of a linear one exclude each other; remove one of the two",
        ),
        stated is None and not given and PartFault(
            (), f"actuator '{name}' needs `pivot` and `arm` (rotary), `nodes`, or `node` and `guide` (linear)",
            lacking=KEYS,
        ),
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
    refs.sound(where, those(
        not arms and (refs.sure or pivot == arm) and PartFault(
            ("arm",),
            f"pivot {pivot} and arm {arm} belong to no common moving member; name two nodes of one member",
        ),
        arms and pivot not in refs.ground and refs.sure and others and PartFault(
            ("pivot",), f"pivot {pivot} joins {both}, which both move; add a `reference` node on one"
        ),
    ))  # fmt: skip


def _check_reference(refs: References, where: Where, pivot: str, reference: str, arm: str) -> None:
    others, joint = [m for m in refs.carriers(pivot, reference) if m != arm], f"pivot {pivot} and reference {reference}"
    refs.sound(where, those(
        reference == pivot and PartFault(
            (), f"reference {reference} is the pivot itself and defines no direction; name another node"
        ),
        not others and refs.sure and PartFault(
            (),
            f"{joint} belong to no common member other than '{arm}'; name a node of the member on which '{arm}' turns",
        ),
        others and not refs.apart(pivot, reference) and PartFault(
            (), f"{joint} coincide and define no direction; move one"
        ),
    ))  # fmt: skip


def _check_telescope(refs: References, where: Where, nodes: Sequence[str]) -> None:
    holders = refs.carriers(*nodes) if refs.nodes((*where, "nodes"), nodes) else []
    refs.record(where, those(holders and PartFault(
        ("nodes",),
        f"nodes {nodes[0]} and {nodes[1]} belong to the same member '{holders[0]}': their distance is constant; name"
        " nodes of two members",
    )))  # fmt: skip


# -- laws -----------------------------------------------------------------------------------


def _check_laws(refs: References) -> None:
    """Record the errors in the laws of all actuators."""
    tables, values, sound = list[Times](), dict[str, list[float]](), set[str]()
    for name, actuator in refs.model.actuators.items():
        law, at = actuator.law, ("actuators", name, "law")
        if law is None or not refs.sound(at, _of_profile(law.profile)):
            continue
        profile = law.profile
        given = [f"`{key.rstrip('_')}`" for key in ("from_", *ENDS, "rate") if getattr(law, key) is not None]
        refs.record(at, those(
            profile.name not in PROFILES and PartFault(
                ("profile",),
                f"profile: expected one of {', '.join(PROFILES)}, got '{profile.name}'{near(profile.name, PROFILES)}",
            ),
            profile.table is not None and given and PartFault(
                (), f"a table gives times and absolute values; remove {' and '.join(given)}"
            ),
        ))  # fmt: skip
        if profile.table is not None:
            values[name] = _check_table(refs, (*at, "profile", "table"), profile.table, tables)
        if profile.table is not None or refs.sound(at, _of_ends(actuator, law)):
            sound.add(name)
    duration = _check_times(refs, tables, sound)
    for name in sound:
        actuator = refs.model.actuators[name]
        _check_course(refs, ("actuators", name, "law"), actuator, values.get(name), duration)


def _of_profile(profile: Profile) -> Iterator[PartFault]:
    """Return the error of a law with several profiles."""
    keys = " and ".join(f"`{key}`" for key in sorted(profile.given))
    return those(len(profile.given) > 1 and PartFault(
        ("profile",), f"expected one of `name`, `polynomial` and `table`, got {keys}"
    ))  # fmt: skip


# -- ends -------------------------------------------------------------------------------------


def _of_ends(actuator: Actuator, law: Law) -> Iterator[PartFault]:
    """Return the errors of keys that do not fit together; those behind the first one may follow from it."""
    ends, shape = [key for key in ENDS if getattr(law, key) is not None], law.profile.polynomial
    first, last, *_ = _extremes(shape) if shape is not None and ended(law) else (0.0, 1.0)
    named = " and ".join(f"`{key}`" for key in ends)
    return those(
        len(ends) > 1 and PartFault(
            (*ends[-1:],), f"expected one of `to`, `by` and `turns`, got {named}; remove one", key=True
        ),
        law.turns is not None and not actuator.rotary and PartFault(
            ("turns",), "`turns` are of a rotary input, this one is linear; write `by` or `to`", key=True
        ),
        law.from_ is not None and not ended(law) and PartFault(
            (), "`to` is missing beside `from`; add `to`, or `by`, `turns` or `rate`", lacking=(*ENDS, "rate")
        ),
        law.rate == 0.0 and PartFault(
            ("rate",), "the rate 0 does not move the input; give another rate, or the law `{by: 0}`"
        ),
        not (abs(first) <= 1e-9 and abs(last - 1.0) <= 1e-9) and PartFault(
            ("profile", "polynomial"),
            f"with given ends the polynomial must go from 0 to 1, got {first:g} to {last:g}; correct it",
        ),
    )  # fmt: skip


# -- durations ----------------------------------------------------------------------------------


def _check_table(refs: References, where: Where, name: str, tables: list[Times]) -> list[float]:
    """Check the table of a law and its duration; return its values, an empty list if it cannot be read."""
    found, duration = refs.table(where, name), refs.model.duration
    if found is None:
        return []
    time, values = found
    span = time[-1] - time[0]
    tables.append((name, span))
    other, wanted = tables[0] if duration is None else ("`duration`", duration)
    refs.record(where, those(
        not SHORTEST <= span <= LONGEST and PartFault(
            (), f"table {name}: expected a duration of {SHORTEST:g} to {LONGEST:g} s, got {span:g} s"
        ),
        abs(span - wanted) > 1e-9 * wanted and PartFault(
            (), f"table {name} covers {span:g} s, {other} is {wanted:g} s; make them equal"
        ),
    ))  # fmt: skip
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
        sure = refs.sound(("actuators", name, "law", "rate"), those(
            seconds <= 0.0 and PartFault((), _wrong_way(model.actuators[name].law or Law(), seconds)),
            not SHORTEST <= seconds <= LONGEST and PartFault(
                (), f"expected a duration of {SHORTEST:g} to {LONGEST:g} s, {text} takes {seconds:g} s"
            ),
            abs(seconds - wanted) > 1e-9 * wanted and PartFault(
                (), f"{text} takes {seconds:g} s, {other} is {wanted:g} s; {cure}"
            ),
        ))  # fmt: skip
        if sure and not known:
            known.append((f"that of '{name}'", seconds))
    for name in sound if not known else ():
        actuator, law = model.actuators[name], model.actuators[name].law or Law()
        endless = law.rate is not None and law.end is None and not actuator.rotary and actuator.given & {*KEYS}
        refs.record(("actuators", name, "law", "rate"), those(endless and PartFault(
            (), "a rate needs an end or a time: add `to` or `by` to the law, or `duration` to the file"
        )))  # fmt: skip
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
    most = MOST_TURNS * (TURN[refs.model.units.angle] if actuator.rotary else refs.size)
    least, farthest = min(values, default=1.0), max([*values, by], key=abs)
    refs.record(at, those(
        actuator.nodes is not None and least <= 0.0 and PartFault(
            (), f"expected a distance above 0, got {least:g}; correct {what}"
        ),
        abs(farthest) > most > 0.0 and PartFault(
            (), f"{what} reaches {farthest:g}, more than the limit {most:g}; shorten it"
        ),
    ))  # fmt: skip
