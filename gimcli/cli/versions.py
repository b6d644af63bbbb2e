"""The lines of `gim --version --verbose`: versions, platform, cache and cores, without importing the libraries."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from shutil import which

REQUIRED = ("numpy", "scipy", "numba", "typer", "pydantic", "PyYAML", "matplotlib", "contourpy", "rich", "mpmath")

EXTRAS = {"pyarrow": "parquet", "ezdxf": "dxf", "distributed": "dask"}
"""Libraries that are needed only for some formats and options, and the extras that install them."""

MEGABYTE = 1e6


def version_lines() -> Iterator[str]:
    """Yield what a report of an error should contain."""
    from gimcli import __file__ as package

    yield f"Python {platform.python_version()} ({platform.python_implementation()}, {sys.executable})"
    yield f"platform: {platform.platform()}"
    yield f"package: {Path(package).parent}"
    for name in REQUIRED:
        yield f"{name} {_version(name) or 'is not installed'}"
    missing = "is not installed (pip install 'gimcli[{}]')"
    for name, extra in EXTRAS.items():
        yield f"{name} {_version(name) or missing.format(extra)}"
    yield f"ffmpeg: {which('ffmpeg') or 'not on the PATH (needed for .mp4)'}"
    yield _cache()
    count = os.cpu_count() or 1
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else count
    yield f"cores: {count}, {usable} usable"


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _cache() -> str:
    """Return the folder of compiled code, and the size of all files in it."""
    from gimcli.kernels.jit import cache_folder

    folder = cache_folder()
    if folder is None:
        return "cache: none (no folder that only this user can write to; code is compiled again in each run)"
    files = [path for path in folder.parent.rglob("*") if path.is_file()]
    size = sum(path.stat().st_size for path in files) / MEGABYTE
    return f"cache: {folder.parent}, {len(files)} files, {size:.1f} MB"
