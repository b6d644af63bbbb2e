"""Inputs between given ones."""

import numpy as np

from gimcli.positions.inputs import divided


def test_steps_are_divided_into_equal_parts():
    """Between the given values, which stay exact, all parts of a step are equal."""
    values = np.array([[0.1, 0.7, -0.4], [1e9, 1e9 + 1.0, 3.0]])
    found = divided(values, np.array([3, 4]))
    assert np.array_equal(found[:, [0, 3, 7]], values)
    steps = np.diff(found) * np.repeat([3, 4], [3, 4])
    assert np.allclose(steps, np.repeat(np.diff(values), [3, 4], axis=1), rtol=1e-6)
    assert np.array_equal(divided(values, np.array([1, 1])), values)
