"""Texts as transport, editors and hostile authors leave them: cut, changed in one place, with numbers out of range."""

from __future__ import annotations

import random
import re

CHARACTERS = "09-+.,|&=%*~AZaz_ \t\n\0\x7fé\u2028{}[]\"'#:"
NUMBERS = ("nan", "inf", "-inf", "1e400", "1e999999", "1_000", "", "-", "0x10", "9" * 20, "1e300", "1e-300")


def cut(text: str, most: int = 400) -> list[str]:
    """Return the text cut at every character, at most `most` of them, evenly spaced."""
    step = max(1, len(text) // most)
    return [text[:end] for end in range(0, len(text), step)]


def changed(text: str, count: int, seed: int = 0) -> list[str]:
    """Return texts with one to three characters replaced, inserted, removed or repeated."""
    source = random.Random(seed)
    found = []
    for _ in range(count):
        own = text
        for _ in range(source.randint(1, 3)):
            at = source.randrange(len(own) + 1)
            own = source.choice(
                (
                    own[:at] + source.choice(CHARACTERS) + own[at + 1 :],
                    own[:at] + source.choice(CHARACTERS) + own[at:],
                    own[:at] + own[at + source.randint(1, 9) :],
                    own[:at] + own[at // 2 : at] + own[at:],
                )
            )
        found.append(own)
    return found


def with_numbers(text: str) -> list[str]:
    """Return texts in which one number is replaced by one that is out of range or none."""
    places = [match.span() for match in re.finditer(r"[-+]?\d+(\.\d+)?", text)]
    return [text[:a] + number + text[b:] for a, b in places for number in NUMBERS]
