"""The expressions in which Pyslvs writes a mechanism: `M[J[R, P[0, 0], L[ground, L1]], ...]`.

A joint has a type (R, P or RP), for a slot its angle `A[...]`, a colour, its place and its links. Source:
expression_parser.py of the program, whose grammar this is; the parts of a joint may come in any order here.
"""

from __future__ import annotations

import cmath
import math
import re
from collections import Counter
from typing import NamedTuple

from gimcli.exchange.draft import DrawnJoint
from gimcli.exchange.records import LARGEST, FilePart, number_of

MOST_CHARACTERS = 300_000
DEEPEST = 3
TYPES = ("R", "P", "RP")
PARTS = ("A", "color", "P", "L")

_TOKEN = re.compile(r"(?P<space>(?:\s|#[^\n]*+)*+)(?P<sign>[\[\],]|\([^()\[\]]*+\)|[^\s\[\](),#]++|[()]|\Z)")


def joints_of(expression: str, source: str, line: int = 1) -> list[DrawnJoint]:
    """Return the joints of an expression that starts in a line of the file `source`.

    Raises ModelError, with the line, for what is no expression.
    """
    start = FilePart(f"{source}:{line}")
    start.refuse(len(expression) > MOST_CHARACTERS, f"the expression has more than {MOST_CHARACTERS} characters")
    reading = _ExpressionReading(expression, source, line)
    whole = reading.tree(0)
    whole.place.refuse(whole.word != "M", f"expected 'M', got '{whole.word[:40]}'")
    reading.expect(not reading.sign, "the end after the mechanism")
    return [_joint(tree) for tree in whole.items]


class _Tree(NamedTuple):
    """A word with its place in the file, and what stands in brackets behind it."""

    word: str
    place: FilePart
    items: list[_Tree]

    def number(self) -> float:
        """Return the word as a finite number."""
        value = number_of(self.word)
        self.place.refuse(
            not abs(value) <= LARGEST, f"expected a number of at most {LARGEST:g}, got '{self.word[:40]}'"
        )
        return value


class _ExpressionReading:
    """An expression that is read from its start to its end; `sign` is the next sign or word, "" at the end."""

    def __init__(self, text: str, source: str, line: int) -> None:
        self.tokens, self.source, self.line, self.sign = _TOKEN.finditer(text), source, line, ""
        self.take()

    def take(self) -> str:
        """Return the next sign or word, and go on after it."""
        sign, match = self.sign, next(self.tokens)
        self.line, self.sign = self.line + match["space"].count("\n"), match["sign"]
        return sign

    def expect(self, good: object, what: str) -> None:
        """Raise ModelError if the next sign is not as expected."""
        found = f"'{self.sign[:40]}'" if self.sign else "the end of the text"
        FilePart(f"{self.source}:{self.line}").refuse(not good, f"expected {what}, got {found}")

    def tree(self, depth: int) -> _Tree:
        """Return the next word and the items behind it."""
        self.expect(self.sign not in ("", "[", "]", "(", ")", ",") and depth <= DEEPEST, "a name or a number")
        tree = _Tree(self.sign, FilePart(f"{self.source}:{self.line}"), [])
        self.take()
        if self.sign == "[":
            self.take()
            while self.sign != "]":
                tree.items.append(self.tree(depth + 1))
                self.expect(self.sign in (",", "]"), "',' or ']'")
                if self.sign == ",":
                    self.take()
            self.take()
        return tree


def _joint(tree: _Tree) -> DrawnJoint:
    tree.place.refuse(tree.word != "J", f"expected 'J', got '{tree.word[:40]}'")
    kind = tree.items[0].word if tree.items else ""
    tree.place.refuse(kind not in TYPES, f"expected a joint type ({', '.join(TYPES)}), got '{kind[:40]}'")
    for part in tree.items[1:]:
        form = f"A[...], color[...], P[...] or L[...] in a joint, got '{part.word[:40]}'"
        part.place.refuse(part.word not in PARTS, f"expected {form}")
    parts = {part.word: part for part in tree.items[1:]}
    needed = {"P": "P[x, y]", "L": "L[...]", **({"A": "A[angle]"} if kind != "R" else {})}
    for key, form in needed.items():
        good = key in parts and len(parts[key].items) == {"P": 2, "A": 1}.get(key, len(parts[key].items))
        tree.place.refuse(not good, f"this joint has no {form}; add it")
    links = [link.word for link in parts["L"].items]
    for link, count in Counter(links).items():
        tree.place.refuse(count > 1, f"link {link[:40]} is named twice in one joint")
    angle = math.radians(parts["A"].items[0].number() % 360.0) if "A" in parts and parts["A"].items else 0.0
    place, direction = complex(*(x.number() for x in parts["P"].items)), cmath.rect(1.0, angle)
    return DrawnJoint(kind, tuple(links), place, direction, own=tree.place)
