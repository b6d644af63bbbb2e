"""The connectors, links and ratios of a file of Linkage: records with the attributes that the conversion uses.

Further values of a connector: `place`, the links on it (`links`), the two connectors between which it slides
(`limits`) and the link to which it is fastened (`fastened`). Those of a link: its connectors (`pins`), and whether it
is a gear that is fastened to an anchor (`anchored`). Those of a ratio: the two links that are wheels (`wheels`) and
their `sizes`. Coordinates and lengths are those of the file.
"""

from __future__ import annotations

from gimcli.exchange.records import FileRecord, by_key
from gimcli.exchange.repeated import RepeatedInput

MECHANISM, DRAWN_ON = 0xFFFFFFF0, 16
"""Layers of the mechanism, of which parts without a layer are on one; the other ones hold lines, text and pictures."""
DEFAULT_RATE = 15.0
"""Revolutions or strokes a minute where the file gives none."""
_ALPHABET = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"

NUMBER = {"id": int}
_PART = {"id": int, "name": "", "layer": DRAWN_ON, "fastenlink": (int,), "startoffset": 0.0, "alwaysmanual": False}
CONNECTOR = {
    **_PART, "x": float, "y": float, "anchor": False, "input": False, "draw": False, "slider": False,
    "slideradius": 0.0, "fasten": (int,), "rpm": DEFAULT_RATE, "limitangle": 0.0, "slidelimits": [NUMBER],
}  # fmt: skip
LINK = {
    **_PART, "actuator": False, "gear": False, "measurementelement": False, "throw": (float,), "cpm": DEFAULT_RATE,
    "fastenconnector": (int,), "connectors": [NUMBER], "fastenconnectors": [NUMBER],
}  # fmt: skip
RATIO = {"type": "", "sizeassize": False, "links": [{"id": int, "size": float}]}
FILE = {
    "programs": [{"units": "", "scalefactor": 1.0}], "connectors": [CONNECTOR], "Links": [LINK], "elements": [LINK],
    "ratioss": [{"ratios": [RATIO]}],
}  # fmt: skip
"""The attributes of tags, and the tags in them, by the plural of their names; older files call links elements."""


class LinkageParts:
    """The parts of a file; ModelError for damaged ones.

    `links`: those of the mechanism, as drawing elements are on layers of their own; `drawn`: the number of others.
    """

    def __init__(self, file: FileRecord) -> None:
        self.connectors = by_key("id", file.connectors, "connector")
        self.all = [*file.Links, *file.elements]
        self.links = [link for link in self.all if _moves(link)]
        for own in file.connectors:
            own.place, own.links, own.name = complex(own.x, own.y), [], own.name or _letters(own.id)
            limits = [limit.id for limit in own.slidelimits[:2]]
            own.limits = limits if own.slider and len(limits) == 2 else []
            own.fastened = own.fastenlink if own.fasten is None else own.fasten
        for link in self.all:
            self._connect(link)
        self.pins = [own for own in file.connectors if own.links or _moves(own)]
        self.drawn = sum(link.measurementelement or link not in self.links for link in self.all)
        self.ratios = [ratio for ratios in file.ratioss for ratio in ratios.ratios if self._paired(ratio)]

    def link(self, ident: int | None) -> FileRecord | None:
        """Return the first link with a number, as the program does where a number is repeated."""
        return next((link for link in self.all if link.id == ident), None)

    def _connect(self, link: FileRecord) -> None:
        link.name, link.pins = link.name or f"{'actuator' if link.actuator else 'link'}{link.id + 1}", []
        for number in dict.fromkeys(own.id for own in link.connectors):
            link.refuse(number not in self.connectors, f"connector {number} does not exist; remove it from the link")
            link.pins.append(self.connectors[number])
            self.connectors[number].links += [link] if link in self.links else []
        to = self.connectors.get(-1 if link.fastenconnector is None else link.fastenconnector)
        link.anchored = link.gear and to is not None and to.anchor
        for fastened in link.fastenconnectors:  # older files have no such attribute of the connector
            pin = self.connectors.get(fastened.id)
            if pin and pin.fastened is None:
                pin.fastened = link.id

    def _paired(self, ratio: FileRecord) -> bool:
        """Set the wheels of a ratio; return whether it has two."""
        known = [(link, wheel.size) for wheel in ratio.links if (link := self.link(wheel.id))]
        ratio.wheels, ratio.sizes = zip(known[0], known[-1], strict=True) if known else ((), ())
        ratio.chain = ratio.type == "chain"
        return len(known) >= 2


def _moves(own: FileRecord) -> bool:
    """Return whether a part is on a layer of the mechanism."""
    return bool((own.layer or DRAWN_ON) & MECHANISM)


def _letters(ident: int) -> str:
    """Return the name that the program shows for a connector without a name: A, B, ... z, A1, B1, ..."""
    return _ALPHABET[ident % 52] + (str(ident // 52) if ident >= 52 else "") if ident >= 0 else f"C{ident}"


def motor_of(pin: FileRecord) -> RepeatedInput:
    """Return the input of a connector that is a motor: clockwise if its rate is positive."""
    if pin.limitangle <= 0.0:
        return RepeatedInput(-6.0 * pin.rpm, pin.alwaysmanual)
    return RepeatedInput.between(-6.0 * pin.rpm, pin.limitangle, pin.startoffset, manual=pin.alwaysmanual)


def actuator_of(link: FileRecord, scale: float) -> RepeatedInput:
    """Return the input of an actuator: it shortens first if its rate is negative."""
    a, b = (c.place for c in link.pins)
    stroke = scale * abs(abs(b - a) / 2.0 if link.throw is None else link.throw)
    return RepeatedInput.between(stroke * link.cpm / 30.0, stroke, link.startoffset * scale, manual=link.alwaysmanual)
