"""Measures: quantities computed from a motion. Each kind has one file and one entry in `KINDS`."""

from __future__ import annotations

from gimcli.measures import advantage, angle, area, centre, curvature, naming, transmission
from gimcli.measures.measure import Kind, Measure
from gimcli.mechanism import Mechanism

KINDS: dict[str, Kind] = {
    kind.name: kind for kind in (centre.KIND, curvature.KIND, transmission.KIND, advantage.KIND, area.KIND, angle.KIND)
}


def measures_of(mechanism: Mechanism, spec: str) -> list[Measure]:
    """Return the measures of a text such as "centre:rod/rocker".

    Raises UsageError for an unknown kind or name.
    """
    kind, colon, names = spec.partition(":")
    if kind not in KINDS:
        raise naming.unknown(spec, "kind", kind, KINDS)
    found, words, spec = KINDS[kind], names.split("/") if colon else [], f"{kind}:{names}"
    naming.refuse_count(spec, words, found.counts, f"{kind}:{found.arguments}")
    return found.make(mechanism, spec, words)


def help_lines() -> list[tuple[str, str]]:
    """Return the form and the description of each kind."""
    return [(f"{kind.name}:{kind.arguments}", kind.text) for kind in KINDS.values()]
