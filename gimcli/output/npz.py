"""Archives of named arrays in numpy's format."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.output.atomic import written_bytes


def write_npz(arrays: Mapping[str, NDArray[Any]], path: Path | str) -> None:
    """Write named arrays into one uncompressed archive."""
    with written_bytes(path) as handle:
        np.savez(handle, **dict(arrays))  # type: ignore[arg-type]  # mypy: a name could be that of a parameter of savez
