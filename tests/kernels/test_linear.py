"""The kernels' own linear algebra against LAPACK."""

import numpy as np
import pytest

from gimcli.kernels.circular import angle_of, cos_sin
from gimcli.kernels.linear import lu_factor, lu_solve, qr_factor, qr_solve


@pytest.mark.parametrize("n", range(1, 15))
@pytest.mark.parametrize("seed", range(5))
def test_elimination_solves_and_returns_the_sign(n, seed):
    generator = np.random.default_rng(seed)
    a, b = generator.standard_normal((n, n)), generator.standard_normal(n)
    a[generator.random((n, n)) < 0.3] = 0.0
    a += np.diag(1e-3 * np.arange(1, n + 1))  # small diagonal: rows have to be exchanged
    factors, x, order = a.copy(), b.copy(), np.zeros(2 * n)
    assert lu_factor(factors, n, order) == np.sign(np.linalg.det(a))
    lu_solve(factors, n, order, x)
    assert np.allclose(x, np.linalg.solve(a, b), rtol=1e-13 * np.linalg.cond(a), atol=1e-13 * np.linalg.cond(a))


def test_the_sign_of_a_singular_matrix_is_zero():
    assert lu_factor(np.zeros((3, 3)), 3, np.zeros(6)) == 0.0
    assert qr_factor(np.zeros((4, 3)), 4, 3, np.zeros(3)) == 0.0


@pytest.mark.parametrize(("m", "n"), [(1, 1), (4, 4), (7, 4), (12, 9)])
@pytest.mark.parametrize("seed", range(5))
def test_reflections_solve_in_the_least_squares_sense(m, n, seed):
    generator = np.random.default_rng(seed)
    a, b = generator.standard_normal((m, n)), generator.standard_normal(m)
    factors, x, diagonal = a.copy(), b.copy(), np.zeros(n)
    assert qr_factor(factors, m, n, diagonal) == 1.0
    qr_solve(factors, m, n, diagonal, x)
    assert np.allclose(x[:n], np.linalg.lstsq(a, b, rcond=None)[0], rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("turns", [0.3, 10.0, 9000.0])
def test_sine_cosine_and_angle_are_those_of_the_library(turns):
    angle = np.random.default_rng(0).uniform(-turns, turns, 5000) * 2.0 * np.pi
    cos, sin = cos_sin(angle)
    assert np.max(np.abs(cos - np.cos(angle))) < 3e-16
    assert np.max(np.abs(sin - np.sin(angle))) < 3e-16
    assert np.max(np.abs(angle_of(cos, np.abs(sin)) - np.arctan2(np.abs(sin), cos))) < 1e-15
