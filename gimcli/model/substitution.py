"""Other numbers in a model: the same as an edit of its file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from gimcli.language.expression import Expression
from gimcli.model.arithmetic import PARAMETERS, in_order
from gimcli.model.part import Part
from gimcli.model.schema import DYNAMIC, Law, Model
from gimcli.model.source import Where

Evaluate = Callable[[Where, Expression, Mapping[str, Any]], Any]


def without_dynamics(model: Model) -> Model:
    """Return a model without the parts on which positions do not depend."""
    for section in DYNAMIC:
        model = model.with_value(section, lambda _: {})
    return model.with_value(
        "actuators", lambda old: {name: one.with_value("rotor", lambda _: None) for name, one in old.items()}
    )


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
