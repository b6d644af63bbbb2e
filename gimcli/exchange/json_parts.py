"""Values of a JSON text, checked where they are used; errors name the file and the keys."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

from gimcli.errors import SYNTAX, ModelError
from gimcli.exchange.draft import LARGEST
from gimcli.exchange.refusing import FilePlace, Refusing

MOST_CHARACTERS = 4_000_000
_NUMBERS: dict[str, Any] = {
    "parse_constant": lambda _word: math.nan, "parse_int": lambda digits: int(digits) if len(digits) < 300 else math.inf
}  # fmt: skip
"""What NaN, Infinity and very long integers mean: no number, which is refused where it is used."""


@dataclass(frozen=True)
class JsonPart(Refusing):
    """A value of a JSON text; `where` is its path of keys, such as `joints.2.position`."""

    value: Any
    source: str
    where: str = ""

    def refused(self, text: str) -> ModelError:
        """Return the error for this value."""
        return ModelError([": ".join(word for word in (self.source, self.where, text) if word)])

    def has(self, key: str) -> bool:
        """Return whether an object has a key whose value is not null."""
        return isinstance(self.value, dict) and self.value.get(key) is not None

    def at(self, key: str | int) -> JsonPart:
        """Return a part of an object or of a list; null if there is none."""
        where = f"{self.where}.{key}".lstrip(".")
        if isinstance(self.value, dict):
            return JsonPart(self.value.get(key), self.source, where)
        inside = isinstance(self.value, list) and isinstance(key, int) and key < len(self.value)
        return JsonPart(self.value[key] if inside else None, self.source, where)

    def entries(self, most: int) -> list[JsonPart]:
        """Return the parts of a list of at most `most` entries."""
        self.refuse(not isinstance(self.value, list), f"expected a list, got {self.found()}")
        self.refuse(len(self.value) > most, f"more than {most} entries are too many for one mechanism")
        return [self.at(k) for k in range(len(self.value))]

    def text(self, default: str = "") -> str:
        """Return a text; numbers are names too."""
        if self.value is None:
            return default
        self.refuse(
            isinstance(self.value, bool) or not isinstance(self.value, str | int),
            f"expected a name, got {self.found()}",
        )
        return str(self.value)

    def number(self, default: float | None = None) -> float:
        """Return a finite number."""
        if self.value is None and default is not None:
            return default
        good = isinstance(self.value, int | float) and not isinstance(self.value, bool)
        self.refuse(
            not good or not abs(self.value) <= LARGEST,
            f"expected a number of at most {LARGEST:g}, got {self.found()}",
        )
        return float(self.value)

    def place(self) -> complex:
        """Return a pair of numbers [x, y]."""
        self.refuse(not isinstance(self.value, list) or len(self.value) != 2, f"expected [x, y], got {self.found()}")
        return complex(self.at(0).number(), self.at(1).number())

    def found(self) -> str:
        """Return what stands there, for a message."""
        if self.value is None:
            return "nothing"
        text = "a list" if isinstance(self.value, list) else "an object" if isinstance(self.value, dict) else ""
        return text or f"'{str(self.value)[:40]}'"


def read_json(text: str, source: str) -> JsonPart:
    """Return the value of a JSON text; raise ModelError with line and column if it is not readable."""
    FilePlace(source).refuse(
        len(text) > MOST_CHARACTERS, f"is too large; at most {MOST_CHARACTERS // 1_000_000} MB are read"
    )
    try:
        return JsonPart(json.loads(text.removeprefix("\ufeff"), **_NUMBERS), source)
    except json.JSONDecodeError as error:
        raise ModelError([f"{source}:{error.lineno}:{error.colno}: not readable as JSON: {SYNTAX}"]) from None
    except RecursionError:
        raise ModelError([f"{source}: not readable as JSON: nested too deeply"]) from None
