"""Reader of YAML text that keeps the line and column of every part.

Plain scalars are read as in YAML 1.2: `on`, `yes` and `no` are text, `1e-3` is a number. The data are built from
the parser's events, so that deep nesting and repeated aliases are rejected before they take time or memory.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from gimcli import shipped
from gimcli.errors import SYNTAX, ModelError, reason
from gimcli.nearest import nearest

Where = tuple[str | int, ...]
Spot = tuple[int, int]  # line and column, from 1

MOST_BYTES = 4_000_000
DEEPEST = 12
MOST_PARTS = 100_000

LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_INTEGER = re.compile(r"-?(0|[1-9][0-9]*)$")  # 007 is read as a float, so that it is no name
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$")
_SPECIAL = re.compile(r"[-+]?\.(inf|Inf|INF)$|\.(nan|NaN|NAN)$")
_WORDS = {"": None, "~": None, "null": None, "Null": None, "true": True, "True": True, "false": False, "False": False}
MERGE = "<<"
REFUSED = -1
"""Stands for an invalid or repeated key in the paths of the parts below it, which are read and left out."""
CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufffe\uffff]")
_LAYOUT = {ord(sign): " " for sign in "\t\n"}
_INVISIBLE = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")
"""Control characters, and characters that change the direction of text; escapes in quoted text can produce them."""


class Fault(NamedTuple):
    """One error of a file; errors sort by line and column."""

    line: int
    column: int
    text: str


@dataclass
class Source:
    """A file's data, the positions of its keys and values, and its errors."""

    path: Path
    data: Any = None
    folder: Path = Path()  # paths of tables start here
    text: str = field(default="", repr=False)
    by_line: bool = True  # errors name line and column, otherwise the path of keys
    keys: dict[Where, Spot] = field(default_factory=dict)
    values: dict[Where, Spot] = field(default_factory=dict)
    extents: dict[Where, tuple[int, int]] = field(default_factory=dict)  # of values in the text, with their anchors
    aliases: dict[Where, Where] = field(default_factory=dict)  # the paths of their anchors
    faults: list[Fault] = field(default_factory=list)

    def fault(self, where: Where, text: str, key: bool = False) -> None:
        """Record an error at a part of the data, or at the nearest part around it that the file has."""
        table = self.keys if key else self.values
        while where and where not in table:
            where, table = where[:-1], self.values
        self.fault_at(table.get(where, (1, 1)), text)

    def fault_at(self, spot: Spot, text: str) -> None:
        """Record an error at a line and column."""
        self.faults.append(Fault(*spot, text))

    def error(self) -> ModelError:
        """Return all recorded errors as one ModelError, each `file:line:column: text` or `file: key.key: text`."""
        found = sorted(dict.fromkeys(self.faults))
        if self.by_line:
            return ModelError([f"{self.path}:{f.line}:{f.column}: {f.text}" for f in found])
        at = {spot: where for table in (self.values, self.keys) for where, spot in reversed(table.items())}
        return ModelError([": ".join([str(self.path), *_keys(at, f), f.text]) for f in found])


def _keys(at: dict[Spot, Where], fault: Fault) -> list[str]:
    """Return the dotted path of keys of an error as a list of one; empty at the top level."""
    name = ".".join(map(str, at.get((fault.line, fault.column), ())))
    return [name] if name and not fault.text.startswith(f"{name}: ") else []


def part_of(data: Any, where: Where) -> Any:
    """Return the part of plain data at a path of keys."""
    for key in where:
        data = data[key]
    return data


def read_source(path: Path) -> Source:
    """Read a model file; raise ModelError if it is not a YAML mapping or too large."""
    return read_yaml(_text(path), path)


def read_yaml(text: str, path: Path) -> Source:
    """Return the source of YAML text; messages name it by `path`.

    Raises ModelError if it is not a YAML mapping or too large.
    """
    refuse_size(len(text.encode("utf-8", "surrogatepass")), path)
    _refuse_control(text, path)
    return _parsed(text, path, LOADER)


def _parsed(text: str, path: Path, reader: Any) -> Source:
    """Return the source of YAML text; libyaml has a bound on nesting of its own, where PyYAML's own reader goes on."""
    source = Source(path, folder=path.parent, text=text)
    loader = reader(text)
    try:
        source.data = _DataBuilder(source, loader).document()
    except yaml.MarkedYAMLError as error:
        if reader is not yaml.SafeLoader and "nesting" in str(error.problem):
            return _parsed(text, path, yaml.SafeLoader)
        source.fault_at(*_syntax(text, error))
        raise source.error() from None
    finally:
        loader.dispose()
    return source


