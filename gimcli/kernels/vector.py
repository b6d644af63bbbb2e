"""Vectors z e^(+-i theta) in the kernels."""

from __future__ import annotations

from gimcli.kernels.jit import kernel
from gimcli.mechanism import FloatArray


@kernel
def turned(zr: float, zi: float, a: int, turn: int, cos: FloatArray, sin: FloatArray) -> tuple[float, float]:
    """Return z rotated by the angle of actuator `a` in the sense `turn` (+1 or -1); z if `a` is negative."""
    if a >= 0:
        c, s = cos[a], sin[a] * turn
        return zr * c - zi * s, zr * s + zi * c
    return zr, zi
