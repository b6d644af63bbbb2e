"""Laws of motion: end values, derivatives compared with differences, and interpolation of tables."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gimcli.input_laws import SummedLaw
from gimcli.model.laws import PROFILES, PolynomialLaw, RunLaw, TableLaw

SMOOTH = {**PROFILES, "polynomial": PolynomialLaw((0.3, -1.0, 2.0, 0.5, 4.0, -2.0))}
INSIDE = np.array([0.13, 0.31, 0.5, 0.77])

CLOSED = {  # Norton, Cam Design and Manufacturing Handbook, 2002, chapter 2
    "uniform": lambda t: t,
    "cubic": lambda t: 3 * t**2 - 2 * t**3,
    "quintic": lambda t: 10 * t**3 - 15 * t**4 + 6 * t**5,
    "cycloidal": lambda t: t - math.sin(2 * math.pi * t) / (2 * math.pi),
    "harmonic": lambda t: (1 - math.cos(math.pi * t)) / 2,
}


@pytest.mark.parametrize("name", PROFILES)
def test_profiles_agree_with_the_handbook(name):
    assert PROFILES[name](INSIDE, 0) == pytest.approx([CLOSED[name](t) for t in INSIDE], rel=1e-14)


@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize(("start", "end"), [(0.1, 0.7), (-1 / 3, 2 * math.pi), (5.0, 5.0), (1e9 / 7, -1e-9)])
def test_both_ends_of_a_law_are_exact(name, start, end):
    values = RunLaw(start, end, PROFILES[name])(np.array([0.0, 1.0]))
    assert values.tolist() == [start, end]


@pytest.mark.parametrize("name", PROFILES)
def test_profiles_are_symmetric_and_increasing(name):
    t = np.linspace(0.0, 1.0, 201)
    s = PROFILES[name](t, 0)
    assert s + s[::-1] == pytest.approx(np.ones_like(t), abs=1e-14)
    assert np.all(np.diff(s) > 0.0)


@pytest.mark.parametrize("name", SMOOTH)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_agree_with_central_differences_to_second_order(name, order):
    law = SummedLaw(((0.5, RunLaw(2.0, -3.0, SMOOTH[name])),))

    def error(step):
        difference = (law(INSIDE + step, order - 1) - law(INSIDE - step, order - 1)) / (2 * step)
        return float(np.max(np.abs(difference - law(INSIDE, order))))

    coarse, fine = error(4e-3), error(2e-3)
    if coarse > 1e-8:
        assert math.log2(coarse / fine) == pytest.approx(2.0, abs=0.05)
    else:  # differences of a parabola or a straight line are exact
        assert fine < 1e-8


@pytest.mark.parametrize("name", ["cubic", "quintic", "cycloidal", "harmonic"])
def test_speed_is_zero_at_both_ends(name):
    assert PROFILES[name](np.array([0.0, 1.0]), 1) == pytest.approx([0.0, 0.0], abs=1e-13)


@pytest.mark.parametrize("name", ["quintic", "cycloidal"])
def test_acceleration_is_zero_at_both_ends(name):
    assert PROFILES[name](np.array([0.0, 1.0]), 2) == pytest.approx([0.0, 0.0], abs=1e-12)


PEAKS = {  # highest speed and acceleration of a unit rise: Norton 2002, table 2-2
    "cubic": (1.5, 6.0),
    "quintic": (1.875, 5.7735),
    "cycloidal": (2.0, 2 * math.pi),
    "harmonic": (math.pi / 2, math.pi**2 / 2),
}


@pytest.mark.parametrize("name", PEAKS)
def test_peaks_of_speed_and_acceleration(name):
    t = np.linspace(0.0, 1.0, 20_001)
    speed, acceleration = (np.max(np.abs(PROFILES[name](t, order))) for order in (1, 2))
    assert (speed, acceleration) == pytest.approx(PEAKS[name], rel=1e-5)


# -- tables ----------------------------------------------------------------------------------

WHEN = [2.0, 3.0, 3.5, 6.0, 7.0]


def test_a_table_interpolates_its_points():
    table = TableLaw(WHEN, [0.0, 1.0, 1.0, 4.0, 4.5])
    t = (np.array(WHEN) - 2.0) / 5.0
    assert table(t) == pytest.approx([0.0, 1.0, 1.0, 4.0, 4.5], abs=1e-14)


def test_a_table_does_not_overshoot():
    table = TableLaw(WHEN, [0.0, 1.0, 1.0, 4.0, 4.5])
    t = np.linspace(0.0, 1.0, 5_001)
    assert np.all(np.diff(table(t)) >= -1e-14)
    flat = table((np.linspace(3.0, 3.5, 50) - 2.0) / 5.0)
    assert flat == pytest.approx(np.ones(50), abs=1e-14)
    assert np.min(table(t)) >= 0.0
    assert np.max(table(t)) <= 4.5 + 1e-14


def test_a_table_of_points_on_a_line_is_linear():
    table = TableLaw(WHEN, [3.0 * t - 1.0 for t in WHEN])
    t = np.linspace(0.0, 1.0, 11)
    assert table(t) == pytest.approx(3.0 * (2.0 + 5.0 * t) - 1.0, rel=1e-14)
    assert table(t, 1) == pytest.approx(np.full(11, 15.0), rel=1e-12)
    assert table(t, 2) == pytest.approx(np.zeros(11), abs=1e-10)


def test_the_derivative_of_a_table_agrees_with_differences():
    table = TableLaw(WHEN, [0.0, 1.0, 1.5, 4.0, 4.5])
    t = (np.array([2.3, 3.2, 4.7, 6.6]) - 2.0) / 5.0
    steps = [1e-3, 5e-4]
    errors = [np.max(np.abs((table(t + h) - table(t - h)) / (2 * h) - table(t, 1))) for h in steps]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
