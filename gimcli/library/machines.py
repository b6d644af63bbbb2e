"""The results of independent machines of one file as one result."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, wraps
from inspect import signature
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np

from gimcli import output
from gimcli.errors import GimError, UsageError, refuse
from gimcli.library.inputs import checked, inputs_of, refuse_follower, refuse_unmoved
from gimcli.library.result import Result, UnderWay, joined
from gimcli.mechanism import Machine, Mechanism
from gimcli.nearest import guess
from gimcli.progress import limited
from gimcli.table import Column, Table


def released_inputs(mechanism: Mechanism, free: str | Sequence[str]) -> tuple[int, ...]:
    """Return the numbers of the released inputs, in the order of the file; inputs that follow others move with them.

    Args:
        mechanism: the mechanism.
        free: names of further inputs that are released, a list or a text with commas.

    Raises:
        UsageError: an unknown name; or several inputs of which none is free in the file or named.
        StructureError: the mechanism has no actuator.
    """
    refuse_unmoved(mechanism, "add an actuator")
    names = [mechanism.actuators[k].name for k in mechanism.drivers]
    wanted = names_of(free)
    for name in wanted:
        if name not in names:
            every = [actuator.name for actuator in mechanism.actuators]
            if name in every:
                refuse_follower(mechanism, every.index(name), f"free {name}", "release")
            raise UsageError(f"free {name}: no actuator '{name}'; {guess(name, names, 'actuators')}")
    own = {r.actuator for r in mechanism.dynamics.releases if r.free and r.actuator in mechanism.drivers}
    own |= {mechanism.drivers[names.index(name)] for name in wanted}
    if not own and len(names) == 1:
        return mechanism.drivers
    refuse(
        (
            not own,
            f"free: {mechanism.name} has {len(names)} inputs and none is free; name those that are released, such as"
            f" {names[0]} (the others are held), or write `free: true` at one of {', '.join(names)}",
        )
    )
    return tuple(sorted(own))


def names_of(free: str | Sequence[str]) -> list[str]:
    """Return the names of a list, or of a text with commas."""
    given = [free] if isinstance(free, str) else list(free)
    return [name.strip() for text in given for name in text.split(",") if name.strip()]


SHARED = ("steps", "samples", "duration")
"""Keys of reports whose values are the same for all machines."""

SAME = ("dimensions",)
"""Keys of reports with entries that are the same for all machines that have them."""

OF_ALL = ("table", "arrays", "report", "workbook")
"""Contents of files that hold all machines; of the others each machine has a file of its own."""


P = ParamSpec("P")
R = TypeVar("R")


class MachinesResult(Result):
    """The results of several machines: `each` by name; the report and the table have those of all machines."""

    def __init__(self, mechanism: Mechanism, each: Mapping[str, Result], table: Table | None = None) -> None:
        self.mechanism, self.each, self._table = mechanism, each, table
        self.limited = any(one.limited for one in each.values())
        self.destinations = next(iter(each.values())).destinations  # type: ignore[method-assign]  # of their class

    def __getattr__(self, name: str) -> Any:
        """Return dicts of the results, such as `statistics`, as one; names that several have follow that of theirs."""
        values = {} if name.startswith("_") else {key: getattr(one, name) for key, one in vars(self)["each"].items()}
        if not values or not all(isinstance(value, dict) for value in values.values()):
            raise AttributeError(f"of several machines '{name}' is an attribute of each: .each[NAME].{name}")
        return _joined(name, values)

    @cached_property
    def inputs(self) -> dict[str, Any]:
        """The inputs of all machines: of the rows (rows,), or those of all rows of a machine."""
        own = self.__getattr__("inputs")
        return super().inputs if any(isinstance(one, np.ndarray) for one in own.values()) else own

    @property
    def complete(self) -> bool:
        """Whether nothing is missing of any machine."""
        return all(one.complete for one in self.each.values())

    @property
    def answered(self) -> bool:
        """Whether everything was found of all machines."""
        return all(one.answered for one in self.each.values())

    @property
    def events(self) -> list[dict[str, Any]]:
        """The events of all machines, each with the name of its machine."""
        return [{**event, "machine": name} for name, one in self.each.items() for event in one.events]

    def by_machine(self) -> dict[str, Result]:
        """Return the results by the names of their machines."""
        return dict(self.each)

    def headline(self) -> str:
        """Return the result in one line."""
        own = (f"{name}: {one.headline().partition(': ')[2]}" for name, one in self.each.items())
        return f"{self.mechanism.name}: {'; '.join(own)}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints: that of each machine, and all of them joined."""
        reports = {name: one.report() for name, one in self.each.items()}
        return joined_reports(reports) | {"machines": [{"name": name, **own} for name, own in reports.items()]}

    def table(self) -> Table:
        """Return the rows of all machines, with their names; cells that a machine does not have are empty."""
        if self._table is None:
            own = [one.table() for one in self.each.values()]
            self._table = joined(widened(own, list(self.each)))
        return self._table

    def contents(self, paths: Iterable[Path]) -> dict[Path, Any]:
        """Return the content of each file; pictures and pages are one file for each machine, with its name."""
        found: dict[Path, Any] = {}
        for path in paths:
            if output.format_of(path).content in OF_ALL:
                found |= super().contents([path])
            else:
                for name, one in self.each.items():
                    found |= one.contents([path.with_name(f"{path.stem}.{name.replace('/', '_')}{path.suffix}")])
        return found


