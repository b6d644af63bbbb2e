"""Check arguments: values of the inputs by name in the file's units, counts and words."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, wraps
from inspect import signature
from types import SimpleNamespace
from typing import Annotated, Any, ParamSpec, TypeVar, get_origin, get_type_hints

import numpy as np

from gimcli.errors import StructureError, UsageError, refuse
from gimcli.mechanism import MOST_TURNS, SPAN, FloatArray, Mechanism
from gimcli.nearest import guess
from gimcli.positions.inputs import driven
from gimcli.positions.options import JIT, METHODS, STRATEGIES
from gimcli.structure.drive_check import explained

MOST_STEPS = 10_000_000

ROUND = 1e-12
"""An input below this value, in rad or in lengths of the normal frame, is shown as 0."""

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True)
class Range:
    """Whole numbers from `least` to `most`, in the annotation of an argument."""

    least: int
    most: int

    def refuse(self, argument: str, value: int) -> None:
        """Raise UsageError if the value is not a whole number of the range."""
        refuse(
            (
                isinstance(value, bool) or not isinstance(value, int | np.integer)
                or not self.least <= value <= self.most,
                f"{argument}: expected a whole number from {self.least} to {self.most}, got {value}",
            )
        )  # fmt: skip


@dataclass(frozen=True)
class OneOf:
    """The words that an argument may have, in its annotation."""

    known: Iterable[str]

    def refuse(self, argument: str, value: str) -> None:
        """Raise UsageError if a word is not one of the known words."""
        refuse((value not in self.known, f"{argument}: expected one of {', '.join(self.known)}, got '{value}'"))


@dataclass(frozen=True)
class Number:
    """The real numbers that an argument may be, in its annotation: in words, and as a function."""

    words: str
    holds: Callable[[float], bool]

    def refuse(self, argument: str, value: float) -> None:
        """Raise UsageError if a number is another one."""
        refuse((not self.holds(value), f"{argument}: expected {self.words}, got {value:g}"))


Steps = Annotated[int, Range(1, MOST_STEPS)]
Time = Annotated[float, Number("a finite number", math.isfinite)]
Tolerance = Annotated[float, Number("a number from 1e-14 to below 1", lambda value: 1e-14 <= value < 1.0)]
Seed = Annotated[int, Range(0, 2**63)]
Jit = Annotated[str, OneOf(JIT)]
Method = Annotated[str, OneOf(METHODS)]
Strategy = Annotated[str, OneOf(STRATEGIES)]


def hints_of(verb: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of a verb's arguments by name; the result may have a type that is not imported."""
    own = {name: text for name, text in verb.__annotations__.items() if name != "return"}
    return get_type_hints(SimpleNamespace(__annotations__=own), verb.__globals__, include_extras=True)


@cache
def limits(verb: Callable[..., Any]) -> dict[str, Range | OneOf | Number]:
    """Return the ranges and words of a verb's arguments by name, from their annotations."""
    return {name: hint.__metadata__[0] for name, hint in hints_of(verb).items() if get_origin(hint) is Annotated}


def checked(verb: Callable[P, R]) -> Callable[P, R]:
    """Refuse arguments outside the ranges and words of a verb's annotations, and explain its errors (decorator).

    A mechanism that its inputs do not drive is then refused with the result of the mobility analysis. An argument that
    has its default is accepted.
    """

    @wraps(verb)
    def decorated(*args: P.args, **kwargs: P.kwargs) -> R:
        form = signature(verb)
        given = form.bind(*args, **kwargs).arguments
        for name, limit in limits(verb).items():
            if name in given and given[name] != form.parameters[name].default:
                limit.refuse(name, given[name])
        with explained(given["mechanism"]):
            return verb(*args, **kwargs)

    return decorated


def inputs_of(
    mechanism: Mechanism, at: Mapping[str, float | str] | None, by_name: Mapping[str, float | str],
    complete: bool = True,
) -> FloatArray:  # fmt: skip
    """Return the inputs (actuators,) in the normal frame: the start of every law, replaced by the given values.

    complete: also those that follow the linkage, as it reaches these inputs from the drawing; else they do not count.
    Raises UsageError for an unknown name, and for a value that the input cannot have.
    """
    values = driven(mechanism).start_inputs
    names = [a.name for a in mechanism.actuators]
    if at is not None and not isinstance(at, Mapping):
        name = next(iter(names), "motor")
        raise UsageError(f"at={at!r}: name the input: {name}={at!r} or at={{'{name}': {at!r}}}")
    for name, value in {**(at or {}), **by_name}.items():
        text = f"at {name}={value}"
        if name not in names:
            raise UsageError(f"{text}: no actuator '{name}'; {guess(name, names, 'actuators')}")
        refuse_follower(mechanism, names.index(name), text)
        values[names.index(name)] = _value(mechanism, names.index(name), text, value)
    if not (mechanism.couplings and complete):
        return mechanism.coupled(values)
    from gimcli.motion.linked_inputs import followed  # imported late: few mechanisms have coupled inputs

    return followed(mechanism, values)


def refuse_follower(mechanism: Mechanism, actuator: int, text: str, cure: str = "give the input of") -> None:
    """Raise UsageError if an actuator follows others, so that its input cannot be chosen."""
    if actuator in mechanism.drivers:
        return
    others = " and ".join(f"'{name}'" for name in leaders(mechanism, actuator))
    raise UsageError(f"{text}: '{mechanism.actuators[actuator].name}' follows {others}; {cure} that one")


def leaders(mechanism: Mechanism, actuator: int) -> list[str]:
    """Return the names of the inputs and members that an input follows."""
    found = next((c for c in mechanism.couplings if c.follower == actuator), None)
    if found is None:
        return []
    names = [mechanism.actuators[k].name for k, _ in found.terms]
    return names + [mechanism.members[row.members[0]].name for row, _ in found.reads]


def _value(mechanism: Mechanism, k: int, text: str, value: float | str) -> float:
    """Return an input in the normal frame; raise UsageError for a value that laws may not have either."""
    try:
        given = float(value)
    except (TypeError, ValueError):
        given = math.nan
    actuator, found = mechanism.actuators[k], float(mechanism.value_from_file(k, given))
    one, unit = (2.0 * math.pi, "turns") if actuator.rotary else (mechanism.size, "times the size of the mechanism")
    refuse(
        (not math.isfinite(given), f"{text}: expected a finite number, got '{value}'"),
        (actuator.kind == SPAN and found <= 0.0, f"{text}: expected a distance above 0"),
        (abs(found) > MOST_TURNS * one, f"{text}: expected a value of at most {MOST_TURNS:g} {unit}"),
    )
    return found


def in_file_units(mechanism: Mechanism, inputs: FloatArray, zero: float = 0.0) -> dict[str, float]:
    """Return inputs (actuators,) by name in the file's units; values up to `zero` in the normal frame become 0."""
    return mechanism.inputs_to_file(np.where(np.abs(inputs) > zero, inputs, 0.0) if zero else inputs)


def interval_of(low: Mapping[str, float], high: Mapping[str, float]) -> dict[str, list[float]]:
    """Return the smallest and the largest value of every input between two ends."""
    return {name: sorted([low[name], high[name]]) for name in low}


def refuse_unmoved(mechanism: Mechanism, cure: str) -> None:
    """Raise StructureError if a mechanism has no actuator, or only inputs that follow the linkage."""
    refuse(
        (not mechanism.drivers, f"{mechanism.name} has no actuator: nothing moves; {cure}"), error=StructureError
    )  # fmt: skip
