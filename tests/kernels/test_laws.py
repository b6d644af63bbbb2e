"""Laws of forces: energy, effort and stiffness belong together, and have the units of their readings."""

import numpy as np
import pytest

from gimcli.calculus.dual import Dual
from gimcli.dynamic_data import SpringForce
from gimcli.kernels import laws

SPRING = SpringForce("s", 0, 300.0, 0.7)
READINGS = np.array([-0.4, 0.0, 0.7, 1.9])


@pytest.mark.parametrize("unit", [1.0, 0.25])
def test_the_effort_of_a_spring_is_minus_the_slope_of_its_energy_and_its_stiffness_minus_the_slope_of_the_effort(unit):
    energy, effort, stiffness = laws.spring(SPRING.law, Dual(READINGS, np.ones((1, len(READINGS)))), unit)
    assert energy.slopes[0] == pytest.approx(-effort.value, rel=1e-14)
    assert effort.slopes[0] == pytest.approx(-stiffness * np.ones(len(READINGS)), rel=1e-14)
    assert effort.value / unit == pytest.approx(-300.0 * (READINGS - 0.7) * unit, rel=1e-14)  # N, at m


def test_a_damper_resists_the_rate():
    assert laws.damper(5.0, 2.0, 0.1) / 0.1 == pytest.approx(-5.0 * 2.0 * 0.1, rel=1e-15)


def test_a_drive_has_no_effort_at_its_idle_speed():
    assert [laws.drive(8.0, 40.0, rate) for rate in (0.0, 10.0, 40.0)] == [8.0, 6.0, 0.0]
    assert laws.drive(8.0, 0.0, 25.0) == 8.0