def for_each_machine(
    machines: Callable[[Mechanism, dict[str, Any]], Sequence[Machine]] = lambda mechanism, _: mechanism.driven_machines,
    own: Callable[[Mechanism, dict[str, Any]], dict[str, Any]] = lambda _, given: given,
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator of verbs: of several machines the verb is applied to each, which gives a MachinesResult.

    The arguments are `checked`.
    `machines` returns them from the mechanism and the other arguments, `own` the arguments of one of them. Of the
    inputs `at`, the others by name and `free` each machine gets its own.
    """

    def decorate(verb: Callable[P, R]) -> Callable[P, R]:
        single = checked(verb)

        @wraps(verb)
        def decorated(*args: P.args, **kwargs: P.kwargs) -> R:
            given: dict[str, Any] = dict(signature(verb).bind(*args, **kwargs).arguments)
            mechanism = given.pop("mechanism")
            if len(mechanism.machines) == 1:
                return single(*args, **kwargs)
            parts, applied = _parts(mechanism, given, machines, own), cast(Any, single)
            with limited(seconds=given.get("seconds")):  # all together
                each = {one.name: applied(one.mechanism, **part) for one, part in parts}
            return cast(R, next(iter(each.values())) if len(each) == 1 else MachinesResult(mechanism, each))

        return decorated

    return decorate


def _parts(
    mechanism: Mechanism, given: dict[str, Any], machines: Callable[..., Sequence[Machine]], own: Callable[..., Any]
) -> Iterator[tuple[Machine, dict[str, Any]]]:
    """Yield the machines, each with its own arguments of a verb."""
    at, inputs, free = given.pop("at", None), given.pop("inputs", {}), given.get("free")
    inputs_of(mechanism, at, inputs)  # refuses names that no machine has
    values = {**(at or {}), **inputs}
    for one in machines(mechanism, given):
        names = {a.name for a in one.mechanism.actuators}
        part = dict(own(one.mechanism, given))
        if values:
            part["at"] = {name: value for name, value in values.items() if name in names}
        if free:
            part["free"] = [name for name in names_of(free) if name in names]
        yield one, part


def accepted(find: Callable[..., Any], *args: Any) -> bool:
    """Return whether a function accepts its arguments, without an error that the user would read."""
    with suppress(GimError):
        find(*args)
        return True
    return False


def loaded_machines(mechanism: Mechanism, _: object = None) -> Sequence[Machine]:
    """Return the machines on which forces act, those with inputs first; the first one if there are none.

    Raise StructureError for other parts that can move.
    """
    driven_machines(mechanism)
    every = sorted(mechanism.loaded_machines, key=lambda one: not one.actuators)
    return [one for one in every if not one.mechanism.dynamics.empty] or every[:1]


def released_machines(mechanism: Mechanism, given: dict[str, Any]) -> list[Machine]:
    """Return the machines with released inputs; the others are held. Raise StructureError for parts that can move."""
    driven_machines(mechanism)
    released = {*released_inputs(mechanism, given.get("free", ()))}
    return [one for one in mechanism.loaded_machines if released & {*one.actuators}]


def driven_machines(mechanism: Mechanism, _: object = None) -> list[Machine]:
    """Return the machines that inputs drive; raise StructureError for other parts that can move."""
    for one in mechanism.machines:
        if not one.actuators:
            from gimcli.structure.mobility import require_driven

            require_driven(one.mechanism)
    return [one for one in mechanism.machines if one.actuators]


class MachineTables(UnderWay[MachinesResult]):
    """The traces of machines that are computed one after the other: first the tables, then the result."""

    def __init__(self, mechanism: Mechanism, begun: dict[str, Any]) -> None:
        self.mechanism, self.begun = mechanism, begun
        self.expected = sum(one.expected for one in begun.values())

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return next(iter(self.tables())).names

    def tables(self) -> Iterator[Table]:
        """Yield the table of each machine, with all columns."""
        yield from widened([joined(one.tables()) for one in self.begun.values()], list(self.begun))

    def result(self, table: Table | None) -> MachinesResult:
        """Return the result, after all tables were read."""
        each = {name: one.result(joined(one.tables())) for name, one in self.begun.items()}
        return MachinesResult(self.mechanism, each, table)


def joined_reports(reports: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the reports of machines, by name, as one: lists and dicts joined, counts added, flags if all have them."""
    keys = dict.fromkeys(key for own in reports.values() for key in own)
    return {key: _joined(key, {name: own[key] for name, own in reports.items() if key in own}) for key in keys}


def _joined(key: str, values: dict[str, Any]) -> Any:
    known = [value for value in values.values() if value is not None]
    if not known or key in SHARED:
        return known[0] if known else None
    if isinstance(known[0], list):
        return [
            {**one, "machine": name} if isinstance(one, dict) else one
            for name, ones in values.items() for one in ones or ()
        ]  # fmt: skip
    if isinstance(known[0], dict):
        counts = Counter(k for one in known for k in one if key not in SAME)
        return {
            k if counts[k] < 2 else f"{name}.{k}": v for name, own in values.items() for k, v in (own or {}).items()
        }  # fmt: skip
    if isinstance(known[0], str):
        return "; ".join(dict.fromkeys(one for one in known if one != "ok")) or "ok"
    return all(known) if isinstance(known[0], bool) else sum(known) if isinstance(known[0], int) else max(known)


def widened(tables: Sequence[Table], names: Sequence[str]) -> list[Table]:
    """Return tables with the columns of all of them, empty where they have none, after a column with their names."""
    kinds = {c.name: c for table in tables for c in table.columns}
    found = []
    for table, name in zip(tables, names, strict=True):
        columns = [Column("machine", np.full(len(table), name))]
        for head, other in kinds.items():
            empty: Any = np.full(len(table), "" if other.values.dtype.kind == "U" else np.nan)
            columns.append(Column(head, table[head] if head in table.names else empty, other.unit))
        found.append(Table(tuple(columns)))
    return found
