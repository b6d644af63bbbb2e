"""The exact number of complex roots of a generic linkage of a topology.

The loops restrict the coordinates (1, theta, s theta_m) to a linear space with the matroid M, and
(1, 1/theta, s/theta_m) to another with the same matroid. The family contains every scaling of an angle or a slide, so
the number of roots is a stable intersection of tropical linear spaces. Slides with a common rail direction cannot be
scaled separately; the number is then an upper bound, and a list that reaches it is proved complete. Without slides
it follows from the recursion of J. Capco, M. Gallet, G. Grasegger, C. Koutschan, N. Lubbes, J. Schicho, The number of
realizations of a Laman graph, SIAM J. Appl. Algebra Geom. 2 (2018), applied to the matroid of the loops. With slides
the cones of both fans are intersected.

Generic linkages with their roots in the user's cache folder: one file per topology, written atomically.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from functools import cache, cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.assemblies.certificate import distinct, prove
from gimcli.assemblies.constants import PRIME, SEARCH
from gimcli.assemblies.loops import LoopFamily
from gimcli.assemblies.root_paths import Generic, generic_start
from gimcli.kernels.jit import user_folder
from gimcli.mechanism import FloatArray
from gimcli.progress import Progress, no_progress, spend

SEED = 20180611
CHUNK = 200_000
"""Pairs of cones that are intersected in one call."""


def root_count(family: LoopFamily) -> int:
    """Return the number of complex roots of a generic member; 0 if there is none, or the count takes too long."""
    if not family.square or family.loops > (SEARCH.count_slides if family.slides else SEARCH.count_loops):
        return 0
    return _with_slides(family) if family.slides else _recursion(Matroid(family))


class Matroid:
    """Ranks of the coordinates (1, angles, slides) on the kernel of the loops at random parameters."""

    def __init__(self, family: LoopFamily) -> None:
        generator = np.random.default_rng(SEED)
        p = [int(v) for v in np.asarray(generator.integers(1, PRIME, family.table.shape[2]))]
        rows = [[sum(int(t) * v for t, v in zip(row, p, strict=True) if t) % PRIME for row in loop] for loop in
                family.table]  # fmt: skip
        self.columns = list(zip(*rows, strict=True))
        self.size = len(self.columns)
        self.everything = (1 << self.size) - 1
        self._loop_rank: dict[int, int] = {0: 0}

    @cached_property
    def _full(self) -> int:
        return self._columns_rank(self.everything)

    def rank(self, mask: int) -> int:
        """Return the rank of a set of coordinates S: |S| minus the number of linear conditions on S alone."""
        return mask.bit_count() - self._full + self._columns_rank(self.everything & ~mask)

    def _columns_rank(self, mask: int) -> int:
        if mask not in self._loop_rank:
            self._loop_rank[mask] = rank_modulo([self.columns[k] for k in range(self.size) if mask >> k & 1])
        return self._loop_rank[mask]


def rank_modulo(vectors: list[tuple[int, ...]]) -> int:
    """Return the rank of integer vectors modulo PRIME."""
    basis: list[tuple[int, list[int]]] = []
    for vector in vectors:
        row = list(vector)
        for pivot, other in basis:
            if row[pivot]:
                factor = row[pivot]
                row = [(a - factor * b) % PRIME for a, b in zip(row, other, strict=True)]
        pivot = next((k for k, v in enumerate(row) if v), -1)
        if pivot >= 0:
            inverse = pow(row[pivot], -1, PRIME)
            basis.append((pivot, [v * inverse % PRIME for v in row]))
    return len(basis)


def _recursion(matroid: Matroid) -> int:
    """Return N(G, H) of all elements; G and H are the matroid with some elements contracted, none at first."""
    rank = matroid.rank

    def of(elements: int, g: int, h: int) -> int:
        """Return N on some elements with g and h contracted; it is symmetric in g and h."""
        return ordered(elements, min(g, h), max(g, h))

    @cache
    def ordered(elements: int, g: int, h: int) -> int:
        rg, rh = rank(g), rank(h)
        if rank(elements | g) - rg + rank(elements | h) - rh != elements.bit_count() + 1:
            return 0
        bits = [1 << k for k in range(elements.bit_length()) if elements >> k & 1]
        if any(rank(g | b) == rg or rank(h | b) == rh for b in bits):
            return 0
        if len(bits) == 1:
            return 1
        e, rest = bits[0], elements & ~bits[0]
        total = of(rest, g | e, h) + of(rest, g, h | e)
        part = (rest - 1) & rest  # proper subsets of the rest
        while part:
            m, k = part | e, rest & ~part | e
            one = of(k & ~e, g | m, h)
            if one:
                total += one * of(m & ~e, g, h | k)
            part = (part - 1) & rest
        return total

    return of(matroid.everything, 0, 0)


def _with_slides(family: LoopFamily) -> int:
    """Return the number of points in which the cones of the two fans intersect after a random shift."""
    matroid = Matroid(family)
    if any(matroid.rank(1 << k) == 0 for k in range(matroid.size)):
        return 0
    flags = np.array(list(_flags(matroid)), dtype=float)  # (flags, L, 2 L) indicators relative to element 0
    if not len(flags):
        return 0
    n, L = family.angles, family.loops
    seen = flags.copy()
    seen[..., :n] *= -1.0
    for q, m in enumerate(family.rail):
        if m >= 0:
            seen[..., n + q] -= 2.0 * flags[..., m]
    shift = np.random.default_rng(SEED).standard_normal(2 * L)
    total = 0
    step = max(1, CHUNK // len(flags))
    for first in range(0, len(flags), step):
        total += _intersections(seen[first : first + step], flags, shift)
    return total


def _intersections(seen: FloatArray, flags: FloatArray, shift: FloatArray) -> int:
    """Return the sum of |det| over the pairs of cones that intersect."""
    a, b = len(seen), len(flags)
    L, size = flags.shape[1:]
    pairs = np.empty((a, b, size, size))
    pairs[:, :, :L] = seen[:, None]
    pairs[:, :, L:] = -flags[None]
    system = pairs.reshape(a * b, size, size).transpose(0, 2, 1)
    weight = np.abs(np.linalg.det(system))
    full = weight > 0.5  # the determinants are integers
    solution = np.linalg.solve(system[full], np.broadcast_to(shift[:, None], (int(full.sum()), size, 1)))[:, :, 0]
    return round(float(weight[full][np.all(solution > 0.0, axis=1)].sum()))


def _flags(matroid: Matroid) -> Iterator[list[list[float]]]:
    """Yield all maximal chains of proper flats, as indicators relative to element 0."""
    top = matroid.rank(matroid.everything)

    def closure(mask: int) -> int:
        own = matroid.rank(mask)
        return sum(1 << k for k in range(matroid.size) if matroid.rank(mask | 1 << k) == own)

    @cache
    def covers(flat: int) -> list[int]:
        left = matroid.everything & ~flat
        return sorted({closure(flat | 1 << k) for k in range(matroid.size) if left >> k & 1})

    def chains(flat: int, rank: int) -> Iterator[list[int]]:
        if rank == top - 1:
            yield []
            return
        for higher in covers(flat):
            for rest in chains(higher, rank + 1):
                yield [higher, *rest]

    for chain in chains(0, 0):
        yield [[float(flat >> k & 1) - float(flat & 1) for k in range(1, matroid.size)] for flat in chain]


FOLDER = "starts-1"
"""Version of the file format."""

KEPT = 64
"""Number of topologies kept in memory."""


@lru_cache(KEPT)
def known_count(family: LoopFamily) -> int | None:
    """Return the exact number of complex roots, from the cache if it is there; None if it is unknown.

    The count 0 also gives None: such a structure has no generic configuration, but special dimensions may allow some.
    """
    cheap = not family.slides or family.loops < SEARCH.count_slides
    path = None if cheap else _path(f"{family.key}-count")
    stored = (_read(path) or {}).get("count")
    if stored is None or stored.shape != ():
        stored = np.array(root_count(family))
        _write(path, count=stored)
    count = int(stored)
    return count if count > 0 else None


def known_start(family: LoopFamily, seed: int, progress: Progress = no_progress) -> Generic:
    """Return a generic linkage with its roots, from the cache if it is there."""
    key = (family.key, seed)
    if key not in _STARTS:
        found = _start(family, seed, progress)
        if spend():  # roots are missing
            return found
        if len(_STARTS) >= KEPT:
            _STARTS.clear()
        _STARTS[key] = found
    return _STARTS[key]


_STARTS: dict[tuple[str, int], Generic] = {}


def _start(family: LoopFamily, seed: int, progress: Progress) -> Generic:
    path, count = _path(f"{family.key}-{seed}"), known_count(family)
    stored = _read(path)
    if stored is not None:
        generic = _checked(family, stored, count)
        if generic is not None:
            return generic
    generic = generic_start(family, seed, count, progress)
    if not spend():
        _write(path, H=generic.H, w=generic.w)
    return generic


def _checked(family: LoopFamily, stored: dict[str, NDArray[Any]], count: int | None) -> Generic | None:
    """Return a stored start, None if it is not valid."""
    shape = (2, family.loops, 1 + family.angles + family.slides)
    H, w = stored.get("H"), stored.get("w")
    if H is None or w is None or H.shape != shape or w.ndim != 2 or w.shape[1] != shape[2] - 1:
        return None
    if not (np.isfinite(H).all() and np.isfinite(w).all()):
        return None
    if count is not None and len(w) != count and not (family.rails_shared and 0 < len(w) < count):
        return None
    proven = distinct(family, prove(family, H.astype(complex), w.astype(complex)))
    return Generic(H.astype(complex), w.astype(complex)) if len(proven.w) == len(w) else None


def _path(name: str) -> Path | None:
    folder = user_folder(FOLDER)
    return folder / f"{name}.npz" if folder is not None else None


def _read(path: Path | None) -> dict[str, NDArray[Any]] | None:
    """Return the arrays of a file; None if it is missing or invalid."""
    if path is None:
        return None
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception:  # a damaged file can raise any error; the start is computed again
        return None


def _write(path: Path | None, **arrays: NDArray[Any]) -> None:
    """Write a temporary file and rename it; errors are ignored, because the cache is optional."""
    if path is None:
        return
    part = path.with_name(f".{os.urandom(6).hex()}.part")
    try:
        with part.open("xb") as handle:
            np.savez(handle, allow_pickle=False, **arrays)
        os.replace(part, path)
    except OSError:
        pass
    finally:
        with suppress(OSError):
            part.unlink()
