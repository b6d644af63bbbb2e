"""Loop equations of a planar linkage in isotropic coordinates.

Unknowns are theta_c = e^(i phi_c) of every rotation class and s_q of every passive slide. For every loop k

    f_k = C0_k + sum_c C_kc theta_c + sum_q U_kq s_q theta_m(q)              = 0
    g_k = conj(C0_k) + sum_c conj(C_kc) / theta_c + sum_q conj(U_kq) s_q / theta_m(q) = 0

m(q) is the class of the rail of slide q. All coefficients are linear in the points and rail directions of the linkage.
The *family* of a topology consists of all complex values of these, with independent conjugates.
Numerically the unknowns are w = [log theta, s]. Source: C. Wampler, Solving the kinematics of
planar mechanisms by Dixon determinant and a complex-plane formulation, J. Mech. Des. 123 (2001).
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, IntArray

GROUND = -1
"""Class of a rail with a known direction."""


@dataclass(frozen=True, eq=False)
class LoopFamily:
    """The tensor of the coefficients, `table` times the parameters; families with equal tensors are equal."""

    table: FloatArray = field(repr=False)  # (L, 1 + n + q, parameters) small integers: constants, angles, slides
    rail: IntArray  # (q,) class, or GROUND

    @property
    def loops(self) -> int:
        """Number of loops L."""
        return len(self.table)

    @property
    def angles(self) -> int:
        """Number of rotation classes n."""
        return int(self.table.shape[1]) - 1 - self.slides

    @property
    def slides(self) -> int:
        """Number of passive slides q."""
        return len(self.rail)

    @property
    def square(self) -> bool:
        """Return whether there are as many equations as unknowns."""
        return self.angles + self.slides == 2 * self.loops

    @cached_property
    def rails_shared(self) -> bool:
        """Return whether slides have a common direction: the count of roots is then only an upper bound."""
        used = np.abs(self.table[:, 1 + self.angles :]).sum(axis=0) > 0
        return bool((used.sum(axis=0) > 1).any())

    @cached_property
    def key(self) -> str:
        """A hash of the tensors, used as the name of the topology."""
        constants, *others = np.split(self.table, [1, 1 + self.angles], axis=1)
        digest = hashlib.sha256(repr((*(other.shape for other in others), self.rail.tolist())).encode())
        for tensor in (constants, *others):
            digest.update(np.ascontiguousarray(tensor, dtype=np.int8).tobytes())
        return digest.hexdigest()[:32]

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, LoopFamily) and self.key == other.key

    @cached_property
    def carried(self) -> FloatArray:
        """Matrix (q, n): 1 if the rail of a slide belongs to a class, else 0."""
        table = np.zeros((self.slides, self.angles))
        for q, m in enumerate(self.rail):
            if m != GROUND:
                table[q, m] = 1.0
        return table

    def member(self, p: ComplexArray, pb: ComplexArray) -> ComplexArray:
        """Return the coefficients H (..., 2, L, 1 + n + q) of f and g.

        p (..., parameters) gives f; pb (..., parameters), independent of p, gives g. The columns are the constant, the
        angles and the slides.
        """
        both = np.stack([p, pb], axis=-2) @ self.table.reshape(-1, self.table.shape[2]).T
        return both.reshape(*both.shape[:-1], *self.table.shape[:2])

    def real(self, p: ComplexArray) -> ComplexArray:
        """Return the coefficients of real linkages with parameters p: those of g are conjugate to those of f."""
        half = self.member(p, p)[..., :1, :, :]
        return np.concatenate([half, half.conj()], axis=-3)


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Coefficients f_k = C0_k + sum_c C_kc theta_c + sum_q U_kq s_q theta_rail(q) of a real linkage; n + q = 2 L."""

    C0: ComplexArray  # (L,)
    C: ComplexArray  # (L, n)
    U: ComplexArray  # (L, q)
    rail: IntArray  # (q,) class of the rail, or GROUND for a rail on the frame


def factors(family: LoopFamily, w: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the factors of the coefficients at w (..., n + q).

    These are (..., 2, 1 + n + q) of 1, theta, s theta_m and of 1, 1/theta, s/theta_m; then (..., 2, q) of
    theta_m and 1/theta_m.
    """
    n = family.angles
    ab = np.ones((*w.shape[:-1], 2, 1 + n + family.slides), dtype=complex)
    ab[..., 0, 1 : 1 + n] = np.exp(w[..., :n])
    ab[..., 1, 1 : 1 + n] = 1.0 / ab[..., 0, 1 : 1 + n]
    ride = ab[..., family.rail + 1]
    ab[..., 1 + n :] = ride * w[..., None, n:]
    return ab, ride


def values(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> ComplexArray:
    """Return f and g (..., 2 L) at w (..., n + q)."""
    ab, _ = factors(family, w)
    value = (H @ ab[..., None])[..., 0]
    return value.reshape(*value.shape[:-2], 2 * family.loops)


def values_and_jacobian(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return f and g (..., 2 L) and their derivatives by w (..., 2 L, n + q)."""
    n, (ab, ride) = family.angles, factors(family, w)
    term = H * ab[..., None, :]
    value = term.sum(axis=-1)
    jacobian = term[..., 1:]
    if family.slides:
        jacobian[..., :n] += term[..., 1 + n :] @ family.carried
    jacobian[..., 1, :, :n] *= -1.0
    if family.slides:
        jacobian[..., n:] = H[..., 1 + n :] * ride[..., None, :]
    lead, rows = value.shape[:-2], 2 * family.loops
    return value.reshape(*lead, rows), jacobian.reshape(*lead, rows, n + family.slides)
