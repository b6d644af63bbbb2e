"""Configurations, circuits and singular positions where the linkage turns gears, by closed forms."""

import numpy as np
import pytest
from coupled_models import rack, sun_and_planet
from scipy.optimize import minimize_scalar

import gimcli
from tests.gears.test_linked_gears import complex_of, driven_apex, rocker, rocker_angle, slider, turned

SHORT = {"in": 2.0, "coupler": 2.2}
DRAWN = np.angle(complex(3.2 - 4.0, 1.83))


def limited(law=(1.0, 1.4)):
    """A double rocker whose gear has a limit: the coupler and the rocker are in line at |AQ| = 4.2."""
    data = rocker({"from": law[0], "to": law[1]}, ground=4.0, **SHORT)
    data["nodes"] |= {"A": [1.08, 1.68], "B": [3.2, 1.83]}
    return data


def test_limits_and_the_gear_there():
    found = gimcli.singularities(gimcli.load(limited()))
    limits = [one for one in found.events if one["kind"] == "limit"]
    turn = np.arccos((20.0 - 4.2**2) / 16.0)
    assert sorted(one["at"]["motor"] for one in limits) == pytest.approx([-turn, turn], abs=1e-9)
    for one in limits:
        angle = np.angle(2.0 * np.exp(1j * one["at"]["motor"]) - 4.0)
        wheel = 6.0 + np.exp(-3j * (angle - DRAWN))
        assert abs(complex(*one["nodes"]["T"]) - wheel) < 1e-8


def wheels(motor):
    """Return B and T in both configurations of the double rocker at an input."""
    for sense in (1.0, -1.0):
        line = 4.0 - 2.0 * np.exp(1j * motor)
        apart = abs(line)
        angle = np.angle(-line) - sense * np.arccos((apart**2 + 4.0 - 2.2**2) / (4.0 * apart))
        yield 4.0 + 2.0 * np.exp(1j * angle), 6.0 + np.exp(-3j * (angle - DRAWN))


@pytest.mark.parametrize("motor", [0.3, 1.2, -1.3])
def test_all_configurations(motor):
    found = gimcli.configurations(gimcli.load(limited()), motor=motor)
    places = list(zip(complex_of(found, "B"), complex_of(found, "T"), strict=True))
    assert len(places) == 2
    for wanted in wheels(motor):
        assert min(max(abs(a - b) for a, b in zip(one, wanted, strict=True)) for one in places) < 1e-9


def test_no_configuration_beyond_the_limit():
    assert gimcli.configurations(gimcli.load(limited()), motor=2.0).count == 0


def test_another_assembly_is_followed_from_its_own_position():
    m = gimcli.assembled(gimcli.load(rocker({"from": 0.0, "to": 2.0 * np.pi})), assembly="+")
    t = gimcli.trace(m, steps=24)
    drawn = np.angle(complex(2.4 - 3.0, 1.9))
    mirrored = -rocker_angle(-t["motor"])  # its pin is on the other side of the line from crank pin to pivot
    assert np.max(abs(complex_of(t, "B") - (3.0 + 2.0 * np.exp(1j * mirrored)))) < 1e-10
    assert np.max(abs(complex_of(t, "T") - (5.0 + np.exp(-3j * (mirrored - drawn))))) < 1e-9


def test_circuits_of_a_rack():
    found = gimcli.circuits(gimcli.load(rack()), values=8).report()
    assert [(one["closed"], one["turns"]) for one in found["curves"]] == [(True, 1.0)] * 2
    low, high = found["curves"][0]["interval"]["mesh"]
    assert (high - low) == pytest.approx(np.degrees(60.0 / 20.0), abs=1e-9)
    assert len(found["configurations"]) == 2


def test_a_trace_of_the_circuit_of_a_rack():
    t = gimcli.trace(gimcli.load(rack()), steps=30, circuit=True)
    angle = (slider(np.radians(t["motor"])) - 130.0) / 20.0
    assert set(t.status) == {"ok"}
    assert np.max(abs(complex_of(t, "T") - turned([150, 20], 20.0, angle + np.pi / 2.0))) < 1e-9
    assert np.ptp(t["motor"]) == pytest.approx(360.0)


EXACT = {"xatol": 1e-9}


def apex(turn):
    return np.sin(turn) + np.sqrt(9.0 - (1.5 - np.cos(turn)) ** 2)


def test_circuits_of_a_gear_inside_a_loop():
    """The apex of the geared five-bar rises and falls while the cranks make a turn, above the frame or below it."""
    found = gimcli.circuits(gimcli.load(driven_apex()), values=8).report()
    high = -minimize_scalar(lambda turn: -apex(turn), bounds=(0.0, np.pi), method="bounded", options=EXACT).fun
    low = minimize_scalar(apex, bounds=(-np.pi, 0.0), method="bounded", options=EXACT).fun
    assert [one["closed"] for one in found["curves"]] == [True, True]
    for one in found["curves"]:
        assert sorted(map(abs, one["interval"]["cylinder"])) == pytest.approx([low, high], abs=1e-6)


def test_the_circuit_closes_after_the_turns_of_the_wheel():
    """Per turn of a double crank its follower makes one turn, and the wheel of twice the size on it a half."""
    data = rocker({"from": 0.0, "to": 6.0}, ground=1.0, **{"in": 3.0, "coupler": 2.5, "out": 2.8})
    data["nodes"] |= {"A": [3.0, 0.0], "B": [2.4, 2.4269322199023195]}
    data["gears"]["mesh"]["ratio"] = 0.5
    found = gimcli.singularities(gimcli.load(data)).report()["circuits"]
    assert [(one["closed"], one["turns"]) for one in found] == [(True, 2.0)]


def test_stationary_positions_of_the_beam_of_a_sun_and_planet_gear():
    """The beam reverses where crank and rod are in line: |OB| = 500 or 300, with |OC| = |200 - 400i| and |BC| = 300."""
    found = gimcli.singularities(gimcli.load(sun_and_planet()))
    still = [one for one in found.events if one["kind"] == "stationary" and "beam" in one["about"]]
    assert len(still) == 2
    for one in still:
        a, b = (complex(*one["nodes"][n]) for n in "AB")
        assert abs((a * b.conjugate()).imag) < 1e-5 * abs(a * b)


def test_methods_agree_where_the_linkage_turns_a_pinion():
    found = gimcli.tradeoff(gimcli.load(rack()), steps=8, tolerances=[1e-8], jit="off").table()
    errors = dict(zip(found["method"], found["error"], strict=True))
    assert all(errors[name] < 1e-7 for name in ("gim-spectral", "newton", "auto", "absolute", "natural"))