def _text(path: Path) -> str:
    try:
        if path.is_dir():
            raise ModelError([f"{path}: is a folder; name a model file in it{_shipped(path)}{_files_in(path)}"])
        with path.open("rb") as handle:
            raw = handle.read(MOST_BYTES + 1)
    except (FileNotFoundError, ValueError):  # ValueError: a path with a null byte
        raise ModelError([f"{path}: no such file{_models_near(path)}{_files_in(path.parent)}"]) from None
    except OSError as error:
        raise ModelError([f"{path}: cannot be read: {reason(error)}; give the path of a model file"]) from None
    refuse_size(len(raw), path)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ModelError([f"{path}: not a text file (byte {error.start} is not UTF-8); save it as UTF-8"]) from None
    return text


def refuse_size(size: int, path: Path) -> None:
    """Raise ModelError if a model file has too many bytes."""
    if size > MOST_BYTES:
        raise ModelError([f"{path}: is too large for a model file; at most {MOST_BYTES // 1_000_000} MB are read"])


def _refuse_control(text: str, path: Path) -> None:
    found = CONTROL.search(text)
    if found:
        line, column = text.count("\n", 0, found.start()) + 1, found.start() - text.rfind("\n", 0, found.start())
        sign = f"control character {ord(found[0]):#04x}"
        raise ModelError([f"{path}:{line}:{column}: not a text file: it contains the {sign}; remove it"])


def _models_near(path: Path) -> str:
    """Return what to give instead of a path that does not exist: a shipped model of a similar name, if there is one."""
    name = nearest(path.stem, shipped.names())
    if name is None:
        return "; give the path of a model file, or the name of a shipped model (`gim new --list`)"
    return f", and no shipped model of this name; did you mean '{name}'? (`gim new --list`)"


def _shipped(folder: Path) -> str:
    """Return how a shipped model is named that has the name of a folder; else ''."""
    found = shipped.path_of(folder)
    return "" if found is None else f", or {found.name} for the shipped model"


def _files_in(folder: Path) -> str:
    """Return '; in that folder: ...' with the YAML files there, else ''."""
    try:
        names = sorted(p.name for p in folder.iterdir() if p.suffix in (".yaml", ".yml"))
    except OSError:
        return ""
    return f"; in that folder: {', '.join(names[:8])}{' ...' if len(names) > 8 else ''}" if names else ""


def _syntax(text: str, error: yaml.MarkedYAMLError) -> tuple[Spot, str]:
    mark = error.problem_mark or error.context_mark
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    lines = text.splitlines()
    row = lines[line - 1] if line <= len(lines) else ""
    if "\t" in row[: len(row) - len(row.lstrip())]:
        return (line, row.index("\t") + 1), "YAML does not allow tabs for indentation; use spaces"
    cure = "; a blank must follow the colon, and keys of one level begin in one column"
    return (line, column), f"not readable as YAML: {SYNTAX}{cure}"


class PlacedError(ModelError):
    """An error found when the model is compiled; `where` is the path of its key in the file."""

    def __init__(self, where: Where, text: str) -> None:
        self.where = where
        super().__init__([text])


class _Anchor(NamedTuple):
    where: Where
    data: Any
    parts: int
    height: int


