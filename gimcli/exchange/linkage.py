"""Files of Linkage (`.linkage2`).

The file has connectors (pins) with coordinates in 1/96 inch, y upwards, and links that share them. Source:
linkageDoc.cpp and Simulator.cpp of the program: positive revolutions a minute are clockwise; all links on a motor turn
with it; an actuator moves its throw out and back `cpm` times a minute; a slider stays on the line through its limits.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from gimcli.connected import connected, grouped
from gimcli.exchange.draft import GROUND, Draft, free_name
from gimcli.exchange.linkage_gears import add_gears, driven_ratios, radius
from gimcli.exchange.linkage_parts import FILE, LinkageParts, actuator_of, motor_of
from gimcli.exchange.records import FileRecord, read as read_part
from gimcli.exchange.repeated import RepeatedMotion
from gimcli.exchange.tags import read_tags

PROGRAM = "Linkage"
PER_INCH = 96.0
DIGIT = 1e-6
"""Last digit of the coordinates in the file."""
LENGTHS = {"": ("mm", 25.4), "millimeters": ("mm", 25.4), "mm": ("mm", 25.4), "inches": ("in", 1.0)}

_ROOT = re.compile(r"<linkage2?(?![\w.-])")
_PARENTS = {
    "program": ("linkage2",), "Link": ("linkage2",), "element": ("linkage2",), "ratios": ("linkage2",),
    "selected": ("linkage2",), "background": ("linkage2",), "ratio": ("ratios",), "link": ("ratio", "selected"),
    "connector": ("linkage2", "Link", "element", "selected"), "slidelimit": ("connector",),
    "fastenconnector": ("Link", "element"),
}  # fmt: skip


def recognises(text: str) -> bool:
    """Return whether a text is probably a file of Linkage."""
    start = text[:4000].lstrip("\ufeff \t\r\n")
    return start.startswith("<") and _ROOT.search(start) is not None


def read(text: str, source: str) -> Draft:
    """Return the mechanism of a file of Linkage; `source` names it in messages."""
    root = read_tags(text, source, _PARENTS)
    root.check({
        "a file of the first version of Linkage; open it with Linkage 3 and save it again": root.name == "linkage",
        "expected <linkage2> as the first tag": root.name != "linkage2",
    })  # fmt: skip
    file = read_part(FILE, root)
    units, factor = next(((own.units, own.scalefactor) for own in file.programs), ("", 1.0))
    length, per_inch = LENGTHS.get(units.lower(), LENGTHS[""])
    draft = Draft(PROGRAM, source, length=length, resolution=2.0 * DIGIT * per_inch / PER_INCH)
    _Linkage(LinkageParts(file), draft, per_inch / PER_INCH).convert()
    scaled = f"the scale factor {factor:g} is left out: lengths are those of the coordinates"
    draft.note(factor not in (0.0, 1.0), scaled)
    return draft


class _Linkage:
    """The conversion of one file.

    It sets for links all links of their body (`whole`), all connectors of these (`around`) and the name of this body
    (`body`, "" for none), for connectors the name of their joint (`named`, "" for none); some connectors are only
    points on links (`point`).
    """

    def __init__(self, parts: LinkageParts, draft: Draft, scale: float) -> None:
        self.parts, self.draft, self.scale, self.pins = parts, draft, scale, parts.pins
        for link in parts.all:
            link.whole, link.around, link.body = [link], {*link.pins}, ""
        for connector in parts.connectors.values():
            connector.named, connector.point = "", False

    def convert(self) -> None:
        """Fill the draft."""
        self._weld()
        self.ratios = driven_ratios(self.parts)
        self._add_joints()
        self._add_bodies()
        add_gears(self.draft, self.parts, self.ratios, self.scale)
        self._add_tracers()
        for connector in self.pins:
            if connector.limits:
                self._add_slider(connector)
        self._add_inputs()
        drawn = f"{self.parts.drawn} drawing element{'s' * (self.parts.drawn > 1)}"
        self.draft.note(self.parts.drawn, f"{drawn} left out: lines, text or measurements")

    # -- links that are one body ----------------------------------------------------------------

    def _weld(self) -> None:
        """Join the links that are fastened to each other, and those that one motor turns."""
        fastened = [(link, self._fastened(link)) for link in self.parts.links]
        self._join(fastened)
        motors = (c for c in self.pins if c.input and c.anchor)
        self._join([*fastened, *([link for link in c.links if self._turns(link)] for c in motors)])

    def _fastened(self, link: FileRecord) -> FileRecord:
        """Return the link that a link is fastened to; itself if there is none."""
        other = self.parts.link(link.fastenlink) or link
        rigid = other in self.parts.links and other is not link
        cure, fixed = "fasten it to a link, or make the connector an anchor", link.fastenconnector is not None
        link.refuse(not rigid and not link.gear and fixed, f"is fastened to a connector; {cure}")
        for own in (link, other) if rigid else ():
            own.refuse(own.actuator, "is an actuator that is fastened to a link; fasten the other link elsewhere")
        return other if rigid else link

    def _turns(self, link: FileRecord) -> bool:
        """Return whether a motor at an anchor of a link turns it: it has no other anchor."""
        rigid = not link.actuator and not link.anchored and sum(c.anchor for c in link.around) == 1
        return rigid and (len(link.around) > 1 or any(link in ratio.wheels for ratio in self.parts.ratios if link.gear))

    def _join(self, ties: Iterable[Iterable[FileRecord]]) -> None:
        """Make links that ties join parts of one body, in the order of the file."""
        for body in connected(ties, frozenset()):
            whole, around = [link for link in self.parts.links if link in body], {c for link in body for c in link.pins}
            for link in whole:
                link.whole, link.around = whole, around

    # -- joints and bodies ----------------------------------------------------------------------

    def _add_joints(self) -> None:
        limits = {ident for c in self.parts.connectors.values() for ident in c.limits}
        for pin in self.pins:
            pin.refuse(pin.input and not pin.anchor, "is an input that is no anchor; make it an anchor")
            pin.point = pin.id not in limits and _is_point(pin)
            if not pin.point:
                pin.named = self.draft.joint(pin.name, pin.place * self.scale, *[GROUND] * pin.anchor)

    def _add_bodies(self) -> None:
        fastened = grouped((connector.fastened, connector) for connector in self.pins)
        for link in self.parts.links:
            if link.actuator or link.whole[0] is not link:
                continue
            if link.anchored:
                link.body = GROUND
                continue
            own = [c for x in link.whole for c in [*x.pins, *fastened.get(x.id, [])]]
            joints = list(dict.fromkeys(c.named for c in own if c.named))
            if len(joints) == 1:
                joints += self._mark(link.whole, joints[0])
            if len(joints) > 1:
                named = [x.name for x in link.whole if len(x.pins) > 1] or [link.name]
                body = self.draft.body("+".join(dict.fromkeys(named)), joints)
                for part in link.whole:
                    part.body = body

    def _mark(self, whole: list[FileRecord], joint: str) -> list[str]:
        """Return the mark of a wheel that is no link: a body needs two joints; none if the wheel transmits nothing."""
        meshing = [link for link in whole if any(link in ratio.wheels for ratio in self.ratios)]
        places = [link.pins[0].place + radius(link, self.ratios) for link in meshing[:1]]
        return [self.draft.joint(f"{joint}_mark", place * self.scale) for place in places]

    def _add_tracers(self) -> None:
        for connector in self.parts.connectors.values():
            carrier = self.parts.link(connector.fastened) if not connector.named and connector.draw else None
            if connector.point:
                carrier = connector.links[0]
            if carrier is not None and carrier.body:
                self.draft.point(connector.name, carrier.body, connector.place * self.scale)
        self.draft.traced = [*self.draft.tracers, *(c.named for c in self.pins if c.named and c.draw and not c.anchor)]

    # -- sliders --------------------------------------------------------------------------------

    def _add_slider(self, connector: FileRecord) -> None:
        known, cure = self.parts.connectors, "which does not exist; correct its limits"
        connector.check({
            **{f"slides to connector {limit}, {cure}": limit not in known for limit in connector.limits},
            "slides along an arc (slideradius); curved slots cannot be converted": connector.slideradius,
        })  # fmt: skip
        a, b = (known[limit] for limit in connector.limits)
        connector.refuse(
            not a.named or not b.named or abs(a.place - b.place) <= DIGIT,
            "its two limits coincide or are on no layer of the mechanism; move one of them",
        )
        shared = [link for link in a.links if link in b.links and not link.actuator]
        carrier = shared[0].body if shared else GROUND if a.anchor and b.anchor else ""
        connector.refuse(not carrier, f"its limits {a.name} and {b.name} are on no common link; correct its limits")
        name, guide = connector.named, (a.named, b.named)
        self.draft.slot(f"slot_{name}", name, carrier, b.place - a.place, guide=guide)

    # -- inputs ---------------------------------------------------------------------------------

    def _add_inputs(self) -> None:
        turns = [c for c in self.pins if c.input]
        motion = RepeatedMotion(self.draft)
        for connector in turns:
            bodies = [link.body for link in connector.links if self._turns(link) and link.body]
            self.draft.note(not bodies, f"input {connector.name} is left out: it turns no link")
            for body in bodies[:1]:
                motion.rotary(connector.name, len(turns) == 1, connector.named, body, motor_of(connector))
        for link in (link for link in self.parts.links if link.actuator):
            ends, motors = [c.named for c in link.pins], [c.name for c in link.pins if c.input]
            turned = f"is an actuator that the motor {', '.join(motors[:1])} turns; put it on an anchor of its own"
            few = f"is an actuator with {len(ends)} connectors; it needs 2"
            link.check({few: len(ends) != 2 or not all(ends), turned: motors})
            name = free_name(link.name, self.draft.travels)
            self.draft.travel(name, type="linear", nodes=ends, law=motion.add(name, actuator_of(link, self.scale)))
        motion.complete()


def _is_point(connector: FileRecord) -> bool:
    """Return whether a connector only draws its path: it is on one body, which has two joints without it."""
    links = connector.links
    joint = connector.anchor or connector.limits or connector.fastened is not None
    if not connector.draw or joint or not links or any(link.actuator for link in links):
        return False
    one = all(link.whole is links[0].whole for link in links)
    return one and sum(not c.draw or c.anchor or len(c.links) > 1 for c in links[0].around) > 1
