"""Generic linkages with their roots in the user's cache folder: one file per topology, written atomically."""

from __future__ import annotations

import os
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.assemblies.certificate import distinct, prove
from gimcli.assemblies.constants import SEARCH
from gimcli.assemblies.count import root_count
from gimcli.assemblies.loops import LoopFamily
from gimcli.assemblies.root_paths import Generic, generic_start
from gimcli.kernels.jit import user_folder
from gimcli.progress import Progress, no_progress, spend

FOLDER = "starts-1"
"""Version of the file format."""

UNKNOWN = -1
"""Value in a file for an unknown count."""

KEPT = 64
"""Number of topologies kept in memory."""


def known_count(family: LoopFamily) -> int | None:
    """Return the exact number of complex roots, from the cache if it is there; None if it is unknown.

    The count 0 also gives None: such a structure has no generic configuration, but special dimensions may allow some.
    """
    return _count(family) or None


def known_start(family: LoopFamily, seed: int, progress: Progress = no_progress) -> Generic:
    """Return a generic linkage with its roots, from the cache if it is there."""
    key = (family.key, seed)
    if key in _STARTS:
        return _STARTS[key]
    found = _start(family, seed, progress)
    if len(_STARTS) >= KEPT:
        _STARTS.clear()
    if not spend():  # otherwise roots are missing
        _STARTS[key] = found
    return found


@lru_cache(KEPT)
def _count(family: LoopFamily) -> int | None:
    cheap = not family.slides or family.loops < SEARCH.count_slides
    path = None if cheap else _path(f"{family.key}-count")
    stored = _read(path)
    if stored is not None and "count" in stored and stored["count"].shape == ():
        value = int(stored["count"])
        return None if value == UNKNOWN else value
    count = root_count(family)
    _write(path, count=np.array(UNKNOWN if count is None else count))
    return count


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
