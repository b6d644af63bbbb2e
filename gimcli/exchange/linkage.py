"""Files of Linkage (`.linkage2`).

The file has connectors (pins) with coordinates in 1/96 inch, y upwards, and links that share them. Source:
linkageDoc.cpp and Simulator.cpp of the program: positive revolutions a minute are clockwise; all links on a motor turn
with it; an actuator moves its throw out and back `cpm` times a minute; a slider stays on the line through its limits.
"""

from __future__ import annotations

import re

from gimcli.connected import grouped
from gimcli.exchange.draft import GROUND, Draft, free_name
from gimcli.exchange.linkage_gears import GearTrains, anchored
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
    if program.scalefactor not in (0.0, 1.0):
        what = f"the scale factor {program.scalefactor:g}"
        draft.left_out.append(f"{what} is left out: lengths are those of the coordinates")
    return draft


class _Linkage:
    """The conversion of one file.

    `whole` has all links of the body of each link, `body` the names of bodies, `names` those of joints; `pins` are the
    connectors of the mechanism, as drawing elements are on layers of their own, and `points` those that are no joints.
    """

    def __init__(self, parts: LinkageParts, draft: Draft, scale: float) -> None:
        self.parts, self.draft, self.scale = parts, draft, scale
        self.order = {link: k for k, link in enumerate(parts.links)}
        self.whole = {link: [link] for link in parts.links}
        self.body: dict[FileRecord, str] = {}
        pins = parts.connectors.values()
        self.pins = [c for c in pins if c.mechanism or any(x.mechanism for x in c.links)]

    def convert(self) -> None:
        """Fill the draft."""
        self._weld()
        self.trains = GearTrains(self.parts, self.whole)
        self._add_joints()
        self._add_bodies()
        self.trains.add_to(self.draft, self.names, self.body, self.scale)
        self._add_tracers()
        for connector in self.pins:
            if connector.limits:
                self._add_slider(connector)
        self._add_inputs()
        self._name_drawing()

    # -- links that are one body ----------------------------------------------------------------

    def _weld(self) -> None:
        """Join the links that are fastened to each other, and those that one motor turns."""
        for link in self.parts.links:
            other = self.parts.link(link.fastenlink)
            if link.mechanism and other is not None and other.mechanism and other is not link:
                for one in (link, other):
                    text = "is an actuator that is fastened to a link; fasten the other link elsewhere"
                    one.refuse(one.actuator, text)
                self._join(link, other)
            elif link.mechanism and not link.gear and link.fastenconnector is not None:
                raise link.refused("is fastened to a connector; fasten it to a link, or make the connector an anchor")
        for connector in self.pins:
            if connector.input and connector.anchor:
                turned = [link for link in connector.links if self._turns(link)]
                for link in turned[1:]:
                    self._join(turned[0], link)

    def _turns(self, link: FileRecord) -> bool:
        """Return whether a motor at an anchor of a link turns it: it has no other anchor."""
        own = self._connectors(link)
        rigid = link.mechanism and not link.actuator and not anchored(link, self.parts)
        meshes = link.gear and any(link in ratio.links for ratio in self.parts.ratios)
        return rigid and (len(own) > 1 or meshes) and sum(c.anchor for c in own) == 1

    def _join(self, a: FileRecord, b: FileRecord) -> None:
        """Make two links parts of one body, in the order of the file."""
        both = sorted({*self.whole[a], *self.whole[b]}, key=self.order.__getitem__)
        self.whole.update(dict.fromkeys(both, both))

    def _connectors(self, link: FileRecord) -> set[FileRecord]:
        """Return all connectors of the body of a link."""
        return {c for x in self.whole[link] if x.mechanism for c in x.connectors}

    # -- joints and bodies ----------------------------------------------------------------------

    def _add_joints(self) -> None:
        limits = {ident for c in self.parts.connectors.values() for ident in c.limits}
        self.points = {c for c in self.pins if c.id not in limits and self._is_point(c)}
        for pin in self.pins:
            pin.refuse(pin.input and not pin.anchor, "is an input that is no anchor; make it an anchor")
        joints = [(c, [GROUND] if c.anchor else []) for c in self.pins if c not in self.points]
        self.names = {c: self.draft.joint(c.name, c.place * self.scale, *fixed) for c, fixed in joints}

    def _is_point(self, connector: FileRecord) -> bool:
        """Return whether a connector only draws its path: it is on one body, which has two joints without it."""
        links = [link for link in connector.links if link.mechanism]
        joint = connector.anchor or connector.limits or connector.fastened is not None
        if not connector.draw or joint or not links or any(link.actuator for link in links):
            return False
        one = all(self.whole[link] is self.whole[links[0]] for link in links)
        return one and sum(not c.draw or c.anchor or len(c.links) > 1 for c in self._connectors(links[0])) > 1

    def _add_bodies(self) -> None:
        fastened = grouped((connector.fastened, connector) for connector in self.pins)
        for link, whole in self.whole.items():
            if not link.mechanism or link.actuator or whole[0] is not link:
                continue
            own = [c for x in whole if x.mechanism for c in [*x.connectors, *fastened.get(x.id, [])]]
            if anchored(link, self.parts):
                self.body[link] = GROUND
                continue
            joints = list(dict.fromkeys(self.names[c] for c in own if c in self.names))
            if len(joints) == 1:
                joints += self._mark(whole, joints[0])
            if len(joints) > 1:
                named = [x.name for x in whole if len(x.connectors) > 1] or [link.name]
                self.body.update(dict.fromkeys(whole, self.draft.body("+".join(dict.fromkeys(named)), joints)))

    def _mark(self, whole: list[FileRecord], joint: str) -> list[str]:
        """Return the mark of a wheel that is no link: a body needs two joints; none if the wheel transmits nothing."""
        meshing = {wheel for ratio in self.trains.driven for wheel in ratio.links}
        places = [link.connectors[0].place + self.trains.radius(link) for link in whole if link in meshing]
        return [self.draft.joint(f"{joint}_mark", place * self.scale) for place in places[:1]]

    def _add_tracers(self) -> None:
        for connector in self.parts.connectors.values():
            carrier = self.parts.link(connector.fastened)
            if connector in self.points:
                carrier = next(link for link in connector.links if link.mechanism)
            elif connector in self.names or not connector.draw:
                continue
            if carrier is not None and (body := self.body.get(carrier)):
                self.draft.point(connector.name, body, connector.place * self.scale)
        drawn = [name for c, name in self.names.items() if c.draw and not c.anchor]
        self.draft.traced = [*self.draft.tracers, *drawn]

    # -- sliders --------------------------------------------------------------------------------

    def _add_slider(self, connector: FileRecord) -> None:
        for ident in connector.limits:
            connector.refuse(
                ident not in self.parts.connectors,
                f"slides to connector {ident}, which does not exist; correct its limits",
            )
        connector.refuse(connector.slideradius, "slides along an arc (slideradius); curved slots cannot be converted")
        a, b = (self.parts.connectors[ident] for ident in connector.limits)
        connector.refuse(
            a not in self.names or b not in self.names or abs(a.place - b.place) <= DIGIT,
            "its two limits coincide or are on no layer of the mechanism; move one of them",
        )
        shared = [link for link in a.links if link in b.links and link.mechanism and not link.actuator]
        carrier = self.body.get(shared[0], "") if shared else GROUND if a.anchor and b.anchor else ""
        connector.refuse(not carrier, f"its limits {a.name} and {b.name} are on no common link; correct its limits")
        name = self.names[connector]
        self.draft.slot(f"slot_{name}", name, carrier, b.place - a.place, guide=(self.names[a], self.names[b]))

    # -- inputs ---------------------------------------------------------------------------------

    def _add_inputs(self) -> None:
        turns = [c for c in self.pins if c.input]
        actuators = [link for link in self.parts.links if link.actuator and link.mechanism]
        motion = RepeatedMotion(self.draft)
        for connector in turns:
            body = next((own for link in connector.links if self._turns(link) and (own := self.body.get(link))), "")
            if body:
                name = "motor" if len(turns) == 1 else f"motor_{connector.name}"
                self.draft.rotary(name, self.names[connector], body, law=motion.add(name, motor_of(connector)))
            else:
                self.draft.left_out.append(f"input {connector.name} is left out: it turns no link")
        for link in actuators:
            link.refuse(
                len(link.connectors) != 2 or any(c not in self.names for c in link.connectors),
                f"is an actuator with {len(link.connectors)} connectors; it needs 2",
            )
            if motors := [c.name for c in link.connectors if c.input]:
                raise link.refused(f"is an actuator that the motor {motors[0]} turns; put it on an anchor of its own")
            name = free_name(link.name, self.draft.travels)
            ends = [self.names[c] for c in link.connectors]
            self.draft.travel(name, type="linear", nodes=ends, law=motion.add(name, actuator_of(link, self.scale)))
        motion.complete()

    # -- what is only drawn ---------------------------------------------------------------------

    def _name_drawing(self) -> None:
        drawn = [link for link in self.parts.links if link.measurementelement or not link.mechanism]
        if drawn:
            what = "drawing element" if len(drawn) == 1 else "drawing elements"
            self.draft.left_out.append(f"{len(drawn)} {what} left out: lines, text or measurements")
