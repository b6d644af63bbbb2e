"""Equilibria with a spring on a wheel that the linkage turns: Q = torque - stiffness times angle times ratio."""

import numpy as np
import pytest
from scipy.optimize import brentq

import gimcli
from tests.gears.test_linked_dynamics import heavy, slope
from tests.gears.test_linked_gears import slider

COIL, TORQUE = 2.0, 0.5  # N m/rad, N m


def loaded(**more):
    return heavy(
        {"start": 60}, springs={"coil": {"pivot": "Q", "arm": "T", "stiffness": COIL, "free": 90.0}},
        loads={"push": {"on": "crank", "torque": TORQUE}}, **more,
    )  # fmt: skip


def force(turn):
    return TORQUE - COIL * (slider(turn) - 130.0) / 20.0 * slope(turn)


ROOTS = [brentq(force, 0.1, 1.0, xtol=1e-14), brentq(force, 2.0, 3.12, xtol=1e-14)]


def test_equilibria_of_a_sprung_pinion():
    found = gimcli.equilibrium(gimcli.load(loaded()))
    assert np.radians([one["inputs"]["motor"] for one in found.equilibria]) == pytest.approx(ROOTS, abs=1e-9)
    assert [one["stability"] for one in found.equilibria] == ["stable", "unstable"]
    h = 1e-5
    for one, turn in zip(found.equilibria, ROOTS, strict=True):
        assert np.radians(one["inputs"]["mesh"] - 90.0) == pytest.approx((slider(turn) - 130.0) / 20.0, abs=1e-9)
        assert one["stiffness"][0][0] == pytest.approx(-(force(turn + h) - force(turn - h)) / (2.0 * h), rel=1e-7)


def test_equilibria_of_two_released_inputs():
    """A pendulum on the rack does not change them: each is one with the pendulum down, and one with it up."""
    data = loaded(gravity=[0, -9.81])
    data["nodes"]["D"] = [160, -50]
    data["links"]["arm"] = ["C", "D"]
    data["masses"] = {"arm": {"mass": 1.0, "inertia": 0.01, "centre": [20, 0]}}
    data["actuators"]["swing"] = {"pivot": "C", "arm": "D", "reference": "B", "free": True, "start": 90}
    found = gimcli.equilibrium(gimcli.load(data))
    places = sorted(
        (round(one["inputs"]["motor"] % 360.0, 6), one["inputs"]["swing"] % 360.0) for one in found.equilibria
    )
    wanted = sorted((round(float(np.degrees(turn)), 6), swing) for turn in ROOTS for swing in (90.0, 270.0))
    assert np.allclose(places, wanted, atol=1e-6)
    assert [one["stability"] for one in found.equilibria].count("stable") == 1
