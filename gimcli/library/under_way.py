"""Results that are computed in parts: their rows can be written while they are computed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from functools import wraps
from inspect import signature
from typing import Generic, ParamSpec, TypeVar

from gimcli.library.result import joined
from gimcli.table import Table

P = ParamSpec("P")
Found = TypeVar("Found", covariant=True)


class UnderWay(ABC, Generic[Found]):
    """A result that is being computed: first the table of each part, then the result."""

    expected: int | None = None
    """Number of rows; None if it is not known before the end."""

    keeps = False
    """Whether the parts are kept, so that any quantity may be asked of all rows."""

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""

    @abstractmethod
    def tables(self) -> Iterator[Table]:
        """Yield the table of each part."""

    @abstractmethod
    def result(self, table: Table | None) -> Found:
        """Return the result, after all tables were read; `table` is None if they were written to a file."""

    def whole(self) -> Found:
        """Return the result with all rows."""
        self.keeps = True
        return self.result(joined(self.tables()))


def in_parts(begin: Callable[P, UnderWay[Found]]) -> Callable[P, Found]:
    """Return the verb whose result a function begins, which is its attribute `begin` (decorator)."""

    @wraps(begin)
    def verb(*args: P.args, **kwargs: P.kwargs) -> Found:
        return begin(*args, **kwargs).whole()

    form = signature(begin)
    own = form.replace(return_annotation=form.return_annotation.removeprefix("UnderWay[").removesuffix("]"))
    vars(verb).update(begin=begin, __signature__=own)
    return verb
