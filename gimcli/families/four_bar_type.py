"""Grashof types of the designs of a family."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gimcli.families.float_tables import FloatTables
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.quantities.state import first_row
from gimcli.structure.four_bars import FourBar
from gimcli.structure.loop_types import cross
from gimcli.structure.mechanism_types import mechanism_type

FLAT = 1e-6
"""Height of a loop, relative to its size, below which rounding decides whether it is crossed."""

LETTERS = "<U40"
"""Type of an array of types."""


def four_bar_types(mechanism: Mechanism, tables: FloatTables, z: ComplexArray) -> NDArray[np.str_]:
    """Return the Grashof type of the first four-bar loop in each design, in the words of `gim check`.

    `z` (designs, nodes) is a position of each design; it distinguishes antiparallelograms. Where all links are in line,
    the initial coordinates do.
    """
    loop = next(one.loop for one in mechanism_type(mechanism, mechanism.drawn).loops if one.four_bar)
    a, b, c, d = (joint.node for joint in loop.joints)
    ends = (d, a), (a, b), (b, c), (c, d)
    lengths = np.stack([_lengths(mechanism, tables, link, *e, z) for link, e in zip(loop.links, ends, strict=True)], 1)
    corners = z[:, [d, a, b, c]]
    corners[_flat(corners)] = mechanism.drawn[[d, a, b, c]]
    kinds = [_kind(row, own) for row, own in zip(lengths.tolist(), corners, strict=True)]
    return np.array(kinds, dtype=LETTERS)


def _flat(corners: ComplexArray) -> BoolArray:
    """Return whether the corners (designs, 4) of each loop are on one line."""
    reach = corners - corners[:, :1]
    far = reach[np.arange(len(reach)), np.argmax(np.abs(reach), axis=1)]
    return np.asarray(np.all(np.abs((reach * far[:, None].conj()).imag) <= FLAT * np.abs(far[:, None]) ** 2, axis=1))


def _kind(lengths: list[float], corners: ComplexArray) -> str:
    """Return the type without the remarks in brackets or after a comma."""
    d, a, b, c = corners.tolist()
    found = FourBar((lengths[0], lengths[1], lengths[2], lengths[3]), cross(d, a, b, c))
    return found.kind.partition(" (")[0].partition(",")[0]


def _lengths(mechanism: Mechanism, tables: FloatTables, link: int, a: int, b: int, z: ComplexArray) -> FloatArray:
    """Return the distance of two nodes of a link in each design: of a member its own, otherwise at the position."""
    if link < len(mechanism.members) and {a, b} <= set(mechanism.members[link].nodes):
        first = first_row(mechanism, link)
        nodes = mechanism.members[link].nodes
        side = tables.shapes[:, first + nodes.index(b)] - tables.shapes[:, first + nodes.index(a)]
        return np.asarray(np.hypot(side[:, 0], side[:, 1]))
    return np.asarray(np.abs(z[:, b] - z[:, a]))
