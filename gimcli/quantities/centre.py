"""Instant centres and centrodes: the point at which two members have the same velocity, over a motion.

A point P of a member has the velocity v + i omega (P - O), v being that of the member's point at the origin O. Two
members i, j have the same velocity at P = i (v_i - v_j) / (omega_i - omega_j). If they are at rest relative to each
other for an instant, both differences are 0 and their derivatives determine the centre. A common pin is always the
centre. The path of the centre in the frame is the fixed centrode, its paths in the members are the moving centrodes.
Source: Bottema & Roth, Theoretical Kinematics, 1979, chapter VIII; Norton, Design of Machinery, section 6.5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.errors import refuse
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.quantities.quantity import Head, Kind, Quantity, member_of, unit_of
from gimcli.quantities.state import State
from gimcli.rates.derivatives import MotionRates
from gimcli.rates.path_derivatives import PathDerivatives
from gimcli.structure.residual import pose


@dataclass(frozen=True)
class Far:
    """Limits beyond which a centre counts as infinitely far."""

    sizes: float = 1e7  # distance in sizes of the mechanism: the velocity difference is accurate to half the digits
    still: float = 1e-12  # relative motion, in sizes per unit of the parameter, below which there is no centre


FAR = Far()


class Centre(Quantity):
    """The instant centre of two members, in the frame and in each of the two that moves."""

    def __init__(self, mechanism: Mechanism, spec: str, first: int, second: int) -> None:
        self.mechanism, self.spec, self.pair = mechanism, spec, (first, second)
        self.moving = [m for m in self.pair if m != FRAME]
        unit = unit_of(mechanism)
        names = [f".{mechanism.members[m].name}" for m in self.moving]
        self.heads = tuple(
            Head(f"{spec}{name}.{axis}", unit, "" if name else "instant centre")
            for name in ["", *names]
            for axis in "xy"
        )

    def values(self, state: State) -> Sequence[Any]:
        """Return x, y in the frame, then x, y in the own frame of each moving member."""
        place = instant_centre(state.path.along, *self.pair)
        columns = [
            self.mechanism.to_file(place),
            *(local_place(self.mechanism, m, place, state.path.motion.z) * self.mechanism.scale for m in self.moving),
        ]
        return [part for column in columns for part in (column.real, column.imag)]

    def curves(self, path: PathDerivatives) -> dict[str, ComplexArray]:
        """Return the centrodes; the moving ones are drawn in the first pose of their member."""
        mechanism, z = self.mechanism, path.motion.z
        place = instant_centre(path.along, *self.pair)
        names = [mechanism.members[m].name for m in self.pair]
        fixed = FRAME in self.pair
        title = f"fixed centrode of {names[1 - self.pair.index(FRAME)]}" if fixed else f"centre {names[0]}/{names[1]}"
        curves = {title: mechanism.to_file(place)}
        good = np.flatnonzero(np.all(np.isfinite(z), axis=0))
        for m in self.moving if len(good) else []:
            first, along = _frame_of(mechanism, m, z[:, good[:1]])
            local = local_place(mechanism, m, place, z)
            curves[f"moving centrode of {mechanism.members[m].name}"] = mechanism.to_file(first + along * local)
        return curves


def instant_centre(rates: MotionRates, first: int, second: int) -> ComplexArray:
    """Return the instant centre of two members (rows,), normal frame; NaN if infinitely far or not defined."""
    mechanism, size = rates.mechanism, rates.mechanism.size
    pins = set(mechanism.members[first].nodes) & set(mechanism.members[second].nodes)
    if len(pins) == 1:
        return np.asarray(rates.nodes[0, pins.pop()])
    drift, spin = (one - other for one, other in zip(_spin(rates, first), _spin(rates, second), strict=True))
    with np.errstate(all="ignore"):
        rests = np.abs(drift) + size * np.abs(spin) <= FAR.still * size
        drift, spin = (np.where(rests[0], value[1], value[0]) for value in (drift, spin))
        near = np.abs(drift) <= FAR.sizes * size * np.abs(spin)
        moves = np.abs(drift) + size * np.abs(spin) > FAR.still * size
        return np.asarray(np.where(near & moves, 1j * drift / spin, complex(np.nan, np.nan)))


def _spin(rates: MotionRates, index: int) -> tuple[ComplexArray, FloatArray]:
    """Return the velocity of a member's point at the origin, and omega, each with its derivative (2, rows)."""
    rows = rates.nodes.shape[2]
    if index == FRAME:
        return np.zeros((2, rows), dtype=complex), np.zeros((2, rows))
    z, v, a = rates.nodes[:3, rates.mechanism.members[index].nodes[0]]
    omega, alpha = rates.angular(index)[:2]
    return np.array([v - 1j * omega * z, a - 1j * alpha * z - 1j * omega * v]), np.array([omega, alpha])


def _frame_of(mechanism: Mechanism, index: int, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return a member's first node and the unit direction to its second node, its own frame in a file; each (rows,)."""
    member, unit = mechanism.members[index], pose(mechanism, index, z)[1]
    along = member.shape[1] - member.shape[0]
    with np.errstate(all="ignore"):
        return z[member.nodes[0]], unit * (along / np.abs(along))


def local_place(mechanism: Mechanism, index: int, place: ComplexArray, z: ComplexArray) -> ComplexArray:
    """Return points (rows,) in the own frame of a moving member, as `local` in a file."""
    first, along = _frame_of(mechanism, index, z)
    return np.asarray((place - first) * np.conj(along))


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> Sequence[Quantity]:
    first, second = (member_of(mechanism, spec, name) for name in names)
    refuse((first == second, f"measure '{spec}': expected two different members"))
    return [Centre(mechanism, spec, first, second)]


KIND = Kind(
    "centre",
    "MEMBER/MEMBER",
    "instant centre of two members (frame: the ground) and its centrodes; empty at infinity",
    (2,),
    _make,
)
