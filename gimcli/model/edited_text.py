"""The text of a model with other dimensions in place; the rest of the text stays as it is."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from gimcli.errors import ModelError, UsageError
from gimcli.mechanism import Mechanism
from gimcli.model.check import checked
from gimcli.model.dimensions import AXES, dimensions_of, written
from gimcli.model.source import Where, read_yaml
from gimcli.model.text_edits import replaced
from gimcli.model.wording import written as written_path

_PLAIN = re.compile(r"[\w(.][\w.+\-*/() ]*")
"""Formulas that need no quotes."""


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
    texts = {written_path(own.source, own.dimensions[name].where): _text(v) for name, v in own.changes.items()}
    texts |= _chosen_positions(own)
    text = replaced(own.source.text, texts)
    _check(new, text)
    return text


def _chosen_positions(own: Any) -> dict[Where, str]:
    """Return the sides and coordinates of nodes without coordinates that an assembly has chosen, by paths of keys."""
    nodes = {n: ", ".join(map(_text, own.model.nodes[n])) for n in own.model.open.chosen}
    return {**_chosen_sides(own), **{("nodes", n): f"[{xy}]" for n, xy in nodes.items()}}


def _chosen_sides(own: Any) -> dict[Where, str]:
    """Return the sides of nodes that an assembly has chosen, by their paths of keys."""
    chosen = {name: part.side for name, part in own.model.open.parts.items() if part.side is not None}
    given = own.source.data["nodes"]
    return {("nodes", n, "side"): side for n, side in chosen.items() if (given[n] or {}).get("side") != side}


def _text(value: float | str) -> str:
    """Return a number, or a formula, as it can be written anywhere in a model file."""
    if isinstance(value, str):
        return value if _PLAIN.fullmatch(value) else json.dumps(value, ensure_ascii=False)
    return repr(float(value)).removesuffix(".0")


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
