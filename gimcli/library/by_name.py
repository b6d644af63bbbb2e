"""Values by the names of the file, such as coordinates and directions, and the error for a name that does not exist."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.nearest import guess
from gimcli.rates.member_angles import direction
from gimcli.structure.carried import carried_point

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


def places(mechanism: Mechanism, z: ComplexArray, shape: Callable[[ComplexArray], Any]) -> ByName:
    """Return the coordinates of nodes and points; `shape` converts complex numbers (rows,) to the value."""
    names = (*mechanism.nodes, *(p.name for p in mechanism.points))
    return ByName(names, lambda name: shape(np.asarray(mechanism.to_file(carried_point(mechanism, name, z)))))


def pairs(z: ComplexArray) -> FloatArray:
    """Return complex numbers (rows,) as x and y (rows, 2)."""
    return np.stack([z.real, z.imag], axis=-1)


def coordinates(found: Mapping[str, complex]) -> dict[str, list[float]]:
    """Return complex numbers by name as x and y, for a report; without those that are not known."""
    return {name: [float(z.real), float(z.imag)] for name, z in found.items() if np.isfinite(z)}


def angles(mechanism: Mechanism, z: ComplexArray, shape: Callable[[FloatArray], Any]) -> ByName:
    """Return the directions of the moving members from their first node to their second, in the file's angle unit.

    `shape` converts angles (rows,) to the value.
    """
    return by_member(mechanism, lambda member: shape(direction(mechanism, member, z)))


def by_member(mechanism: Mechanism, find: Callable[[int], Any]) -> ByName:
    """Return values of the moving members by name; `find` is given the index of a member."""
    members = {m.name: k for k, m in enumerate(mechanism.members) if k != FRAME}
    return ByName(tuple(members), lambda name: find(members[name]))
