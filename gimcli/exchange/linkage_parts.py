"""The connectors and links of a file of Linkage, with their attributes as numbers."""

from __future__ import annotations

from dataclasses import dataclass, field

from gimcli.errors import ModelError
from gimcli.exchange.draft import LARGEST, MOST_PLACES, number_of
from gimcli.exchange.refusing import Refusing
from gimcli.exchange.repeated import RepeatedInput
from gimcli.exchange.tags import Tag

MOST_PARTS = 300
"""Most connectors, links and ratios that are read; the largest samples of the program have 60."""
MECHANISM = 0xFFFFFFF0
"""Layers of the mechanism; the other ones hold lines, text and pictures."""
DEFAULT_RATE = 15.0
"""Revolutions or strokes a minute where the file gives none."""

_ALPHABET = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"


@dataclass(frozen=True)
class PartReader(Refusing):
    """Attributes of one tag; errors name the file, the line and the tag."""

    tag: Tag
    source: str

    def refused(self, text: str) -> ModelError:
        """Return the error for this tag."""
        ident = self.tag.attributes.get("id", "")
        what = f"{self.tag.name} {ident}".strip()
        return ModelError([f"{self.source}:{self.tag.line}: {what}: {text}"])

    def inside(self, *names: str) -> list[PartReader]:
        """Return the tags in this one that have one of some names; all if none is given."""
        return [PartReader(child, self.source) for child in self.tag.children if not names or child.name in names]

    def text(self, key: str) -> str:
        """Return an attribute; "" if it is not given."""
        return self.tag.attributes.get(key, "").strip()

    def true(self, key: str) -> bool:
        """Return whether an attribute is `true`."""
        return self.text(key).lower() == "true"

    def number(self, key: str, default: float | None = None) -> float:
        """Return a finite number."""
        text = self.text(key)
        if not text and default is not None:
            return default
        self.refuse(not text, f"`{key}` is missing; give a number")
        value = number_of(text)
        self.refuse(
            not abs(value) <= LARGEST, f"expected a number of at most {LARGEST:g} for `{key}`, got '{text[:40]}'"
        )
        return value

    def integer(self, key: str, default: int | None = None) -> int:
        """Return a whole number."""
        value = self.number(key, default)
        self.refuse(value != int(value), f"expected a whole number for `{key}`, got '{self.text(key)[:40]}'")
        return int(value)

    def layer(self) -> bool:
        """Return whether the part is on a layer of the mechanism."""
        return bool((self.integer("layer", 16) or 16) & MECHANISM)


@dataclass(eq=False)
class PinPart:
    """A point of links; coordinates and lengths are those of the file."""

    ident: int
    name: str
    place: complex
    mechanism: bool
    anchor: bool
    input: bool
    drawn: bool
    motor: RepeatedInput
    limits: list[int]  # of a slider: the two connectors between which it slides
    slide_radius: float
    fastened: int | None  # link
    own: PartReader
    links: list[LinkPart] = field(default_factory=list)


@dataclass(eq=False)
class LinkPart:
    """A link, with the connectors on it."""

    ident: int
    name: str
    mechanism: bool
    actuator: bool
    gear: bool
    measurement: bool
    manual: bool
    throw: float | None
    cpm: float
    start_offset: float
    fastened: int | None  # link
    fastened_connector: int | None
    own: PartReader
    connectors: list[PinPart] = field(default_factory=list)


@dataclass(frozen=True)
class RatioPart:
    """Two gears that mesh, or that a chain joins."""

    links: tuple[LinkPart, LinkPart]
    sizes: tuple[float, float]
    chain: bool
    radii: bool  # the sizes are radii, else only their ratio matters
    own: PartReader


@dataclass(eq=False)
class LinkageParts:
    """All parts of a file."""

    connectors: dict[int, PinPart] = field(default_factory=dict)
    links: list[LinkPart] = field(default_factory=list)
    ratios: list[RatioPart] = field(default_factory=list)

    def link(self, ident: int | None) -> LinkPart | None:
        """Return the first link with a number, as the program does where a number is repeated."""
        return next((link for link in self.links if link.ident == ident), None)


