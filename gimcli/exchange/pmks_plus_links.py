"""The joints and bodies of a PMKS+ document: sliders are one joint each, welded bars are one body.

Older versions of PMKS+ write a slider as three objects: a slider, a pin at the same place, and a block that joins them.
They become the slider, with the name of the pin, as newer versions write it.
"""

from __future__ import annotations

from dataclasses import replace

from gimcli.errors import ModelError
from gimcli.exchange.draft import MOST_PLACES
from gimcli.exchange.pmks_plus_codec import PlusDocument, PlusJoint, PlusLink
from gimcli.exchange.refusing import Refusing


class PlusStructure(Refusing):
    """The joints by their ids, the bodies by the ids of their links, and the body of each link."""

    def __init__(self, document: PlusDocument, source: str) -> None:
        self.source = source
        self.joints = {joint.id: joint for joint in document.joints}
        self.links = {link.id: link for link in document.links}
        self.refuse(
            len(self.joints) < len(document.joints) or len(self.links) < len(document.links),
            "two joints or two links have the same name; copy the whole address or file again",
        )
        self.refuse(
            sum(len(link.joints) + len(link.parts) for link in document.links) > MOST_PLACES,
            f"more than {MOST_PLACES} joints on links are too many for one mechanism",
        )
        self._refer()
        self.renamed: dict[str, str] = {}
        for link in document.links:
            if link.block:
                self._fold(link)
        roots = [link for link in document.links if link.root and not link.block]
        self.bodies = {
            link.id: list(dict.fromkeys(self.renamed.get(name, name) for name in link.joints)) for link in roots
        }
        self.body_of: dict[str, str] = {}
        for root in self.bodies:
            self._claim(root)

    def refused(self, text: str) -> ModelError:
        """Return the error for a part of the document."""
        return ModelError([f"{self.source}: {text}"])

    def _refer(self) -> None:
        """Check that all joints, bars and carriers that are named exist."""
        for link in self.links.values():
            parts = [name for name in link.parts if name not in self.links]
            missing = [*(name for name in link.joints if name not in self.joints), *parts]
            self.refuse(
                missing or not link.joints,
                f"link {link.id}: '{', '.join(missing)}' is missing; copy the whole address again",
            )
        for joint in self.joints.values():
            known = joint.carrier in self.links and {joint.start, joint.end} <= self.joints.keys()
            self.refuse(
                joint.carrier and not known,
                f"joint {joint.id}: the link of its slot is missing; copy the whole address again",
            )
            self.refuse(
                joint.slides and not joint.fixed and not joint.carrier and joint.sealed,
                f"joint {joint.id}: the cylinder has no barrel",
            )

    def _fold(self, block: PlusLink) -> None:
        """Let the slider and the pin that a block joins be one joint."""
        sliders = [self.joints[name] for name in block.joints if self.joints[name].slides]
        pins = [self.joints[name] for name in block.joints if not self.joints[name].slides]
        self.refuse(len(sliders) != 1 or len(pins) != 1, f"link {block.id}: expected a block with a slider and a pin")
        slider, pin = sliders[0], pins[0]
        self.renamed[slider.id] = pin.id
        self.joints[pin.id] = replace(
            slider, id=pin.id, name=pin.name, welded=pin.welded, mass=block.mass,
            fixed=slider.fixed or (pin.fixed and not slider.carrier), driven=slider.driven or pin.driven,
            traced=slider.traced or pin.traced, speed=slider.speed or pin.speed,
        )  # fmt: skip
        del self.joints[slider.id]

    def _claim(self, root: str) -> None:
        """Note the body of its own link and of all bars that are welded into it."""
        open_ends = [root]
        while open_ends:
            own = open_ends.pop()
            self.refuse(
                own in self.body_of or (own != root and self.links[own].root),
                f"link {own} belongs to two welded links; copy the whole address or file again",
            )
            self.body_of[own] = root
            open_ends += self.links[own].parts

    def riders(self, joint: PlusJoint) -> list[str]:
        """Return the bodies that a joint belongs to."""
        return [body for body, joints in self.bodies.items() if joint.id in joints]

    def moving(self, body: str) -> bool:
        """Return whether a body is not fixed by pins of the ground."""
        return not all(self.joints[name].fixed and not self.joints[name].slides for name in self.bodies[body])

    def slot(self, joint: PlusJoint) -> tuple[str, str]:
        """Return the two joints along which a joint slides."""
        return self.renamed.get(joint.start, joint.start), self.renamed.get(joint.end, joint.end)
