"""Reports as JSON objects."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gimcli.output.atomic import written_text


def json_text(report: Mapping[str, Any]) -> str:
    """Return a report as one line of JSON; NaN and infinity become null."""
    return json.dumps(_plain(report), ensure_ascii=False)


def write_json(report: Mapping[str, Any], path: Path | str) -> None:
    """Write a report as a JSON file."""
    with written_text(path) as handle:
        handle.write(json_text(report) + "\n")


def single(value: Any) -> Any:
    """Return a value as a number, text or list of Python, if it is a number or an array of NumPy."""
    return value.tolist() if hasattr(value, "tolist") else value


def _plain(value: Any) -> Any:
    value = single(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value
