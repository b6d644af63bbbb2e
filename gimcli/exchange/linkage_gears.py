"""Gears and chains of Linkage.

They transmit a motion between the links on which their wheels turn. Source: link.cpp and Simulator.cpp of
the program. Relative to the link that has the connectors of both wheels, gears turn in opposite senses and the wheels
of a chain in the same one, by the inverse ratio of their sizes. A wheel turns with the link to which it is fastened,
and with the motor on its connector; one that is fastened to an anchor is fixed.
"""

from __future__ import annotations

from gimcli.connected import connected
from gimcli.exchange.draft import GROUND, Draft
from gimcli.exchange.linkage_parts import LinkageParts
from gimcli.exchange.records import FileRecord

UNKNOWN = 0.25
"""Radius of a wheel of a chain whose sizes are only a ratio, relative to the distance of the pivots: for its mark."""


def driven_ratios(parts: LinkageParts) -> list[FileRecord]:
    """Return the pairs of wheels that turn with something other than gears: a link, a motor or the ground."""
    trains = connected(({*a.whole, *b.whole} for a, b in (ratio.wheels for ratio in parts.ratios)), frozenset())
    driving = {x for x in parts.links if len(x.pins) > 1 or x.anchored or any(c.input for c in x.pins)}
    moved = {link for train in trains if train & driving for link in train}
    return [ratio for ratio in parts.ratios if ratio.wheels[0] in moved]


def add_gears(draft: Draft, parts: LinkageParts, ratios: list[FileRecord], scale: float) -> None:
    """Add gears and chains to a draft, with lengths of `scale`; name those that do not transmit a motion."""
    for ratio in ratios:
        a, b = pivots(ratio)
        what = "chain" if ratio.chain else "gears"
        carriers = (x for x in a.links if x in b.links and not x.actuator and x not in ratio.wheels)
        link = next(carriers, None)
        held = link.body if link else GROUND if a.anchor and b.anchor else ""
        wheels, names = [wheel.body for wheel in ratio.wheels], " and ".join(wheel.name for wheel in ratio.wheels)
        radii = ratio.chain and ratio.sizeassize
        gear = {
            "type": "belt" if ratio.chain else "external", "members": wheels, "pivots": [a.named, b.named],
            "carrier": held, "radii" if radii else "teeth": [size * scale if radii else size for size in ratio.sizes],
        }  # fmt: skip
        turning = held and all(wheels)
        draft.gears += [(f"{what}_{a.named}_{b.named}", gear)] if turning else []
        draft.note(not turning, f"the {what} of {names} have no effect: no link has both of their connectors")
    kept = [link for ratio in ratios for link in ratio.wheels]
    idle = [link.name for link in parts.links if link.gear and link not in kept]
    draft.note(idle, f"gears that drive no link are left out: {', '.join(idle)}")


def radius(link: FileRecord, ratios: list[FileRecord]) -> float:
    """Return the pitch radius of a wheel in the first pair that has it (file's unit)."""
    ratio = next(ratio for ratio in ratios if link in ratio.wheels)
    a, b = pivots(ratio)
    gap, own = abs(b.place - a.place), ratio.sizes[ratio.wheels.index(link)]
    if ratio.chain:
        return float(own if ratio.sizeassize else UNKNOWN * gap)
    return float(gap * own / sum(ratio.sizes))


def pivots(ratio: FileRecord) -> tuple[FileRecord, FileRecord]:
    """Return the connectors about which two wheels turn: the first ones of their links."""
    for link in ratio.wheels:
        ratio.refuse(not link.pins, f"the gear '{link.name}' has no connector; put it on one")
    ratio.refuse(min(ratio.sizes) <= 0.0, "the sizes of two gears are not positive; correct them")
    first, second = ratio.wheels
    return first.pins[0], second.pins[0]
