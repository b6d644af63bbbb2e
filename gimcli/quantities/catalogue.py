"""The quantities of a mechanism by name: what may be kept, plotted, compared, and asked of any result."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.errors import UsageError, refuse
from gimcli.language.arrays import ARRAYS, strict
from gimcli.language.expression import Expression, ExpressionError, PartKind
from gimcli.language.reader import ExpressionReader, KnownNames
from gimcli.mechanism import FRAME, Mechanism
from gimcli.nearest import guess
from gimcli.quantities.coordinates import LETTERS, TURNING, MemberTurning, PointVector, RowValue
from gimcli.quantities.forces import ForceQuantity, force_quantities, no_forces
from gimcli.quantities.kinds import KINDS, quantities_of
from gimcli.quantities.quantity import Head, Item, Quantity
from gimcli.quantities.state import State
from gimcli.structure.derived import derived

LISTED = 12
"""Number of names that the message for an unknown name lists."""

SHORT = {
    "stroke": "range({})",
    "time_ratio": "max(abs(argmax({0}) - argmin({0})), {1} - abs(argmax({0}) - argmin({0})))"
    " / min(abs(argmax({0}) - argmin({0})), {1} - abs(argmax({0}) - argmin({0})))",
    "worst_transmission": "min(min(transmission), {1} / 2 - max(transmission))",
}
"""Short names of numbers of a motion: of a column, such as stroke:P.x, or a member; {1} is a full turn.

