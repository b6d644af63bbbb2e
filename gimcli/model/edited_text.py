"""The text of a model file with other values in place; everything else stays as it is written.

Values are replaced at their position in the text; keys that are missing are added to their mapping. An alias whose
anchor or own value changes is written out, so that every other part keeps its value.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from gimcli.errors import ModelError, UsageError
from gimcli.mechanism import Mechanism
from gimcli.model.check import checked
from gimcli.model.dimensions import AXES, dimensions_of, written
from gimcli.model.source import Source, Where, part_of, read_yaml
from gimcli.model.wording import written as written_path
from gimcli.model.yaml_text import flow

_PROPERTIES = re.compile(r"(?:[&!]\S*\s+)*")
"""Anchors and tags before a value."""


Edit = tuple[int, int, str]
"""A piece of a text, by the indices of its first character and behind its last one, and the new text."""


def written_with(mechanism: Mechanism, changes: Mapping[str, float | str] | None = None) -> str:
    """Return the text of a mechanism's model with other dimensions in place.

    Args:
        mechanism: from `load` or `loads`, or from its `with_`, whose dimensions are then written, too.
        changes: numbers (file's units) or formulas by the names of dimensions, as for `with_`.

    Returns:
        The text. A dimension that the file does not have is added as a key.

    Raises:
        UsageError: an unknown name, or a text in which the value cannot be replaced.
        ModelError: the model does not allow these values.
    """
    new = mechanism.with_(changes or {})
    own = new.written
    values = {written_path(own.source, own.dimensions[name].where): value for name, value in own.changes.items()}
    text = replaced(own.source, values | _chosen_positions(own))
    _check(new, text)
    return text


def _chosen_positions(own: Any) -> dict[Where, Any]:
    """Return the sides and coordinates of nodes without coordinates that an assembly has chosen, by paths of keys."""
    model, given = own.model, own.source.data["nodes"]
    sides = {name: part.side for name, part in model.open.parts.items() if part.side is not None}
    new: dict[Where, Any] = {("nodes", name): model.nodes[name] for name in model.open.chosen}
    return new | {("nodes", n, "side"): side for n, side in sides.items() if (given[n] or {}).get("side") != side}


def _check(mechanism: Mechanism, text: str) -> None:
    """Raise UsageError if a text has other dimensions than a mechanism."""
    own = written(mechanism)
    path, wanted = own.source.path, own.dimensions
    try:
        source = read_yaml(text, path)
        source.folder = own.source.folder
        found = dimensions_of(checked(source))
    except ModelError as error:
        raise UsageError(f"{path}: the new numbers cannot be written in place: {error}") from None
    new = {f"{name}.{axis}" for name in own.model.open.chosen for axis in AXES}
    whole = own.model.nodes.keys() >= own.source.data["nodes"].keys()  # not one of several machines
    names = {**wanted, **found} if whole else wanted
    wrong = [name for name in names if wanted.get(name) != found.get(name) and name not in new]
    if wrong:
        raise UsageError(f"{path}: {wrong[0]} cannot be written in place; write it into the file by hand")


# -- edits ----------------------------------------------------------------------------------


def replaced(source: Source, changes: Mapping[Where, Any]) -> str:
    """Return the text of a model file with other values: plain data by their paths of keys.

    A key that is missing is added; a list of nodes becomes a mapping for it.
    """
    inner = {where for where in changes if any(where[:k] in source.aliases for k in range(len(where) + 1))}
    edits = [_edit(source, where, value) for where, value in changes.items() if where not in inner]
    edits += [_written_out(source, where, changes) for where in source.aliases if _changes(source, where, changes)]
    text = source.text
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def _edit(source: Source, where: Where, value: Any) -> Edit:
    """Return the edit that gives a part another value; missing keys are added to the last mapping on its path."""
    depth = max(k for k in range(len(where) + 1) if where[:k] in source.extents)
    at, rest = where[:depth], where[depth:]
    start, end = source.extents[at]
    start = _PROPERTIES.match(source.text, start, end).end()  # type: ignore[union-attr]  # it also matches nothing
    old = part_of(source.data, at)
    brackets = source.text[start:end].startswith(("[", "{"))
    if rest and old and isinstance(old, dict):
        return _added(source, at, flow(changed({}, rest, value), depth)[1:-1], brackets)
    if isinstance(old, list) and not brackets:  # it begins below its key
        start = len(source.text[:start].rstrip())
    needs_space = start == end or (isinstance(old, list) and not brackets)
    return start, end, " " * needs_space + flow(changed(old, rest, value), depth)


def _added(source: Source, at: Where, item: str, brackets: bool) -> Edit:
    """Return the edit that adds an entry to a mapping in brackets, or a line with it to one without."""
    text, end, keys = source.text, source.extents[at][1], [*part_of(source.data, at)]
    if brackets:
        last = max(source.extents[*at, key][1] for key in keys)
        return last, last, f", {item}"
    indent = " " * (source.keys[*at, keys[0]][1] - 1)
    line = end if text[end - 1] == "\n" else text.find("\n", end) + 1
    ending = "\r\n" if "\r\n" in text else "\n"
    if not line:
        return len(text), len(text), f"{ending}{indent}{item}"
    return line, line, f"{indent}{item}{ending}"


def _written_out(source: Source, alias: Where, changes: Mapping[Where, Any]) -> Edit:
    """Return the edit that replaces an alias by its value, with the changes in it."""
    depth, value = len(alias), part_of(source.data, alias)
    for where, new in changes.items():
        if where[:depth] == alias:
            value = changed(value, where[depth:], new)
    return *source.extents[alias], flow(value, depth)


def _changes(source: Source, alias: Where, changes: Mapping[Where, Any]) -> bool:
    """Return whether the value of an alias is given by a change, or that of its anchor changes."""
    anchor = source.aliases[alias]
    inner = (one for one in source.aliases if one[: len(anchor)] == anchor)
    own = any(path[: len(part)] == part for path in changes for part in (alias, anchor))
    return own or any(_changes(source, one, changes) for one in inner)


def changed(data: Any, where: Where, value: Any) -> Any:
    """Return plain data with another value at a path; missing keys are added, for which a list becomes `nodes`."""
    if not where:
        return value
    key, rest = where[0], where[1:]
    if isinstance(data, list) and isinstance(key, int):
        return [changed(one, rest, value) if k == key else one for k, one in enumerate(data)]
    own = {"nodes": data} if isinstance(data, list) else data if isinstance(data, dict) else {}
    return {**own, key: changed(own.get(key), rest, value)}
