"""Loop equations of a planar linkage in isotropic coordinates.

Unknowns are theta_c = e^(i phi_c) of every rotation class and s_q of every passive slide. For every loop k

    f_k = C0_k + sum_c C_kc theta_c + sum_q U_kq s_q theta_m(q)              = 0
    g_k = conj(C0_k) + sum_c conj(C_kc) / theta_c + sum_q conj(U_kq) s_q / theta_m(q) = 0

m(q) is the class that carries the rail of slide q. All coefficients are linear in the linkage's own points
and rail directions: the *family* of a topology is every complex choice of these, with the conjugates independent.
Numerically the unknowns are w = [log theta, s]. Source: C. Wampler, Displacement analysis of spherical and
planar mechanisms, 2001 (isotropic coordinates).
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray, FloatArray, IntArray

GROUND = -1
"""Rail of a slide whose direction is known."""


class Coefficients(NamedTuple):
    """Coefficients of f (C0, C, U) and of g (D0, D, V); leading axes, if any, are members of the family."""

    C0: ComplexArray  # (..., L)
    C: ComplexArray  # (..., L, n)
    U: ComplexArray  # (..., L, q)
    D0: ComplexArray  # (..., L)
    D: ComplexArray  # (..., L, n)
    V: ComplexArray  # (..., L, q)


@dataclass(frozen=True)
class Family:
    """Which coefficients each parameter enters: C0 = T0 p, C = TC p, U = TU p."""

    T0: FloatArray = field(repr=False)  # (L, parameters) small integers
    TC: FloatArray = field(repr=False)  # (L, n, parameters)
    TU: FloatArray = field(repr=False)  # (L, q, parameters)
    rail: IntArray  # (q,) class, or GROUND

    @property
    def loops(self) -> int:
        """Number of loops L."""
        return self.T0.shape[0]

    @property
    def angles(self) -> int:
        """Number of rotation classes n."""
        return self.TC.shape[1]

    @property
    def slides(self) -> int:
        """Number of passive slides q."""
        return self.TU.shape[1]

    @property
    def square(self) -> bool:
        """Tell whether there are as many equations as unknowns."""
        return self.angles + self.slides == 2 * self.loops

    @cached_property
    def key(self) -> str:
        """A name of the topology: the same for the same tensors."""
        digest = hashlib.sha256(repr((self.TC.shape, self.TU.shape, self.rail.tolist())).encode())
        for tensor in (self.T0, self.TC, self.TU):
            digest.update(np.ascontiguousarray(tensor, dtype=np.int8).tobytes())
        return digest.hexdigest()[:32]

    @cached_property
    def carried(self) -> FloatArray:
        """(q, n) 1 where a class carries the rail of a slide."""
        table = np.zeros((self.slides, self.angles))
        for q, m in enumerate(self.rail):
            if m != GROUND:
                table[q, m] = 1.0
        return table

    @cached_property
    def stacked(self) -> FloatArray:
        """The three tensors as one (L (1 + n + q), parameters)."""
        count = self.T0.shape[-1]
        return np.concatenate([self.T0.reshape(-1, count), self.TC.reshape(-1, count), self.TU.reshape(-1, count)])

    def member(self, p: ComplexArray, pb: ComplexArray) -> Coefficients:
        """Return the coefficients for parameters p and, independent of them, pb, both (..., parameters)."""
        return Coefficients(*self._half(p), *self._half(pb))

    def _half(self, p: ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        L, n, q = self.loops, self.angles, self.slides
        flat = p @ self.stacked.T
        lead = flat.shape[:-1]
        c0, c, u = flat[..., :L], flat[..., L : L + L * n], flat[..., L + L * n :]
        return c0, c.reshape(*lead, L, n), u.reshape(*lead, L, q)


@dataclass(frozen=True)
class Loops:
    """The loop equations of one real linkage; n + q = 2 L."""

    C0: ComplexArray  # (L,)
    C: ComplexArray  # (L, n)
    U: ComplexArray  # (L, q)
    rail: IntArray  # (q,) class that carries the rail, or GROUND
    family: Family = field(repr=False)
    p: ComplexArray = field(repr=False)  # (parameters,)

    @classmethod
    def of(cls, family: Family, p: ComplexArray) -> Loops:
        """Return the linkage of a family that has parameters p."""
        c0, c, u = family.member(p, p)[:3]
        return cls(c0, c, u, family.rail, family, p)

    @cached_property
    def coefficients(self) -> Coefficients:
        """Both halves; the second is the conjugate of the first."""
        return Coefficients(self.C0, self.C, self.U, self.C0.conj(), self.C.conj(), self.U.conj())

    @property
    def span(self) -> float:
        """Largest coefficient of a length: what residuals are relative to."""
        return float(max(np.max(np.abs(self.C0), initial=0.0), np.max(np.abs(self.C), initial=0.0)))


class Terms(NamedTuple):
    """The terms of f and g at some roots, from which the equations and the Jacobian are summed."""

    turn: ComplexArray  # (roots, n) theta
    ride: ComplexArray  # (roots, q) theta_m
    f_angle: ComplexArray  # (roots, L, n)
    g_angle: ComplexArray
    f_slide: ComplexArray  # (roots, L, q)
    g_slide: ComplexArray


def terms(family: Family, h: Coefficients, w: ComplexArray) -> Terms:
    """Return the terms at w (roots, n + q)."""
    n = family.angles
    turn, s = np.exp(w[:, :n]), w[:, n:]
    back = 1.0 / turn
    if not family.slides:
        none = np.zeros((len(w), family.loops, 0), dtype=complex)
        return Terms(turn, s, h.C * turn[:, None, :], h.D * back[:, None, :], none, none)
    ride = np.concatenate([np.ones((len(w), 1)), turn], axis=1)[:, family.rail + 1]
    f_slide = h.U * (s * ride)[:, None, :]
    g_slide = h.V * (s / ride)[:, None, :]
    return Terms(turn, ride, h.C * turn[:, None, :], h.D * back[:, None, :], f_slide, g_slide)


def values(family: Family, h: Coefficients, w: ComplexArray) -> ComplexArray:
    """Return f and g (roots, 2 L) at w (roots, n + q)."""
    t = terms(family, h, w)
    f = h.C0 + t.f_angle.sum(axis=2) + t.f_slide.sum(axis=2)
    g = h.D0 + t.g_angle.sum(axis=2) + t.g_slide.sum(axis=2)
    return np.concatenate([f, g], axis=1)


def values_and_jacobian(family: Family, h: Coefficients, w: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return f and g (roots, 2 L) and their derivatives by w (roots, 2 L, n + q)."""
    t, L, n = terms(family, h, w), family.loops, family.angles
    value = np.empty((len(w), 2 * L), dtype=complex)
    value[:, :L] = h.C0 + t.f_angle.sum(axis=2) + t.f_slide.sum(axis=2)
    value[:, L:] = h.D0 + t.g_angle.sum(axis=2) + t.g_slide.sum(axis=2)
    jacobian = np.empty((len(w), 2 * L, n + family.slides), dtype=complex)
    jacobian[:, :L, :n] = t.f_angle
    jacobian[:, L:, :n] = -t.g_angle
    if family.slides:
        jacobian[:, :L, :n] += t.f_slide @ family.carried
        jacobian[:, L:, :n] -= t.g_slide @ family.carried
        jacobian[:, :L, n:] = h.U * t.ride[:, None, :]
        jacobian[:, L:, n:] = h.V / t.ride[:, None, :]
    return value, jacobian


def real_point(family: Family, w: ComplexArray, tolerance: float) -> NDArray[np.bool_]:
    """Tell which points (roots, n + q) are their own mirror image: unit theta, real s."""
    n = family.angles
    off = np.concatenate([np.abs(w[:, :n].real), np.abs(w[:, n:].imag)], axis=1)
    return np.asarray(np.max(off, axis=1, initial=0.0) <= tolerance)