The time ratio is that of the slower and the faster stroke in one turn of the input, at constant speed.
"""


class Catalogue(KnownNames):
    """The quantities of a mechanism, as names of expressions."""

    what = "column or measure"
    words: Sequence[str] = ()
    """Names that come first in a message."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.points = tuple(dict.fromkeys([*mechanism.traced, *(p.name for p in mechanism.points), *mechanism.nodes]))
        self.members = {m.name: k for k, m in enumerate(mechanism.members) if k != FRAME}
        self.rows = {"step": "", "time": "s", "residual": ""}
        self.rows |= {a.name: mechanism.unit_of(a) for a in mechanism.actuators}
        self._known: dict[str, tuple[Item, ...]] = {}
        self._named: dict[str, Expression | None] = {}

    @property
    def columns(self) -> Iterator[str]:
        """The names of all columns but those of kinds with arguments."""
        yield from self.rows
        yield from (f"{name}.{letter}{axis}" for name in self.points for letter in LETTERS for axis in "xy")
        yield from (f"{name}.{word}" for name in self.members for word in TURNING)
        yield from (head.name for one in self.forces for head in one.heads)

    @cached_property
    def forces(self) -> tuple[ForceQuantity, ...]:
        """The quantities of forces."""
        return tuple(force_quantities(self.mechanism))

    def find(self, name: str) -> tuple[Item, ...]:
        """Return the column with a name, or the columns of a point, a vector such as P.v or a kind; () if unknown."""
        if name not in self._known:
            self._known[name] = tuple(self._found(name))
        return self._known[name]

    def column(self, name: str) -> Item | None:
        """Return the one column with a name; None if there is none."""
        return next((item for item in self.find(name) if item.head.name == name), None)

    def named(self, name: str) -> Expression | None:
        """Return the expression that a name of the file, or a short name, stands for; None for others.

        Raises UsageError for an expression that is not valid.
        """
        if name not in self._named:
            text, word, column = self.mechanism.quantities.get(name), *name.partition(":")[::2]
            one = column in self.members or bool(self.find(column)) or not set(column) & set(" ()+-*/<>=!,|")
            if text is None and word in SHORT and one and bool(column) == (word != "worst_transmission"):
                turn = 360.0 if self.mechanism.angle_unit == "deg" else 2.0 * np.pi
                own = f"{column}.angle" if column in self.members else column
                text = SHORT[word].format(own, turn)
                if column in self.points and word == "stroke":
                    text = f"hypot(range({column}.x), range({column}.y))"
            if text is not None:
                self._named[name] = Expression(name, (), PartKind("itself"))  # until it is read
            self._named[name] = None if text is None else self.expression(text, f"quantity {name}")
        return self._named[name]

    def expression(self, text: str, where: str) -> Expression:
        """Return the expression of a text; raise UsageError, which begins with `where`, if it is none."""
        try:
            return ExpressionReader(text, self).whole()
        except (ExpressionError, UsageError) as error:
            raise UsageError(str(error) if str(error).startswith(where) else f"{where} '{text}': {error}") from None

    def is_number(self, text: str) -> bool:
        """Return whether a text is an expression with one value for a whole motion, such as range(P.y)."""
        if text in self.members or self.find(text):
            return False
        with suppress(UsageError):
            return self.expression(text, "").kind.what == "number"
        return "(" in text  # its reader has the reason

    def number(self, text: str, state: State) -> float:
        """Return the value of a text that is a number of a motion; raise UsageError if it is none."""
        own = self.expression(text, "quantity")
        state.swept()
        columns = {name: self.columns_in(state, name)[..., None, :] for name in own.names}  # those of one design
        with np.errstate(all="ignore"):
            return float(np.ravel(own.value(columns, strict(state.lacks)))[0])

    def columns_in(self, state: State, name: str) -> Any:
        """Return the column with a name in a state (..., rows), or several (columns, ..., rows)."""
        found = [state.value(*item) for item in self.find(name)]
        return np.stack(found) if len(found) > 1 else found[0]

    def asked(self, text: str) -> tuple[Item, ...]:
        """Return the columns of a text: a name, a kind such as "centre:rod/rocker", or an expression.

        Raises UsageError for other texts, and for what has one value for the whole motion.
        """
        found = self.find(text)
        if not found and text.partition(":")[0] in KINDS and not set(text) & set(" ()+*"):
            found = tuple(item for one in quantities_of(self.mechanism, text) for item in _items(one))  # or the reason
        if found:
            return found
        own = self.expression(text, "measure")
        refuse(
            (
                own.kind.what != "rows" or own.reduces,
                f"measure '{text}': expected a column, with a value for each row, such as hypot(P.x, P.y); `gim trace"
                " --plot` and `gim sweep --keep` have numbers of a motion",
            ),
            (
                own.kind.columns > 1,
                f"measure '{text}': it has {own.kind.columns} columns; name one of them, or write |{text}|",
            ),
        )
        return tuple(_items(Formula(self, own)))

    # -- the names of expressions ------------------------------------------------------------------------

    def kind(self, name: str) -> PartKind:
        """Return what a name stands for: one or several columns, or an expression."""
        items = () if name in self.mechanism.quantities else self.find(name)
        if items:
            return PartKind("rows", items[0].head.unit, len(items))
        own = self.named(name)
        if own is not None and own.kind.what == "itself":
            raise UsageError(f"'{name}' depends on itself")
        return PartKind("") if own is None else own.kind

    def code(self, name: str) -> Sequence[Any]:
        """Return the code of a name: the name itself, or the expression that it is short for."""
        own = self.named(name) if name in self.mechanism.quantities or not self.find(name) else None
        return (name,) if own is None else own.code

    def across(self) -> tuple[str, str]:
        """Return name and unit of the only independent input, or of the time."""
        drivers = self.mechanism.drivers
        name = self.mechanism.actuators[drivers[0]].name if len(drivers) == 1 else "time"
        return name, self.rows[name]

    def unknown(self, name: str, rest: str = "") -> UsageError:
        """Return the error for an unknown name, with a similar one."""
        kind, colon, _ = name.partition(":")
        if kind in KINDS:
            try:
                quantities_of(self.mechanism, name)
            except UsageError as error:
                return error
        words = [*self.words, *self.mechanism.quantities, *KINDS, *self.columns]
        near = guess(kind, KINDS) if colon else no_forces(self.mechanism, name) or guess(name, words, most=LISTED)
        if f"{name}.length" in self.words:
            near = f"did you mean '{name}.length'?"
        elif name in self.members:
            near = f"did you mean '{name}.angle'?"
        return UsageError(f"no {self.what} '{name}'; {near}")

    def refuse_value(self, name: str, value: float) -> None:
        """Raise UsageError: a column has all rows."""
        raise UsageError(f"at({name}={value:g}) is one row, a column has all of them; `gim sweep --keep` has it")

    # -- names -------------------------------------------------------------------------------------------

    def _found(self, name: str) -> Iterator[Item]:
        head, _, tail = name.rpartition(".")
        if name in self.rows:
            yield Item(RowValue(name, self.rows[name]), 0)
        elif head in self.members and tail in TURNING:
            yield Item(MemberTurning(self.mechanism, self.members[head], TURNING.index(tail)), 0)
        elif head in self.points and tail[-1:] in ("x", "y") and tail[:-1] in LETTERS:
            vector = PointVector(self.mechanism, head, LETTERS.index(tail[:-1]))
            yield Item(vector, "xy".index(tail[-1]))
        elif name in self.points or (head in self.points and tail in LETTERS[1:]):
            order = 0 if name in self.points else LETTERS.index(tail)
            yield from _items(PointVector(self.mechanism, name if not order else head, order))
        elif name.partition(":")[0] in KINDS:
            yield from self._of_kind(name)
        elif name in self.mechanism.quantities:
            own = self.named(name)
            if own is not None and own.kind.what == "rows" and own.kind.columns == 1 and not own.reduces:
                yield Item(Formula(self, own, name), 0)
        else:
            vectors = [one for one in self.forces if one.own.vector and one.spec in (name, f"{name}.f")]
            alone = [item for one in self.forces for item in _items(one) if item.head.name == name]
            yield from alone or [item for one in vectors[:1] for item in _items(one)]

    def _of_kind(self, name: str) -> Iterator[Item]:
        """Yield the columns of a kind with arguments, such as centre:a/b, or the one with this name."""
        parts = name.split(".")
        for k in range(len(parts), 0, -1):
            try:
                items = [item for one in quantities_of(self.mechanism, ".".join(parts[:k])) for item in _items(one)]
            except UsageError:
                continue
            exact = [item for item in items if item.head.name == name]
            yield from exact or (items if k == len(parts) else [])
            return


