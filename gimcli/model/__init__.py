"""The YAML edge: schema, loading with line numbers, units, laws, and the compiler."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gimcli.mechanism import Mechanism
from gimcli.model.check import load_model
from gimcli.model.compile import compile_model
from gimcli.model.files import files_read
from gimcli.model.schema import json_schema

__all__ = ["compile_model", "json_schema", "load", "load_model"]


def load(path: Path | str) -> Mechanism:
    """Read, validate and compile a model file."""
    path = Path(path)
    model = load_model(path)
    named = model if model.name else model.model_copy(update={"name": path.stem})
    return replace(compile_model(named, path.parent), files=files_read(model, path))
