"""The YAML edge: schema, loading with line numbers, units, laws, and the compiler."""

from __future__ import annotations

from pathlib import Path

from gimcli.mechanism import Mechanism
from gimcli.model.check import load_model
from gimcli.model.compile import compile_model
from gimcli.model.schema import json_schema

__all__ = ["compile_model", "json_schema", "load", "load_model"]


def load(path: Path | str) -> Mechanism:
    """Read, validate and compile a model file."""
    model = load_model(path)
    return compile_model(model if model.name else model.model_copy(update={"name": Path(path).stem}), Path(path).parent)
