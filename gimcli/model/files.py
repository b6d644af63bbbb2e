"""The files from which a model is read: the model file and its tables."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from gimcli.model.part import Part
from gimcli.model.schema import Model


def files_read(model: Model, path: Path | None, folder: Path) -> tuple[Path, ...]:
    """Return the model file, if there is one, and every table of laws, efforts and loads."""
    found = (*([path] if path else []), *(folder / name for name in tables_of(model)))
    return tuple(file.absolute() for file in found)


def tables_of(data: Any) -> tuple[str, ...]:
    """Return the tables of laws, efforts and loads as a model, or the data of a model file, names them."""
    return tuple(dict.fromkeys(_tables(data)))


def _tables(data: Any) -> Iterator[str]:
    """Yield the text of every key `table`, at any depth."""
    parts: dict[str, Any] = vars(data) if isinstance(data, Part) else data if isinstance(data, dict) else {}
    for key, value in parts.items():
        if key == "table" and isinstance(value, str):
            yield value
        elif isinstance(value, dict | Part):
            yield from _tables(value)
