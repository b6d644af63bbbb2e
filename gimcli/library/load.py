"""Load a mechanism from a model file, from YAML text or from a dict."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gimcli.mechanism import Mechanism


def load(model: Path | str | Mapping[str, Any], folder: Path | str | None = None) -> Mechanism:
    """Load a mechanism from a model file, or from a dict with the keys of a model file.

    Args:
        model: path of the file, or the dict.
        folder: folder of the tables that the model names; by default the folder of the file, for a dict the current
            folder.

    Returns:
        The mechanism, the first argument of all other functions.

    Raises:
        ModelError: the model has errors. The message has one line for each; `.faults` is the list of these lines. They
            name line and column of a file, or the keys of a dict.
    """
    from gimcli.model.read import read_data, read_file

    if isinstance(model, Mapping):
        return read_data(model, Path(folder or ""))
    return read_file(Path(model), None if folder is None else Path(folder))


def loads(text: str, folder: Path | str = "") -> Mechanism:
    """Load a mechanism from YAML text.

    Args:
        text: the content of a model file, at most 4 MB.
        folder: folder of the tables that the model names; by default the current folder.

    Returns:
        The mechanism.

    Raises:
        ModelError: the model has errors; see `load`.
    """
    from gimcli.model.read import read_text

    return read_text(text, Path(folder))
