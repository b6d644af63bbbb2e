"""A model as written in its file: the places of its keys, its dimensions, and other values for them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from numbers import Real
from typing import Any

from pydantic_core import SchemaValidator, ValidationError

from gimcli.errors import ModelError, UsageError
from gimcli.mechanism import Mechanism
from gimcli.model import dimensions as named
from gimcli.model.arithmetic import DependenceError
from gimcli.model.check import check
from gimcli.model.compile import compile_model
from gimcli.model.dimensions import Dimension, dimensions_of, name_of
from gimcli.model.formula import Formula, FormulaError, is_number, parsed
from gimcli.model.references import References
from gimcli.model.schema import Model
from gimcli.model.source import Fault, Source, Where
from gimcli.model.substitution import substituted, with_numbers
from gimcli.model.wording import expected, value_schema
from gimcli.recording import FUNCTIONS, Recording

SHOWN = 4
"""Number of changed dimensions that a message lists."""


@dataclass(frozen=True)
class Written:
    """A model as written, and the places of its keys."""

    model: Model
    source: Source
    changes: Mapping[str, float | str] = field(default_factory=dict)  # of dimensions, by name, since it was read

    @cached_property
    def dimensions(self) -> dict[str, Dimension]:
        """The dimensions by name, parameters first."""
        return dimensions_of(self.model)

    def dimension(self, name: str) -> Dimension:
        """Return a dimension by its name; the name of a link stands for its length. Raise UsageError for others."""
        return named.found(self.dimensions, name)

    def substituted(self, changes: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]) -> Model:
        """Return the model with other dimensions, without any check; see `substitution.substituted`."""
        return substituted(self.model, changes, functions)

    def changed(self, mechanism: Mechanism, changes: Mapping[str, float | str]) -> Mechanism:
        """Return the mechanism of this model with other dimensions; see `Mechanism.with_`."""
        wanted = {self.dimension(name): value for name, value in changes.items()}
        if len(wanted) < len(changes):
            raise UsageError(f"{_listed(changes)}: two values for one dimension; give one")
        given = {dimension.where: _value(dimension, value, self.model) for dimension, value in wanted.items()}
        values = zip(wanted, given.values(), strict=True)
        own = {one.name: value.text if isinstance(value, Formula) else value for one, value in values}
        source = _ChangedSource(**{**vars(self.source), "faults": []}, changes=own)
        try:
            model, numbers = with_numbers(self.model, given, source.number)
        except DependenceError as cycle:
            source.fault(("parameters", cycle.names[-1]), str(cycle))
            raise source.error() from None
        source.refuse(numbers)
        check(References(source, model, ()))
        if source.faults:
            raise source.error()
        changes = {**self.changes, **own}
        compiled = compile_model(model, self.source.folder)
        written = Written(model, self.source, changes)
        return replace(compiled, files=mechanism.files, path=mechanism.path, written=written)

    def recorded(self, mechanism: Mechanism, names: Sequence[str]) -> tuple[Mechanism, Recording]:
        """Return the mechanism with recorded numbers as dimensions, in its normal frame, and the recording.

        The variables of the recording are the dimensions, in the file's units.
        """
        recording = Recording()
        changes = {name: recording.variable(self.dimension(name).value) for name in names}
        model = self.substituted(changes, FUNCTIONS)
        return compile_model(model, self.source.folder, (mechanism.origin, mechanism.scale)), recording

    def place(self, where: Where) -> str:
        """Return file and line of a part, or its path of keys if the model was not read from a file."""
        if not self.source.by_line:
            return f"{self.source.path}: {'.'.join(map(str, where))}" if where else str(self.source.path)
        while where and where not in self.source.keys:
            where = where[:-1]
        line, _ = self.source.keys.get(where, (1, 1))
        return f"{self.source.path}:{line}"

    def member(self, name: str) -> Where:
        """Return the path of a member's key."""
        return ("ground",) if name == "ground" else ("links" if name in self.model.links else "elements", name)


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

    def number(self, where: Where, formula: Formula, values: Mapping[str, float]) -> float:
        """Return the value of a formula; raise ModelError if it has none."""
        try:
            return formula.number(values)
        except FormulaError as error:
            self.fault(where, f"expected a number, got '{formula.text}'; {error}")
            raise self.error() from None

    def refuse(self, numbers: Mapping[Where, float]) -> None:
        """Raise ModelError for numbers outside the limits of their keys."""
        for where, value in numbers.items():
            try:
                _validator(where).validate_python(value)
            except ValidationError as error:
                for one in error.errors(include_url=False):
                    limits = one.get("ctx", {})
                    self.fault(where, expected(where, one["type"], value, limits))
        if self.faults:
            raise self.error()


@lru_cache(1024)
def _validator(where: Where) -> SchemaValidator:
    """Return the validator of a number."""
    return SchemaValidator(value_schema(where))


def _value(dimension: Dimension, value: Any, model: Model) -> float | Formula:
    """Return a new value of a dimension as a number, or a formula."""
    if isinstance(value, str):
        try:
            value = float(value) if is_number(value) else parsed(value, model.parameters)
        except FormulaError as error:
            raise UsageError(f"{dimension.name}: expected a number, got '{value}'; {error}") from None
    if isinstance(value, Formula):
        return value
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise UsageError(f"{dimension.name}: expected a finite number, got {value!r}")
    return float(value)


def _listed(changes: Mapping[str, float | str]) -> str:
    shown = [f"{name} = {v if isinstance(v, str) else format(v, '.6g')}" for name, v in [*changes.items()][:SHOWN]]
    return ", ".join(shown) + ", ..." * (len(changes) > SHOWN)
