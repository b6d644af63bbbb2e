"""Gauss-Newton from many starts, and curves of critical positions, for systems with known solutions."""

from __future__ import annotations

import numpy as np

from gimcli.continuation.gauss_newton import settle
from gimcli.mechanism import FloatArray, IntArray
from gimcli.reach.critical_curves import Fold, Stratum, sides
from gimcli.structure.quadric import Quadric

UNIT = Quadric(np.array([-1.0]), np.zeros((1, 2)), 2.0 * np.eye(2)[None])
"""x^2 + y^2 = 1."""


def test_starts_converge_on_a_circle_unless_there_is_no_solution() -> None:
    """A circle and a horizontal line for each start: two intersections, one, or none."""
    heights = np.array([0.0, 0.6, -0.9, 1.5])

    def equations(x: FloatArray, which: IntArray) -> tuple[FloatArray, FloatArray]:
        value = np.stack([np.sum(x**2, axis=1) - 1.0, x[:, 1] - heights[which]], axis=1)
        return value, np.stack([2.0 * x, np.broadcast_to([0.0, 1.0], x.shape)], axis=1)

    x, good = settle(equations, np.array([[2.0, 1.0], [-0.3, 0.2], [0.1, 3.0], [0.4, 0.4]]))
    assert good.tolist() == [True, True, True, False]
    exact = np.sqrt(1.0 - heights[:3] ** 2) * np.array([1.0, -1.0, 1.0])
    assert np.abs(x[:3] - np.stack([exact, heights[:3]], axis=1)).max() < 1e-10


def test_redundant_and_underdetermined_equations_converge() -> None:
    def equations(x: FloatArray, which: IntArray) -> tuple[FloatArray, FloatArray]:
        value = UNIT.value(x)
        return np.hstack([value, 3.0 * value]), np.concatenate([UNIT.slope(x), 3.0 * UNIT.slope(x)], axis=1)

    start = np.array([[3.0, 4.0], [-0.1, 0.05]])
    x, good = settle(equations, start)
    assert good.all()
    assert np.allclose(x, start / np.linalg.norm(start, axis=1, keepdims=True), atol=1e-12)  # the closest point


def test_critical_positions_of_a_projected_sphere_are_its_equator() -> None:
    """x^2 + y^2 + z^2 = 1 projected along z: the rim of a disc, with the disc on its inner side."""
    sphere = Quadric(np.array([-1.0]), np.zeros((1, 3)), 2.0 * np.eye(3)[None])
    fold = Fold(Stratum(sphere, np.eye(2, 3)))
    rng = np.random.default_rng(0)
    start = rng.normal(size=(30, 3))
    start /= np.linalg.norm(start, axis=1, keepdims=True)
    p, good = settle(lambda at, _: fold.linearised(at), fold.starts(start))
    p = p[good & (np.abs(p[:, 4:]).max(axis=1) > 1e-6)]
    assert len(p) > 20
    assert np.abs(p[:, 2]).max() < 1e-9
    assert np.abs(np.linalg.norm(p[:, :2], axis=1) - 1.0).max() < 1e-9
    for q in p:
        tangent = np.linalg.svd(fold.jacobian(q))[2][-1]
        (side,) = sides(fold, q, tangent)
        assert np.sign(side) == -np.sign(q[4:] @ q[:2])  # the point can only move towards the centre
