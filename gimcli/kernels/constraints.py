"""Errors of positions in constraints of each kind: over arrays of rows when interpreted, of one row when compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.kernels.circular import angle_of
from gimcli.kernels.jit import kernel


@kernel
def span_error(dx: Any, dy: Any, inverse: Any) -> Any:
    """Return the relative error of a distance, given 1 / distance: eq. (1) of Petuya et al. 2004."""
    return abs(np.sqrt(dx * dx + dy * dy) * inverse - 1.0)


@kernel
def angle_error(ax: Any, ay: Any, bx: Any, by: Any) -> Any:
    """Return the angle [rad, 0..pi] between two directions that should be equal: eq. (2) of Petuya et al. 2004."""
    return angle_of(ax * bx + ay * by, abs(ax * by - ay * bx))


@kernel
def height_error(nx: Any, ny: Any, px: Any, py: Any, height: Any, size: Any) -> Any:
    """Return the error of the height of p over a line with normal n (of any length), relative to `size`."""
    return abs((nx * px + ny * py) / np.sqrt(nx * nx + ny * ny) - height) / size
