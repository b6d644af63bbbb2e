"""The numbers and names of any value of the package: equal values have equal contents."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def contents(value: Any) -> Iterator[bytes]:
    """Yield all numbers and names of a value and its parts, such as a mechanism with its laws and tables."""
    if isinstance(value, np.ndarray):
        yield value.tobytes()
    elif isinstance(value, tuple | list):
        for part in value:
            yield from contents(part)
    elif isinstance(value, dict):
        yield from contents(tuple(value.items()))
    elif is_dataclass(value) or type(value).__module__.startswith("gimcli."):
        own = [field.name for field in fields(value)] if is_dataclass(value) else sorted(vars(value))
        yield type(value).__name__.encode()
        for name in own:
            yield from contents(getattr(value, name))
    elif hasattr(value, "c") and hasattr(value, "x"):  # a piecewise polynomial
        yield value.x.tobytes() + value.c.tobytes()
    else:
        yield repr(value).encode()
