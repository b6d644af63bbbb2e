"""Positions at which branches of a curve meet, to full accuracy, and the tangents of the branches.

At p the Jacobian G_p (m, n + 1) has lost k of its rank n: its right null space has dimension k + 1, its left one r = m
- n + k. With bases B, C of both, the bordered system [G_p B; C' 0] [V; H] = [0; I] defines H (r, k + 1), which is 0 if
the rank is lost. G + B e = 0 and H = 0 are regular equations for p and e (minimal augmentation). e is the residual of
the equations at the position of rank loss: 0 if branches meet there. Their tangents are V a with w' G_pp (V a)(V a) = 0
for all left null vectors w. Source: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, 2000,
chapters 4 and 8; Allgower & Georg 2003, section 8.3.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from gimcli.continuation.arclength import Implicit
from gimcli.mechanism import FloatArray
from gimcli.status import CHANGE, TANGENCY

EPS = float(np.finfo(float).eps)


class SecondOrder(Implicit, Protocol):
    """A curve of solutions with second derivatives."""

    def jacobian_along(self, p: FloatArray, v: FloatArray) -> FloatArray:
        """Return the derivative of the Jacobian (m, n + 1) along v (n + 1,)."""


@dataclass(frozen=True)
class BifurcationConstants:
    """Constants of the search."""

    corrections: int = 40  # greatest number; tangent branches converge only linearly, by a factor of 2
    closeness: float = 1e-14  # converged if a correction is below this
    rounding: float = 1e-10  # also converged if corrections below this no longer decrease
    rank: float = 1e-11  # relative rank tolerance of the equations for the corrections
    lost: float = 1e-6  # singular values below this fraction of the greatest are 0
    most: int = 6  # greatest loss of rank for which the branches (up to 2^most) are listed
    double: float = 1e-6  # relative discriminant below which two tangents are one double tangent
    none: float = 1e-9  # a quadratic form below this, relative to the second derivatives, is 0
    starts: int = 60  # number of initial directions for the tangents if more than two branches may meet
    single: float = 1e-4  # singular value of the derivatives of the forms below which a tangent is not isolated
    apart: float = 1e-5  # rad: tangents that differ by less are equal


BRANCHING = BifurcationConstants()


@dataclass(frozen=True)
class Crossing:
    """A position at which the Jacobian of a curve loses rank."""

    p: FloatArray  # (n + 1,)
    miss: float  # residual of the equations; 0 if branches meet
    right: FloatArray  # (n + 1, k + 1) null space
    left: FloatArray  # (m, r)
    forms: FloatArray  # (., k + 1, k + 1) independent quadratic forms that are 0 for the tangent of a branch

    @property
    def lost(self) -> int:
        """Loss of rank k."""
        return int(self.right.shape[1]) - 1

    @property
    def tangents(self) -> tuple[FloatArray, ...]:
        """The unit tangents (n + 1,) of all branches, each in one sense; branches that touch have a common one."""
        return self._branches[0]

    @property
    def touching(self) -> bool:
        """Whether a tangent is double, or not determined by second derivatives."""
        return self._branches[1]

    @property
    def loose(self) -> bool:
        """Whether a surface (more than one freedom) meets the curve there: its tangents are not isolated."""
        return self._branches[2]

    @property
    def kind(self) -> str:
        """Whether branches cross here."""
        count = len(self.tangents)
        return TANGENCY if not self.loose and (count == 1 or (self.touching and not count)) else CHANGE

    @cached_property
    def _branches(self) -> tuple[tuple[FloatArray, ...], bool, bool]:
        if self.lost > BRANCHING.most:
            return (), False, False
        found, touching, loose = _tangents(self.forms)
        return tuple(self.right @ a for a in found), touching, loose

    def near(self, v: FloatArray) -> FloatArray | None:
        """Return the branch tangent closest to a direction v (n + 1,), in its sense; None if it is not isolated.

        Only this tangent is computed, regardless of the number of branches.
        """
        a = self.right.T @ v
        if not np.linalg.norm(a) > 0.0 or not len(self.forms):
            return None
        if self.lost == 1:
            found = max(self.tangents, key=lambda t: abs(float(t @ v)), default=None)
        else:
            settled = next(_settled(self.forms, a[None] / np.linalg.norm(a)), None)
            found = self.right @ settled if settled is not None and _single(self.forms, settled) else None
        return found if found is None or found @ v >= 0.0 else -found


def crossing(curve: SecondOrder, guess: FloatArray) -> Crossing | None:
    """Return the singular position closest to a guess (n + 1,); None if none is found."""
    n = len(guess) - 1
    for lost in _losses(curve, guess):
        p = _refined(curve, guess, lost)
        if p is None:
            continue
        left, values, right = np.linalg.svd(curve.jacobian(p))
        if int(np.sum(values[:n] <= BRANCHING.lost * values[0])) == lost:
            null, normal = right[n - lost :].T, left[:, n - lost :]
            miss = float(np.linalg.norm(normal.T @ curve.linearised(p)[0]))
            return Crossing(p, miss, null, normal, _independent(_forms(curve, p, null, normal)))
    return None


def _losses(curve: SecondOrder, guess: FloatArray) -> list[int]:
    """Return the losses of rank to try; the first one is given by the widest gap between singular values."""
    values = np.linalg.svd(curve.jacobian(guess), compute_uv=False)[: len(guess) - 1]
    gaps = values[:-1] / np.maximum(values[1:], np.finfo(float).eps * values[0])  # rounding errors of 0 make no gap
    likely = len(values) - 1 - int(np.argmax(gaps)) if len(gaps) else 1
    return list(dict.fromkeys([likely, *range(1, min(BRANCHING.most, len(values)) + 1)]))


def _refined(curve: SecondOrder, p: FloatArray, lost: int) -> FloatArray | None:
    """Return the position with a given loss of rank, by Newton's method; None if it does not converge."""
    n = len(p) - 1
    left, _, right = np.linalg.svd(curve.jacobian(p))
    b, c = left[:, n - lost :], right[n - lost :].T
    r, count, last = b.shape[1], 0, np.inf
    e = np.zeros(r)
    for count in range(BRANCHING.corrections):
        g, table = _augmented(curve, p, e, b, c)
        if not (np.all(np.isfinite(g)) and np.all(np.isfinite(table))):
            return None
        step = np.linalg.lstsq(table, -g, rcond=BRANCHING.rank)[0]
        p, e = p + step[: n + 1], e + step[n + 1 :]
        size = float(np.linalg.norm(step))
        if size <= BRANCHING.closeness or (size >= last and last <= BRANCHING.rounding):
            return p
        if size > 1.0 or (count > 8 and size > 0.9 * last):
            return None
        last = size
    return p if last <= BRANCHING.lost else None


