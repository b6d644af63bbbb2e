"""The text of a model file with other numbers; everything else stays as it is written.

Values are replaced at their position in the text; keys that are missing are added to their mapping. An alias whose
anchor or own value changes is written out, so that every other part keeps its value.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
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
    names: dict[Any, str] | None = None  # the keys of a mapping as written
    flow: bool = False  # of a list or a mapping: in brackets
    column: int = 0  # of the first key of a mapping, from 0
    target: _Piece | None = None  # of an alias


def replaced(text: str, changes: Mapping[Where, str]) -> str:
    """Return the text of a model file with other scalars, which `changes` gives by their paths of keys.

    A key that is missing is added; a list of nodes becomes a mapping for it.
    """
    root = _Reader(text).document()
    edits, changed = [], set[int]()
    for where, new in changes.items():
        piece, rest = _deepest(root, where)
        if piece.target is None:
            edits.append(_added(text, piece, rest, new) if rest else (piece.start, piece.end, _spaced(piece, new)))
            changed.add(id(piece))
    for where, alias in _aliases(root, ()):
        if any(path[: len(where)] == where for path in changes) or _holds(alias, changed):
            edits.append((alias.start, alias.end, _flow(alias, where, changes)))
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def _deepest(piece: _Piece, where: Where) -> tuple[_Piece, Where]:
    """Return the last value on a path of keys that the text has, or the alias on the path, and the rest of the path."""
    for k, key in enumerate(where):
        if piece.parts is None or key not in piece.parts:
            return piece, where[k:]
        piece = piece.parts[key]
    return piece, ()


def _spaced(piece: _Piece, new: str) -> str:
    """Return a new value; one in place of an empty value needs a space behind the colon."""
    return new if piece.end > piece.start else f" {new}"


def _added(text: str, piece: _Piece, rest: Where, new: str) -> tuple[int, int, str]:
    """Return the edit that adds a key to a value: start, end and new text."""
    item = f"{rest[0]}: {_nested(rest[1:], new)}"
    if piece.parts is None:
        return piece.start, piece.end, _spaced(piece, f"{{{item}}}")
    if piece.names is None:
        start = piece.start if piece.flow else len(text[: piece.start].rstrip())
        return start, piece.end, " " * (not piece.flow) + f"{{nodes: {_flow(piece, (), {})}, {item}}}"
    if piece.flow:
        last = max((part.end for part in piece.parts.values()), default=piece.start + 1)
        return last, last, f", {item}" if piece.parts else item
    line = piece.end if text[piece.end - 1] == "\n" else text.find("\n", piece.end) + 1
    end = "\r\n" if "\r\n" in text else "\n"
    if not line:
        return len(text), len(text), f"{end}{' ' * piece.column}{item}"
    return line, line, f"{' ' * piece.column}{item}{end}"


def _nested(rest: Where, new: str) -> str:
    """Return a value inside mappings of one key each."""
    return f"{{{rest[0]}: {_nested(rest[1:], new)}}}" if rest else new


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
    depth = len(where)
    more = {path[depth]: _nested(path[depth + 1 :], new) for path, new in changes.items()
            if path[:depth] == where and path[depth] not in inner}  # fmt: skip
    if piece.names is None and not more:
        return "[" + ", ".join(inner.values()) + "]"
    if piece.names is None:
        inner = {"nodes": "[" + ", ".join(inner.values()) + "]"}
    names = piece.names or {}
    return "{" + ", ".join(f"{names.get(key, key)}: {one}" for key, one in {**inner, **more}.items()) + "}"


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
            self._fill(piece, event)
        if event.anchor is not None:
            self.anchors[str(event.anchor)] = piece
        return piece

    def _fill(self, piece: _Piece, start: Any) -> None:
        mapping, parts = isinstance(start, yaml.MappingStartEvent), dict[Any, _Piece]()
        piece.parts, piece.flow, piece.names = parts, bool(start.flow_style), {} if mapping else None
        while not self.loader.check_event(yaml.SequenceEndEvent, yaml.MappingEndEvent):
            key: Any = len(parts)
            if piece.names is not None:
                event = self.loader.get_event()
                key = str(event.value)
                piece.column = event.start_mark.column if not parts else piece.column
                piece.names[key] = self.text[event.start_mark.index : event.end_mark.index]
            parts[key] = self._piece()
        end = self.loader.get_event().end_mark.index
        piece.end = end if piece.flow else max((part.end for part in parts.values()), default=end)
