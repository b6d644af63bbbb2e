"""The joints and bodies of a PMKS+ document: sliders are one joint each, welded bars are one body.

Older versions of PMKS+ write a slider as three objects: a slider, a pin at the same place, and a block that joins them.
They become the slider, with the name of the pin, as newer versions write it.
"""

from __future__ import annotations

from gimcli.exchange.pmks_plus_codec import PlusDocument
from gimcli.exchange.records import Record, by_key

AGAIN = "is missing; copy the whole address again"


class PlusStructure:
    """The joints by their ids, the bodies by the ids of their links, and the body of each link."""

    def __init__(self, document: PlusDocument) -> None:
        self.joints = by_key("id", document.joints, "joint")
        self.links = by_key("id", document.links, "link")
        self._refer()
        self.renamed: dict[str, str] = {}
        for link in document.links:
            if link.block:
                self._fold(link)
        self.bodies = {
            link.id: list(dict.fromkeys(self.renamed.get(name, name) for name in link.joints))
            for link in document.links
            if link.root and not link.block
        }
        self.body_of: dict[str, str] = {}
        for root in self.bodies:
            self._claim(root)

    def _refer(self) -> None:
        """Check that all joints, bars and carriers that are named exist."""
        for link in self.links.values():
            missing = [*(name for name in link.joints if name not in self.joints),
                       *(name for name in link.parts if name not in self.links)]  # fmt: skip
            link.refuse(missing or not link.joints, f"'{', '.join(missing)}' {AGAIN}")
        for joint in self.joints.values():
            known = joint.carrier in self.links and {joint.start, joint.end} <= self.joints.keys()
            joint.refuse(joint.carrier and not known, f"the link of its slot {AGAIN}")
            barrel = joint.fixed or joint.carrier
            joint.refuse(joint.slides and joint.sealed and not barrel, "the cylinder has no barrel")

    def _fold(self, block: Record) -> None:
        """Let the slider and the pin that a block joins be one joint."""
        ends = [self.joints[name] for name in block.joints]
        sliders, pins = [joint for joint in ends if joint.slides], [joint for joint in ends if not joint.slides]
        block.refuse(len(sliders) != 1 or len(pins) != 1, "expected a block with a slider and a pin")
        slider, pin = sliders[0], pins[0]
        self.renamed[slider.id] = pin.id
        del self.joints[slider.id]
        for key in ("x", "y", "angle", "carrier", "start", "end", "slides", "sealed"):
            setattr(pin, key, getattr(slider, key))
        pin.fixed = slider.fixed or (pin.fixed and not slider.carrier)
        pin.driven, pin.traced = slider.driven or pin.driven, slider.traced or pin.traced
        pin.speed, pin.mass = slider.speed or pin.speed, block.mass

    def _claim(self, root: str) -> None:
        """Note the body of its own link and of all bars that are welded into it."""
        open_ends = [root]
        for own in open_ends:
            link = self.links[own]
            twice = own in self.body_of or (own != root and link.root)
            link.refuse(twice, "it belongs to two welded links; copy the whole address or file again")
            self.body_of[own] = root
            open_ends += link.parts

    def riders(self, joint: Record) -> list[str]:
        """Return the bodies that a joint belongs to."""
        return [body for body, joints in self.bodies.items() if joint.id in joints]

    def moving(self, body: str) -> bool:
        """Return whether a body is not fixed by pins of the ground."""
        return not all(self.joints[name].fixed and not self.joints[name].slides for name in self.bodies[body])

    def slot(self, joint: Record) -> tuple[str, str]:
        """Return the two joints along which a joint slides."""
        return self.renamed.get(joint.start, joint.start), self.renamed.get(joint.end, joint.end)
