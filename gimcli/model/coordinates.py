"""The text of a model file with other coordinates; everything else stays as it is written.

Values are replaced at their position in the text. An alias whose anchor or own value changes is written out, so that
every other part keeps its value.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import yaml

from gimcli.model.source import LOADER, Where

_PROPERTIES = re.compile(r"(?:[&!]\S*\s+)*")
"""Anchors and tags before a value."""

_FLOW = set(",[]{}\n")
"""Characters that plain text in a flow list must not contain."""


@dataclass
class _Piece:
    """A value in the text: a scalar, a list, a mapping or an alias."""

    start: int  # index of its first character, after anchors and tags
    end: int
    text: str = ""  # as written; of a scalar or an alias
    parts: dict[Any, _Piece] | None = None  # of a list or a mapping
    names: dict[Any, str] = field(default_factory=dict)  # the keys of a mapping as written; empty for a list
    target: _Piece | None = None  # of an alias


def replaced(text: str, changes: Mapping[Where, str]) -> str:
    """Return the text of a model file with other scalars, which `changes` gives by their paths of keys."""
    root = _Reader(text).document()
    edits, changed = [], set[int]()
    for where, new in changes.items():
        piece = _direct(root, where)
        if piece is not None:
            edits.append((piece.start, piece.end, new))
            changed.add(id(piece))
    for where, alias in _aliases(root, ()):
        if any(path[: len(where)] == where for path in changes) or _holds(alias, changed):
            edits.append((alias.start, alias.end, _flow(alias, where, changes)))
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def _direct(piece: _Piece, where: Where) -> _Piece | None:
    """Return the scalar at a path of keys; None if the path leads through an alias."""
    for key in where:
        if piece.parts is None:
            return None
        piece = piece.parts[key]
    return piece if piece.target is None else None


def _aliases(piece: _Piece, where: Where) -> Iterator[tuple[Where, _Piece]]:
    """Yield every alias in the text with its path of keys."""
    if piece.target is not None:
        yield where, piece
    for key, part in (piece.parts or {}).items():
        yield from _aliases(part, (*where, key))


def _holds(piece: _Piece, changed: set[int]) -> bool:
    """Return whether a changed scalar is in a value, also through aliases."""
    if piece.target is not None:
        return _holds(piece.target, changed)
    return id(piece) in changed or any(_holds(part, changed) for part in (piece.parts or {}).values())


def _flow(piece: _Piece, where: Where, changes: Mapping[Where, str]) -> str:
    """Return a value in one line, with the changes."""
    if piece.target is not None:
        return _flow(piece.target, where, changes)
    if piece.parts is None:
        return changes.get(where) or _in_line(piece.text)
    inner = {key: _flow(part, (*where, key), changes) for key, part in piece.parts.items()}
    if piece.names:
        return "{" + ", ".join(f"{piece.names[key]}: {one}" for key, one in inner.items()) + "}"
    return "[" + ", ".join(inner.values()) + "]"


def _in_line(text: str) -> str:
    """Return a scalar as it can be written in a flow list."""
    quoted = text[:1] in "\"'" and "\n" not in text
    return text if quoted or not _FLOW & set(text) else json.dumps(yaml.safe_load(text))


class _Reader:
    """Reads the pieces of a text from the events of its parser."""

    def __init__(self, text: str) -> None:
        self.text, self.anchors = text, dict[str, _Piece]()
        self.loader = LOADER(text)

    def document(self) -> _Piece:
        """Return the only document."""
        try:
            for _ in range(2):
                self.loader.get_event()  # the start of the stream and of the document
            return self._piece()
        finally:
            self.loader.dispose()

    def _piece(self) -> _Piece:
        event = self.loader.get_event()
        start, end = event.start_mark.index, event.end_mark.index
        if isinstance(event, yaml.AliasEvent):
            return _Piece(start, end, target=self.anchors[str(event.anchor)])
        found = _PROPERTIES.match(self.text, start, end)
        start = start if found is None else found.end()
        piece = _Piece(start, end, self.text[start:end])
        if not isinstance(event, yaml.ScalarEvent):
            piece.parts = {}
            self._fill(piece, isinstance(event, yaml.MappingStartEvent))
        if event.anchor is not None:
            self.anchors[str(event.anchor)] = piece
        return piece

    def _fill(self, piece: _Piece, mapping: bool) -> None:
        parts = piece.parts = dict[Any, _Piece]()
        while not self.loader.check_event(yaml.SequenceEndEvent, yaml.MappingEndEvent):
            key: Any = len(parts)
            if mapping:
                event = self.loader.get_event()
                key = str(event.value)
                piece.names[key] = self.text[event.start_mark.index : event.end_mark.index]
            parts[key] = self._piece()
        self.loader.get_event()
