"""The equilibrium that a mechanism reaches from a position when it moves slowly under its forces.

Each step solves K d = Q; where K is not positive definite, the magnitudes of its eigenvalues are used, so that the
steps follow the forces towards a stable equilibrium. Source: Nocedal & Wright, Numerical Optimization, 2006, section
3.4 (modified Newton's method).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.dynamics.small_motions import Linearisation, Linearised
from gimcli.errors import StructureError
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.status import Status

STEPS, HALVINGS = 200, 40
FARTHEST = 0.3
"""Longest step of a coordinate: rad, or sizes of the mechanism."""

BALANCED = 1e-13
"""Remaining efforts, relative to the forces that act, at which the iteration ends."""

ACCEPTED = 1e-10
"""Remaining efforts that are an equilibrium if further steps do not reduce them."""

OVERSHOOT = 0.5
"""Greatest effort against a step at its end, relative to that along it at its start."""

FLAT = 1e-9
"""Least curvature of the potential that a step uses, relative to the scale of its contributions."""


@dataclass(frozen=True)
class Settled:
    """The end of the iteration."""

    status: Status  # OK, NOT_CONVERGED, or LIMIT: the next position is not reached
    found: Linearised  # at the last position


def settled(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, released: tuple[int, ...], time: float = 0.0
) -> Settled:
    """Return the equilibrium that a position moves to under its forces; arguments as for `linearised`.

    Raises ModelError and StructureError as `linearised`; also StructureError if the forces lead to a singular position.
    """
    equations = Linearisation(mechanism, released, time)
    found, status = equations.at(z, inputs), Status.NOT_CONVERGED
    for _ in range(STEPS):
        before = float(np.max(found.unbalance))
        if before <= BALANCED:
            break
        ahead, status = _next(equations, found)
        if ahead is None or (before <= ACCEPTED and np.max(ahead.unbalance) >= before):
            break
        found = ahead
    equations.require_regular()
    return Settled(Status.OK if np.max(found.unbalance) <= ACCEPTED else status, found)


def _next(equations: Linearisation, found: Linearised) -> tuple[Linearised | None, Status]:
    """Return the linearised equations after a step, shortened where it goes too far, or None, and the status there."""
    step, status = _step(found), Status.NOT_CONVERGED
    for _ in range(HALVINGS):
        place = equations.moved(step)
        if place is None:
            status = Status.LIMIT
        else:
            ahead = _at(equations, place)
            if ahead is not None and _is_good(found, ahead, step):
                return ahead, Status.NOT_CONVERGED
            equations.at(found.z, found.inputs, found.gauges)
        step = 0.5 * step
    return None, status


def _at(equations: Linearisation, place: tuple[ComplexArray, FloatArray, FloatArray]) -> Linearised | None:
    try:
        return equations.at(*place)
    except StructureError:
        return None


def _is_good(found: Linearised, ahead: Linearised, step: FloatArray) -> bool:
    """Return whether a step does not go far beyond the place where the effort along it is zero."""
    if ahead.names != found.names or np.max(ahead.unbalance) <= ACCEPTED:
        return True
    return bool(ahead.effort @ step >= -OVERSHOOT * (found.effort @ step))


def _step(found: Linearised) -> FloatArray:
    """Return Newton's step where the potential is convex, else one down its slope; at most FARTHEST."""
    metre = found.mechanism.dynamics.metre or 1.0
    length = np.array([1.0 if unit == "rad" else found.mechanism.size * metre for unit in found.units])
    stiffness, effort = found.stiffness * length[:, None] * length, found.effort * length
    values, vectors = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    least = FLAT * float(np.max(found.stiffness_scale * length[:, None] * length))
    if values[0] > least:
        step = np.linalg.solve(stiffness, effort)
    else:
        step = vectors @ ((vectors.T @ effort) / np.maximum(np.abs(values), max(least, np.finfo(float).tiny)))
    return np.asarray(step * length * min(1.0, FARTHEST / max(float(np.max(np.abs(step))), 1e-300)))
