"""Curvature of a point's path; it does not depend on the speed.

kappa = Im(v* a) / |v|^3, positive if the path turns to the left of the direction of motion. Where the point comes to
rest, v = a s + j s^2 / 2 + ... near that row: the path has a cusp (radius 0) unless a and j are parallel. If they are,
the point reverses on its path, and the curvature is the mean of the values one step before and behind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.quantities.quantity import Head, Kind, Quantity, place_of, point_names, unit_of
from gimcli.quantities.state import State
from gimcli.rates.path_derivatives import PathDerivatives


@dataclass(frozen=True)
class CurvatureConstants:
    """Limits for straight paths and for points at rest."""

    flat: float = 1e-12  # sine between v and a, or size / radius, below which it is rounding and the path is straight
    rest: float = 2e-5  # |v| / |a| in the parameter below which a point is at rest; above it 7 digits are correct
    cusp: float = 1e-4  # sine between a and j above which a point at rest has a cusp; greater than the effect of `rest`
    step: float = 1e-4  # step of the parameter beside a row at rest: truncation and rounding errors are equal
    straight: float = 1e-7  # size / radius below which the path is straight at that step, where rounding is about 1e-8


LIMITS = CurvatureConstants()


class Curvature(Quantity):
    """Curvature, signed radius and centre of curvature of a path."""

    def __init__(self, mechanism: Mechanism, spec: str, point: str) -> None:
        self.mechanism, self.spec, self.point = mechanism, spec, point
        unit = unit_of(mechanism)
        self.heads = (
            Head(f"{spec}.radius", unit, "radius of curvature"),
            Head(f"{spec}.curvature", unit_of(mechanism, "1/{}"), "curvature"),
            Head(f"{spec}.centre.x", unit),
            Head(f"{spec}.centre.y", unit),
        )

    def values(self, state: State) -> Sequence[Any]:
        """Return radius (inf if straight, 0 at a cusp), curvature, and x, y of the centre (NaN if straight)."""
        kappa, place, normal = path_curvature(state.path, self.point)
        radius = np.where(kappa == 0.0, np.inf, 1.0 / kappa)
        centre = self.mechanism.to_file(place + np.where(np.isfinite(radius), radius, np.nan) * normal)
        scale = self.mechanism.scale
        return [radius * scale, kappa / scale, centre.real, centre.imag]


def path_curvature(derivatives: PathDerivatives, point: str) -> tuple[FloatArray, ComplexArray, ComplexArray]:
    """Return signed curvature, position and unit left normal of a point's path, each (rows,), normal frame."""
    size = derivatives.mechanism.size
    p, v, a = derivatives.along.point(point)
    kappa = _curvature(v, a, size)
    with np.errstate(all="ignore"):
        normal = 1j * v / np.abs(v)
        rests = np.flatnonzero(np.abs(v) <= LIMITS.rest * np.maximum(np.abs(a), size))
    if len(rests):
        _at_rest(derivatives, point, rests, kappa, normal)
    kappa[~(derivatives.smooth & np.isfinite(p))] = np.nan
    return kappa, p, normal


def _curvature(v: ComplexArray, a: ComplexArray, size: float) -> FloatArray:
    """Return the signed curvature from two derivatives; 0 if it is only rounding."""
    with np.errstate(all="ignore"):
        speed, bend = np.abs(v), (np.conj(v) * a).imag
        kappa = bend / speed**3
        flat = (np.abs(bend) <= LIMITS.flat * speed * np.abs(a)) | (np.abs(kappa) * size <= LIMITS.flat)
    return np.asarray(np.where(flat, 0.0, kappa))


def _at_rest(derivatives: PathDerivatives, point: str, rows: IntArray, kappa: FloatArray, normal: ComplexArray) -> None:
    """Set curvature and normal in rows in which the point is at rest, in place."""
    size = derivatives.mechanism.size
    _, _, a, j = derivatives.along_to(3, rows).point(point)
    sides = (derivatives.beside(rows, step).point(point) for step in (LIMITS.step, -LIMITS.step))
    ahead, behind = (_curvature(side[1], side[2], size) for side in sides)
    turned = (ahead - behind) / 2.0  # behind the row the direction of motion is opposite
    turned[np.abs(turned) * size <= LIMITS.straight] = 0.0
    with np.errstate(all="ignore"):
        cusp = np.abs((np.conj(a) * j).imag) > LIMITS.cusp * np.abs(a) * np.maximum(np.abs(j), np.abs(a))
        kappa[rows] = np.where(cusp, np.inf, turned)
        normal[rows] = 1j * a / np.abs(a)
    kappa[rows[~(np.abs(a) > LIMITS.rest * size)]] = np.nan  # a point that does not move has no path


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> Sequence[Quantity]:
    place_of(spec, "point or node", names[0], point_names(mechanism))
    return [Curvature(mechanism, spec, names[0])]


KIND = Kind(
    "curvature", "POINT", "radius (+ to the left of the motion, inf where straight), curvature and centre of a path",
    (1,), _make,
)  # fmt: skip
