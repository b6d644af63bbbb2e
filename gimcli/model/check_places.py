"""Checks of what is carried by a member at one place: points and forces."""

from __future__ import annotations

from gimcli.model.references import References
from gimcli.model.schema import Load, Tracer
from gimcli.model.source import Where


def check_drawn(refs: References, where: Where, nodes: list[str]) -> None:
    """Note a member whose drawn place is not defined, as its first two nodes are drawn at one."""
    a, b = nodes[:2]
    if {a, b} <= set(refs.model.nodes) and a != b and not refs.apart(a, b):
        refs.fault(where, f"nodes {a} and {b} are drawn at one place, which shows no direction; draw them apart")


def check_place(refs: References, where: Where, part: Tracer | Load, what: str) -> None:
    """Check what is carried by a member at one place."""
    known = refs.member((*where, "on"), part.on)
    if (part.at is None) == (part.local is None):
        refs.lack(where, ("at", "local"), f"{what} '{where[1]}' needs either `at` (drawn) or `local`")
    elif known and part.at is not None and part.on != "ground":
        check_drawn(refs, (*where, "at"), refs.every[part.on])
