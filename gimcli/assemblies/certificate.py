"""Proof that a root exists, that it is the only one in a ball, and whether it is real.

With Y the inverse of the Jacobian at w, beta = |Y F| + |Y| err F bounds the correction, and kappa the change of
I - Y J in the ball of radius rho about w. If max beta + kappa rho < rho, the ball contains exactly one root
(Kantorovich; Krawczyk). The smallest such rho encloses the root; within the largest there is no other root.
Rounding is bounded by terms of eps, not by directed rounding; the proof holds for the rounded coefficients.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.assemblies.loops import LoopFamily, factors, values_and_jacobian
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray

EPS = float(np.finfo(float).eps)
LADDER: FloatArray = 10.0 ** np.linspace(-14.5, 0.25, 60)
"""Radii that are tried [rad, lengths of the normal frame], from rounding errors to values too large for any proof."""

REAL_CORRECTIONS = 2
"""Newton-Raphson steps for a proved real root after its imaginary parts, which are rounding errors, are removed."""


@dataclass(frozen=True)
class Proven:
    """Candidates and their proofs; one row per candidate."""

    w: ComplexArray  # (roots, n + q)
    small: FloatArray  # (roots,) radius that encloses the root; infinite without a proof
    large: FloatArray  # (roots,) radius within which it is the only root
    off: FloatArray  # (roots,) distance from its mirror image
    residual: FloatArray  # (roots,) |f|, |g| relative to the largest coefficient

    @property
    def sure(self) -> BoolArray:
        """Whether each is proved (roots,)."""
        return np.isfinite(self.small)

    @property
    def real(self) -> BoolArray:
        """Whether each is proved to be real (roots,): its mirror image is a root too, but no other root is so near."""
        return np.asarray(self.sure & (self.off + self.small < self.large))

    @property
    def complex(self) -> BoolArray:
        """Whether each is proved not to be real (roots,)."""
        return np.asarray(self.sure & ~self.real & (self.off > 2.0 * self.small))

    def take(self, chosen: BoolArray | IntArray) -> Proven:
        """Return some of the candidates."""
        return Proven(*(getattr(self, f.name)[chosen] for f in fields(self)))

    def joined(self, other: Proven) -> Proven:
        """Return these candidates and others."""
        return Proven(*(np.concatenate([getattr(self, f.name), getattr(other, f.name)]) for f in fields(self)))


def prove(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> Proven:
    """Return the proofs of candidates w (roots, n + q); H (2, L, 1 + n + q), or one for each candidate."""
    with np.errstate(all="ignore"):
        value, jacobian = values_and_jacobian(family, H, w)
        usable = np.asarray(np.isfinite(jacobian).all(axis=(1, 2)) & np.isfinite(value).all(axis=1))
        J = np.where(usable[:, None, None], jacobian, np.eye(w.shape[1]))
        Y = _inverse(J)
        fixed, growing, riding = _bounds(family, H, w, value, J, Y)
        small, large = _radii(fixed, growing, riding, np.abs(w[:, family.angles :]))
        usable &= np.isfinite(Y).all(axis=(1, 2))
        scale = np.max(np.abs(H), axis=(-3, -2, -1))
        residual = np.max(np.abs(value), axis=1, initial=0.0) / scale
    small = np.where(usable, small, np.inf)
    return Proven(w, small, np.where(usable, large, 0.0), mirror_distance(family, w), residual)


def mirror_distance(family: LoopFamily, w: ComplexArray) -> FloatArray:
    """Return the distances (roots,) of points from their images under theta -> 1/conj(theta), s -> conj(s)."""
    n = family.angles
    parts = np.concatenate([np.abs(w[:, :n].real), np.abs(w[:, n:].imag)], axis=1)
    return np.asarray(2.0 * np.max(parts, axis=1, initial=0.0))


def real_form(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> ComplexArray:
    """Return real roots with |theta| = 1 and real s, corrected with these conditions.

    w (roots, n + q); one H for all, or one for each root.
    """
    w, unit = without_image(family, w)
    with np.errstate(all="ignore"):
        for _ in range(REAL_CORRECTIONS):
            table, error = real_equations(family, H, w)
            step = (_inverse(table) @ error[:, :, None])[:, :, 0]
            w = w - np.where(np.isfinite(step), step, 0.0) * unit
    return w


def without_image(family: LoopFamily, w: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return points w (..., n + q) with |theta| = 1 and real s, and the units of such unknowns (n + q,): i and 1."""
    unit = np.repeat([1j, 1.0], [family.angles, family.slides])
    return np.where(unit.imag, 1j * w.imag, w.real), unit


