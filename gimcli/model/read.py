"""A mechanism from a model file, from YAML text, or from plain data: the same checks, the same compiler."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import yaml

from gimcli.errors import ModelError
from gimcli.mechanism import Mechanism
from gimcli.model.check import checked
from gimcli.model.compile import compile_model
from gimcli.model.files import files_read
from gimcli.model.source import DEEPEST, Source, read_source, read_yaml

NAME = "mechanism"


def read_file(path: Path, folder: Path | None = None) -> Mechanism:
    """Read, validate and compile a model file; tables are looked for in `folder`, by default beside it."""
    folder = path.parent if folder is None else folder
    return _mechanism(read_source(path), folder, path.stem, path)


def read_text(text: str, folder: Path) -> Mechanism:
    """Read, validate and compile a model given as YAML text."""
    return _mechanism(read_yaml(text, Path("<text>")), folder, NAME)


def read_data(data: Mapping[str, Any], folder: Path) -> Mechanism:
    """Validate and compile a model given as plain data; faults name keys instead of lines."""
    text = yaml.safe_dump(_plain(data, ()), sort_keys=False, allow_unicode=True, width=float("inf"))
    source = read_yaml(text, Path("<dict>"))
    source.by_line = False
    return _mechanism(source, folder, NAME)


def _mechanism(source: Source, folder: Path, name: str, path: Path | None = None) -> Mechanism:
    source.folder = folder
    model = checked(source)
    model.name = model.name or name
    return replace(compile_model(model, folder), files=files_read(model, path, folder))


def _plain(value: Any, where: tuple[Any, ...]) -> Any:
    """Return what YAML can write of a value: mappings, lists, words and numbers of any library."""
    if len(where) > DEEPEST:
        raise ModelError([f"<dict>: {'.'.join(map(str, where[:4]))}...: nested too deeply for a model"])
    if isinstance(value, Mapping):
        named = {("on" if key is True else str(key)): part for key, part in value.items()}  # YAML 1.1 reads `on` so
        return {key: _plain(part, (*where, key)) for key, part in named.items()}
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value)
    if hasattr(value, "tolist"):
        return _plain(value.tolist(), where)
    if isinstance(value, Sequence):
        return [_plain(part, (*where, k)) for k, part in enumerate(value)]
    if isinstance(value, Path):
        return str(value)
    kind = type(value).__name__
    raise ModelError([f"<dict>: {'.'.join(map(str, where))}: met a {kind}; write a number, a word, a list or a dict"])
