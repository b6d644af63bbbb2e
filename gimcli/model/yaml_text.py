"""Writer of model files: plain data as tidy YAML text, which readers of YAML 1.1 and of YAML 1.2 read alike."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

WIDTH = 100
"""Greatest length of a line with a mapping or a list in brackets [characters]; longer ones are divided."""
LONGEST_KEY = 1000
"""Greatest length of a key without a question mark before it [characters]; parsers allow 1024."""
_WORDS = {"true", "false", "yes", "no", "on", "off", "y", "n", "null"}
"""Words that YAML 1.1 or 1.2 does not read as text."""
_PLAIN = re.compile(r"""[^\W\d](?:[^\[\]{},:#&!|>'"%@`?\\]*[^\[\]{},:#&!|>'"%@`?\\\s])?""")
"""Text that needs no quotes anywhere, if all its characters are printable."""
_SENTENCE = re.compile(r"[^\W\d](?:[^:#]|:(?=\S)|(?<=\S)#)*(?<![\s:])")
"""Text that needs no quotes outside of brackets, if all its characters are printable."""
_FORMULA = re.compile(r"(?=.*[*/( ])[\d(][\w.+\-*/() ]*(?<! )")
"""A formula, or a number with a unit, that needs no quotes anywhere."""
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}


def yaml_text(
    data: Mapping[str, Any], comments: Sequence[str] = (), notes: Mapping[tuple[str, ...], str] | None = None
) -> str:
    """Return plain data as the text of a model file.

    Args:
        data: the sections by name, in the order in which they are written: mappings with text as keys, lists, text,
            numbers, truth values and None.
        comments: lines of comment at the head of the text.
        notes: comments behind parts, by section and name, such as `("links", "crank")`. A section that has any is
            written with one line for each part.

    Returns:
        The text. Each part of a section is on one line if it fits in `WIDTH` characters. Numbers have as few digits
        as identify them. Text is quoted only where a reader of YAML 1.1 or 1.2 needs it; the key `on` of a part
        is not: such a reader's `true` is understood in its place.
    """
    head = [f"# {_printable(line)}".rstrip() for comment in comments for line in comment.split("\n")]
    body = [line for name, value in data.items() for line in _entry(str(name), value, (), notes or {})]
    return "".join(f"{line}\n" for line in (*head, *body))


def _entry(name: str, value: Any, above: tuple[str, ...], notes: Mapping[tuple[str, ...], str]) -> Iterator[str]:
    """Yield the lines of a key and its value."""
    where, indent = (*above, name), "  " * len(above)
    note = f"  # {_printable(notes[where])}" if where in notes else ""
    key = indent + _key(name, len(where), f"\n{indent}")
    line = f"{key} {_sentence(value) if isinstance(value, str) else flow(value, len(where))}"
    whole = not isinstance(value, Mapping | list | tuple) or not value
    if whole or (len(line) <= WIDTH and not _divided(value, where, notes)):
        yield line + note
        return
    yield key + note
    if isinstance(value, Mapping):
        for own, part in value.items():
            yield from _entry(str(own), part, where, notes)
    else:
        yield from _filled([flow(part, len(where) + 1) for part in value], indent + "  ")


def _divided(value: Any, where: tuple[str, ...], notes: Mapping[tuple[str, ...], str]) -> bool:
    """Return whether a value has one line for each part although it may be short: a section of mappings or lists."""
    if len(where) > 1 or not isinstance(value, Mapping):
        return False
    return any(isinstance(part, Mapping | list | tuple) for part in value.values()) or any(
        other[: len(where)] == where and len(other) > len(where) for other in notes
    )


def _filled(pieces: list[str], indent: str) -> Iterator[str]:
    """Yield the lines of a list in brackets whose entries do not fit on one line."""
    line = f"{indent}[{pieces[0]}"
    for piece in pieces[1:]:
        if len(line) + len(piece) + 3 > WIDTH:
            yield f"{line},"
            line = f"{indent} {piece}"
        else:
            line += f", {piece}"
    yield f"{line}]"


def flow(value: Any, depth: int) -> str:
    """Return plain data in one line; `depth` is the number of keys above it."""
    if isinstance(value, Mapping):
        parts = (f"{_key(str(name), depth + 1)} {flow(part, depth + 1)}" for name, part in value.items())
        return "{" + ", ".join(parts) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(flow(part, depth + 1) for part in value) + "]"
    return _text(value) if isinstance(value, str) else _number(value)


def _key(name: str, depth: int, gap: str = " ") -> str:
    """Return a key with its colon; at depth 3, in a part of a section, `on` is a key of the format.

    A long key has a question mark before it, and a `gap` between key and colon.
    """
    text = "on" if name == "on" and depth == 3 else _text(name)
    return f"? {text}{gap}:" if len(text) > LONGEST_KEY else f"{text}:"


def _sentence(text: str) -> str:
    """Return text outside of brackets."""
    plain = _SENTENCE.fullmatch(text) and text.isprintable() and text.lower() not in _WORDS
    return text if plain else _text(text)


def _text(text: str) -> str:
    """Return text in quotes where it needs them."""
    plain = (_PLAIN.fullmatch(text) and text.lower() not in _WORDS) or _FORMULA.fullmatch(text)
    return text if plain and text.isprintable() else f'"{"".join(map(_escaped, text))}"'


def _escaped(sign: str) -> str:
    """Return a character as it is written between double quotes."""
    if sign in _ESCAPES:
        return _ESCAPES[sign]
    code = ord(sign)
    return sign if sign.isprintable() else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def _number(value: Any) -> str:
    """Return a number, a truth value or None; numbers with an exponent have a point, which YAML 1.1 requires."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(int(value))
    value = float(value)
    if not math.isfinite(value):
        return ".nan" if math.isnan(value) else "-.inf" if value < 0.0 else ".inf"
    digits, mark, exponent = repr(value).partition("e")
    if mark:
        return f"{digits}{'' if '.' in digits else '.0'}e{exponent}"
    return digits if digits == "-0.0" else digits.removesuffix(".0")


def _printable(text: str) -> str:
    """Return text without control characters."""
    return "".join(sign if sign.isprintable() else " " for sign in text)
