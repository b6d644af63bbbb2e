"""Circuits, limits and branches of mechanisms whose inputs follow one: a geared five-bar in closed form."""

from fractions import Fraction

import numpy as np
import pytest

import gimcli
from gimcli.continuation.curve import PositionCurve
from tests.gears.test_coupled_positions import five_bar


def folds(ratio, phase, turns, d=3.0, a=(1.0, 1.2), b=(3.5, 3.0)):
    """Return the angles [deg] of the first crank at which the dyad is stretched or folded: sign changes, bisected."""

    def excess(t):
        apart = abs(d + a[1] * np.exp(1j * (ratio * t + np.radians(phase))) - a[0] * np.exp(1j * t))
        return np.array([sum(b) - apart, apart - abs(b[0] - b[1])])

    t = np.linspace(0.0, 2.0 * np.pi * turns, 20_001)
    values = excess(t)
    found = []
    for row in range(2):
        for k in np.flatnonzero(np.diff(np.sign(values[row]))):
            low, high = t[k], t[k + 1]
            for _ in range(60):
                middle = 0.5 * (low + high)
                same = np.sign(excess(middle)[row]) == np.sign(excess(low)[row])
                low, high = (middle, high) if same else (low, middle)
            found.append(np.degrees(low))
    return sorted(found)


# After q turns of the first crank the second one, with the ratio p / q, has made p turns: both are as at the start.
@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("ratio", "turns"), [(2.0, 1), (0.5, 2), (-1.0, 1), (1.0 / 3.0, 3), (-2.0 / 3.0, 3), (20.0 / 21.0, 21)]
)
def test_circuits_close_after_the_turns_that_the_ratio_requires(ratio, turns):
    m = gimcli.load(five_bar(ratio, 60.0))
    curve = PositionCurve(m)
    assert curve.period == pytest.approx(2.0 * np.pi * Fraction(ratio).limit_denominator(50).denominator)
    if turns > 3:
        return
    found = gimcli.circuits(m, values=12).report()
    assert found["complete"]
    assert [(one["closed"], one["turns"]) for one in found["curves"]] == [(True, turns)] * 2
    assert found["samples"] == 12 * turns


def test_an_irrational_ratio_does_not_close():
    result = gimcli.circuits(gimcli.load(five_bar(2.0**0.5, 60.0)), values=12)
    found = result.report()
    assert [one["closed"] for one in found["curves"]] == [False, False]
    assert found["complete"]


SHORT = {"b": (1.6, 1.3), "drawn": (1.5, 1.0)}


@pytest.mark.parametrize(("ratio", "turns"), [(2.0, 1), (-1.0, 1), (0.5, 2)])
def test_limits_are_where_the_dyad_is_stretched_or_folded(ratio, turns):
    m = gimcli.load(five_bar(ratio, 60.0, **SHORT))
    exact = folds(ratio, 60.0, turns, b=SHORT["b"])
    found = gimcli.circuits(m, values=72).report()
    ends = {
        round(branch[end]["motor"] % (360.0 * turns), 6)
        for curve in found["curves"]
        for branch in curve["branches"]
        for end in ("from", "to")
    }
    assert sorted(ends) == pytest.approx(exact, abs=2e-6)
    for curve in found["curves"]:
        low, high = curve["interval"]["motor"]
        at_low, at_high = sorted(curve["interval"]["second"])
        assert sorted(ratio * v + 60.0 for v in (low, high)) == pytest.approx([at_low, at_high])


def test_limits_of_the_circuit_of_the_start():
    m = gimcli.load(five_bar(2.0, 60.0, **SHORT))
    exact = folds(2.0, 60.0, 1, b=SHORT["b"])
    found = gimcli.singularities(m)
    at = {round(one["at"]["motor"] % 360.0, 6) for one in found.report()["singularities"] if one["kind"] == "limit"}
    assert at
    assert all(min(abs(value - one) for one in exact) < 2e-6 for value in at)


def test_a_motion_reverses_at_the_limits_of_a_coupled_input():
    m = gimcli.load(five_bar(2.0, 60.0, **SHORT, law={"from": 0, "to": 360}))
    exact = folds(2.0, 60.0, 1, b=SHORT["b"])
    t = gimcli.trace(m, steps=90, at_limit="reverse")
    assert set(t.status) == {"ok"}
    assert np.allclose(t["second"], 2.0 * t["motor"] + 60.0, atol=1e-9)
    low, high = t["motor"].min(), t["motor"].max()
    assert max(value for value in (v - 360.0 for v in exact)) <= low
    assert high <= min(v for v in exact if v > 0.0) + 1e-9
