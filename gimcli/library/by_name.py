"""Values by the names of the file, and the error for a name that does not exist."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from gimcli.nearest import guess

LISTED = 20
"""Number of known names in the message for an unknown name."""


class ByName(Mapping[str, Any]):
    """A mapping from names of the file to values; each value is computed when it is read."""

    made_again = True
    """Whether a result is pickled without it."""

    def __init__(self, names: tuple[str, ...], find: Callable[[str], Any]) -> None:
        self._names, self._find = names, find

    def __getitem__(self, name: str) -> Any:
        if name not in self._names:
            raise unknown(name, self._names)
        return self._find(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"{{{', '.join(f'{name!r}: ...' for name in self._names)}}}"


def unknown(name: str, names: Sequence[str]) -> KeyError:
    """Return the error for a name that does not exist, with the most similar name or the known names."""
    return KeyError(f"{name}; {guess(str(name), names, most=LISTED)}")