def real_equations(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return the Jacobian (..., 2 L, n + q) and values (..., 2 L) of the real equations at w of `without_image`."""
    unit, (value, J) = np.repeat([1j, 1.0], [family.angles, family.slides]), values_and_jacobian(family, H, w)
    rows, half = J[..., : family.loops, :] * unit, value[..., : family.loops]
    return np.concatenate([rows.real, rows.imag], axis=-2), np.concatenate([half.real, half.imag], axis=-1)


def _inverse(J: NDArray[Any]) -> NDArray[Any]:
    return each_of(np.linalg.inv, J, J)


def each_of(solve: Callable[..., NDArray[Any]], like: NDArray[Any], *stacks: NDArray[Any]) -> NDArray[Any]:
    """Return the results of a numpy function for stacks of matrices; NaN, shaped as `like`, for singular ones."""
    try:
        return np.asarray(solve(*stacks))
    except np.linalg.LinAlgError:
        result = np.full_like(like, np.nan)
        for k, own in enumerate(zip(*stacks, strict=True)):
            with suppress(np.linalg.LinAlgError):
                result[k] = solve(*own)
        return result


def _bounds(
    family: LoopFamily, H: ComplexArray, w: ComplexArray, value: ComplexArray, J: ComplexArray, Y: ComplexArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return beta and the row sums of |I - Y J| as (roots, m, 2), and the terms that grow with the radius.

    The row sums of |Y| E are (roots, m) times e^rho - 1, plus (roots, m, q) times (|s| + rho) e^rho - |s|.
    """
    n, size = family.angles, w.shape[1]
    ab, ride = factors(family, w)
    term = np.abs(H * ab[..., None, :]).reshape(len(w), 2 * family.loops, 1 + n + family.slides)
    inverse = np.abs(Y)
    rounding = (1 + n + family.slides + 12) * EPS
    beta = np.abs(Y @ value[:, :, None])[:, :, 0] + (inverse @ (rounding * term.sum(axis=2))[:, :, None])[:, :, 0]
    moving = family.carried.any(axis=1)
    rides = np.abs(H[..., 1 + n :] * ride[..., None, :]).reshape(len(w), 2 * family.loops, family.slides) * moving
    spread = term[:, :, 1 : 1 + n].sum(axis=2) + rides.sum(axis=2)
    own = np.abs(np.eye(size) - Y @ J).sum(axis=2)
    own += (inverse @ (2 * size * EPS * np.abs(J)).sum(axis=2)[:, :, None])[:, :, 0]
    growing = (inverse @ spread[:, :, None])[:, :, 0]
    return np.stack([beta, own], axis=2), growing, inverse @ rides


def _radii(fixed: FloatArray, growing: FloatArray, riding: FloatArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and the largest proved radius of LADDER; infinite and 0 if none is proved."""
    kappa = fixed[:, :, 1, None] + growing[:, :, None] * np.expm1(LADDER)
    if s.shape[1]:
        reach = (s[:, :, None] + LADDER) * np.exp(LADDER) - s[:, :, None]
        kappa = kappa + riding @ reach
    beta = np.max(fixed[:, :, 0], axis=1)
    good = beta[:, None] + np.max(kappa, axis=1) * LADDER < LADDER
    small = np.where(good.any(axis=1), LADDER[np.argmax(good, axis=1)], np.inf)
    last = good.shape[1] - 1 - np.argmax(good[:, ::-1], axis=1)
    return small, np.where(good.any(axis=1), LADDER[last], 0.0)


def distances(family: LoopFamily, a: ComplexArray, b: ComplexArray) -> FloatArray:
    """Return the distances (a, b) of points a (a, n + q) from b (b, n + q); angles are compared modulo a full turn."""
    return size_of(family, a[:, None, :] - b[None, :, :])


def size_of(family: LoopFamily, gap: ComplexArray) -> FloatArray:
    """Return the greatest parts (...) of differences (..., n + q), whose angles are reduced by full turns in place."""
    angles = gap[..., : family.angles]
    angles -= 2j * np.pi * np.round(angles.imag / (2.0 * np.pi))
    return np.asarray(np.max(np.abs(gap), axis=-1, initial=0.0))


def distinct(family: LoopFamily, proven: Proven) -> Proven:
    """Return the proved candidates without duplicates."""
    proven = proven.take(proven.sure)
    if len(proven.w) < 2:
        return proven
    proven = proven.take(np.argsort(proven.small, kind="stable"))
    gap = distances(family, proven.w, proven.w)
    same = gap <= proven.small[:, None] + proven.small[None, :]
    return proven.take(~np.any(np.tril(same, -1), axis=1))
