"""Stamps of files: they change when a file is written, replaced, deleted or created."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

Stamp = tuple[int, int, int] | None
"""Time of the last change [ns], size in bytes and inode; None: there is no such file."""


def stamps(paths: Iterable[Path]) -> dict[Path, Stamp]:
    """Return the present stamp of each file."""
    return {path: _stamp(path) for path in paths}


def _stamp(path: Path) -> Stamp:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino
