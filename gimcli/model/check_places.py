"""Checks of points fixed to a member: tracer points and points of application of forces."""

from __future__ import annotations

from gimcli.model.references import References
from gimcli.model.schema import Load, Tracer
from gimcli.model.source import Where


def check_drawn(refs: References, where: Where, nodes: list[str]) -> None:
    """Record an error if the first two nodes of a member coincide: its initial direction is then undefined."""
    a, b = nodes[:2]
    if {a, b} <= set(refs.model.nodes) and a != b and not refs.apart(a, b):
        refs.fault(where, f"nodes {a} and {b} coincide and define no direction; move one")


def check_place(refs: References, where: Where, part: Tracer | Load, what: str, known: bool) -> None:
    """Check the coordinates of a point or force (`what`) on a member, which is `known` if it exists."""
    if (part.at is None) == (part.local is None):
        refs.lack(where, ("at", "local"), f"{what} '{where[1]}' needs either `at` (initial coordinates) or `local`")
    elif known and part.at is not None and part.on != "ground":
        check_drawn(refs, (*where, "at"), refs.every[part.on])
