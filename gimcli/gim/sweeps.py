"""Sweeps of the Geometrical-Iterative Method: a sequence in the arrays of the kernel, and its execution."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gimcli.kernels import sweep as kernels
from gimcli.mechanism import HEIGHT, ComplexArray, FloatArray, IntArray
from gimcli.positions.newton import Run
from gimcli.status import Status
from gimcli.structure.restrictions import Move
from gimcli.structure.steps import NONE


@dataclass(frozen=True)
class SweepConstants:
    """Constants of the iteration."""

    sweeps: int = 20000
    patience: int = 500  # number of sweeps in which the error must decrease
    progress: float = 0.5  # factor of this decrease
    rounding: float = 4.0 * float(np.finfo(float).eps)  # distance, relative to the size, of equal positions


ENDS = {
    kernels.SETTLED: Status.OK,
    kernels.EXHAUSTED: Status.NOT_CONVERGED,
    kernels.STALLED: Status.STALLED,
    kernels.CYCLING: Status.CYCLING,
    kernels.DIVERGED: Status.DIVERGED,
}


@dataclass(frozen=True)
class SweptPosition:
    """The result of sweeps for one position."""

    status: Status
    z: ComplexArray
    sweeps: int
    length_error: float  # eq. (1)
    angle_error: float  # eq. (2)
    history: FloatArray = field(repr=False)  # (sweeps + 1, 2)

    @property
    def good(self) -> bool:
        """Whether the errors of eqs (1) and (2) are within the tolerance."""
        return self.status is Status.OK


def pack(moves: tuple[Move, ...]) -> tuple[IntArray, FloatArray]:
    """Return a sequence in the arrays of the kernel."""
    heads, factors = [], []
    for move in moves:
        r, vector = move.restriction, move.restriction.vector
        kind = kernels.AIM if r.kind == HEIGHT and move.node != r.p else r.kind
        u, v, turning, turn = (vector.u, vector.v, vector.actuator, vector.turn) if vector else (NONE, NONE, NONE, 1)
        z = vector.z if vector else 0.0j
        heads.append((kind, move.node, r.q, r.p, r.value.actuator, u, v, turning, turn))
        factors.append((r.value.constant, r.value.gain, z.real, z.imag))
    return np.array(heads, dtype=np.int64).reshape(-1, 9), np.array(factors, dtype=float).reshape(-1, 4)


def limits(tolerance: float, policy: SweepConstants) -> FloatArray:
    """Return the stopping criteria for the kernel."""
    return np.array([tolerance, policy.sweeps, policy.patience, policy.progress, policy.rounding])


def settle(
    moves: tuple[Move, ...], z: ComplexArray, inputs: FloatArray, size: float, tolerance: float, run: Run,
    policy: SweepConstants | None = None, record: int = 0,
) -> SweptPosition:  # fmt: skip
    """Sweep from a start z (nodes,), in which all nodes that are not moved are in place."""
    policy = policy or SweepConstants()
    mi, mz = pack(moves)
    x, y = np.ascontiguousarray(z.real), np.ascontiguousarray(z.imag)
    history, mark, out = np.full((record, 2), np.nan), np.zeros((2, len(x))), np.zeros(3)
    with np.errstate(all="ignore"):
        end = run(kernels.settle)(
            x, y, inputs, np.cos(inputs), np.sin(inputs), mi, mz, size, limits(tolerance, policy), mark, history, out
        )
    done = int(out[2])
    return SweptPosition(ENDS[int(end)], x + 1j * y, done, float(out[0]), float(out[1]), history[: done + 1])
