"""Gears and chains of Linkage.

They transmit a motion between the links on which their wheels turn. Source: link.cpp and Simulator.cpp of
the program. Relative to the link that has the connectors of both wheels, gears turn in opposite senses and the wheels
of a chain in the same one, by the inverse ratio of their sizes. A wheel turns with the link to which it is fastened,
and with the motor on its connector; one that is fastened to an anchor is fixed.
"""

from __future__ import annotations

from collections.abc import Mapping

from gimcli.connected import connected
from gimcli.exchange.draft import GROUND, Draft
from gimcli.exchange.linkage_parts import LinkageParts
from gimcli.exchange.records import FileRecord

UNKNOWN = 0.25
"""Radius of a wheel of a chain whose sizes are only a ratio, relative to the distance of the pivots: for its mark."""


class GearTrains:
    """The gears of a file; `whole` has all links of the body of each link."""

    def __init__(self, parts: LinkageParts, whole: Mapping[FileRecord, list[FileRecord]]) -> None:
        self.parts = parts
        trains = connected(({*whole[a], *whole[b]} for a, b in (ratio.links for ratio in parts.ratios)), frozenset())
        moved = {link for train in trains if any(map(self._driving, train)) for link in train}
        self.driven = [ratio for ratio in parts.ratios if ratio.links[0] in moved]
        """The pairs of wheels that turn with something other than gears: a link, a motor or the ground."""
        kept = {link for ratio in self.driven for link in ratio.links}
        self.idle = [link.name for link in parts.links if link.gear and link not in kept]

    def _driving(self, link: FileRecord) -> bool:
        return len(link.connectors) > 1 or anchored(link, self.parts) or any(c.input for c in link.connectors)

    def add_to(
        self, draft: Draft, names: Mapping[FileRecord, str], bodies: Mapping[FileRecord, str], scale: float
    ) -> None:  # fmt: skip
        """Add the gears and chains to a draft; name those that do not transmit a motion.

        `names` and `bodies` are those of the joints and bodies of the draft, `scale` its length per unit of the file.
        """
        for ratio in self.driven:
            a, b = pivots(ratio)
            link, what = carrier(ratio), "chain" if ratio.chain else "gears"
            held = GROUND if link is None and a.anchor and b.anchor else bodies.get(link, "") if link else ""
            wheels = [bodies.get(wheel, "") for wheel in ratio.links]
            if held and all(wheels):
                radii = ratio.chain and ratio.sizeassize
                sizes = [size * scale if radii else size for size in ratio.sizes]
                gear = {
                    "type": "belt" if ratio.chain else "external", "members": wheels, "pivots": [names[a], names[b]],
                    "carrier": held, "radii" if radii else "teeth": sizes,
                }  # fmt: skip
                draft.gears.append((f"{what}_{names[a]}_{names[b]}", gear))
            else:
                idle = " and ".join(wheel.name for wheel in ratio.links)
                draft.left_out.append(f"the {what} of {idle} have no effect: no link has both of their connectors")
        if self.idle:
            draft.left_out.append(f"gears that drive no link are left out: {', '.join(self.idle)}")

    def radius(self, link: FileRecord) -> float:
        """Return the pitch radius of a wheel in the first pair that has it (file's unit)."""
        ratio = next(ratio for ratio in self.driven if link in ratio.links)
        gap, own = abs(pivots(ratio)[1].place - pivots(ratio)[0].place), ratio.sizes[ratio.links.index(link)]
        if ratio.chain:
            return float(own if ratio.sizeassize else UNKNOWN * gap)
        return float(gap * own / sum(ratio.sizes))


def pivots(ratio: FileRecord) -> tuple[FileRecord, FileRecord]:
    """Return the connectors about which two wheels turn: the first ones of their links."""
    for link in ratio.links:
        ratio.refuse(not link.connectors, f"the gear '{link.name}' has no connector; put it on one")
    ratio.refuse(min(ratio.sizes) <= 0.0, "the sizes of two gears are not positive; correct them")
    first, second = ratio.links
    return first.connectors[0], second.connectors[0]


def anchored(link: FileRecord, parts: LinkageParts) -> bool:
    """Return whether a gear does not turn: it is fastened to an anchor."""
    to = parts.connectors.get(-1 if link.fastenconnector is None else link.fastenconnector)
    return link.gear and to is not None and to.anchor


def carrier(ratio: FileRecord) -> FileRecord | None:
    """Return the link that has the pivots of both wheels; None if both are anchors, or if there is none."""
    a, b = pivots(ratio)
    return next((x for x in a.links if x in b.links and x.mechanism and not x.actuator and x not in ratio.links), None)
