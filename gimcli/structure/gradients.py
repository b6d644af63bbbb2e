"""Values of constraints with one equation (no CLOSURE) at a position, and their gradients by the nodes."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import ANGLE, HEIGHT, SPAN, ComplexArray, FloatArray
from gimcli.structure.steps import NONE, Constraint, Vector


def gradient(r: Constraint, z: ComplexArray, inputs: FloatArray) -> dict[int, complex]:
    """Return {node: g} with d(constraint) = sum Re(conj(g) dz), as a length; an angle is multiplied by |p - q|."""
    a, b = complex(z[r.q]), complex(z[r.p])
    if r.kind == SPAN:
        n = (b - a) / abs(b - a) if b != a else 1.0 + 0.0j  # coincident nodes: any direction
        return {r.p: n, r.q: -n}
    assert r.vector is not None
    w, factor = vector_value(r.vector, z, inputs)
    if r.kind == ANGLE:  # as if satisfied: the input of an actuator need not match the position
        u = (b - a) / abs(b - a) if b != a else w / abs(w)
        g = {r.p: 1j * u, r.q: -1j * u}
        if r.vector.u != NONE:
            arm = complex(z[r.vector.v] - z[r.vector.u])
            reach = (u.conjugate() * (b - a)).real
            turn = 1j * arm / abs(arm) ** 2 * reach  # the ray rotates with the arm
            g[r.vector.v] = g.get(r.vector.v, 0.0) - turn
            g[r.vector.u] = g.get(r.vector.u, 0.0) + turn
        return g
    g = {r.p: w, r.q: -w}
    if r.vector.u != NONE:
        lever = factor.conjugate() * (b - a)
        g[r.vector.v] = g.get(r.vector.v, 0.0) + lever
        g[r.vector.u] = g.get(r.vector.u, 0.0) - lever
    return g


def measure(r: Constraint, z: ComplexArray, inputs: FloatArray) -> float:
    """Return the value of a constraint as a length; its gradient is `gradient`."""
    a, b = complex(z[r.q]), complex(z[r.p])
    if r.kind == SPAN:
        return abs(b - a)
    assert r.vector is not None
    w, _ = vector_value(r.vector, z, inputs)
    if r.kind == HEIGHT:
        return (w.conjugate() * (b - a)).real
    turn = w.conjugate() * (b - a)
    return float(np.angle(turn)) * abs(b - a)


def vector_value(vector: Vector, z: ComplexArray, inputs: FloatArray) -> tuple[complex, complex]:
    """Return the value of a vector at a position z (nodes,), and its factor z e^(+-i theta)."""
    factor = vector.z
    if vector.actuator != NONE:
        factor *= complex(np.exp(1j * vector.turn * inputs[vector.actuator]))
    base = complex(z[vector.v] - z[vector.u]) if vector.u != NONE else 1.0 + 0.0j
    return factor * base, factor
