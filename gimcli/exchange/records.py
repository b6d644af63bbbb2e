"""Parts of a file of another program as records, whose keys and types of values a form declares.

A form is a value that the key has if the file has none (0.0, "", or False, which all but true is), the type of a value
that must be given (float, str, object), a tuple of one form whose value may be missing (None), a list of one form for
all entries of a list, or a dict of forms by key for a record. JSON values and attributes of tags have the same forms;
errors name the file and the keys.
"""

from __future__ import annotations

import json
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, TypeVar
from urllib.parse import unquote

from gimcli.errors import SYNTAX, ModelError

Item = TypeVar("Item")
Value = TypeVar("Value")

LARGEST = 1e12
"""Largest number in files of programs that write models of any size."""
MOST_ENTRIES = 500
"""Most entries of a list: joints, links, or joints of a link."""
_NUMBERS: dict[str, Any] = {
    "parse_constant": lambda _word: math.nan, "parse_int": lambda digits: int(digits) if len(digits) < 300 else math.inf
}  # fmt: skip
"""What NaN, Infinity and very long integers mean: no number, which is refused where it is used."""

FLAGS = {"true": True, "t": True, "false": False, "f": False}


class Refusing(ABC):
    """A part of a file, or the whole of it."""

    @abstractmethod
    def refused(self, text: str) -> ModelError:
        """Return the error for this part, with its place."""

    def refuse(self, bad: object, text: str) -> None:
        """Raise ModelError if something is wrong with this part."""
        if bad:
            raise self.refused(text)

    def check(self, faults: Mapping[str, object]) -> None:
        """Raise ModelError with the first of the texts that holds."""
        for text, bad in faults.items():
            self.refuse(bad, text)


class FileRecord(SimpleNamespace, Refusing):
    """The values of a part by their keys as attributes, and the part (`own`); further ones may be set."""

    own: FilePart
    __eq__ = object.__eq__
    __hash__ = object.__hash__  # type: ignore[assignment]  # records have no equals

    def refused(self, text: str) -> ModelError:
        """Return the error for this part."""
        return self.own.refused(text)

    def at(self, key: str) -> FilePart:
        """Return the part of a value, for its errors."""
        return self.own.at(key)


@dataclass
class FilePart(Refusing):
    """A value in a file: `place` is its file, or its line and tag, and `keys` the path of keys from there.

    `texts`: all values are texts, as in attributes of tags.
    """

    place: str
    value: Any = None
    keys: tuple[str | int, ...] = ()
    texts: bool = False

    def refused(self, text: str) -> ModelError:
        """Return the error for this value."""
        return ModelError([": ".join(word for word in (self.place, ".".join(map(str, self.keys)), text) if word)])

    def expect(self, good: bool, what: str) -> None:
        """Raise ModelError if the value is not as expected."""
        if not good:
            kinds = {list: "a list", dict: "an object", type(None): "nothing"}
            shown = str(self.value)[:40] if isinstance(self.value, int | float) else f"'{str(self.value)[:40]}'"
            raise self.refused(f"expected {what}, got {kinds.get(type(self.value), shown)}")

    def at(self, key: str) -> FilePart:
        """Return the value of a key of an object; null if it has none."""
        return FilePart(self.place, self.value.get(key), (*self.keys, key), self.texts)

    def entries(self) -> list[FilePart]:
        """Return the entries of a list, which may be parts with places of their own."""
        self.expect(isinstance(self.value, list), "a list")
        self.refuse(len(self.value) > MOST_ENTRIES, f"more than {MOST_ENTRIES} entries are too many for one mechanism")
        return [own if isinstance(own, FilePart) else FilePart(self.place, own, (*self.keys, k), self.texts)
                for k, own in enumerate(self.value)]  # fmt: skip

    # -- values by type -------------------------------------------------------------------------

    def text(self) -> str:
        """Return a text; numbers are names too."""
        text = str(self.value).strip()
        self.expect(bool(text) and isinstance(self.value, str | int) and not isinstance(self.value, bool), "a name")
        return text

    def number(self) -> float:
        """Return a finite number."""
        value = number_of(str(self.value)) if self.texts else self.value
        good = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST
        self.expect(good, f"a number of at most {LARGEST:g}")
        return float(value)

    def integer(self) -> int:
        """Return a whole number."""
        self.expect(self.number().is_integer(), "a whole number")
        return int(self.number())

    def flag(self) -> bool:
        """Return a truth value."""
        text = str(self.value).lower()
        self.expect(text in FLAGS, "true or false")
        return FLAGS[text]

    def point(self) -> complex:
        """Return a pair of numbers [x, y]."""
        self.expect(isinstance(self.value, list) and len(self.value) == 2, "[x, y]")
        return complex(*(part.number() for part in self.entries()))


READERS: dict[type, Callable[[FilePart], Any]] = {
    str: FilePart.text, float: FilePart.number, int: FilePart.integer, bool: FilePart.flag, complex: FilePart.point,
    object: lambda part: part.value,
}  # fmt: skip


def read(form: Any, part: FilePart) -> Any:
    """Return a value by its form; raise ModelError with the faults of all entries of a list."""
    missing = part.value is None or (part.value == "" and (part.texts or form == ""))
    if isinstance(form, tuple):
        return None if missing else read(form[0], part)
    if isinstance(form, list):
        return all_of(lambda entry: read(form[0], entry), part.entries())
    if isinstance(form, dict):
        part.expect(isinstance(part.value, dict), "an object")
        return FileRecord(own=part, **{key: read(own, part.at(key)) for key, own in form.items()})
    if isinstance(form, type):
        return READERS[form](part)
    if form is False:
        return FLAGS.get(str(part.value).lower(), False)
    return form if missing else READERS[type(form)](part)


def all_of(reader: Callable[[Item], Value], entries: Iterable[Item]) -> list[Value]:
    """Return the values of all entries; raise ModelError with the faults of all of them."""
    found, faults = list[Value](), list[str]()
    for entry in entries:
        try:
            found.append(reader(entry))
        except ModelError as error:
            faults += error.faults
    if faults:
        raise ModelError(faults)
    return found


def number_of(text: str) -> float:
    """Return a finite number; nan for any other text."""
    try:
        number = float(text)
    except ValueError:
        return math.nan
    return number if math.isfinite(number) and "_" not in text else math.nan


def by_key(key: str, records: Iterable[FileRecord], what: str) -> dict[Any, FileRecord]:
    """Return records by the value of a key, which no two of them may have in common."""
    found: dict[Any, FileRecord] = {}
    for own in records:
        name = getattr(own, key)
        own.refuse(name in found, f"the {what} '{str(name)[:40]}' is given twice; rename one of the two")
        found[name] = own
    return found


def query_of(address: str) -> list[tuple[str, str]]:
    """Return the keys and the texts behind the question mark of an address, in their order."""
    parts = (part.partition("=") for part in re.split("[?&]", address)[1:])
    return [(key, unquote(text)) for key, _, text in parts]


def read_json(text: str, source: str) -> FilePart:
    """Return the value of a JSON text; raise ModelError with line and column if it is not readable."""
    try:
        return FilePart(source, json.loads(text.removeprefix("\ufeff"), **_NUMBERS))
    except json.JSONDecodeError as error:
        raise ModelError([f"{source}:{error.lineno}:{error.colno}: not readable as JSON: {SYNTAX}"]) from None
    except RecursionError:
        raise ModelError([f"{source}: not readable as JSON: nested too deeply"]) from None
