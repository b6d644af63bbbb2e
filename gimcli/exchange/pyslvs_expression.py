"""The expressions in which Pyslvs writes a mechanism: `M[J[R, P[0, 0], L[ground, L1]], ...]`.

A joint has a type (R, P or RP), for a slot its angle `A[...]`, a colour, its place and its links. Source:
expression_parser.py of the program, whose grammar this is; the parts of a joint may come in any order here.
"""

from __future__ import annotations

import cmath
import math
import re
from collections import Counter

from gimcli.exchange.draft import MOST, DrawnJoint, coordinates
from gimcli.exchange.records import LARGEST, FilePart, number_of

MOST_CHARACTERS = 300_000
TYPES = ("R", "P", "RP")
FORMS = {"P": "P[x, y]", "L": "L[...]", "A": "A[angle]", "color": "color[...]"}
"""The parts of a joint; A only for slots, and a colour may be missing."""

_COMMENT = re.compile(r"#[^\n]*")
_START = re.compile(r"\s*M\s*\[")
_JOINT = re.compile(
    r"\s*(?P<start>J)\s*\[\s*(?P<kind>[^\s\[\],]*)\s*(?P<parts>(?:[^\[\]]++|\[[^\[\]]*+\])*+)\]\s*(?:,|(?=\]))"
)
_PART = re.compile(r"\s*,\s*([^\s\[\],]+)\s*\[([^\[\]]*)\]")


def joints_of(expression: str, source: str, line: int = 1) -> list[DrawnJoint]:
    """Return the joints of an expression that starts in a line of the file `source`.

    Raises ModelError, with the line, for what is no expression.
    """

    def place(at: int) -> FilePart:
        lines = text.count("\n", 0, at)
        return FilePart(f"{source}:{line + lines}")

    text, joints = _COMMENT.sub(lambda match: " " * len(match[0]), expression), []
    place(0).refuse(len(text) > MOST_CHARACTERS, f"the expression has more than {MOST_CHARACTERS} characters")
    start = _START.match(text)
    at = start.end() if start else 0
    while start and (match := _JOINT.match(text, at)):
        joints.append(_joint(match["kind"], match["parts"], place(match.start("start"))))
        at = match.end()
    rest = text[at:].lstrip()
    shown = rest.partition("\n")[0][:40]
    found = f"'{shown}'" if rest else "the end of the text"
    form = "M[...]" if start is None else "a joint such as J[R, P[0, 0], L[ground, L1]], or ']' at the end"
    place(len(text) - len(rest)).refuse(not start or rest.rstrip() != "]", f"expected {form}, got {found}")
    place(0).refuse(len(joints) > MOST, f"more than {MOST} joints are too many for one mechanism")
    return joints


def _joint(kind: str, text: str, place: FilePart) -> DrawnJoint:
    """Return a joint from its type and the text of its parts."""
    place.refuse(kind not in TYPES, f"expected a joint type ({', '.join(TYPES)}), got '{kind[:40]}'")
    parts = {word: [item.strip() for item in items.split(",") if item.strip()] for word, items in _PART.findall(text)}
    strange = [*(word for word in parts if word not in FORMS), *_PART.sub("", text).strip(", \t\r\n").split("\n")]
    expected = "A[...], color[...], P[...] or L[...] in a joint"
    place.refuse(any(strange), f"expected {expected}, got '{''.join(strange)[:40]}'")
    counts = {word: len(items) for word, items in parts.items()}
    lacking = {"P": counts.get("P") != 2, "L": "L" not in parts, "A": kind != "R" and counts.get("A") != 1}
    place.check({f"this joint has no {FORMS[word]}; add it": bad for word, bad in lacking.items()})
    numbers = [*parts["P"], *(parts.get("A") or ["0"])[:1]]
    expected = f"expected a number of at most {LARGEST:g}"
    place.check({f"{expected}, got '{text[:40]}'": not abs(number_of(text)) <= LARGEST for text in numbers})
    links, (x, y, angle) = tuple(parts["L"]), map(float, numbers)
    twice = [link for link, count in Counter(links).items() if count > 1]
    place.refuse(twice, f"link {''.join(twice[:1])[:40]} is named twice in one joint")
    return DrawnJoint(kind, links, (x, y), coordinates(cmath.rect(1.0, math.radians(angle % 360.0))), own=place)