class _DataBuilder:
    """Builds plain data from the events of one document."""

    def __init__(self, source: Source, loader: Any) -> None:
        self.source, self.loader = source, loader
        self.parts = self.end = 0  # `end`: index in the text behind the last value
        self.anchors: dict[str, _Anchor] = {}

    def document(self) -> dict[str, Any]:
        """Return the data of the only document, a mapping."""
        self.loader.get_event()  # the stream's start
        if self.loader.check_event(yaml.StreamEndEvent):
            raise self.refused((1, 1), "the file is empty; a model needs `nodes`, `ground` and `links` or `elements`")
        self.loader.get_event()  # the document's start
        first = self.loader.peek_event()
        if not isinstance(first, yaml.MappingStartEvent):
            raise self.refused(
                _spot(first), "the file has no keys; a model file starts with keys such as `nodes:` and `ground:`"
            )
        data, _ = self.part(())
        self.loader.get_event()  # the document's end
        if not self.loader.check_event(yaml.StreamEndEvent):
            raise self.refused(
                _spot(self.loader.peek_event()), "a second document starts here; one file holds one model"
            )
        assert isinstance(data, dict)
        return data

    def refused(self, spot: Spot, text: str) -> ModelError:
        """Record an error after which the file cannot be read further; return all errors."""
        self.source.fault_at(spot, text)
        return self.source.error()

    def part(self, where: Where) -> tuple[Any, int]:
        """Return the next part and its height (0 for a scalar)."""
        event = self.loader.get_event()
        self.source.values[where], self.end = _spot(event), event.end_mark.index
        if isinstance(event, yaml.AliasEvent):
            data, height = self.alias(event, where)
        else:
            before = self.count(event, len(where))
            data, height = self.value(event, where)
            if event.anchor is not None:
                self.anchors[event.anchor] = _Anchor(where, data, self.parts - before, height)
        self.source.extents[where] = event.start_mark.index, self.end
        return data, height

    def value(self, event: Any, where: Where) -> tuple[Any, int]:
        """Return the data and the height of a part that begins with an event; without brackets it ends as its last."""
        if isinstance(event, yaml.ScalarEvent):
            data = scalar(event)
            if isinstance(data, str):
                self.refuse_invisible(data.translate(_LAYOUT), event)
            return data, 0
        found = self.entries(where, isinstance(event, yaml.MappingStartEvent))
        closed = self.loader.get_event().end_mark.index
        self.end = closed if event.flow_style else self.end
        return found

    def count(self, event: Any, depth: int, parts: int = 1) -> int:
        """Count parts and return the count before them; raise ModelError if there are too many or too deep ones."""
        if depth > DEEPEST:
            raise self.refused(_spot(event), "nested too deeply for a model file; `gim schema` lists the keys")
        self.parts += parts
        if self.parts > MOST_PARTS:
            raise self.refused(_spot(event), f"more than {MOST_PARTS} keys and values are too many; shorten the file")
        return self.parts - parts

    def alias(self, event: Any, where: Where) -> tuple[Any, int]:
        """Return the data of an alias; its parts are counted as if it were written out."""
        anchor = self.anchors.get(event.anchor)
        if anchor is None:
            if REFUSED not in where:
                text = f"alias *{event.anchor} has no anchor; write &{event.anchor} before it"
                self.source.fault_at(_spot(event), text)
            return None, 0
        self.count(event, len(where) + anchor.height, anchor.parts)
        self.source.aliases[where] = anchor.where
        return anchor.data, anchor.height

    def entries(self, where: Where, named: bool) -> tuple[Any, int]:
        """Return the entries up to the end of a mapping (`named`) or a sequence, and their height.

        Invalid and repeated keys are recorded.
        """
        found, height = dict[str | int, Any](), 0
        end = yaml.MappingEndEvent if named else yaml.SequenceEndEvent
        while not self.loader.check_event(end):
            name = self.key(where) if named else len(found)
            part, below = self.part((*where, REFUSED if name is None else name))
            height = max(height, below)
            if name is not None:
                found[name] = part
        return found if named else [*found.values()], height + 1

    def key(self, where: Where) -> str | None:
        """Return the next key and store its position; None for an invalid or repeated key."""
        event = self.loader.peek_event()
        spot = _spot(event)
        if not isinstance(event, yaml.ScalarEvent) or not event.value:
            self.part((*where, REFUSED))
            self.source.fault_at(spot, "a key must be a word, such as `name: ...`")
            return None
        self.loader.get_event()
        name = str(event.value)
        if name == MERGE and event.style not in ("'", '"'):
            text = f"merge keys (`{MERGE}`) are not read; write the keys out, or use an alias (*name) for a whole value"
            self.source.fault_at(spot, text)
            return None
        self.refuse_invisible(name, event)
        first = self.source.keys.setdefault((*where, name), spot)
        if first is not spot:
            self.source.fault_at(spot, f"'{name}' is given twice, first in line {first[0]}; rename or remove one")
            return None
        return name

    def refuse_invisible(self, text: str, event: Any) -> None:
        """Record an error if an escape sequence produced a control character."""
        found = _INVISIBLE.search(text)
        if found:
            self.source.fault_at(_spot(event), f"contains the control character {ord(found[0]):#04x}; remove it")


def _spot(event: Any) -> Spot:
    return event.start_mark.line + 1, event.start_mark.column + 1


def scalar(event: Any) -> Any:
    """Return the value of a scalar: text, a number, true, false or None; quoted scalars are text."""
    text = str(event.value)
    if event.style in ("'", '"', "|", ">"):
        return text
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.match(text) and len(text) < 300:
        return int(text)
    if _NUMBER.match(text):
        return float(text)
    if _SPECIAL.match(text):
        return float(text.replace(".", ""))
    return text
