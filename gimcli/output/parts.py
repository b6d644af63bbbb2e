"""Results of long runs, kept in parts that are written atomically, so that an interrupted run can be resumed."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.errors import OutputError, UsageError
from gimcli.output.atomic import refuse_unwritable, written_bytes, written_text

HEADER = "header.json"


class Parts:
    """A folder of numbered arrays, and a header that identifies their run."""

    def __init__(self, folder: Path, header: Mapping[str, Any], resume: bool) -> None:
        """Open the folder; without `resume` existing parts are removed, with it they must have the same header.

        Raises UsageError if they have another header, OutputError if the folder has other files or cannot be written.
        """
        self.folder, self.header = folder, json.loads(json.dumps(header))
        self.run = hashlib.sha256(json.dumps(header).encode()).hexdigest()[:12]
        if folder.exists() and not folder.is_dir():
            raise OutputError(f"{folder}: is a file, not a folder for the parts of this run; move or rename it")
        kept = header_of(folder)
        if resume and kept is not None and kept != self.header:
            raise UsageError(
                f"resume: {folder} belongs to another run ({_difference(kept, self.header)}); remove resume to start"
                " a new run"
            )
        if not resume or kept is None:
            self.clear()
            refuse_unwritable((), folder / HEADER)
            with written_text(folder / HEADER) as handle:
                handle.write(json.dumps(self.header, indent=1) + "\n")

    @property
    def done(self) -> set[int]:
        """Numbers of the existing parts."""
        found = (re.fullmatch(rf"part-(\d+)-{self.run}", path.stem) for path in self.folder.glob("part-*.npy"))
        return {int(match[1]) for match in found if match is not None}

    def put(self, number: int, values: NDArray[Any]) -> None:
        """Write a part atomically."""
        with written_bytes(self._path(number)) as handle:
            np.save(handle, values, allow_pickle=False)

    def get(self, number: int) -> NDArray[Any]:
        """Read a part."""
        return np.asarray(np.load(self._path(number), allow_pickle=False))

    def clear(self) -> None:
        """Remove the folder; raise OutputError if it has other files."""
        if not self.folder.exists():
            return
        ours = [self.folder / HEADER, *self.folder.glob("part-*.npy"), *self.folder.glob(".gim-*.part")]
        if set(self.folder.iterdir()) - set(ours):
            raise OutputError(
                f"{self.folder}: contains files that do not belong to this run; move them, or choose another folder"
            )
        with suppress(OSError):
            shutil.rmtree(self.folder)

    def _path(self, number: int) -> Path:
        """Return the path of a part, with a hash of the header: runs at the same time in one folder stay apart."""
        return self.folder / f"part-{number:06d}-{self.run}.npy"


def header_of(folder: Path) -> dict[str, Any] | None:
    """Return the header of the parts in a folder; None if there is none."""
    try:
        found = json.loads((folder / HEADER).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def _difference(kept: Mapping[str, Any], requested: Mapping[str, Any]) -> str:
    """Return the names of the entries in which two headers differ, as text."""
    names = [name for name in requested if kept.get(name) != requested[name]]
    return "differs in " + ", ".join(names) if names else "differs"
