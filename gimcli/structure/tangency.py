"""Mechanisms that are tangent in every position: each input has one position, a double root of the equations.

Newton's method loses half the digits there. Instead the least singular value of the Jacobian is made zero, together
with the part of the equations that the Jacobian can reach; the rest of them decides whether a position exists.
Source: Beyn et al., Numerical continuation, and computation of normal forms, 2002, section 4 (defining equations).
"""

from __future__ import annotations

import math

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.structure.residual import holds
from gimcli.structure.system import system_of

CORRECTIONS = 20
"""Most corrections of a position."""

CLOSE = 1e-13
"""Correction, relative to the size, at which a position is found."""

DOUBLE, SIMPLE = 1e-10, 1e-6
"""Singular values relative to the greatest: below the first one it is zero, above the second one it is not."""

CURVED = 1e-6
"""Second derivative along the free direction, for equations with gradients of about 1, above which a root is double."""

STEP = 0.02
"""Longest step of the inputs [rad, or sizes]; a position must not be farther from its guess than `FAR` steps."""

FAR = 10.0

BESIDE = 2e-2
"""Change of an input [rad, or sizes] to the neighbour that must be tangent too: that of a limit is not assembled."""

EXACT = 1e-10
"""Greatest residual, relative to the size: at a distance `BESIDE` from a singular position it is about its square."""

MOST_NODES = 60
"""Greatest mechanism: its equations are stored as full tables."""


def tangent_position(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, tolerance: float
) -> ComplexArray | None:
    """Return the position (nodes,) near z (nodes,), if it and a neighbour are tangent and satisfy all constraints."""
    if mechanism.complete is not None or not len(inputs) or len(mechanism.nodes) > MOST_NODES:
        return None
    found = _tangent(mechanism, z, inputs, tolerance)
    if found is None:
        return None
    beside = (inputs + sense * BESIDE * move for move in np.eye(len(inputs)) for sense in (1.0, -1.0))
    return found if any(_tangent(mechanism, found, near, tolerance) is not None for near in beside) else None


def tangent_positions(
    mechanism: Mechanism, z: ComplexArray, begin: FloatArray, inputs: FloatArray, tolerance: float
) -> ComplexArray:  # fmt: skip
    """Return the positions (nodes, rows) at inputs (actuators, rows), from z (nodes,) at `begin` (actuators,) on.

    Those behind the last one that is found are NaN.
    """
    found = np.full((len(z), inputs.shape[1]), complex(math.nan, math.nan))
    here = z if np.isfinite(z).all() else None
    for row, end in enumerate(inputs.T):
        parts = max(1, math.ceil(float(np.max(np.abs(end - begin))) / STEP))
        for part in np.arange(1, parts + 1) / parts:
            here = None if here is None else _tangent(mechanism, here, begin + (end - begin) * part, tolerance)
        if here is None:
            break
        found[:, row], begin = here, end
    return found


def _tangent(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, tolerance: float) -> ComplexArray | None:
    """Return the tangent position at some inputs (actuators,) near z (nodes,); None if there is none."""
    system = system_of(mechanism)
    if system.m < system.n:
        return None
    start = x = system.coordinates(z)
    for _ in range(CORRECTIONS):
        left, values, right = np.linalg.svd(system.jacobian(x, inputs), full_matrices=False)
        along = np.append(right[-1], np.zeros(len(inputs)))
        bend = left[:, -1] @ system.jacobian_along(x, inputs, along)[:, : system.n]
        if not (abs(bend @ right[-1]) > CURVED and values[-2:-1].min(initial=1.0) > SIMPLE * values[0]):
            return None
        wanted = np.append(-(left[:, :-1].T @ system.residual(x, inputs)), -values[-1])
        change = np.linalg.solve(np.vstack([values[:-1, None] * right[:-1], bend]), wanted)
        x = x + change
        if not np.linalg.norm(x - start) <= FAR * STEP * mechanism.size:
            return None
        if np.linalg.norm(change) <= CLOSE * mechanism.size:
            break
    found = system.nodes(x)
    double = values[-1] <= DOUBLE * values[0]
    fits = holds(mechanism, found[:, None], inputs[:, None], min(tolerance, EXACT))[0]
    return found if double and fits else None
