"""Formulas of a model file: text in place of a number, such as `2*a + 3` with the parameter `a`, and its value."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from graphlib import CycleError, TopologicalSorter
from typing import Any

from gimcli.errors import refuse
from gimcli.language.expression import CONSTANTS, FUNCTIONS, Expression, ExpressionError, PartKind
from gimcli.language.reader import NAMED, SIGNED, WORD, ExpressionReader, KnownNames
from gimcli.model.part import Part
from gimcli.model.schema import Law, Model
from gimcli.model.source import Where, part_of
from gimcli.model.units import SPEEDS, speed
from gimcli.nearest import near

MOST_PARAMETERS = 1000
MOST_HINTS = 20
"""Most unknown names for which a similar one is searched: the search is slow."""
PARAMETERS = "parameters"

Evaluate = Callable[[Where, Expression, Mapping[str, Any]], Any]

WORDS = (*FUNCTIONS, *CONSTANTS)
"""Words that are no parameters."""

_UNIT = re.compile(r"[-+]?[\d.]+\s*([^\W\d]+)$")


def evaluated(
    data: dict[str, Any], texts: Iterable[Where]
) -> tuple[dict[str, Any], dict[Where, Expression], dict[Where, str]]:
    """Evaluate the texts at some paths of the data, which is not changed.

    Returns:
        Plain data with numbers in place of formulas, the formulas by path, and the texts without a value with the
        reason; this is empty if a parameter in the formula is refused itself.
    """
    data = copied(data)
    names = data[PARAMETERS] if isinstance(data.get(PARAMETERS), dict) else {}
    formulas, refused = dict[Where, Expression](), dict[Where, str]()
    for where in texts:
        try:
            if (rate := _speed(data, where)) is None:
                formulas[where] = _formula(part_of(data, where), names)
            else:
                part_of(data, where[:-1])[where[-1]] = rate
        except ValueError as error:
            refused[where] = reason(error, names if len(refused) < MOST_HINTS else ())
    values = {name: float(v) for name, v in names.items() if type(v) in (int, float) and math.isfinite(v)}
    for where in _ordered(formulas, refused):
        formula = formulas[where]
        if not formula.names <= set(values):
            refused[where] = ""  # the fault of a parameter, which is recorded there
            continue
        try:
            value = formula.number(values)
        except ExpressionError as error:
            refused[where] = str(error)
            continue
        part_of(data, where[:-1])[where[-1]] = value
        if where[0] == PARAMETERS:
            values[str(where[1])] = value
    return data, {where: formulas[where] for where in _ordered(formulas, refused)}, refused


def copied(data: Any) -> Any:
    """Return plain data with its own dicts and lists."""
    if isinstance(data, dict):
        return {name: copied(value) for name, value in data.items()}
    return [copied(value) for value in data] if isinstance(data, list) else data


def in_order(formulas: Mapping[Where, Expression]) -> tuple[Where, ...]:
    """Return the paths of formulas in an order in which they can be evaluated; raise ExpressionError for a cycle."""
    own = {str(where[1]): formula for where, formula in formulas.items() if where[0] == PARAMETERS}
    graph = {name: sorted(formula.names & own.keys()) for name, formula in own.items()}
    try:
        order = tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        raise DependenceError(error.args[1]) from None
    return (*((PARAMETERS, name) for name in order), *(where for where in formulas if where[0] != PARAMETERS))


class DependenceError(ExpressionError):
    """Parameters that depend on each other: each on the one before it, and the first on the last, which is the same."""

    def __init__(self, names: list[str]) -> None:
        super().__init__(f"{names[0]} depends on itself: {' -> '.join(names[::-1])}")
        self.names = names[1:]


def reason(error: ValueError, names: Collection[str]) -> str:
    """Return the text of an error, with the name among `names` that was probably meant."""
    if isinstance(error, UnknownNameError):
        return f"{error}{near(error.word, names) or near(error.word, WORDS)}"
    return str(error)


def _ordered(formulas: Mapping[Where, Expression], refused: dict[Where, str]) -> tuple[Where, ...]:
    """Return the paths of formulas that are not refused in the order of evaluation; refuse those of cycles."""
    while True:
        left = {where: formula for where, formula in formulas.items() if where not in refused}
        try:
            return in_order(left)
        except DependenceError as cycle:
            refused.update({(PARAMETERS, name): "" for name in cycle.names})
            refused[PARAMETERS, cycle.names[-1]] = str(cycle)


def _speed(data: dict[str, Any], where: Where) -> float | None:
    """Return the number of the file for a speed of an input with a unit, such as 60 rpm; None for other texts.

    Raises ValueError for a unit that the input does not have.
    """
    if where[0] != "actuators" or where[-1] not in SPEEDS:
        return None
    units = data["units"] if isinstance(data.get("units"), dict) else {}
    own, text = part_of(data, where[:2]), part_of(data, where)
    length, angle = str(units.get("length", "m")), str(units.get("angle", "deg"))
    if not {"pivot", "arm", "nodes", "node", "guide"} & set(own):  # an error of its own: both kinds are possible
        with suppress(ValueError):
            return speed(text, True, length, angle)
    return speed(text, "pivot" in own or "arm" in own, length, angle)


def _formula(text: str, names: Mapping[str, Any]) -> Expression:
    unit = _UNIT.match(text.strip())
    refuse(
        (unit is not None and unit[1] not in names, "set units once, under `units:`"),
        (is_number(text), "write it without quotes"),
        (len(names) > MOST_PARAMETERS,
         f"{len(names)} parameters are too many for formulas; at most {MOST_PARAMETERS} are read"),
        error=ExpressionError,
    )  # fmt: skip
    return parsed(text, names)


# -- other numbers in a model ----------------------------------------------------------------


def with_numbers(model: Model, wanted: Mapping[Where, Any], evaluate: Evaluate) -> tuple[Model, dict[Where, Any]]:
    """Return a model with other numbers or formulas at some paths, and all numbers that were replaced."""
    formulas = {where: formula for where, formula in model.formulas.items() if where not in wanted}
    new = {where: value for where, value in wanted.items() if isinstance(value, Expression)}
    if new:
        merged = {**formulas, **new}
        formulas = {where: merged[where] for where in in_order(merged)}
    numbers = {where: value for where, value in wanted.items() if where not in new}
    values: dict[str, Any] = {**model.parameters, **{str(w[1]): v for w, v in numbers.items() if w[0] == PARAMETERS}}
    changed = {str(where[1]) for where in wanted if where[0] == PARAMETERS}
    for where, formula in formulas.items():
        if where in new or not changed.isdisjoint(formula.names):
            numbers[where] = evaluate(where, formula, values)
            if where[0] == PARAMETERS:
                values[str(where[1])] = numbers[where]
                changed.add(str(where[1]))
    for where, value in numbers.items():
        model = _with(model, where, value)
    model.formulas = formulas
    return model, numbers


def _with(part: Any, where: Where, value: Any) -> Any:
    """Return a copy of a part with another value at a path; everything beside the path is shared."""
    if not where:
        return value
    key, rest = where[0], where[1:]
    if part is None:
        part = Law()  # of an actuator: the only mapping that may be absent
    if isinstance(part, Part):
        return part.with_value(str(key), lambda old: _with(old, rest, value))
    copy = part.copy()
    copy[key] = _with(copy[key], rest, value)
    return copy


# -- one formula ----------------------------------------------------------------------------


class UnknownNameError(ExpressionError):
    """A word in a formula of a model file that is not a parameter."""

    def __init__(self, word: str) -> None:
        super().__init__(f"'{word}' is not a parameter")
        self.word = word


class Parameters(KnownNames):
    """The parameters of a model file: words that stand for numbers."""

    def __init__(self, names: Mapping[str, Any]) -> None:
        self.names = names

    def longest(self, text: str) -> str:
        """Return the parameter with which a text begins; "" if it begins with none."""
        word = WORD.match(text)
        return word[0] if word is not None and word[0] in self.names and word[0] not in WORDS else ""

    def kind(self, name: str) -> PartKind:
        """Return that every parameter is a number."""
        return PartKind("number")

    def unknown(self, word: str, rest: str) -> Exception:
        """Return the error for a word that is not a parameter."""
        return UnknownNameError(found[0] if (found := WORD.match(word)) else word)


def is_name(word: str) -> bool:
    """Return whether a word can be the name of a parameter."""
    return WORD.fullmatch(word) is not None and word not in WORDS


def is_number(text: str) -> bool:
    """Return whether a text is a number, not a formula."""
    return SIGNED.fullmatch(text) is not None


def parsed(text: str, names: Mapping[str, Any]) -> Expression:
    """Return a formula of a model file with parameters among `names`; raise ExpressionError if it is none."""
    found = ExpressionReader(text, Parameters(names)).whole()
    if found.kind.what != "number":
        raise ExpressionError(f"expected a number, got {NAMED[found.kind.what]}")
    return found
