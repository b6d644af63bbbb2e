"""Files of Linkage (`.linkage2`).

The file has connectors (pins) with coordinates in 1/96 inch, y upwards, and links that share them. Source:
linkageDoc.cpp and Simulator.cpp of the program: positive revolutions a minute are clockwise; all links on a motor turn
with it; an actuator moves its throw out and back `cpm` times a minute; a slider stays on the line through its limits.
"""

from __future__ import annotations

import re

from gimcli.connected import grouped
from gimcli.exchange.draft import GROUND, Draft, free_name
from gimcli.exchange.linkage_gears import add_gears, anchored, driven_ratios, radius
from gimcli.exchange.linkage_parts import LinkageParts, actuator_of, motor_of
from gimcli.exchange.records import FilePart, FileRecord
from gimcli.exchange.repeated import RepeatedMotion
from gimcli.exchange.tags import Tag, read_tags

PROGRAM = "Linkage"
PER_INCH = 96.0
DIGIT = 1e-6
"""Last digit of the coordinates in the file."""
LENGTHS = {"": ("mm", 25.4), "millimeters": ("mm", 25.4), "mm": ("mm", 25.4), "inches": ("in", 1.0)}
SETTINGS = {"units": "", "scalefactor": 1.0}

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
    first, old = FilePart(f"{source}:{root.line}"), "a file of the first version of Linkage"
    first.refuse(root.name == "linkage", f"<linkage>: {old}; open it with Linkage 3 and save it again")
    first.refuse(root.name != "linkage2", f"expected <linkage2> as the first tag, got <{root.name[:40]}>")
    parts = LinkageParts(root, source)
    program = parts.read(SETTINGS, next(iter(root.inside("program")), Tag("program", 1)))
    length, per_inch = LENGTHS.get(program.units.lower(), LENGTHS[""])
    draft = Draft(PROGRAM, source, length=length, resolution=2.0 * DIGIT * per_inch / PER_INCH)
    _Linkage(parts, draft, per_inch / PER_INCH).convert()
    factor = f"the scale factor {program.scalefactor:g}"
    draft.note(program.scalefactor not in (0.0, 1.0), f"{factor} is left out: lengths are those of the coordinates")
    return draft


