"""Load a mechanism: from a model file, from YAML text, or from plain data."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gimcli.mechanism import Mechanism


def load(model: Path | str | Mapping[str, Any], folder: Path | str | None = None) -> Mechanism:
    """Return the mechanism of a model file, or of a dict with the keys of one.

    Tables of laws and loads are looked for in `folder`: by default beside the file, for a dict where the program runs.
    Raises ModelError with all faults: of a file with line and column, of a dict with the names of the keys.
    """
    from gimcli.model.read import read_data, read_file

    if isinstance(model, Mapping):
        return read_data(model, Path(folder or ""))
    return read_file(Path(model), None if folder is None else Path(folder))


def loads(text: str, folder: Path | str = "") -> Mechanism:
    """Return the mechanism of a model given as YAML text; tables are looked for in `folder`."""
    from gimcli.model.read import read_text

    return read_text(text, Path(folder))
