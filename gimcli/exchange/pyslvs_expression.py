"""The expressions in which Pyslvs writes a mechanism: `M[J[R, P[0, 0], L[ground, L1]], ...]`.

A joint has a type (R, P or RP), for a slot its angle `A[...]`, a colour, its place and its links. Source:
expression_parser.py of the program, whose grammar this is; the parts of a joint may come in any order here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any, TypeVar

from gimcli.errors import ModelError
from gimcli.exchange.draft import LARGEST, DrawnJoint, number_of
from gimcli.exchange.refusing import FilePlace, Refusing

MOST_JOINTS = 500
MOST_LINKS = 50
"""Most links of one joint; ten times as many may be in the whole mechanism."""
MOST_CHARACTERS = 300_000
MOST_COLOUR = 10
"""Most words and signs of a colour."""
TYPES = ("R", "P", "RP")

_TOKEN = re.compile(r"(?:\s|#[^\n]*+)*+(?:(?P<sign>[\[\](),])|(?P<word>[^\s\[\](),#]+))")
Item = TypeVar("Item")


def joints_of(expression: str, source: str, line: int = 1) -> list[DrawnJoint]:
    """Return the joints of an expression that starts in a line of the file `source`.

    Raises ModelError, with the line, for what is no expression.
    """
    start = FilePlace(f"{source}:{line}")
    start.refuse(len(expression) > MOST_CHARACTERS, f"the expression has more than {MOST_CHARACTERS} characters")
    joints = _Expression(expression, source, line).mechanism()
    count = len({link for joint in joints for link in joint.links})
    start.refuse(count > 10 * MOST_LINKS, f"more than {10 * MOST_LINKS} links are too many for one mechanism")
    return joints


class _Expression(Refusing):
    def __init__(self, text: str, source: str, line: int) -> None:
        self.text, self.source, self.first = text, source, line
        self.at = 0

    def refused(self, text: str) -> ModelError:
        return ModelError([f"{self.source}:{self.line()}: {text}"])

    def line(self) -> int:
        """Return the line of the next sign."""
        match = _TOKEN.match(self.text, self.at)
        return self.first + self.text.count("\n", 0, match.start(match.lastgroup or 0) if match else self.at)

    # -- signs ----------------------------------------------------------------------------------

    def peek(self) -> str:
        """Return the next sign or word; "" at the end."""
        match = _TOKEN.match(self.text, self.at)
        return "" if match is None else match["sign"] or match["word"]

    def take(self) -> str:
        """Return the next sign or word, and go on after it."""
        sign, match = self.peek(), _TOKEN.match(self.text, self.at)
        self.at = len(self.text) if match is None else match.end()
        return sign

    def require(self, right: bool, expected: str) -> str:
        """Return the next sign or word, and go on after it; raise ModelError if it is not right."""
        found = f"'{self.peek()[:40]}'" if self.peek() else "the end of the text"
        self.refuse(not right, f"expected {expected}, got {found}")
        return self.take()

    def expect(self, *signs: str) -> None:
        """Go on after signs that must come next."""
        for sign in signs:
            self.require(self.peek() == sign, f"'{sign}'")

    def more(self) -> bool:
        """Return whether another item of a list follows; go on after its comma or the end of the list."""
        if self.peek() != "]":
            self.require(self.peek() == ",", "',' or ']'")
        return not self.ended()

    def ended(self) -> bool:
        """Return whether a list ends here; go on after its end."""
        end = self.peek() == "]"
        if end:
            self.take()
        return end

    def items(self, item: Callable[[], Item], most: int, what: str) -> list[Item]:
        """Return the items up to the end of a list."""
        found: list[Item] = []
        more = not self.ended()
        while more:
            self.refuse(len(found) >= most, f"more than {most} {what}")
            found.append(item())
            more = self.more()
        return found

    # -- the mechanism --------------------------------------------------------------------------

    def mechanism(self) -> list[DrawnJoint]:
        self.expect("M", "[")
        joints = self.items(self.joint, MOST_JOINTS, "joints are too many for one mechanism")
        self.require(not self.peek(), "the end after the mechanism")
        return joints

    def joint(self) -> DrawnJoint:
        place = FilePlace(f"{self.source}:{self.line()}")
        self.expect("J", "[")
        kind = self.require(self.peek() in TYPES, f"a joint type ({', '.join(TYPES)})")
        parts: dict[str, Any] = {}
        read = {"P": lambda: self.numbers(2), "A": lambda: self.numbers(1), "L": self.names, "color": self.colour}
        while self.more():
            key = self.take()
            self.expect("[")
            self.refuse(key not in read, f"expected A[...], color[...], P[...] or L[...] in a joint, got '{key[:40]}'")
            parts[key] = read[key]()
        for key, form in (("P", "P[x, y]"), ("L", "L[...]"), *([("A", "A[angle]")] if kind != "R" else [])):
            place.refuse(key not in parts, f"this joint has no {form}; add it")
        angle = math.radians(parts["A"][0] % 360.0) if "A" in parts else 0.0
        return DrawnJoint(tuple(parts["L"]), kind, complex(*parts["P"]), angle, place.where)

    def numbers(self, count: int) -> list[float]:
        found = []
        for k in range(count):
            if k:
                self.expect(",")
            good = abs(number_of(self.peek())) <= LARGEST
            found.append(float(self.require(good, f"a number of at most {LARGEST:g}")))
        self.expect("]")
        return found

    def names(self) -> list[str]:
        """Return the names of links up to the end of the list."""
        found = self.items(self.name, MOST_LINKS, "links are too many for one joint")
        for name in found:
            self.refuse(found.count(name) > 1, f"link {name[:40]} is named twice in one joint")
        return found

    def name(self) -> str:
        """Return the name of a link."""
        return self.require(self.peek() not in ("", "[", "]", "(", ")", ","), "the name of a link")

    def colour(self) -> None:
        """Go on after a colour: a name, or three numbers in parentheses."""
        for _ in range(MOST_COLOUR):
            if self.peek() not in ("]", ""):
                self.take()
        self.expect("]")