def read_parts(root: Tag, source: str) -> LinkageParts:
    """Return the parts of a file; raise ModelError for damaged ones."""
    parts, whole = LinkageParts(), PartReader(root, source)
    for own in whole.inside("connector"):
        _add_connector(parts, own)
    for own in whole.inside("Link", "element"):
        _add_link(parts, own)
    for ratios in whole.inside("ratios"):
        for own in ratios.inside():
            _add_ratio(parts, own)
    return parts


def _add_connector(parts: LinkageParts, own: PartReader) -> None:
    ident = own.integer("id")
    first = parts.connectors[ident].own.tag.line if ident in parts.connectors else 0
    own.refuse(first, f"this number is given twice, first in line {first}; change one of the two")
    own.refuse(len(parts.connectors) >= MOST_PARTS, f"more than {MOST_PARTS} connectors are too many for one mechanism")
    limits = [child.integer("id") for child in own.inside("slidelimit")]
    sliding = own.true("slider") and len(limits) >= 2
    parts.connectors[ident] = PinPart(
        ident, own.text("name") or _letters(ident), complex(own.number("x"), own.number("y")), own.layer(),
        own.true("anchor"), own.true("input"), own.true("draw"), _motor(own), limits[:2] if sliding else [],
        own.number("slideradius", 0.0), _ident(own, "fasten", "fastenlink"), own,
    )  # fmt: skip


def _motor(own: PartReader) -> RepeatedInput:
    """Return the input of a connector that is a motor: clockwise if its rate is positive."""
    speed, limit = -6.0 * own.number("rpm", DEFAULT_RATE), own.number("limitangle", 0.0)
    offset, manual = own.number("startoffset", 0.0), own.true("alwaysmanual")
    if limit <= 0.0:
        return RepeatedInput(speed, manual)
    return RepeatedInput.between(speed, limit, offset, manual=manual)


def _letters(ident: int) -> str:
    """Return the name that the program shows for a connector without a name: A, B, ... z, A1, B1, ..."""
    return _ALPHABET[ident % 52] + (str(ident // 52) if ident >= 52 else "") if ident >= 0 else f"C{ident}"


def _ident(own: PartReader, *keys: str) -> int | None:
    return next((own.integer(key) for key in keys if own.text(key)), None)


def _add_link(parts: LinkageParts, own: PartReader) -> None:
    own.refuse(len(parts.links) >= MOST_PARTS, f"more than {MOST_PARTS} links are too many for one mechanism")
    ident = own.integer("id")
    kind = "actuator" if own.true("actuator") else "link"
    link = LinkPart(
        ident, own.text("name") or f"{kind}{ident + 1}", own.layer(), own.true("actuator"), own.true("gear"),
        own.true("measurementelement"), own.true("alwaysmanual"), own.number("throw") if own.text("throw") else None,
        own.number("cpm", DEFAULT_RATE), own.number("startoffset", 0.0), _ident(own, "fastenlink"),
        _ident(own, "fastenconnector"), own,
    )  # fmt: skip
    numbers = [child.integer("id") for child in own.inside("connector")]
    for number in dict.fromkeys(numbers):
        own.refuse(number not in parts.connectors, f"connector {number} does not exist; remove it from the link")
        connector = parts.connectors[number]
        link.connectors.append(connector)
        connector.links.append(link)
    for child in own.inside("fastenconnector"):  # older files have no such attribute of the connector
        fastened = parts.connectors.get(child.integer("id"))
        if fastened is not None and fastened.fastened is None:
            fastened.fastened = ident
    parts.links.append(link)
    own.refuse(
        sum(len(x.connectors) for x in parts.links) > MOST_PLACES,
        f"more than {MOST_PLACES} connectors on links are too many for one mechanism",
    )


def _add_ratio(parts: LinkageParts, own: PartReader) -> None:
    own.refuse(len(parts.ratios) >= MOST_PARTS, f"more than {MOST_PARTS} ratios are too many for one mechanism")
    wheels = own.inside("link")
    known = [(link, wheel) for wheel in wheels if (link := parts.link(wheel.integer("id"))) is not None]
    if own.tag.name == "ratio" and len(known) >= 2:
        (a, first), (b, second) = known[0], known[-1]
        sizes = (first.number("size"), second.number("size"))
        parts.ratios.append(RatioPart((a, b), sizes, own.text("type") == "chain", own.true("sizeassize"), own))
