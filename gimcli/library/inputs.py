"""Values of the inputs, by the user's names and in the file's units."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

from gimcli.errors import StructureError, UsageError
from gimcli.mechanism import MOST_TURNS, SPAN, FloatArray, Mechanism

MOST_STEPS = 10_000_000


def refuse_count(option: str, value: int, least: int, most: int) -> None:
    """Raise UsageError where what is counted is no whole number within its bounds."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise UsageError(f"--{option} {value}: a whole number from {least} to {most} is needed")


def refuse_choice(option: str, value: str, known: Iterable[str]) -> None:
    """Raise UsageError where a word is none of those known."""
    if value not in known:
        raise UsageError(f"--{option} {value}: choose {', '.join(known)}")


def inputs_of(mechanism: Mechanism, given: Mapping[str, float | str], before: str = "") -> FloatArray:
    """Return the inputs (actuators,): the start of every law, replaced by the values given.

    Messages begin with `before`. Raises UsageError where a name or a value is none that an input can have.
    """
    values = mechanism.start_inputs
    names = [a.name for a in mechanism.actuators]
    for name, value in given.items():
        text = f"{before}{name}={value}"
        if name not in names:
            raise UsageError(f"{text}: no actuator '{name}'{near(name, names)}")
        values[names.index(name)] = _value(mechanism, names.index(name), text, value)
    return values


def near(name: str, names: Iterable[str], what: str = "actuators") -> str:
    """Return what was probably meant, or what there is."""
    import difflib

    known = list(names)
    found = difflib.get_close_matches(name, known, 1)
    return f"; did you mean '{found[0]}'?" if found else f"; {what}: {', '.join(known) or 'none'}"


def _value(mechanism: Mechanism, k: int, text: str, value: float | str) -> float:
    """Return an input in the normal frame; refuse what no law may reach either."""
    try:
        given = float(value)
    except (TypeError, ValueError):
        given = math.nan
    if not math.isfinite(given):
        raise UsageError(f"{text}: '{value}' is not a finite number")
    actuator, found = mechanism.actuators[k], float(mechanism.value_from_file(k, given))
    if actuator.kind == SPAN and found <= 0.0:
        raise UsageError(f"{text}: a distance must be above 0")
    if abs(found) > MOST_TURNS * (2.0 * math.pi if actuator.rotary else mechanism.size):
        raise UsageError(f"{text}: more than {MOST_TURNS:g} turns, or sizes of the mechanism, from 0")
    return found


def in_file_units(mechanism: Mechanism, inputs: FloatArray, zero: float = 0.0) -> dict[str, float]:
    """Return inputs (actuators,) by name in the file's units; what is at most `zero` in the normal frame is 0."""
    return mechanism.inputs_to_file(np.where(np.abs(inputs) > zero, inputs, 0.0) if zero else inputs)


def interval_of(low: Mapping[str, float], high: Mapping[str, float]) -> dict[str, list[float]]:
    """Return the least and the greatest value of every input between two ends."""
    return {name: sorted([low[name], high[name]]) for name in low}


def refuse_unmoved(mechanism: Mechanism, cure: str) -> None:
    """Raise StructureError where a mechanism has no actuator."""
    if not mechanism.actuators:
        raise StructureError(f"{mechanism.name} has no actuator: nothing moves; {cure}")
