"""Legs of laws between their reversals, and the line of several inputs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bundled import MODELS

from gimcli import Mechanism, load
from gimcli.mechanism import InputLaw
from gimcli.model.laws import PROFILES, PolynomialLaw, RunLaw, TableLaw
from gimcli.motion.legs import Leg, dense, legs
from gimcli.positions.inputs import input_line, line_through


def with_law(law: InputLaw, name: str = "crank_rocker") -> Mechanism:
    mechanism = load(MODELS / f"{name}.yaml")
    return replace(mechanism, actuators=tuple(replace(a, law=law) for a in mechanism.actuators))


def ends(found: list[Leg]) -> list[tuple[float, float, float, float]]:
    return [(leg.first, leg.last, leg.begin, leg.end) for leg in found]


@pytest.mark.parametrize("profile", PROFILES)
def test_a_profile_between_two_values_is_one_leg(profile: str) -> None:
    for start, end in ((0.2, 3.0), (3.0, 0.2)):
        (leg,) = legs(with_law(RunLaw(start, end, PROFILES[profile])))
        assert (leg.first, leg.last, leg.begin, leg.end) == (0.0, 1.0, start, end)
        assert leg.sense == np.sign(end - start)


def test_a_polynomial_reverses_at_the_roots_of_its_derivative() -> None:
    """t (1 - 2 t)^2 = t - 4 t^2 + 4 t^3 increases to 2/27 at 1/6, decreases to 0 at 1/2 and increases to 1."""
    found = np.array(ends(legs(with_law(PolynomialLaw((0.0, 1.0, -4.0, 4.0))))))
    assert found[:, :2] == pytest.approx(np.array([[0.0, 1 / 6], [1 / 6, 0.5], [0.5, 1.0]]), abs=1e-15)
    assert found[:, 2:] == pytest.approx(np.array([[0.0, 2 / 27], [2 / 27, 0.0], [0.0, 1.0]]), abs=1e-15)


def test_an_inflection_with_a_horizontal_tangent_is_no_reversal() -> None:
    assert len(legs(with_law(PolynomialLaw((0.125, 0.75, -1.5, 1.0))))) == 1  # (t - 1/2)^3 + 1/4


def test_a_table_reverses_at_its_samples_and_dwells_between_them() -> None:
    """A dwell belongs to the leg before it, whether the law then continues or reverses."""
    law = TableLaw((0.0, 1.0, 2.0, 3.0, 4.0, 5.0), (0.0, 1.0, 1.0, 2.0, 2.0, 0.5))
    found = np.array(ends(legs(with_law(law))))
    assert found == pytest.approx(np.array([[0.0, 0.8, 0.0, 2.0], [0.8, 1.0, 2.0, 0.5]]), abs=1e-15)


def test_a_constant_law_is_one_leg() -> None:
    assert ends(legs(with_law(PolynomialLaw((0.7,))))) == [(0.0, 1.0, 0.7, 0.7)]


def test_coordinates_of_a_leg_increase_with_time_and_give_the_inputs_of_the_law() -> None:
    mechanism = with_law(PolynomialLaw((0.3, 4.0, -4.0)))
    for leg in legs(mechanism):
        time = np.linspace(leg.first, leg.last, 101)
        s = leg.places(time)
        assert np.all(np.diff(s) >= 0.0)
        assert leg.inputs(s) == pytest.approx(mechanism.actuators[0].law(time)[None], abs=1e-15)
        assert leg.time_at(float(s[40])) == pytest.approx(time[40], abs=1e-9)
        assert leg.inputs(np.array([leg.goal + 0.1]))[0, 0] == pytest.approx(leg.end + 0.1 * leg.sense)


def test_a_leg_is_mirrored_at_a_reversal_of_the_input() -> None:
    """The law goes from 0 to 2, the input reverses at 1.25; mirrored twice there, the leg is the law again."""
    (leg,) = legs(with_law(RunLaw(0.0, 2.0, PROFILES["uniform"])))
    back = leg.reflected(1.25, 0.625)
    assert (back.first, back.begin, back.end, back.sense) == (0.625, 1.25, 0.5, -1.0)
    assert back.values(np.array([0.75]))[0, 0] == 1.0
    again = back.reflected(1.25)
    assert not again.mirrored
    assert again.end == leg.end


def test_inputs_with_proportional_laws_are_on_a_line() -> None:
    """The parameter of the line is the value of the input that changes most, in rad or sizes."""
    mechanism = load(MODELS / "five_bar.yaml")
    for profile in PROFILES.values():
        laws = (RunLaw(0.5, 0.0, profile), RunLaw(-1.0, 2.0, profile))
        driven = replace(
            mechanism, actuators=tuple(replace(a, law=w) for a, w in zip(mechanism.actuators, laws, strict=True))
        )
        line = input_line(driven)
        assert line is not None
        assert line.main == 1
        time = np.linspace(0.0, 1.0, 11)
        assert line.at(laws[1](time)) == pytest.approx(np.array([w(time) for w in laws]), abs=1e-15)
    assert line_through(mechanism, np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 4.0]])) is None


def test_inputs_with_other_laws_are_followed_by_the_time() -> None:
    mechanism = load(MODELS / "five_bar.yaml")
    laws = (RunLaw(0.5, 0.0, PROFILES["cubic"]), RunLaw(-1.0, 2.0, PROFILES["uniform"]))
    driven = replace(
        mechanism, actuators=tuple(replace(a, law=w) for a, w in zip(mechanism.actuators, laws, strict=True))
    )
    (leg,) = legs(driven)
    assert leg.line is None
    assert leg.inputs(np.array([0.25]))[:, 0] == pytest.approx([w(np.array([0.25]))[0] for w in laws], abs=1e-15)


def test_a_dense_grid_contains_the_given_coordinates() -> None:
    given = np.array([0.1, 0.1001, 3.0])
    grid, own = dense(0.0, given, 2.0 * np.pi)
    assert np.array_equal(grid[own], given)
    assert np.all(np.diff(grid) > 0.0)
    assert np.max(np.diff(grid)) <= 2.0 * np.pi / 90 * (1.0 + 1e-8)