class _Linkage:
    """The conversion of one file.

    It sets for links all links of their body (`whole`) and the name of this body (`body`, "" for none), for connectors
    the name of their joint (`named`, "" for none). `pins` are the connectors of the mechanism, as drawing elements are
    on layers of their own; some are only points on links (`point`).
    """

    def __init__(self, parts: LinkageParts, draft: Draft, scale: float) -> None:
        self.parts, self.draft, self.scale = parts, draft, scale
        connectors = parts.connectors.values()
        self.pins = [c for c in connectors if c.mechanism or any(link.mechanism for link in c.links)]
        for link in parts.links:
            link.whole, link.body = [link], ""
        for connector in connectors:
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
        drawn = sum(link.measurementelement or not link.mechanism for link in self.parts.links)
        what = "drawing element" if drawn == 1 else "drawing elements"
        self.draft.note(drawn, f"{drawn} {what} left out: lines, text or measurements")

    # -- links that are one body ----------------------------------------------------------------

    def _weld(self) -> None:
        """Join the links that are fastened to each other, and those that one motor turns."""
        for link in (link for link in self.parts.links if link.mechanism):
            other = self.parts.link(link.fastenlink)
            if other is not None and other.mechanism and other is not link:
                text = "is an actuator that is fastened to a link; fasten the other link elsewhere"
                link.refuse(link.actuator, text)
                other.refuse(other.actuator, text)
                self._join(link, other)
            else:
                cure = "fasten it to a link, or make the connector an anchor"
                fastened = not link.gear and link.fastenconnector is not None
                link.refuse(fastened, f"is fastened to a connector; {cure}")
        for connector in (c for c in self.pins if c.input and c.anchor):
            turned = [link for link in connector.links if self._turns(link)]
            for link in turned[1:]:
                self._join(turned[0], link)

    def _turns(self, link: FileRecord) -> bool:
        """Return whether a motor at an anchor of a link turns it: it has no other anchor."""
        own = _connectors(link)
        rigid = link.mechanism and not link.actuator and not anchored(link, self.parts)
        meshes = link.gear and any(link in ratio.links for ratio in self.parts.ratios)
        return rigid and (len(own) > 1 or meshes) and sum(c.anchor for c in own) == 1

    def _join(self, a: FileRecord, b: FileRecord) -> None:
        """Make two links parts of one body, in the order of the file."""
        both = [link for link in self.parts.links if link in a.whole or link in b.whole]
        for link in both:
            link.whole = both

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
            if not link.mechanism or link.actuator or link.whole[0] is not link:
                continue
            own = [c for x in link.whole if x.mechanism for c in [*x.connectors, *fastened.get(x.id, [])]]
            if anchored(link, self.parts):
                link.body = GROUND
                continue
            joints = list(dict.fromkeys(c.named for c in own if c.named))
            if len(joints) == 1:
                joints += self._mark(link.whole, joints[0])
            if len(joints) > 1:
                named = [x.name for x in link.whole if len(x.connectors) > 1] or [link.name]
                body = self.draft.body("+".join(dict.fromkeys(named)), joints)
                for part in link.whole:
                    part.body = body

    def _mark(self, whole: list[FileRecord], joint: str) -> list[str]:
        """Return the mark of a wheel that is no link: a body needs two joints; none if the wheel transmits nothing."""
        meshing = [link for link in whole if any(link in ratio.links for ratio in self.ratios)]
        places = [link.connectors[0].place + radius(link, self.ratios) for link in meshing[:1]]
        return [self.draft.joint(f"{joint}_mark", place * self.scale) for place in places]

    def _add_tracers(self) -> None:
        for connector in self.parts.connectors.values():
            carrier = self.parts.link(connector.fastened) if not connector.named and connector.draw else None
            if connector.point:
                carrier = next(link for link in connector.links if link.mechanism)
            if carrier is not None and carrier.body:
                self.draft.point(connector.name, carrier.body, connector.place * self.scale)
        self.draft.traced = [*self.draft.tracers, *(c.named for c in self.pins if c.named and c.draw and not c.anchor)]

    # -- sliders --------------------------------------------------------------------------------

    def _add_slider(self, connector: FileRecord) -> None:
        for ident in connector.limits:
            missing = ident not in self.parts.connectors
            connector.refuse(missing, f"slides to connector {ident}, which does not exist; correct its limits")
        connector.refuse(connector.slideradius, "slides along an arc (slideradius); curved slots cannot be converted")
        a, b = (self.parts.connectors[ident] for ident in connector.limits)
        connector.refuse(
            not a.named or not b.named or abs(a.place - b.place) <= DIGIT,
            "its two limits coincide or are on no layer of the mechanism; move one of them",
        )
        shared = [link for link in a.links if link in b.links and link.mechanism and not link.actuator]
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
            name = "motor" if len(turns) == 1 else f"motor_{connector.name}"
            for body in bodies[:1]:
                self.draft.rotary(name, connector.named, body, law=motion.add(name, motor_of(connector)))
        for link in (link for link in self.parts.links if link.actuator and link.mechanism):
            ends, motors = [c.named for c in link.connectors], [c.name for c in link.connectors if c.input]
            few = f"is an actuator with {len(ends)} connectors; it needs 2"
            link.refuse(len(ends) != 2 or not all(ends), few)
            turned = f"is an actuator that the motor {', '.join(motors[:1])} turns; put it on an anchor of its own"
            link.refuse(motors, turned)
            name = free_name(link.name, self.draft.travels)
            self.draft.travel(name, type="linear", nodes=ends, law=motion.add(name, actuator_of(link, self.scale)))
        motion.complete()


def _connectors(link: FileRecord) -> set[FileRecord]:
    """Return all connectors of the body of a link."""
    return {c for x in link.whole if x.mechanism for c in x.connectors}


def _is_point(connector: FileRecord) -> bool:
    """Return whether a connector only draws its path: it is on one body, which has two joints without it."""
    links = [link for link in connector.links if link.mechanism]
    joint = connector.anchor or connector.limits or connector.fastened is not None
    if not connector.draw or joint or not links or any(link.actuator for link in links):
        return False
    one = all(link.whole is links[0].whole for link in links)
    return one and sum(not c.draw or c.anchor or len(c.links) > 1 for c in _connectors(links[0])) > 1
