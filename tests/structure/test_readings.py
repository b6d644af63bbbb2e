"""The quantities of constraints and their derivatives, which follow from the equations: closed forms, differences."""

import math

import numpy as np
import pytest

from gimcli.mechanism import ANGLE, HEIGHT, SPAN
from gimcli.structure.readings import Readings
from gimcli.structure.steps import Constraint, Value, Vector

VERTEX, RIGHT, FAR, UP, TWIN = range(5)
PLACES = np.array([0.0j, 2.0 + 0.0j, 3.0 + 4.0j, 0.5j, 3.0 + 4.0j])
NONE = Value(0.0)

ROWS = {
    "distance": Constraint("", SPAN, FAR, VERTEX, Value(7.0)),
    "height over a line of the frame": Constraint("", HEIGHT, FAR, RIGHT, Value(7.0), Vector(1j)),
    "height over a line of two nodes": Constraint("", HEIGHT, FAR, UP, NONE, Vector(0.5j, VERTEX, RIGHT)),
    "angle from an axis": Constraint("", ANGLE, FAR, VERTEX, NONE, Vector(1.0 + 0.0j)),
    "angle of two arms": Constraint("", ANGLE, FAR, VERTEX, NONE, Vector(1j, VERTEX, RIGHT, actuator=3)),
}
EXPECTED = {
    "distance": (5.0, {VERTEX: -0.6 - 0.8j, FAR: 0.6 + 0.8j}),
    "height over a line of the frame": (4.0, {RIGHT: -1j, FAR: 1j}),
    # i (V - U) / 2 = i: the height is 3.5; it changes by Re(conj(i / 2 dV) (3 + 3.5 i)) = 1.75 dVx - 1.5 dVy
    "height over a line of two nodes": (3.5, {FAR: 1j, UP: -1j, RIGHT: 1.75 - 1.5j, VERTEX: -1.75 + 1.5j}),
    "angle from an axis": (math.atan2(4.0, 3.0), {FAR: (-4.0 + 3.0j) / 25.0, VERTEX: (4.0 - 3.0j) / 25.0}),
    # arms of lengths 5 and 2, a quarter turn between the second and the ray
    "angle of two arms": (
        math.atan2(4.0, 3.0) - math.pi / 2.0,
        {FAR: (-4.0 + 3.0j) / 25.0, RIGHT: -0.5j, VERTEX: (4.0 - 3.0j) / 25.0 + 0.5j},
    ),
}


@pytest.mark.parametrize("name", ROWS)
def test_values_and_gradients_have_the_closed_forms(name):
    found = Readings([ROWS[name]], len(PLACES))
    value, by_node = EXPECTED[name]
    assert found.values(PLACES) == pytest.approx([value], abs=1e-15)
    expected = np.zeros(len(PLACES), dtype=complex)
    expected[list(by_node)] = list(by_node.values())
    assert found.slopes(PLACES).view(complex)[0] == pytest.approx(expected, abs=1e-15)


def test_second_derivatives_are_those_of_differences():
    rng = np.random.default_rng(3)
    z, motion = rng.normal(size=(2, len(PLACES), 2)) @ [1.0, 1j]
    found, h = Readings(list(ROWS.values()), len(PLACES)), 1e-5
    expected = (found.slopes(z + h * motion) - found.slopes(z - h * motion)) / (2.0 * h)
    assert found.slopes_along(z, motion) == pytest.approx(expected, abs=1e-7)


def test_coincident_nodes_have_a_gradient_of_any_direction():
    found = Readings([Constraint("", SPAN, TWIN, FAR, NONE)], len(PLACES))
    gradient = found.slopes(PLACES).view(complex)[0]
    assert abs(gradient[TWIN]) == 1.0
    assert gradient[FAR] == -gradient[TWIN]
