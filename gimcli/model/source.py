"""YAML text as plain data, with the line and column of every part.

Plain scalars are read as in YAML 1.2: `on`, `yes` and `no` are words, `1e-3` is a number.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from gimcli.errors import ModelError

Where = tuple[str | int, ...]

MOST_BYTES = 4_000_000
DEEPEST = 12
MOST_PARTS = 400_000

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_INTEGER = re.compile(r"[-+]?[0-9]+$")
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$")
_SPECIAL = re.compile(r"[-+]?\.(inf|Inf|INF)$|\.(nan|NaN|NAN)$")
_WORDS = {"": None, "~": None, "null": None, "Null": None, "true": True, "True": True, "false": False, "False": False}


@dataclass
class Source:
    """A file's data and where its parts stand."""

    path: Path
    data: Any = None
    keys: dict[Where, tuple[int, int]] = field(default_factory=dict)
    values: dict[Where, tuple[int, int]] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    def at(self, where: Where, key: bool = False) -> str:
        """Return file:line:column of a part, or of what holds it."""
        table = self.keys if key else self.values
        while where and where not in table:
            where, table = where[:-1], self.values
        line, column = table.get(where, (1, 1))
        return f"{self.path}:{line}:{column}"


def read_source(path: Path) -> Source:
    """Read a model file; raise ModelError where it is no YAML mapping of reasonable size."""
    text = _text(path)
    _shallow(path, text)
    source = Source(path)
    try:
        loader = _LOADER(text)
        try:
            root = loader.get_single_node()
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        raise ModelError([_syntax(path, text, error)]) from None
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise ModelError([f"{path}:1:1: not readable as YAML: {str(error).splitlines()[0]}"]) from None
    if root is None:
        raise ModelError([f"{path}:1:1: the file is empty; a model needs nodes, ground and links or elements"])
    if not isinstance(root, yaml.MappingNode):
        raise ModelError([f"{path}:1:1: met no keys; a model file starts with keys such as `nodes:` and `ground:`"])
    source.data = _Builder(source).build(root, ())
    return source


def _text(path: Path) -> str:
    if path.is_dir():
        raise ModelError([f"{path}: is a folder; name a model file in it"])
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise ModelError([f"{path}: {size / 1e6:.0f} MB is no model file; the most that is read is 4 MB"])
        raw = path.read_bytes()
    except FileNotFoundError:
        near = sorted(p.name for p in path.parent.glob("*.y*ml"))[:5] if path.parent.is_dir() else []
        hint = f"; in that folder: {', '.join(near)}" if near else ""
        raise ModelError([f"{path}: no such file{hint}"]) from None
    except OSError as error:
        raise ModelError([f"{path}: cannot be read: {error.strerror}"]) from None
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ModelError([f"{path}: not a text file (byte {error.start} is not UTF-8)"]) from None
    if "\0" in text:
        raise ModelError([f"{path}: not a text file (it has a zero byte)"])
    return text


def _shallow(path: Path, text: str) -> None:
    """Refuse nesting that no model has, before the parser recurses into it."""
    depth = 0
    for number, line in enumerate(text.splitlines(), start=1):
        if line.count("- ") > DEEPEST or len(line) - len(line.lstrip(" ")) > 40 * DEEPEST:
            raise ModelError([f"{path}:{number}:1: nested too deeply for a model file"])
        if "[" not in line and "{" not in line and "]" not in line and "}" not in line:
            continue
        for column, sign in enumerate(line, start=1):
            depth += (sign in "[{") - (sign in "]}")
            depth = max(depth, 0)
            if depth > DEEPEST:
                raise ModelError([f"{path}:{number}:{column}: nested too deeply for a model file"])


def _syntax(path: Path, text: str, error: yaml.MarkedYAMLError) -> str:
    mark = error.problem_mark or error.context_mark
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    lines = text.splitlines()
    row = lines[line - 1] if line <= len(lines) else ""
    if "\t" in row[: len(row) - len(row.lstrip())]:
        return f"{path}:{line}:{row.index(chr(9)) + 1}: tabs cannot indent in YAML; use spaces"
    return f"{path}:{line}:{column}: not readable as YAML: {error.problem or error.context}; mend the line"


class _Builder:
    def __init__(self, source: Source) -> None:
        self.source = source
        self.parts = 0

    def build(self, node: Any, where: Where) -> Any:
        self.parts += 1
        if self.parts > MOST_PARTS or len(where) > DEEPEST:
            raise ModelError([f"{self.source.path}:1:1: too many or too deeply nested parts for a model file"])
        self.source.values[where] = (node.start_mark.line + 1, node.start_mark.column + 1)
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, where)
        if isinstance(node, yaml.SequenceNode):
            return [self.build(child, (*where, k)) for k, child in enumerate(node.value)]
        return scalar(node)

    def _mapping(self, node: yaml.MappingNode, where: Where) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for key, value in node.value:
            spot = (key.start_mark.line + 1, key.start_mark.column + 1)
            if not isinstance(key, yaml.ScalarNode):
                self.source.faults.append(f"{self.source.path}:{spot[0]}:{spot[1]}: a key must be a word")
                continue
            name = str(key.value)
            if name in result:
                first = self.source.keys[(*where, name)][0]
                self.source.faults.append(
                    f"{self.source.path}:{spot[0]}:{spot[1]}: '{name}' is given twice, first in line {first};"
                    " rename or remove one"
                )
                continue
            self.source.keys[(*where, name)] = spot
            result[name] = self.build(value, (*where, name))
        return result


def scalar(node: Any) -> Any:
    """Return the value of a scalar: quoted ones are text."""
    text = str(node.value)
    if node.style in ("'", '"', "|", ">"):
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
