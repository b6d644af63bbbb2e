"""Mechanisms whose longest and shortest link, or lever arm and extent, differ by up to 1e4.

Positions, limits and efforts are compared with closed forms of 40 digits. The accepted error is the accuracy asked for,
or ten times what a change of the lengths by a few roundings causes.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from extreme_cases import exact_ray, meet
from mpmath import mp, mpc, mpf

import gimcli

STEPS = 72
FORCE = 3 - 5j
ROUNDED = 2e-15
"""Relative changes of the lengths, of alternate sign, that rounding may cause."""


def dot(p, q):
    return mp.re(mpc(p) * mp.conj(q))


def drawn_at_random(seed):
    """Return lengths (crank, coupler, rocker, frame) from 0.01 to 100, an angle [deg] and a side of a four-bar."""
    rng = np.random.default_rng(seed)
    while True:
        a, b, c, d = (10.0 ** rng.uniform(-2.0, 2.0, 4)).tolist()
        angle = float(rng.uniform(-180.0, 180.0))
        diagonal = abs(d - a * np.exp(1j * np.radians(angle)))
        if abs(b - c) * 1.001 < diagonal < (b + c) * 0.999:
            return (a, b, c, d), angle, int(rng.choice([-1, 1]))


def four_bar(lengths, start, side):
    a, b, c, d = lengths
    crank = complex(a * exact_ray(start))
    apex = complex(meet(crank, b, d, c, side)[0])
    return {
        "units": {"length": "m"},
        "nodes": {"O": [0, 0], "C": [d, 0], "A": [crank.real, crank.imag], "B": [apex.real, apex.imag]},
        "ground": ["O", "C"],
        "links": {
            "crank": {"nodes": ["O", "A"], "length": a},
            "rod": {"nodes": ["A", "B"], "length": b},
            "rocker": {"nodes": ["C", "B"], "length": c},
        },
        "actuators": {"motor": {"pivot": "O", "arm": "A", "law": {"from": start, "to": start + 360}}},
        "loads": {"weight": {"on": "B", "force": [FORCE.real, FORCE.imag]}},
    }


def place_and_torque(lengths, degrees, side):
    """Return the end of the rocker and the crank's torque by virtual work: FORCE . dB + torque . dangle = 0."""
    a, b, c, d = map(mpf, lengths)
    crank = a * exact_ray(degrees)
    apex = meet(crank, b, d, c, side)[0]
    rod = apex - crank
    turned = dot(rod, 1j * crank) / dot(rod, 1j * (apex - d))
    return apex, -dot(FORCE, 1j * turned * (apex - d))


def first_limit(lengths, start):
    """Return the turn [deg] from a start at which the dyad is stretched or folded; 360 if none is met."""
    a, b, c, d = map(mpf, lengths)
    cosines = [(a**2 + d**2 - reach**2) / (2 * a * d) for reach in (b - c, b + c)]
    limits = [sign * mp.degrees(mp.acos(x)) for x in cosines if abs(x) < 1 for sign in (1, -1)]
    return min([float((x - start) % 360) for x in limits], default=360.0)


def changed(lengths):
    return [length * (1 + ROUNDED * (-1) ** k) for k, length in enumerate(lengths)]


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(400))
def test_four_bars_have_the_positions_limits_and_torques_of_the_closed_form(seed):
    lengths, start, side = drawn_at_random(seed)
    found = gimcli.forces(gimcli.loads(json.dumps(four_bar(lengths, start, side))), steps=STEPS)
    trace = gimcli.trace(found.mechanism, steps=STEPS)
    turned = 360.0 * np.arange(STEPS + 1) / STEPS
    limit = first_limit(lengths, start)
    solved = np.asarray(trace["status"]) == "ok"
    clear = np.abs(turned - limit) > 1e-6
    assert np.array_equal(solved[clear], (turned < limit)[clear] | (limit == 360.0))
    for k in np.flatnonzero(solved & clear):
        place, torque = place_and_torque(lengths, start + turned[k], side)
        beside, other = place_and_torque(changed(lengths), start + turned[k], side)
        size = max(lengths)
        error = abs(mpc(trace["B.x"][k], trace["B.y"][k]) - place)
        assert error <= max(1e-9 * size, 10 * abs(beside - place))
        spread = 1e-8 * abs(torque) + 1e-9 * abs(FORCE) * lengths[0] + 10 * abs(other - torque)
        assert abs(found["motor.effort"][k] - torque) <= spread


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(100))
def test_a_lid_on_a_ram_near_its_hinge_has_the_force_of_the_moments(seed):
    """A lid of 10 m held at 1 mm to 1 m from its hinge: the ram's lever arm is a small part of the extent."""
    rng = np.random.default_rng(seed)
    arm, foot = 10.0 ** rng.uniform(-3.0, 0.0), 10.0 ** rng.uniform(-3.0, 0.0)
    low, high = np.sqrt(arm**2 + foot**2 - 2 * arm * foot * np.cos(np.radians([30.0, 150.0])))
    ray = np.exp(1j * np.radians(30.0))
    lid = {
        "units": {"length": "m"},
        "nodes": {
            "O": [0, 0],
            "Q": [foot, 0],
            "P": [arm * ray.real, arm * ray.imag],
            "T": [10 * ray.real, 10 * ray.imag],
        },
        "ground": ["O", "Q"],
        "elements": {"lid": ["O", "P", "T"]},
        "actuators": {"ram": {"nodes": ["Q", "P"], "law": {"from": float(low), "to": float(high)}}},
        "loads": {"weight": {"on": "T", "force": [0, -50]}},
    }
    found = gimcli.forces(gimcli.loads(json.dumps(lid)), steps=24)
    length = found["ram"]
    angle = np.arccos((arm**2 + foot**2 - length**2) / (2 * arm * foot))
    lever = arm * foot * np.sin(angle) / length
    expected = 50.0 * 10.0 * np.cos(angle) / lever
    assert np.max(np.abs(found["ram.effort"] - expected) / np.max(np.abs(expected))) < 1e-8


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", [73, 223, 32, *range(100)])
def test_four_bars_have_the_mobility_and_the_limits_of_the_closed_form(seed):
    """Seeds 73 and 223: a crank of 1e-4 of the size, whose unscaled equations hold at length 0 too; 32: sharp bends."""
    lengths, start, side = drawn_at_random(seed)
    mechanism = gimcli.loads(json.dumps(four_bar(lengths, start, side)))
    assert gimcli.mobility(mechanism).report()["mobility"] == 1
    a, b, c, d = map(mpf, lengths)
    cosines = [(a**2 + d**2 - reach**2) / (2 * a * d) for reach in (b - c, b + c)]
    limits = [float(sign * mp.degrees(mp.acos(x))) for x in cosines if abs(x) < 1 for sign in (1, -1)]
    found = [
        s["at"]["motor"] for s in gimcli.singularities(mechanism).report()["singularities"] if s["kind"] == "limit"
    ]
    assert len(found) == min(len(limits), 2)
    assert all(min(abs((one - limit + 180) % 360 - 180) for limit in limits) < 1e-6 for one in found)
