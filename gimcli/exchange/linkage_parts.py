"""The connectors, links and ratios of a file of Linkage: records with the attributes that the conversion uses.

Further values of a connector: `place`, the links on it (`links`), the two connectors between which it slides
(`limits`) and the link to which it is fastened (`fastened`). Those of a link: its `connectors`. Those of a ratio: the
two links that are wheels (`links`) and their `sizes`. Coordinates and lengths are those of the file.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from gimcli.exchange.records import FilePart, FileRecord, read
from gimcli.exchange.repeated import RepeatedInput
from gimcli.exchange.tags import Tag

MOST_PARTS = 300
"""Most connectors, links and ratios that are read; the largest samples of the program have 60."""
MECHANISM, DRAWN_ON = 0xFFFFFFF0, 16
"""Layers of the mechanism, of which parts without a layer are on one; the other ones hold lines, text and pictures."""
DEFAULT_RATE = 15.0
"""Revolutions or strokes a minute where the file gives none."""
_ALPHABET = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"

_PART = {"id": int, "name": "", "layer": DRAWN_ON, "fastenlink": (int,), "startoffset": 0.0, "alwaysmanual": False}
CONNECTOR = {
    **_PART, "x": float, "y": float, "anchor": False, "input": False, "draw": False, "slider": False,
    "slideradius": 0.0, "fasten": (int,), "rpm": DEFAULT_RATE, "limitangle": 0.0,
}  # fmt: skip
LINK = {
    **_PART, "actuator": False, "gear": False, "measurementelement": False, "throw": (float,), "cpm": DEFAULT_RATE,
    "fastenconnector": (int,),
}  # fmt: skip
RATIO = {"type": "", "sizeassize": False}
WHEEL = {"id": int, "size": float}
NUMBER = {"id": int}


class LinkageParts:
    """All parts of a file; ModelError for damaged ones."""

    def __init__(self, root: Tag, source: str) -> None:
        self.source = source
        self.connectors: dict[int, FileRecord] = {}
        self.links: list[FileRecord] = []
        self.ratios: list[FileRecord] = []
        for tag in root.inside("connector"):
            self._add_connector(tag)
        for tag in root.inside("Link", "element"):
            self._add_link(tag)
        for tag in (tag for ratios in root.inside("ratios") for tag in ratios.inside("ratio")):
            self._add_ratio(tag)

    def link(self, ident: int | None) -> FileRecord | None:
        """Return the first link with a number, as the program does where a number is repeated."""
        return next((link for link in self.links if link.id == ident), None)

    def read(self, form: dict[str, Any], tag: Tag, known: Collection[Any] = ()) -> FileRecord:
        """Return a tag as a record; errors name the file, the line and the tag. `known`: the records before it."""
        what = f"{tag.name} {tag.attributes.get('id', '')}".strip()
        part = FilePart(f"{self.source}:{tag.line}: {what}", tag.attributes, texts=True)
        part.refuse(
            len(known) >= MOST_PARTS, f"more than {MOST_PARTS} {tag.name.lower()}s are too many for one mechanism"
        )
        own: FileRecord = read(form, part)
        if "layer" in form:
            own.mechanism = bool((own.layer or DRAWN_ON) & MECHANISM)
        return own

    def named(self, tag: Tag, *names: str) -> list[int]:
        """Return the numbers in the tags of some names in a tag."""
        return [self.read(NUMBER, child).id for child in tag.inside(*names)]

    def _add_connector(self, tag: Tag) -> None:
        own, limits = self.read(CONNECTOR, tag, self.connectors), self.named(tag, "slidelimit")
        first = self.connectors[own.id].line if own.id in self.connectors else 0
        own.refuse(first, f"this number is given twice, first in line {first}; change one of the two")
        own.line, own.place, own.links = tag.line, complex(own.x, own.y), []
        own.name = own.name or _letters(own.id)
        own.limits = limits[:2] if own.slider and len(limits) >= 2 else []
        own.fastened = own.fastenlink if own.fasten is None else own.fasten
        self.connectors[own.id] = own

    def _add_link(self, tag: Tag) -> None:
        link = self.read(LINK, tag, self.links)
        link.name, link.connectors = link.name or f"{'actuator' if link.actuator else 'link'}{link.id + 1}", []
        for number in dict.fromkeys(self.named(tag, "connector")):
            link.refuse(number not in self.connectors, f"connector {number} does not exist; remove it from the link")
            link.connectors.append(self.connectors[number])
            self.connectors[number].links.append(link)
        for number in self.named(tag, "fastenconnector"):  # older files have no such attribute of the connector
            if number in self.connectors and self.connectors[number].fastened is None:
                self.connectors[number].fastened = link.id
        self.links.append(link)

    def _add_ratio(self, tag: Tag) -> None:
        ratio = self.read(RATIO, tag, self.ratios)
        wheels = [self.read(WHEEL, child) for child in tag.inside("link")]
        known = [(link, wheel.size) for wheel in wheels if (link := self.link(wheel.id))]
        if len(known) >= 2:
            ratio.links, ratio.sizes = zip(known[0], known[-1], strict=True)
            ratio.chain = ratio.type == "chain"
            self.ratios.append(ratio)


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
    a, b = (c.place for c in link.connectors)
    stroke = scale * abs(abs(b - a) / 2.0 if link.throw is None else link.throw)
    return RepeatedInput.between(stroke * link.cpm / 30.0, stroke, link.startoffset * scale, manual=link.alwaysmanual)