class Formula(Quantity):
    """An expression of columns, with one value for each row."""

    def __init__(self, known: Catalogue, expression: Expression, name: str = "") -> None:
        self.known, self.expression, self.spec = known, expression, name or expression.text
        self.heads = (Head(self.spec, expression.kind.unit or "", self.spec),)

    def values(self, state: State) -> Sequence[Any]:
        """Return the value of each row."""
        columns = {name: self.known.columns_in(state, name) for name in self.expression.names}
        return [self.expression.value(columns, ARRAYS)]


@derived
def catalogue(mechanism: Mechanism) -> Catalogue:
    """Return the quantities of a mechanism."""
    return Catalogue(mechanism)


def _items(quantity: Quantity) -> Iterator[Item]:
    return (Item(quantity, k) for k in range(len(quantity.heads)))


def refuse_names(mechanism: Mechanism) -> None:
    """Raise ModelError for quantities of the file that repeat a name, are no expressions, or depend on themselves."""
    own, plain = catalogue(mechanism), Catalogue(replace(mechanism, quantities={}))
    source = mechanism.written.source
    for name in mechanism.quantities:
        if plain.find(name) or plain.named(name) or name in (*plain.points, *plain.members):
            source.fault(
                ("quantities", name), f"'{name}' is already the name of a part or a column; choose another", True
            )
            continue
        try:
            own.named(name)
        except UsageError as error:
            source.fault(("quantities", name), str(error))
    if source.faults:
        raise source.error()
