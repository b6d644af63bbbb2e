"""The joints and bodies of a PMKS+ document: sliders are one joint each, welded bars are one body.

Older versions of PMKS+ write a slider as three objects: a slider, a pin at the same place, and a block that joins them.
They become the slider, with the name of the pin, as newer versions write it.
"""

from __future__ import annotations

from gimcli.exchange.pmks_plus_codec import PlusDocument
from gimcli.exchange.records import FileRecord, by_key

AGAIN = "is missing; copy the whole address again"


class PlusStructure:
    """The joints and the bodies, and all links by their ids.

    Further values of a joint: its `place`, its bodies (`riders`), and the body and the two joints of its slot
    (`slotted`, None on the ground). That of a link: its `body`, the link that it is welded into, which may be itself;
    None for blocks.
    """

    def __init__(self, document: PlusDocument) -> None:
        known, self.links = by_key("id", document.joints, "joint"), by_key("id", document.links, "link")
        for link in document.links:
            missing = [*(name for name in link.joints if name not in known),
                       *(name for name in link.parts if name not in self.links)]  # fmt: skip
            link.refuse(missing or not link.joints, f"'{', '.join(missing)}' {AGAIN}")
            link.body = None
        for joint in document.joints:
            slot = {joint.start, joint.end}
            joint.check({
                f"the link of its slot {AGAIN}": joint.carrier and joint.carrier not in self.links,
                f"a joint of its slot {AGAIN}": joint.carrier and not slot <= known.keys(),
                "the cylinder has no barrel": joint.slides and joint.sealed and not (joint.fixed or joint.carrier),
            })  # fmt: skip
        for link in document.links:
            if link.block:
                slider, pin = _folded(link, [known[name] for name in link.joints])
                known.update({slider.id: pin, pin.id: pin})
        self.bodies = [link for link in document.links if link.root and not link.block]
        for link in self.bodies:
            link.joints = list(dict.fromkeys(known[name] for name in link.joints))
            self._claim(link)
        self.joints = [joint for name, joint in known.items() if joint.id == name]
        for joint in self.joints:
            joint.place = complex(joint.x, joint.y)
            joint.riders = [link for link in self.bodies if joint in link.joints]
            ends = (known.get(joint.start), known.get(joint.end))
            joint.slotted = (self.links[joint.carrier].body, *ends) if joint.carrier else None

    def _claim(self, root: FileRecord) -> None:
        """Note the body of its own link and of all bars that are welded into it."""
        open_ends = [root]
        for link in open_ends:
            twice = link.body or (link is not root and link.root)
            link.refuse(twice, "it belongs to two welded links; copy the whole address or file again")
            link.body = root
            open_ends += [self.links[part] for part in link.parts]


def _folded(block: FileRecord, ends: list[FileRecord]) -> tuple[FileRecord, FileRecord]:
    """Let the slider and the pin that a block joins be one joint, the pin; return both."""
    ends.sort(key=lambda joint: not joint.slides)
    good = [joint.slides for joint in ends] == [True, False]
    block.refuse(not good, "expected a block with a slider and a pin")
    slider, pin = ends
    for key in ("x", "y", "angle", "carrier", "start", "end", "slides", "sealed"):
        setattr(pin, key, getattr(slider, key))
    pin.fixed = slider.fixed or (pin.fixed and not slider.carrier)
    pin.driven, pin.traced = slider.driven or pin.driven, slider.traced or pin.traced
    pin.speed, pin.mass = slider.speed or pin.speed, block.mass
    return slider, pin


def moving(body: FileRecord) -> bool:
    """Return whether a body is not fixed by pins of the ground."""
    return not all(joint.fixed and not joint.slides for joint in body.joints)
