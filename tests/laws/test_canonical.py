"""Results that rounding would decide have one form: angles at the end of their range, equal values, ties."""

import math

import numpy as np
import pytest
from fences import compare, is_near

import gimcli
from gimcli import equilibrium, loads
from gimcli.canonical import ROUNDING, beside, first_greatest, first_least, phase, principal, ranks
from gimcli.structure.coordinate_partitioning import free_choice
from gimcli.structure.equations import coupled_terms

NOISE = [0.0, 4e-16, -4e-16, 1e-13, -1e-13, 1e-11, -1e-11]


@pytest.mark.parametrize("turns", [-3, -1, 0, 1, 2])
@pytest.mark.parametrize("error", NOISE)
def test_half_a_turn_is_at_the_upper_end(error, turns):
    angle = (turns + 0.5) * 2.0 * math.pi + error
    assert principal(angle) == pytest.approx(math.pi, abs=1e-10)
    assert beside(angle, 2.0) == pytest.approx(math.pi, abs=1e-10)
    assert principal((turns + 0.5) * 360.0 + error, 360.0) == pytest.approx(180.0, abs=1e-9)


def test_angles_off_the_end_stay():
    angle = np.linspace(-math.pi + 1e-6, math.pi - 1e-6, 1001)
    assert np.array_equal(principal(angle), angle)
    assert principal(-math.pi + 1e-6) < 0.0
    assert phase(np.array([complex(-1.0, -0.0), complex(-1.0, 0.0), -1j])) == pytest.approx(
        [math.pi, math.pi, -math.pi / 2]
    )


@pytest.mark.parametrize("error", NOISE)
def test_equal_values_have_one_order(error):
    assert first_greatest(np.array([math.nan, 2.0, 2.0 + error, 1.0])) == 1
    assert ranks(np.array([3.0 + error, 1.0, 3.0, 1.0 - error]), ROUNDING).tolist() == [1, 0, 1, 0]
    assert first_greatest(np.array([math.nan, math.nan])) == 0


def pendulum(drawn, law=""):
    """A pendulum that hangs at q = 0 and stands at 180 degrees; gravity along +x."""
    x, y = math.cos(math.radians(drawn)), math.sin(math.radians(drawn))
    return loads(
        f"nodes: {{O: [0, 0], A: [{x!r}, {y!r}]}}\nground: [O]\nlinks: {{arm: [O, A]}}\n"
        "units: {length: m}\nmasses: {A: 1}\ngravity: [9.81, 0]\n"
        f"actuators: {{q: {{type: rotary, pivot: O, arm: A, free: true{law}}}}}\n"
    )


@pytest.mark.few(5)
@pytest.mark.parametrize("error", [0.0, 1e-13, -1e-13, 1e-11, -1e-11])
@pytest.mark.parametrize(
    ("law", "expected"),
    [("", [0.0, 180.0]), (", law: {from: -180, to: 180}", [0.0, 180.0]), (", law: {from: 180, to: -180}", [0.0, 180.0]),
     (", law: {from: -360, to: 0}", [-180.0, 0.0]), (", law: {from: 180, to: 540}", [180.0, 360.0])],
)  # fmt: skip
def test_equilibria_at_the_ends_of_the_turn_have_one_angle(law, expected, error):
    """The pendulum hangs and stands in the line of gravity; an error of rounding decides neither angle nor order."""
    found = equilibrium(pendulum(error, law), free="q").equilibria
    assert [one["inputs"]["q"] for one in found] == pytest.approx(expected, abs=1e-6)


def test_samples_of_the_manual_are_compared_by_numbers():
    compare("at -0.000 mm, 12.35 N", "at 0.000 mm, 12.36 N")  # one unit of the last digit
    compare("1234567 rows", "1234568 rows")
    for one, other in (("12.35 N", "12.37 N"), ("180 deg", "-180 deg"), ("limit 1", "stop 1")):
        with pytest.raises(AssertionError):
            compare(one, other)
    assert is_near("1.5e-03", "1.6e-03")
    assert not is_near("1.5e-03", "1.7e-03")


@pytest.mark.parametrize("noise", [1e-13, -1e-13])
def test_modes_of_one_frequency_have_one_form(noise):
    """Two equal pendulums on one sliding base that is held have shapes in which one moves and the other rests."""
    from gimcli.dynamics.modes import _separated

    turn = np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    values = np.array([4.0, 4.0 + 10.0 * noise, 9.0])
    np.testing.assert_allclose(_separated(values, turn + noise), np.eye(3), atol=1e-9)
    assert np.array_equal(_separated(np.array([1.0, 4.0, 9.0]), turn), turn)


def test_the_peak_of_equal_ends_is_the_first():
    from gimcli.dynamics.force_statistics import Extremum, Statistic

    for noise in (1e-13, -1e-13):
        low, high = Extremum(-7.0 * (1.0 + noise), 0.2, {}), Extremum(7.0, 0.6, {})
        assert Statistic("N", 0.0, 5.0, low, high, 1.0).peak is low
        later = Extremum(low.value, 0.8, {})
        assert Statistic("N", 0.0, 5.0, later, high, 1.0).peak is high


def test_the_least_of_equal_values_is_the_first():
    for noise in (1e-13, -1e-13):
        assert first_least(np.array([3.0, 1e-16, noise, 2.0]), 1e-9) == 1


@pytest.mark.parametrize("name", ["chebyshev", "lift_table", "spring_block", "stephenson_2", "suspension"])
def test_equally_good_independent_variables(name):
    """The first of those that are equally good is chosen, whatever the rounding of the position is."""
    mechanism = gimcli.load(name).nearby
    terms, source, found = coupled_terms(mechanism), np.random.default_rng(1), set()
    first = terms.first_reading
    for _ in range(12):
        v = np.zeros(terms.variables)
        v[0:first:2], v[1:first:2], v[-1] = mechanism.drawn.real, mechanism.drawn.imag, 1.0
        v[first : first + len(mechanism.actuators)] = mechanism.drawn_inputs
        v[:first] += 1e-15 * source.normal(size=first)
        found.add(free_choice(terms, v, (), len(mechanism.drivers)).independent)
    assert len(found) == 1
