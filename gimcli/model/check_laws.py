"""Checks of the laws of motion: ends and rates that fit together, durations that agree, values that can be reached."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from gimcli.mechanism import MOST_TURNS
from gimcli.model.compile_geometry import measured
from gimcli.model.laws import PROFILES, PolynomialLaw, ended, increment, run_times
from gimcli.model.references import PartFault, References
from gimcli.model.schema import ENDS, LONGEST, SHORTEST, Actuator, Law, Profile
from gimcli.model.source import Where
from gimcli.model.units import TURN
from gimcli.nearest import near

SAMPLES = 1001
"""Times at which a polynomial is evaluated besides its stationary points, of which rounding may hide one."""

Times = tuple[str, float]  # name of a table and its duration [s]


def check_laws(refs: References) -> None:
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
    """Yield the errors of keys that do not fit together; those behind the first one may follow from it."""
    ends = [f"`{key}`" for key in ENDS if getattr(law, key) is not None]
    if len(ends) > 1:
        text = f"expected one of `to`, `by` and `turns`, got {' and '.join(ends)}; remove one"
        yield PartFault((ends[-1].strip("`"),), text, key=True)
    if law.turns is not None and not actuator.rotary:
        yield PartFault(("turns",), "`turns` are of a rotary input, this one is linear; write `by` or `to`", key=True)
    if law.from_ is not None and not ended(law):
        text = "`to` is missing beside `from`; add `to`, or `by`, `turns` or `rate`"
        yield PartFault((), text, lacking=(*ENDS, "rate"))
    if law.rate == 0.0:
        yield PartFault(("rate",), "the rate 0 does not move the input; give another rate, or the law `{by: 0}`")
    if law.profile.polynomial is not None and ended(law):
        first, last, *_ = _extremes(law.profile.polynomial)
        if not (abs(first) <= 1e-9 and abs(last - 1.0) <= 1e-9):
            text = f"with given ends the polynomial must go from 0 to 1, got {first:g} to {last:g}; correct it"
            yield PartFault(("profile", "polynomial"), text)


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
        at = ("actuators", name, "law", "rate")
        if name not in sound:
            continue
        if seconds <= 0.0:
            refs.fault(at, _wrong_way(model.actuators[name].law or Law(), seconds))
        elif not SHORTEST <= seconds <= LONGEST:
            refs.fault(at, f"expected a duration of {SHORTEST:g} to {LONGEST:g} s, {text} takes {seconds:g} s")
        elif known and abs(seconds - known[0][1]) > 1e-9 * known[0][1]:
            other, wanted = known[0]
            cure = (
                "remove one of them" if other == "`duration`" else "make them equal, or add `duration` and remove one"
            )
            refs.fault(at, f"{text} takes {seconds:g} s, {other} is {wanted:g} s; {cure}")
        else:
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
