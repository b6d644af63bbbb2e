"""Load a mechanism from a model file, from a file of another program, from YAML text or from a dict."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gimcli.errors import ModelError
from gimcli.mechanism import Mechanism

ADDRESS = ("http://", "https://")
YAML = (".yaml", ".yml")
"""Suffixes of model files; the content of other files may be in the format of another program."""


def load(
    model: Path | str | Mapping[str, Any], folder: Path | str | None = None, *, assembly: int | str | None = None
) -> Mechanism:
    """Load a mechanism from a model file, a file of another program, or a dict with the keys of a model file.

    Args:
        model: path of the file, or the name of a shipped model if there is no such path, or the dict. The file of
            another program, or the address (URL) in which it keeps a mechanism, is converted; `left_out` of the
            mechanism names what did not come over.
        folder: folder of the tables that the model names; by default the folder of the file, for a dict the current
            folder.
        assembly: number or signs of the configuration in which the mechanism is assembled, as for `assembled`. It is
            required for a model with nodes without coordinates whose `side` is open.

    Returns:
        The mechanism, the first argument of all other functions.

    Raises:
        ModelError: the model has errors. The message has one line for each; `.faults` is the list of these lines. They
            name line and column of a file, or the keys of a dict.
        UsageError: there is no such assembly.
    """
    return _in_assembly(load_undecided(model, folder), assembly)


def _in_assembly(mechanism: Mechanism, assembly: int | str | None) -> Mechanism:
    """Return a mechanism in a configuration, or in that of its file."""
    if assembly is None:
        return decided(mechanism)
    from gimcli.library.assembled import assembled

    return assembled(mechanism, assembly=assembly)


def decided(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism; raise ModelError, with the choices, if the position of a node without coordinates is open."""
    if mechanism.written is None:
        return mechanism
    opened = mechanism.written.model.open
    if not opened.undecided and not opened.coupled:
        return mechanism
    from gimcli.library.sides import settled

    return settled(mechanism)


def load_undecided(model: Path | str | Mapping[str, Any], folder: Path | str | None = None) -> Mechanism:
    """Load a mechanism as `load` does, also if the side of a node is open: one of the two is then used."""
    from gimcli.model.read import read_data

    if isinstance(model, Mapping):
        return _started(read_data(model, Path(folder or "")))
    return _started(_from_file(model, None if folder is None else Path(folder)))


def _started(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose coupled nodes, if there are any, have rough positions that the solvers can begin at."""
    if mechanism.quantities:
        from gimcli.quantities.catalogue import refuse_names

        refuse_names(mechanism)
    if any(coupling.reads for coupling in mechanism.couplings):
        from gimcli.motion.linked_inputs import with_linked_laws

        mechanism = with_linked_laws(mechanism)
    if mechanism.written is None or not mechanism.written.model.open.coupled:
        return mechanism
    from gimcli.library.sides import with_rough_start

    return with_rough_start(mechanism)


def is_address(model: Path | str) -> bool:
    """Return whether a model is given by an address, which holds the whole mechanism: it is never fetched."""
    return isinstance(model, str) and model.lower().startswith(ADDRESS)


def _from_file(model: Path | str, folder: Path | None) -> Mechanism:
    """Return the mechanism of a model file, or of a file or an address of another program."""
    from gimcli.model.read import read_file

    if is_address(model):
        found = read_by_others(str(model), "<address>", folder=folder)
        if found is None:
            raise ModelError(
                ["<address>: holds no mechanism of a known program (`gim manual other-programs`); give a file"]
            )
        return found
    path = model_path(Path(model))
    ours = path.suffix.lower() in YAML
    if not ours and (found := _converted(path, folder)) is not None:
        return found
    try:
        return read_file(path, folder)
    except ModelError:
        if ours and (found := _converted(path, folder)) is not None:
            return found
        raise


def _converted(path: Path, folder: Path | None) -> Mechanism | None:
    """Return the mechanism of a file of another program; None if the content is in no known format."""
    from gimcli.exchange.content import content_of

    return read_by_others(content_of(path), str(path), path, folder)


def read_by_others(text: str, source: str, path: Path | None = None, folder: Path | None = None) -> Mechanism | None:
    """Return the mechanism of a text in the format of another program; None if it is in none of them."""
    from gimcli.exchange.assembling import model_of
    from gimcli.exchange.registry import draft_of
    from gimcli.model.read import read_data

    draft = draft_of(text, source)
    folder = folder or (path.parent if path else Path())
    return None if draft is None else read_data(model_of(draft), folder, source, draft.left_out, path)


def model_path(model: Path) -> Path:
    """Return the path of a model's file: the path that is given if it exists, else that of a shipped model."""
    if os.path.exists(model):  # unlike `Path.exists`, false for a name that is too long
        return model
    from gimcli.shipped import path_of

    return path_of(model) or model


def loads(text: str, folder: Path | str = "", *, assembly: int | str | None = None) -> Mechanism:
    """Load a mechanism from YAML text.

    Args:
        text: the content of a model file, at most 4 MB.
        folder: folder of the tables that the model names; by default the current folder.
        assembly: number or signs of the configuration in which the mechanism is assembled; see `load`.

    Returns:
        The mechanism.

    Raises:
        ModelError: the model has errors; see `load`.
    """
    from gimcli.model.read import read_text

    return _in_assembly(_started(read_text(text, Path(folder))), assembly)
