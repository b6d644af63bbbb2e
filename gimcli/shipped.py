"""The shipped models, which every command finds by name: the folder `models` of the repository.

Setup maps this folder into the package, as `gimcli/models`; in a clone and in an editable installation it stands beside
the package.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

SUFFIX = ".yaml"


@cache
def folder() -> Path:
    """Return the folder of the shipped models."""
    package = Path(__file__).parent
    inside = package / "models"
    return inside if inside.is_dir() else package.parent / "models"


@cache
def names() -> tuple[str, ...]:
    """Return the names of all shipped models, sorted."""
    return tuple(sorted(path.stem for path in folder().glob(f"*{SUFFIX}")))


def path_of(name: str | Path) -> Path | None:
    """Return the file of a shipped model by its name, with or without `.yaml`; None if there is none."""
    stem = str(name).removesuffix(SUFFIX)
    return folder() / f"{stem}{SUFFIX}" if stem in names() else None
