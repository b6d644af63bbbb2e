"""Ends of a law of motion, and the durations that follow from its rate.

A law starts at `from`, or at the initial value of its input. It ends at `to`, or after the increment `by`, `turns` or
rate x duration. All values are in the file's units; they may be recorded numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from gimcli.calculus.numbers import nominal
from gimcli.model.schema import Actuator, Law, Model
from gimcli.model.units import TURN

ENDS = ("to", "by", "turns")
"""Keys of which a law may have one; a rate needs none of them where the duration is known."""


class RunTime(NamedTuple):
    """The duration that the rate of an input gives [s]."""

    actuator: str
    seconds: Any
    text: str  # the keys that it follows from


def ended(law: Law) -> bool:
    """Return whether a law has an end, so that a polynomial in it goes from 0 to 1."""
    return law.rate is not None or any(getattr(law, key) is not None for key in ENDS)


def increment(law: Law, turn: float, duration: Any | None) -> Any | None:
    """Return the increment of a law without `to`; None if the law has no end.

    Args:
        law: the law.
        turn: one turn in the file's unit of angle; 0 for a linear input.
        duration: duration of the motion [s]; None if it follows from the rate itself.
    """
    if law.by is not None:
        return law.by
    if law.turns is not None:
        return turn * law.turns * _sense(law)
    if law.rate is not None:
        return turn * _sense(law) if duration is None else law.rate * duration
    return None


def run_times(model: Model, initial: Callable[[str, Actuator], Any | None], timed: bool) -> list[RunTime]:
    """Return the durations that the rates of a model give.

    Args:
        model: the model.
        initial: function that returns the initial value of an actuator (the file's unit), or None.
        timed: whether `duration` or a table gives the duration.

    Returns:
        One for each rate with `to`, `by` or `turns`; if there is none, and nothing else gives the duration, one turn
        for each rotary input with a rate.
    """
    turn = TURN[model.units.angle]
    rated = [
        (n, a, a.law, a.law.rate) for n, a in model.actuators.items() if a.law is not None and a.law.rate is not None
    ]
    rated = [one for one in rated if nominal(one[-1])]
    found = list[RunTime]()
    for name, actuator, law, rate in rated:
        change = increment(law, turn * actuator.rotary, 0.0)
        key = next((key for key in ENDS if getattr(law, key) is not None), None)
        if law.to is not None:
            start = initial(name, actuator) if law.from_ is None else law.from_
            change = None if start is None else law.to - start
        if key is not None and change is not None:
            change = -change if nominal(change) < 0.0 < nominal(rate) else change  # a positive rate is a speed
            found.append(RunTime(name, change / rate, f"`{key}` at this `rate`"))
    if found or timed:
        return found
    return [
        RunTime(name, turn * _sense(law) / rate, "one turn") for name, actuator, law, rate in rated if actuator.rotary
    ]


def _sense(law: Law) -> float:
    """Return 1, or -1 for a law that runs clockwise."""
    return -1.0 if law.rate is not None and nominal(law.rate) < 0.0 else 1.0
