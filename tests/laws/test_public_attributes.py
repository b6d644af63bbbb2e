"""What results have in public is plain data, results, mechanisms, or in the manual's page on Python."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import pytest
from bundled import MANUAL
from package_source import modules, nodes
from verbs import CALLS, OTHERS, result

import gimcli
from gimcli import Mechanism
from gimcli.library.result import Result

MORE: dict[str, Any] = {
    "check of machines": lambda: gimcli.check("floating_hexagon"),
    "circuit": lambda: gimcli.trace("crank_rocker", 8, circuit=True),
    "graphs": lambda: gimcli.trace("crank_rocker", 8, derivatives=2, measure="transmission", plot="P.vx"),
    "fit of targets": lambda: gimcli.fit(
        "crank_rocker", {"crank.length": (38, 42)}, gimcli.trace("crank_rocker", 6).xy["P"][1:4], starts=1
    ),
    "statistics": lambda: gimcli.forces("engine", 24, measure="hypot(O.fx, O.fy)"),
    "grid": lambda: gimcli.workspace("five_bar", grid=3),
    "history": lambda: gimcli.solve("crank_rocker", method="gim", history=True),
    "machines": lambda: gimcli.trace("floating_hexagon", 4),
    "positions": lambda: gimcli.solve("crank_rocker", motor=[0, 30]),
    "reactions": lambda: gimcli.simulate("swing", 0.01, reactions=True),
    "rows": lambda: gimcli.sweep("crank_rocker", {"crank.length": [39, 41]}, steps=4, goal="max(P.y)", best=1),
    "spread": lambda: gimcli.sensitivity("engine", samples=16),
    "velocities": lambda: gimcli.solve("crank_rocker", velocities=True, measure="P.vx"),
    "wheel": lambda: gimcli.reduce("engine", steps=24, fluctuation=0.05, rpm=600),
}
"""Calls with arguments that fill attributes which are otherwise empty."""


def documented() -> set[str]:
    """Return the names in the columns "attribute" and "attributes" of the manual's page on Python."""
    names = set[str]()
    for table in re.findall(r"(?m)(?:^\|.*\n)+", (MANUAL / "python.md").read_text(encoding="utf-8")):
        head, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines())
        columns = [k for k, cell in enumerate(head) if cell.startswith("attribute")]
        names |= {name for row in rows for k in columns for name in re.findall(r"`\.?(\w+)", row[k])}
    return names


def inner(value: Any, known: bool) -> Iterator[str]:
    """Yield the inner objects in a value; of an object that is `known` those in its public attributes."""
    own = type(value).__module__.startswith("gimcli.") and not isinstance(value, Mapping)
    if isinstance(value, Result | Mechanism):
        return
    if own and not known:
        yield type(value).__name__
    elif own:
        yield from (f"{name} {one}" for name in attributes(value) for one in inner(getattr(value, name), True))
    elif isinstance(value, Mapping | list | tuple):
        yield from (
            one for part in (value.values() if isinstance(value, Mapping) else value) for one in inner(part, known)
        )


def attributes(found: Any) -> list[str]:
    """Return the names of the public attributes that are not methods, of those that the object has."""
    names = [name for name in dir(found) if not name.startswith("_") and hasattr(found, name)]
    return [name for name in names if not inspect.isroutine(getattr(found, name))]


@cache
def returned(call: str) -> Any:
    """Return the result of a call, computed once."""
    return MORE[call]() if call in MORE else result(call)


@pytest.mark.parametrize("call", [*CALLS, *OTHERS, *MORE])
def test_inner_objects_are_not_public(call: str) -> None:
    found, known = returned(call), documented()
    if not isinstance(found, Mechanism):
        assert not [
            f"{name}: {one}" for name in attributes(found) for one in inner(getattr(found, name), name in known)
        ]


@pytest.mark.parametrize("call", [*CALLS, *OTHERS, *MORE])
def test_public_methods_take_and_return_no_inner_objects(call: str) -> None:
    """Except those that the manual has, and those of every result, which give contents of files for `save`."""
    found = type(returned(call))
    known = {*documented(), *vars(Result), *(cls.__name__ for cls in found.__mro__)}
    for name, method in inspect.getmembers(found, inspect.isroutine):
        if found is not Mechanism and not name.startswith("_") and name not in known:
            words = set(re.findall(r"\w+", " ".join(map(str, getattr(method, "__annotations__", {}).values()))))
            assert not words & classes() - known, name


@cache
def classes() -> set[str]:
    """Return the names of the package's classes."""
    return {node.name for tree in modules().values() for node in nodes(tree) if isinstance(node, ast.ClassDef)}
