"""The text of a model with other dimensions in place; the rest of the text stays as it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gimcli.errors import ModelError, UsageError
from gimcli.mechanism import Mechanism
from gimcli.model.check import checked
from gimcli.model.dimensions import AXES, dimensions_of, written
from gimcli.model.source import Where, read_yaml
from gimcli.model.text_edits import replaced
from gimcli.model.wording import written as written_path


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
