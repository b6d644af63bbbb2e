"""Values and vectors of constraints in the kernels: constant + gain u, and z (V - U) e^(+-i theta)."""

from __future__ import annotations

from gimcli.kernels.jit import kernel
from gimcli.mechanism import FloatArray


@kernel
def copy(to: FloatArray, values: FloatArray) -> None:
    """Copy an array; a slice assignment would need memory."""
    for k in range(len(to)):
        to[k] = values[k]


@kernel
def value_at(constant: float, gain: float, actuator: int, values: FloatArray) -> float:
    """Return a constant plus `gain` times the value of an actuator; the constant if `actuator` is negative."""
    return constant + gain * values[actuator] if actuator >= 0 else constant


@kernel
def turned(zr: float, zi: float, a: int, turn: int, cos: FloatArray, sin: FloatArray) -> tuple[float, float]:
    """Return z rotated by the angle of actuator `a` in the sense `turn` (+1 or -1); z if `a` is negative."""
    if a >= 0:
        c, s = cos[a], sin[a] * turn
        return zr * c - zi * s, zr * s + zi * c
    return zr, zi


@kernel
def stretched(zr: float, zi: float, u: int, v: int, x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Return z (V - U) for the nodes u and v; z if `u` is negative."""
    if u >= 0:
        ex, ey = x[v] - x[u], y[v] - y[u]
        return zr * ex - zi * ey, zr * ey + zi * ex
    return zr, zi
