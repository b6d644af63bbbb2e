"""A generic linkage of a topology with all its complex roots, from which paths to other linkages start.

A random point and random parameters, projected so that the loops close, give one root. The others are found along
triangles in the space of parameters (monodromy), which permute the roots transitively: the pairs of linkage and root
are a vector bundle over the roots. Source: T. Duff et al., Solving polynomial systems via homotopy continuation and
monodromy, IMA J. Numer. Anal. 39 (2019).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gimcli.assemblies.certificate import distinct, prove
from gimcli.assemblies.constants import SEARCH
from gimcli.assemblies.loops import LoopFamily, factors
from gimcli.assemblies.root_paths import corrected, track
from gimcli.mechanism import ComplexArray
from gimcli.progress import Progress, no_progress


@dataclass(frozen=True)
class Generic:
    """A linkage with random complex dimensions and its roots."""

    H: ComplexArray  # (2, L, 1 + n + q)
    w: ComplexArray  # (roots, n + q)


def generic_member(family: LoopFamily, generator: np.random.Generator) -> tuple[ComplexArray, ComplexArray]:
    """Return coefficients of a random complex linkage and one root (1, n + q) of it."""
    n, q = family.angles, family.slides
    w = np.concatenate([_normal(generator, n).real * 0.5 + 1j * generator.uniform(-np.pi, np.pi, n),
                        _normal(generator, q)])  # fmt: skip
    ab, _ = factors(family, w)
    stacked = family.stacked.reshape(family.loops, 1 + n + q, -1)
    halves = []
    for part in (0, 1):
        closing = np.einsum("k,lkp->lp", ab[part], stacked)  # the loops close if this times p is 0
        p = _normal(generator, stacked.shape[2])
        p = p - np.linalg.pinv(closing) @ (closing @ p)
        halves.append(p / np.linalg.norm(p) * np.sqrt(len(p)))
    return family.member(halves[0], halves[1]), w[None, :]


def random_member(family: LoopFamily, generator: np.random.Generator) -> ComplexArray:
    """Return coefficients of a random complex linkage."""
    count = family.stacked.shape[1]
    return family.member(_normal(generator, count), _normal(generator, count))


def _normal(generator: np.random.Generator, count: int) -> ComplexArray:
    return np.asarray((generator.standard_normal(count) + 1j * generator.standard_normal(count)) / np.sqrt(2.0))


def generic_start(family: LoopFamily, seed: int, count: int | None, progress: Progress = no_progress) -> Generic:
    """Return a generic linkage with `count` roots, or with all roots that monodromy finds."""
    generator = np.random.default_rng([seed, 20041])
    H, w = generic_member(family, generator)
    idle = 0
    for _ in range(SEARCH.monodromy):
        if len(w) == count or ((count is None or family.rails_shared) and idle >= SEARCH.idle):
            break
        found = _round_trip(family, H, w, generator)
        idle = 0 if len(found) > len(w) else idle + 1
        w = found
        progress(len(w), count or 2 * len(w))
    return Generic(H, w)


def _round_trip(family: LoopFamily, H: ComplexArray, w: ComplexArray, generator: np.random.Generator) -> ComplexArray:
    """Follow the roots around a triangle of linkages; return all known roots with the new ones."""
    corners = [H, random_member(family, generator), random_member(family, generator), H]
    tracking = replace(SEARCH.tracking, correction=SEARCH.tracking.correction * SEARCH.tighter[0])
    there = w
    for start, end in pairwise(corners):
        done = track(family, start, end, there, tracking)
        there = done.w[done.arrived]
    there = corrected(family, H, there, SEARCH.polish)
    both = np.concatenate([w, there[np.isfinite(there).all(axis=1)]])
    return distinct(family, prove(family, H, both)).w
