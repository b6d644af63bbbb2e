"""A mechanism with other dimensions: the same as an edit of its file, without reading the file again."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from numbers import Real
from typing import Any

from pydantic_core import SchemaValidator, ValidationError

from gimcli.errors import ModelError, UsageError
from gimcli.language.expression import Expression, ExpressionError
from gimcli.mechanism import Mechanism
from gimcli.model.arithmetic import DependenceError, is_number, parsed, reason, with_numbers
from gimcli.model.check import check
from gimcli.model.compile import compile_model, in_assembly_of
from gimcli.model.dimensions import Dimension, name_of
from gimcli.model.pairs import sized_nodes
from gimcli.model.references import References
from gimcli.model.schema import Model
from gimcli.model.source import Fault, Source, Where
from gimcli.model.units import SPEEDS, speed
from gimcli.model.wording import expected, value_schema

SHOWN = 4
"""Number of changed dimensions that a message lists."""


def changed(own: Any, mechanism: Mechanism, changes: Mapping[str, float | str]) -> Mechanism:
    """Return a mechanism, whose model as written is `own`, with other dimensions; see `Mechanism.with_`."""
    wanted = {own.dimension(name): value for name, value in changes.items()}
    if len(wanted) < len(changes):
        raise UsageError(f"{_listed(changes)}: two values for one dimension; give one")
    given = {dimension.where: _value(dimension, value, own.model) for dimension, value in wanted.items()}
    new = {one.name: v.text if isinstance(v, Expression) else v for one, v in zip(wanted, given.values(), strict=True)}
    source = _ChangedSource(**{**vars(own.source), "faults": []}, changes=new)
    try:
        model, numbers = with_numbers(own.model, given, source.number)
    except DependenceError as cycle:
        source.fault(("parameters", cycle.names[-1]), str(cycle))
        raise source.error() from None
    source.refuse(numbers)
    model = _placed(source, model) if model.open.parts else model
    check(References(source, model, sized_nodes(model)))
    if source.faults:
        raise source.error()
    compiled = in_assembly_of(compile_model(model, own.source.folder), mechanism, own.model)
    written = replace(own, model=model, changes={**own.changes, **new})
    return replace(compiled, files=mechanism.files, path=mechanism.path, written=written)


def _placed(source: _ChangedSource, model: Model) -> Model:
    """Return a model with new positions of its nodes without coordinates; raise ModelError if they do not exist."""
    from gimcli.model.placing import placed_anew

    model, faults = placed_anew(source, model)
    for fault in faults:
        source.fault(fault.at, fault.text.removeprefix(f"{fault.at[-1]} "))  # errors name the dimension
    if source.faults:
        raise source.error()
    return model


@dataclass
class _ChangedSource(Source):
    """Records the errors of changed dimensions by name instead of line and column."""

    changes: Mapping[str, float | str] = field(default_factory=dict)

    def fault(self, where: Where, text: str, key: bool = False) -> None:
        """Record an error at a part of the data."""
        self.faults.append(Fault(1, 1, f"{name_of(where)}: {text}"))

    def error(self) -> ModelError:
        """Return all recorded errors as one ModelError."""
        place = f"{self.path} with {_listed(self.changes)}"
        return ModelError([f"{place}: {fault.text}" for fault in dict.fromkeys(self.faults)])

    def number(self, where: Where, formula: Expression, values: Mapping[str, float]) -> float:
        """Return the value of a formula; raise ModelError if it has none."""
        try:
            return formula.number(values)
        except ExpressionError as error:
            self.fault(where, f"expected a number, got '{formula.text}'; {error}")
            raise self.error() from None

    def refuse(self, numbers: Mapping[Where, float]) -> None:
        """Raise ModelError for numbers outside the limits of their keys."""
        for where, value in numbers.items():
            try:
                _validator(where).validate_python(value)
            except ValidationError as error:
                for one in error.errors(include_url=False):
                    self.fault(where, expected(where, one["type"], value, one.get("ctx", {})))
        if self.faults:
            raise self.error()


@lru_cache(1024)
def _validator(where: Where) -> SchemaValidator:
    """Return the validator of a number."""
    return SchemaValidator(value_schema(where))


def _value(dimension: Dimension, value: Any, model: Model) -> float | Expression:
    """Return a new value of a dimension as a number, or a formula."""
    if isinstance(value, str):
        try:
            value = _read(dimension, value, model)
        except ValueError as error:
            text = reason(error, model.parameters)
            raise UsageError(f"{dimension.name}: expected a number, got '{value}'; {text}") from None
    if isinstance(value, Expression):
        return value
    if isinstance(value, int) and abs(value) > sys.float_info.max:
        value = math.inf
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise UsageError(f"{dimension.name}: expected a finite number, got {value!r}")
    return float(value)


def _read(dimension: Dimension, text: str, model: Model) -> float | Expression:
    """Return a number, the speed of an input with a unit, or a formula; raise ValueError for other texts."""
    if dimension.where[0] == "actuators" and dimension.where[-1] in SPEEDS:
        rotary = model.actuators[str(dimension.where[1])].rotary
        if (found := speed(text, rotary, model.units.length, model.units.angle)) is not None:
            return found
    return float(text) if is_number(text) else parsed(text, model.parameters)


def _listed(changes: Mapping[str, float | str]) -> str:
    shown = [f"{name} = {v if isinstance(v, str) else format(v, '.6g')}" for name, v in [*changes.items()][:SHOWN]]
    return ", ".join(shown) + ", ..." * (len(changes) > SHOWN)
