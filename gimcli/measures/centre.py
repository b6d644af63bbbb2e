"""Instant centres and centrodes: where a point of two members has one velocity, over the motion.

A point P of a member moves at v + i omega (P - O); two members i, j agree at P = i (v_i - v_j) / (omega_i - omega_j),
v being the velocity of the member's point at the frame's origin. Where they rest against each other for a moment, both
differences vanish and their derivatives determine the centre; a pin that joins them is their centre always. Its
place in the frame is the fixed centrode, its places in the members are the moving ones; they roll on each other.
Source: Bottema & Roth, Theoretical Kinematics, 1979, chapter VIII; Norton, Design of Machinery, section 6.5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.errors import UsageError
from gimcli.measures import naming
from gimcli.measures.measure import Head, Kind, Measure
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.rates.derivatives import MotionRates
from gimcli.rates.path_derivatives import PathDerivatives
from gimcli.structure.residual import pose


@dataclass(frozen=True)
class Far:
    """Where a centre counts as being at infinity."""

    sizes: float = 1e7  # of the mechanism: half the digits of the difference of two speeds are gone
    still: float = 1e-12  # sizes a unit of the parameter: members that hardly move against each other have no centre


FAR = Far()


class Centre(Measure):
    """The instant centre of two members, in the frame and in each of them that moves."""

    def __init__(self, mechanism: Mechanism, spec: str, first: int, second: int) -> None:
        self.mechanism, self.spec, self.pair = mechanism, spec, (first, second)
        self.moving = [m for m in self.pair if m != FRAME]
        unit = mechanism.length_unit
        names = [f".{mechanism.members[m].name}" for m in self.moving]
        self.heads = tuple(
            Head(f"{spec}{name}.{axis}", unit, "" if name else "instant centre")
            for name in ["", *names]
            for axis in "xy"
        )

    def values(self, derivatives: PathDerivatives) -> list[FloatArray]:
        """Return x, y in the frame, then along and to the left of each moving member's first two nodes."""
        place = instant_centre(derivatives.along, *self.pair)
        columns = [self.mechanism.to_file(place)]
        columns += [
            local_place(self.mechanism, m, place, derivatives.motion.z) * self.mechanism.scale for m in self.moving
        ]
        return [part for column in columns for part in (column.real, column.imag)]

    def curves(self, derivatives: PathDerivatives) -> dict[str, ComplexArray]:
        """Return the centrodes: the moving ones in the first pose."""
        mechanism, z = self.mechanism, derivatives.motion.z
        place = instant_centre(derivatives.along, *self.pair)
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
    """Return where two members have one velocity (rows,), normal frame; NaN at infinity or where they are one."""
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
    """Return a member's first node and the direction (unit) to its second, as `local` in a file; (rows,)."""
    member, unit = mechanism.members[index], pose(mechanism, index, z)[1]
    along = member.shape[1] - member.shape[0]
    with np.errstate(all="ignore"):
        return z[member.nodes[0]], unit * (along / np.abs(along))


def local_place(mechanism: Mechanism, index: int, place: ComplexArray, z: ComplexArray) -> ComplexArray:
    """Return places (rows,) as seen from a moving member: along, and to the left of, its first two nodes."""
    first, along = _frame_of(mechanism, index, z)
    return np.asarray((place - first) * np.conj(along))


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> list[Measure]:
    first, second = (naming.member(mechanism, spec, name) for name in names)
    if first == second:
        raise UsageError(f"measure '{spec}': two different members have an instant centre")
    return [Centre(mechanism, spec, first, second)]


KIND = Kind(
    "centre",
    "MEMBER/MEMBER",
    "instant centre of two members (frame: the ground) and its centrodes; empty at infinity",
    (2,),
    _make,
)