def _augmented(
    curve: SecondOrder, p: FloatArray, e: FloatArray, b: FloatArray, c: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the equations for p and e and their derivatives (m + r (k + 1), n + 1 + r)."""
    m, r = b.shape
    n1, k1 = c.shape
    g, jacobian = curve.linearised(p)
    bordered = np.block([[jacobian, b], [c.T, np.zeros((k1, r))]])
    identity = np.eye(m + k1)
    try:
        solved = np.linalg.solve(bordered, identity[:, m:])
        turned = np.linalg.solve(bordered.T, identity[:, n1:])
    except np.linalg.LinAlgError:
        return np.full(1, np.nan), np.full((1, 1), np.nan)
    v, h, w = solved[:n1], solved[n1:], turned[:m]
    slopes = np.array([-w.T @ curve.jacobian_along(p, v[:, j]) for j in range(k1)])  # (k + 1, r, n + 1)
    table = np.block([[jacobian, b], [slopes.reshape(k1 * r, n1), np.zeros((k1 * r, r))]])
    return np.concatenate([g + b @ e, h.T.ravel()]), table


def _forms(curve: SecondOrder, p: FloatArray, right: FloatArray, left: FloatArray) -> FloatArray:
    """Return the quadratic forms (r, k + 1, k + 1) of the second derivatives, relative to the greatest of these."""
    along = [curve.jacobian_along(p, v) for v in right.T]
    forms = np.array([left.T @ table @ right for table in along])  # (a, r, b)
    scale = max(float(np.linalg.norm(table)) for table in along)
    return np.asarray(np.moveaxis(forms, 1, 0) / (scale or 1.0))


def _independent(forms: FloatArray) -> FloatArray:
    """Return a basis, of norm 1, of the forms that are not 0."""
    size = forms.shape[1]
    _, values, rows = np.linalg.svd(forms.reshape(len(forms), -1), full_matrices=False)
    return np.asarray(rows[values > BRANCHING.none].reshape(-1, size, size))


def _tangents(forms: FloatArray) -> tuple[list[FloatArray], bool, bool]:
    """Return the isolated directions (k + 1,) with all forms 0, whether one is double, and whether there are others.

    Without forms there are no isolated directions.
    """
    if not len(forms):
        return [], True, False
    if forms.shape[1] == 2:
        return (*_of_two(forms), False)
    found, loose = _of_many(forms)
    return found, False, loose


def _of_two(forms: FloatArray) -> tuple[list[FloatArray], bool]:
    """Return the common zero directions of binary forms, and whether they are one double direction."""
    (a, b), (_, c) = forms[0]
    disc = float(b * b - a * c)
    if disc < -BRANCHING.double:
        return [], False
    touching = disc <= BRANCHING.double
    root = 0.0 if touching else float(np.sqrt(disc))
    q = -(b + (root if b >= 0.0 else -root))  # of a x^2 + 2 b x y + c y^2, without cancellation
    pairs = [(q, a), (c, q)] if not touching else [(q, a) if abs(a) > abs(c) else (c, q)]
    found = [np.array(pair) / np.hypot(*pair) for pair in pairs if np.hypot(*pair) > 0.0]
    bound = float(np.sqrt(BRANCHING.double)) if touching else BRANCHING.double
    return [v for v in found if np.all(np.abs(_at(forms, v)) <= bound)], touching


def _of_many(forms: FloatArray) -> tuple[list[FloatArray], bool]:
    """Return the isolated common zero directions of forms in three or more variables, and whether there are others.

    Newton's method starts from many random directions. A direction is not isolated if the derivatives of the forms do
    not determine it.
    """
    size = forms.shape[1]
    rng = np.random.default_rng(0)
    found: list[FloatArray] = []
    loose = False
    starts = rng.normal(size=(BRANCHING.starts * 2 ** (size - 2), size))
    for v in _settled(forms, starts / np.linalg.norm(starts, axis=1, keepdims=True)):
        if not _single(forms, v):
            loose = True
        elif all(np.arccos(min(1.0, abs(float(v @ other)))) > BRANCHING.apart for other in found):
            found.append(v)
    return sorted(found, key=lambda v: [round(part, 6) for part in v.tolist()]), loose


def _single(forms: FloatArray, v: FloatArray) -> bool:
    """Return whether a common zero direction is isolated."""
    size = forms.shape[1]
    return bool(np.linalg.svd(forms @ v, compute_uv=False)[size - 2 : size - 1].sum() > BRANCHING.single)


def _settled(forms: FloatArray, v: FloatArray) -> Iterator[FloatArray]:
    """Yield the common zero directions to which Newton's method converges from starts v (starts, variables)."""
    v, going = v.copy(), np.arange(len(v))
    for _ in range(BRANCHING.corrections):
        at = v[going]
        slope = 2.0 * np.einsum("rij,sj->sri", forms, at)
        value = np.concatenate([np.einsum("sri,si->sr", slope, at) / 2.0, (at * at).sum(axis=1)[:, None] - 1.0], axis=1)
        slope = np.concatenate([slope, 2.0 * at[:, None]], axis=1)
        step = -(np.linalg.pinv(slope, rcond=EPS * max(slope.shape[1:])) @ value[:, :, None])[:, :, 0]
        v[going] += step
        going = going[np.linalg.norm(step, axis=1) > BRANCHING.closeness]
        if not len(going):
            break
    for one in v:
        norm = float(np.linalg.norm(one))
        if norm > 0.0 and np.linalg.norm(_at(forms, one)) <= BRANCHING.rounding * norm**2:
            yield one / norm


def _at(forms: FloatArray, v: FloatArray) -> FloatArray:
    """Return the values (r,) of the forms at v."""
    return np.asarray(np.einsum("i,rij,j->r", v, forms, v))
