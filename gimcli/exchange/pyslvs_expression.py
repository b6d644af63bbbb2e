"""The expressions in which Pyslvs writes a mechanism: `M[J[R, P[0, 0], L[ground, L1]], ...]`.

A joint has a type (R, P or RP), for a slot its angle `A[...]`, a colour, its place and its links. Source:
expression_parser.py of the program, whose grammar this is; the parts of a joint may come in any order here.
"""

from __future__ import annotations

import math
import re

from gimcli.errors import ModelError
from gimcli.exchange.draft import DrawnJoint

MOST_JOINTS = 500
MOST_LINKS = 50
"""Most links of one joint; ten times as many may be in the whole mechanism."""
MOST_CHARACTERS = 300_000
MOST_COLOUR = 10
"""Most words and signs of a colour."""
TYPES = ("R", "P", "RP")

_TOKEN = re.compile(r"(?:\s|#[^\n]*+)*+(?:(?P<sign>[\[\](),])|(?P<word>[^\s\[\](),#]+))")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")
_LARGEST = 1e12


def joints_of(expression: str, source: str, line: int = 1) -> list[DrawnJoint]:
    """Return the joints of an expression that starts in a line of the file `source`.

    Raises ModelError, with the line, for what is no expression.
    """
    if len(expression) > MOST_CHARACTERS:
        raise ModelError([f"{source}:{line}: the expression has more than {MOST_CHARACTERS} characters"])
    joints = _Expression(expression, source, line).mechanism()
    if len({link for joint in joints for link in joint.links}) > 10 * MOST_LINKS:
        raise ModelError([f"{source}:{line}: more than {10 * MOST_LINKS} links are too many for one mechanism"])
    return joints


class _Expression:
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
        match = _TOKEN.match(self.text, self.at)
        self.at = len(self.text) if match is None else match.end()
        return "" if match is None else match["sign"] or match["word"]

    def expect(self, *signs: str) -> None:
        """Go on after signs that must come next."""
        for sign in signs:
            if self.peek() != sign:
                raise self.refused(f"expected '{sign}', got {self.found()}")
            self.take()

    def found(self) -> str:
        """Return what comes next, for a message."""
        return f"'{self.peek()[:40]}'" if self.peek() else "the end of the text"

    def more(self) -> bool:
        """Return whether another item of a list follows; go on after its comma or the end of the list."""
        if self.peek() == ",":
            self.take()
        elif self.peek() != "]":
            raise self.refused(f"expected ',' or ']', got {self.found()}")
        if self.peek() == "]":
            self.take()
            return False
        return True

    # -- the mechanism --------------------------------------------------------------------------

    def mechanism(self) -> list[DrawnJoint]:
        joints: list[DrawnJoint] = []
        self.expect("M", "[")
        if self.peek() == "]":
            self.take()
        else:
            joints.append(self.joint())
            while self.more():
                if len(joints) >= MOST_JOINTS:
                    raise self.refused(f"more than {MOST_JOINTS} joints are too many for one mechanism")
                joints.append(self.joint())
        if self.peek():
            raise self.refused(f"expected the end after the mechanism, got {self.found()}")
        return joints

    def joint(self) -> DrawnJoint:
        line = self.line()
        self.expect("J", "[")
        kind = self.peek()
        if kind not in TYPES:
            raise self.refused(f"expected a joint type ({', '.join(TYPES)}), got {self.found()}")
        self.take()
        place: list[float] | None = None
        links: list[str] | None = None
        angle: list[float] = []
        while self.more():
            key = self.take()
            self.expect("[")
            if key == "P":
                place = self.numbers(2)
            elif key == "A":
                angle = self.numbers(1)
            elif key == "L":
                links = self.names()
            elif key == "color":
                self.colour()
            else:
                raise self.refused(f"expected A[...], color[...], P[...] or L[...] in a joint, got '{key[:40]}'")
        missing = "P[x, y]" if place is None else "L[...]" if links is None else "A[angle]"
        if place is None or links is None or (kind != "R" and not angle):
            raise ModelError([f"{self.source}:{line}: this joint has no {missing}; add it"])
        direction = math.radians(angle[0] % 360.0) if angle else 0.0
        return DrawnJoint(tuple(links), kind, complex(*place), direction, f"{self.source}:{line}")

    def numbers(self, count: int) -> list[float]:
        found = []
        for k in range(count):
            if k:
                self.expect(",")
            value = float(self.peek()) if _NUMBER.match(self.peek()) else math.nan
            if not abs(value) <= _LARGEST:
                raise self.refused(f"expected a number of at most {_LARGEST:g}, got {self.found()}")
            found.append(value)
            self.take()
        self.expect("]")
        return found

    def names(self) -> list[str]:
        """Return the names of links up to the end of the list."""
        found: list[str] = []
        if self.peek() == "]":
            self.take()
            return found
        more = True
        while more:
            if self.peek() in ("", "[", "]", "(", ")", ","):
                raise self.refused(f"expected the name of a link, got {self.found()}")
            name = self.take()
            if name in found:
                raise self.refused(f"link {name[:40]} is named twice in one joint")
            if len(found) >= MOST_LINKS:
                raise self.refused(f"more than {MOST_LINKS} links are too many for one joint")
            found.append(name)
            more = self.more()
        return found

    def colour(self) -> None:
        """Go on after a colour: a name, or three numbers in parentheses."""
        for _ in range(MOST_COLOUR):
            if self.peek() not in ("]", ""):
                self.take()
        self.expect("]")
