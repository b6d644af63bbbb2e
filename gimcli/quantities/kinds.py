"""Kinds of quantities with arguments, such as centre:a/b."""

from __future__ import annotations

from collections.abc import Sequence

from gimcli.errors import refuse
from gimcli.mechanism import Mechanism
from gimcli.quantities import advantage, angle, area, centre, curvature, distance, transmission
from gimcli.quantities.quantity import Kind, Quantity, place_of

KINDS: dict[str, Kind] = {
    kind.name: kind
    for kind in (
        centre.KIND,
        curvature.KIND,
        transmission.KIND,
        advantage.KIND,
        area.KIND,
        angle.KIND,
        distance.KIND,
    )
}


def quantities_of(mechanism: Mechanism, spec: str) -> Sequence[Quantity]:
    """Return the quantities of a text such as "centre:rod/rocker".

    Raises UsageError for an unknown kind or name.
    """
    kind, colon, names = spec.partition(":")
    place_of(spec, "kind", kind, KINDS)
    found, words, spec = KINDS[kind], names.split("/") if colon else [], f"{kind}:{names}"
    refuse((len(words) not in found.counts or not all(words), f"measure '{spec}': expected {kind}:{found.arguments}"))
    return found.make(mechanism, spec, words)


def help_lines() -> list[tuple[str, str]]:
    """Return the form and the description of each kind."""
    return [(f"{kind.name}:{kind.arguments}", kind.text) for kind in KINDS.values()]
