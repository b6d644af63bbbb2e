"""Curvature of a point's path: a property of the path alone, not of the speed.

kappa = Im(v* a) / |v|^3, positive where the path bends to the left of the motion's direction. Where the point comes to
rest, v = a s + j s^2 / 2 + k s^3 / 6 about that row: it either has a cusp (radius 0, unless a and j are parallel)
or turns back on its own path, with kappa = Im(a* k) / (3 |a|^3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.analysis.influence import Sight
from gimcli.analysis.measures import naming
from gimcli.analysis.measures.measure import Head, Kind, Measure, unit_of
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism


@dataclass(frozen=True)
class Limits:
    """Where a path counts as straight, and a point as resting."""

    flat: float = 1e-12  # sine between v and a, or size over radius: nothing but rounding is left
    rest: float = 6e-6  # |v| / |a| in the parameter: cube root of the rounding, where both formulas err alike
    cusp: float = 1e-4  # sine between a and j above which a point at rest has a cusp: more than `rest` can make
    straight: float = 1e-10  # size over radius where a point turns back: fourth derivatives have fewer digits


LIMITS = Limits()


class Curvature(Measure):
    """Curvature, signed radius and centre of curvature of a path."""

    def __init__(self, mechanism: Mechanism, spec: str, point: str) -> None:
        self.mechanism, self.spec, self.point = mechanism, spec, point
        unit = mechanism.length_unit
        self.heads = (
            Head(f"{spec}.radius", unit, "radius of curvature"),
            Head(f"{spec}.curvature", unit_of(mechanism, "1/{}"), "curvature"),
            Head(f"{spec}.centre.x", unit),
            Head(f"{spec}.centre.y", unit),
        )

    def values(self, sight: Sight) -> list[FloatArray]:
        """Return radius (inf where straight, 0 at a cusp), curvature, and the centre (empty where straight)."""
        kappa, place, normal = path_curvature(sight, self.point)
        with np.errstate(all="ignore"):
            radius = np.where(kappa == 0.0, np.inf, 1.0 / kappa)
            centre = self.mechanism.to_file(place + np.where(np.isfinite(radius), radius, np.nan) * normal)
        scale = self.mechanism.scale
        return [radius * scale, kappa / scale, centre.real, centre.imag]


def path_curvature(sight: Sight, point: str) -> tuple[FloatArray, ComplexArray, ComplexArray]:
    """Return signed curvature, place and left normal (unit) of a point's path, each (rows,), normal frame."""
    size = sight.mechanism.size
    p, v, a = sight.along.point(point)
    with np.errstate(all="ignore"):
        speed, bend = np.abs(v), (np.conj(v) * a).imag
        kappa = bend / speed**3
        flat = (np.abs(bend) <= LIMITS.flat * speed * np.abs(a)) | (np.abs(kappa) * size <= LIMITS.flat)
        kappa[flat] = 0.0
        normal = 1j * v / speed
    _at_rest(sight, point, np.flatnonzero(speed <= LIMITS.rest * np.maximum(np.abs(a), size)), kappa, normal)
    known = sight.way.smooth & np.isfinite(p)
    kappa[~known] = np.nan
    return kappa, p, normal


def _at_rest(sight: Sight, point: str, rows: IntArray, kappa: FloatArray, normal: ComplexArray) -> None:
    """Set curvature and normal of rows in which the point rests."""
    if not len(rows):
        return
    _, _, a, j, k = sight.along_to(4, rows).point(point)
    size = sight.mechanism.size
    with np.errstate(all="ignore"):
        pace, bend = np.abs(a), (np.conj(a) * k).imag / 3.0
        turned = bend / pace**3
        turned[np.abs(turned) * size <= LIMITS.straight] = 0.0
        cusp = np.abs((np.conj(a) * j).imag) > LIMITS.cusp * pace * np.maximum(np.abs(j), pace)
        kappa[rows] = np.where(cusp, np.inf, turned)
        normal[rows] = 1j * a / pace
    kappa[rows[~(pace > LIMITS.rest * size)]] = np.nan  # a point that does not move has no path


def _make(mechanism: Mechanism, names: Sequence[str]) -> list[Measure]:
    spec = f"{KIND.name}:{'/'.join(names)}"
    naming.refuse_count(spec, names, (1,), f"{KIND.name}:{KIND.arguments}")
    naming.refuse_no_point(mechanism, spec, names[0])
    return [Curvature(mechanism, spec, names[0])]


KIND = Kind(
    "curvature", "POINT", "radius (+ to the left of the motion, inf where straight), curvature and centre of a path",
    _make,
)  # fmt: skip
