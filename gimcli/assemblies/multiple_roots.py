"""Multiple roots: they cannot be proved, so they are corrected as far as possible and the list is not complete."""

from __future__ import annotations

import numpy as np

from gimcli.assemblies.certificate import Proven, distances, mirror_distance
from gimcli.assemblies.constants import SEARCH
from gimcli.assemblies.loops import LoopFamily, values_and_jacobian
from gimcli.mechanism import BoolArray, ComplexArray

CUT = 1e-9
"""Singular value relative to the largest below which a direction is not corrected (double root or curve)."""

TIMES = 60
"""Number of corrections; each halves the error of a double root."""


def doubtful_real(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> list[ComplexArray]:
    """Return the real points among candidates for multiple roots (candidates, n + q), without duplicates."""
    w = w[np.isfinite(w).all(axis=1)]
    w = w[mirror_distance(family, w) < SEARCH.real] if len(w) else w
    found: list[ComplexArray] = []
    for point in w:
        settled = _settled(family, H, point)
        value, _ = values_and_jacobian(family, H, settled[None])
        if not np.max(np.abs(value), initial=0.0) <= SEARCH.residual * np.max(np.abs(H)):
            continue
        if all(float(distances(family, settled[None], other[None])[0, 0]) > SEARCH.near for other in found):
            found.append(settled)
    return found


def _settled(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> ComplexArray:
    """Return the real point near a candidate, from least-squares corrections."""
    n = family.angles
    w = np.concatenate([1j * w[:n].imag, w[n:].real.astype(complex)])
    unit = np.concatenate([np.full(n, 1j), np.ones(family.slides)])
    for _ in range(TIMES):
        value, J = values_and_jacobian(family, H, w[None])
        rows, half = J[0, : family.loops] * unit, value[0, : family.loops]
        table, error = np.concatenate([rows.real, rows.imag]), np.concatenate([half.real, half.imag])
        if not np.max(np.abs(error), initial=0.0) > np.finfo(float).eps * np.max(np.abs(H)):
            break
        w = w - unit * np.linalg.lstsq(table, error, rcond=CUT)[0]
    return w


def kept_apart(family: LoopFamily, proven: Proven, each: int) -> BoolArray:
    """Return for every group of `each` consecutive roots whether they are proved to be different."""
    if each == 1:
        return np.ones(len(proven.w), dtype=bool)
    gap = proven.w[0::each] - proven.w[1::each]
    n = family.angles
    gap[:, :n] -= 2j * np.pi * np.round(gap[:, :n].imag / (2.0 * np.pi))
    far = np.max(np.abs(gap), axis=1, initial=0.0)
    return np.asarray(far > proven.small[0::each] + proven.small[1::each])
