"""Forward dynamics: published cases, closed forms, and laws that hold for every mechanism."""

from __future__ import annotations

import csv
import json
import math
import pathlib
import re

import numpy as np
import pytest
from bundled import MODELS, changed, reference, written
from heavy_models import released
from scipy.integrate import solve_ivp, trapezoid
from scipy.special import ellipk

import gimcli
from gimcli import UsageError, load
from gimcli.dynamics.forces import inverse_dynamics
from gimcli.dynamics.simulation import Settings, simulate
from gimcli.dynamics.simulation_table import reactions
from gimcli.dynamics.statics import statics
from gimcli.kernels.jit import compiled
from gimcli.positions.dispatch import plain
from gimcli.status import Status

TIGHT = Settings(rtol=1e-12)
PERIOD, STANDSTILL, FASTEST = 3.59374750406788, 406.279660669895, 10.7287922500559


@pytest.fixture(scope="module")
def watt():
    return load(MODELS / "watt_durango.yaml")


# -- Watt's six-bar: an energy integral in 34 digits ------------------------------------------------


def test_watt_agrees_with_the_reference(watt):
    table = reference("watt_six_bar_W1.csv")
    found = simulate(watt, table["t"], TIGHT, compiled)
    for order, name in enumerate(("theta2", "omega", "alpha")):
        assert np.abs(found.inputs[order, 0] - table[name]).max() < 1e-9, name
    assert np.abs(found.energy[0] - table["T"]).max() < 1e-8
    assert np.abs(found.energy[1] - table["V"]).max() < 1e-8
    (stop,) = found.events
    assert stop.kind == "standstill"
    assert abs(2.0 * stop.time - PERIOD) < 1e-9
    assert abs(math.degrees(stop.inputs[0]) - STANDSTILL) < 1e-9


def test_watt_reactions_agree_with_the_reference(watt):
    table = reference("watt_six_bar_W1.csv")
    forces = reactions(simulate(watt, table["t"], TIGHT, compiled))
    names = [m.name for m in watt.members]
    held = {"O2": "crank", "A": "link3", "O4": "link4", "E": "link6", "B": "link4", "C": "link5", "D": "link6"}
    for pin in forces.statics.pins:
        node = watt.nodes[pin.node]
        force = forces.pin(pin, names.index(held[node]))
        expected = table[f"F{node}x"] + 1j * table[f"F{node}y"]
        # the reference may have the opposite sign
        assert min(np.abs(force - expected).max(), np.abs(force + expected).max()) < 1e-6, node
    assert np.abs(forces.effort(0)).max() < 1e-9  # no driving torque


def test_watt_has_its_greatest_speed_where_the_reference_has(watt):
    near = np.linspace(0.71, 0.75, 41)
    found = simulate(watt, np.concatenate(([0.0], near)), TIGHT, compiled)
    speed = np.polynomial.Chebyshev.fit(near, found.inputs[1, 0, 1:], 16)
    at = next(t.real for t in speed.deriv().roots() if abs(t.imag) < 1e-12 and 0.71 < t.real < 0.75)
    assert abs(speed(at) - FASTEST) < 1e-9
    angle = np.polynomial.Chebyshev.fit(near, found.inputs[0, 0, 1:], 16)
    assert abs(math.degrees(angle(at)) - 257.2871126) < 1e-6


def test_the_default_method_keeps_the_energy_over_ten_periods(watt):
    found = simulate(watt, np.linspace(0.0, 10.0 * PERIOD, 500), Settings(), compiled)
    assert found.worst_drift < 1e-9
    assert found.corrected < 1e-5  # J, sum of the corrections of the speeds
    stops = [e.time for e in found.events]
    assert np.abs(np.array(stops) - 0.5 * PERIOD * np.arange(1, len(stops) + 1)).max() < 2e-8


def test_the_errors_of_euler_agree_with_the_reference(watt):
    found = simulate(watt, np.linspace(0.0, 3.0, 31), Settings("euler", standstills=1), compiled)
    (stop,) = found.events
    assert stop.inputs[0] - math.radians(STANDSTILL) == pytest.approx(-0.0331, rel=0.1)
    assert stop.time - 0.5 * PERIOD == pytest.approx(-2.3e-3, rel=0.1)
    assert np.abs(found.drift).max() == pytest.approx(0.451, rel=0.1)
    assert abs(found.evaluations - 4965) < 10


def test_the_drift_of_euler_is_in_proportion_to_its_step_and_half_with_the_exact_slope(watt):
    """As the reference: 0.82 % at 1e-3 rad, halved by the exact dJ/dq; the table of the manual has these numbers."""
    text = (pathlib.Path(gimcli.__file__).parent / "manual" / "dynamics.md").read_text(encoding="utf-8")
    table = re.findall(r"^\| (0[\d.]+) \| ([\d.e-]+) \| ([\d.e-]+) \|$", text, re.MULTILINE)
    assert [row[0] for row in table] == ["0.01", "0.003", "0.001", "0.0001"]
    drift = {}
    for step, *printed in table:
        for method, number in zip(("euler", "euler-exact"), printed, strict=True):
            settings = Settings(method, step=float(step), standstills=1)
            found = simulate(watt, np.linspace(0.0, 3.0, 31), settings, compiled)
            drift[method, float(step)] = found.worst_drift
            assert found.worst_drift == pytest.approx(float(number), rel=0.02)  # two digits
    assert drift["euler", 1e-3] == pytest.approx(0.0082, abs=1e-4)
    for method in ("euler", "euler-exact"):
        assert drift[method, 1e-3] / drift[method, 1e-4] == pytest.approx(10.0, rel=0.03)
    assert drift["euler-exact", 1e-4] / drift["euler", 1e-4] == pytest.approx(0.5, rel=0.01)


@pytest.mark.parametrize(("unit", "size"), [("m", 1.0), ("mm", 1000.0)])
def test_the_step_of_a_travel_is_a_length_of_the_file(unit, size):
    """A block that falls in a guide, g t^2 / 2: the scheme is exact for a constant acceleration."""
    model = gimcli.load(
        {
            "units": {"length": unit},
            "nodes": {"A": [0, 0], "B": [0, 2 * size], "P": [0, size], "Q": [0, 1.2 * size]},
            "ground": ["A", "B"],
            "links": {"block": ["P", "Q"]},
            "prismatic": {"guide": {"nodes": ["P", "Q"], "guide": ["A", "B"]}},
            "actuators": {"height": {"node": "P", "guide": ["A", "B"], "free": True}},
            "masses": {"block": {"mass": 2.0, "inertia": 0.0, "centre": [0, 0]}},
            "gravity": [0, -9.81],
        }
    )
    found = gimcli.simulate(model, 0.4, dt=0.1, integrator="euler", step=0.01 * size)
    fallen = 0.5 * 9.81 * np.linspace(0.0, 0.4, 5) ** 2
    assert found["P.y"] == pytest.approx(size * (1.0 - fallen), rel=1e-9)
    assert found.report()["integrator_steps"] == math.ceil(fallen[-1] / 0.01)


@pytest.mark.parametrize("method", ["rk45", "radau", "lsoda", "rk4"])
def test_other_methods_agree(watt, method):
    found = simulate(watt, np.linspace(0.0, 2.0, 5), Settings(method, rtol=1e-8), compiled)
    (stop,) = found.events
    assert abs(2.0 * stop.time - PERIOD) < 1e-6


def test_plain_and_compiled_kernels_agree(watt):
    times = np.linspace(0.0, 0.3, 4)
    one, other = (simulate(watt, times, Settings(rtol=1e-6), run) for run in (plain, compiled))
    assert np.abs(one.nodes - other.nodes).max() < 1e-13 * np.abs(other.nodes).max()


# -- closed forms ---------------------------------------------------------------------------------------

PENDULUM = """
units: {{length: {length}, angle: {angle}}}
nodes: {{O: [0, 0], A: [{arm}, 0]}}
ground: [O]
links: {{rod: [O, A]}}
actuators: {{swing: {{type: rotary, pivot: O, arm: A, free: true, start: {start}, speed: {speed} {more}}}}}
masses: {{rod: {{mass: 2.0, inertia: 0, centre: [{arm}, 0]}}}}
gravity: [0, -9.81]
"""


def pendulum(folder, start="-30", length="m", arm="0.7", angle="deg", speed="0", more="", rest=""):
    text = PENDULUM.format(start=start, length=length, arm=arm, angle=angle, speed=speed, more=more)
    return written(folder, text + rest)


def test_a_pendulum_has_the_period_of_the_elliptic_integral(tmp_path):
    """T = 4 sqrt(l / g) K(sin^2(A / 2)): here A = 60 deg from the vertical."""
    period = 4.0 * math.sqrt(0.7 / 9.81) * ellipk(math.sin(math.radians(30.0)) ** 2)
    found = simulate(pendulum(tmp_path), np.linspace(0.0, 1.05 * period, 20), TIGHT)
    assert [e.kind for e in found.events] == ["standstill", "standstill"]
    assert abs(found.events[0].time - period / 2.0) < 1e-11
    assert abs(found.events[1].time - period) < 1e-11
    assert found.events[0].inputs[0] == pytest.approx(math.radians(-150.0), abs=1e-11)


def test_the_motion_does_not_depend_on_the_units_of_the_file(tmp_path):
    one = simulate(pendulum(tmp_path), np.linspace(0.0, 1.0, 5), TIGHT)
    other = simulate(pendulum(tmp_path, str(math.radians(-30.0)), "mm", "700", "rad"), np.linspace(0.0, 1.0, 5), TIGHT)
    assert np.abs(one.inputs - other.inputs).max() < 1e-11
    assert np.abs(one.energy - other.energy).max() < 1e-11


def test_a_damped_oscillator_agrees_with_its_closed_form(tmp_path):
    """A mass on a spring and a damper, pushed: x'' + 2 d x' + w^2 (x - 0.3) = F / m."""
    text = """
nodes: {O: [0, 0], G: [1, 0], P: [0.5, 0], Q: [0.6, 0]}
ground: [O, G]
links: {block: [P, Q]}
prismatic: {slide: {nodes: [P, Q], guide: [O, G]}}
actuators: {x: {type: linear, node: P, guide: [O, G], free: true, start: 0.5, effort: 3.0}}
masses: {block: {mass: 2.0}}
springs: {spring: {nodes: [O, P], stiffness: 50, free: 0.3}}
dampers: {damper: {nodes: [O, P], damping: 1.5}}
friction: {slide: 0.5}
"""
    times = np.linspace(0.0, 3.0, 31)
    found = simulate(written(tmp_path, text), times, TIGHT)
    metre = found.mechanism.dynamics.metre
    rest, d = 0.3 + 3.0 / 50.0, 2.0 / (2.0 * 2.0)
    w = math.sqrt(25.0 - d * d)
    x = rest + (0.5 - rest) * np.exp(-d * times) * (np.cos(w * times) + d / w * np.sin(w * times))
    assert np.abs(found.inputs[0, 0] * metre - x).max() < 1e-11
    assert found.worst_drift < 1e-11
    v = found.inputs[1, 0] * metre
    power = trapezoid(2.0 * np.interp(np.linspace(0, 3, 30001), times, v) ** 2, dx=1e-4)
    assert found.energy[2, -1] == pytest.approx(power, rel=0.05)
    assert np.abs(found.energy[3] - 3.0 * (x - 0.5)).max() < 1e-11


ROD = """
nodes: {O: [0, 0], P: [1, 0], A: [0.5, 0.8660254037844386]}
ground: [O, P]
links: {rod: [O, A]}
masses: {rod: {mass: 3, inertia: 0.25}}
actuators: {q: {type: rotary, pivot: O, arm: A, free: true}}
springs: {s: {nodes: [P, A], stiffness: 40, free: 0.25}}
"""


def test_a_spring_passes_its_zero_length(tmp_path):
    """A rod of J = 1 swings from 60 deg to -60 deg and back, over the anchor: V = 20 (2 |sin q/2| - 1/4)^2."""
    from scipy.integrate import quad

    def potential(angle):
        return 20.0 * (2.0 * abs(math.sin(angle / 2.0)) - 0.25) ** 2

    def slowness(u):  # q = 60 deg cos u removes the singularity at the ends
        energy = potential(math.pi / 3.0) - potential(math.pi / 3.0 * math.cos(u))
        return math.pi / 3.0 * math.sin(u) / math.sqrt(2.0 * energy)

    quarter = quad(slowness, 0.0, math.pi / 2.0, epsabs=1e-12, epsrel=1e-12)[0]
    times = np.linspace(0.0, 4.0 * quarter, 9)
    found = simulate(written(tmp_path, ROD), times, Settings(rtol=1e-10), compiled)
    assert found.status is Status.OK
    turns = [e.time for e in found.events if e.kind == "standstill"]
    assert turns[:1] == pytest.approx([2.0 * quarter], abs=1e-6)
    angles = np.angle(found.nodes[0, 2])
    assert angles[[0, 4, 8]] == pytest.approx([math.pi / 3, -math.pi / 3, math.pi / 3], abs=1e-6)
    assert found.energy[1] == pytest.approx([potential(a) for a in angles], abs=1e-9)


def test_a_linear_torque_characteristic_accelerates_to_its_idle_speed(tmp_path):
    """J w' = stall (1 - w / idle): an exponential."""
    line = ", effort: {stall: 4.0, idle: 720}"
    text = PENDULUM.format(start="0", length="m", arm="0.7", angle="deg", speed="0", more=line).replace(
        "gravity: [0, -9.81]", ""
    )
    times = np.linspace(0.0, 4.0, 9)
    found = simulate(written(tmp_path, text), times, TIGHT)
    idle, inertia = 4.0 * math.pi, 2.0 * 0.7**2
    assert np.abs(found.inputs[1, 0] - idle * (1.0 - np.exp(-4.0 / (inertia * idle) * times))).max() < 1e-10


def test_tables_of_torque_and_load(tmp_path):
    """A torque that rises with the time turns a wheel by t^3; a table of load over the input does work."""
    (tmp_path / "t.csv").write_text("time,value\n0,0\n1,1\n2,2\n3,3\n")
    text = PENDULUM.format(
        start="0", length="m", arm="0.7", angle="rad", speed="0", more=", effort: {table: t.csv}"
    ).replace("gravity: [0, -9.81]", "")
    times = np.linspace(0.0, 2.0, 5)
    found = simulate(written(tmp_path, text), times, TIGHT)
    assert np.abs(found.inputs[0, 0] - times**3 / 6.0 / (2.0 * 0.7**2)).max() < 1e-9
    load_text = PENDULUM.format(start="0", length="m", arm="0.7", angle="rad", speed="0", more="").replace(
        "gravity: [0, -9.81]", "loads: {twist: {on: rod, torque: 1.0, table: t.csv}}"
    )
    other = simulate(written(tmp_path, load_text), times, TIGHT)
    assert np.abs(other.inputs[0] - found.inputs[0]).max() < 1e-11
    assert other.worst_drift < 1e-9


DOUBLE = """
nodes: {O: [0, 0], A: [1, 0], B: [2, 0]}
ground: [O]
links: {first: [O, A], second: [A, B]}
actuators:
  one: {type: rotary, pivot: O, arm: A, free: true, start: 10}
  two: {type: rotary, pivot: A, arm: B, reference: O, free: true, start: 150, speed: 30}
masses: {first: {mass: 1, inertia: 0, centre: [1, 0]}, second: {mass: 1, inertia: 0, centre: [1, 0]}}
gravity: [0, -9.81]
"""


def test_a_double_pendulum_agrees_with_lagranges_equations(tmp_path):
    """Two free inputs, the second a floating one; Landau & Lifshitz, Mechanics, section 5, problem 1, equal masses."""

    def slopes(_, y):
        a, b, p, q = y
        m = np.array([[2.0, math.cos(a - b)], [math.cos(a - b), 1.0]])
        s = math.sin(a - b)
        right = np.array([-s * q * q - 2.0 * 9.81 * math.cos(a), s * p * p - 9.81 * math.cos(b)])
        return np.concatenate(([p, q], np.linalg.solve(m, right)))

    times = np.linspace(0.0, 2.0, 11)
    y = np.radians([10.0, -20.0, 0.0, 30.0])
    expected = solve_ivp(slopes, (0.0, 2.0), y, "DOP853", times, rtol=1e-13, atol=1e-13).y
    found = simulate(written(tmp_path, DOUBLE), times, TIGHT)
    assert np.abs(found.inputs[0] - [expected[0], expected[1] - expected[0] + math.pi]).max() < 1e-9
    assert np.abs(found.inputs[1] - [expected[2], expected[3] - expected[2]]).max() < 1e-9


# -- dead points, limits, singular positions --------------------------------------------------------------

SLIDER_CRANK = """
nodes: {O: [0, 0], A: [0, 1], B: [2.8284271247461903, 0], G: [5, 0]}
ground: [O, G]
links: {crank: [O, A], rod: {nodes: [A, B], length: 3}}
prismatic: {slide: {node: B, guide: [O, G]}}
actuators:
  INPUT
masses: {crank: {mass: 2, inertia: 0.5}, rod: {mass: 1, inertia: 0.75}}
gravity: [0, -9.81]
"""
BY_SLIDER = "x: {type: linear, node: B, guide: [O, G], free: true, start: 2.8284271247461903, speed: -6}"
BY_CRANK = "q: {type: rotary, pivot: O, arm: A, free: true, start: 90, speed: 343.77467707849395}"


def test_dead_points_are_passed(tmp_path):
    """The slider as input, through both its dead centres, against the crank as input, which has none."""
    times = np.linspace(0.0, 3.0, 61)
    by_slider = simulate(written(tmp_path, SLIDER_CRANK.replace("INPUT", BY_SLIDER)), times, TIGHT, compiled)
    by_crank = simulate(written(tmp_path, SLIDER_CRANK.replace("INPUT", BY_CRANK)), times, TIGHT, compiled)
    assert by_slider.status is Status.OK
    assert len(by_slider.time) == len(times)
    dead = [e for e in by_slider.events if e.kind == "dead point"]
    turns = (by_crank.inputs[0, 0, -1] - math.pi / 2.0) / math.pi
    assert len(dead) == math.floor(abs(turns) + 0.5) >= 4
    metre = by_slider.mechanism.dynamics.metre
    for event in dead:
        assert min(abs(event.inputs[0] * metre - 4.0), abs(event.inputs[0] * metre - 2.0)) < 1e-9
        assert abs(event.speeds[0]) < 1e-6
    assert np.abs(by_slider.nodes[0] - by_crank.nodes[0]).max() < 1e-8
    assert np.abs(by_slider.nodes[1] - by_crank.nodes[1]).max() < 1e-7
    assert by_slider.worst_drift < 1e-9


def test_a_motion_can_start_at_a_dead_point(tmp_path):
    """A crank in line with its rod falls; the slider is the input, which does not determine the motion there."""
    text = SLIDER_CRANK.replace("A: [0, 1]", "A: [1, 0]").replace("B: [2.8284271247461903, 0]", "B: [4, 0]")
    start = "x: {type: linear, node: B, guide: [O, G], free: true, start: 4}"
    times = np.linspace(0.0, 1.0, 11)
    found = simulate(written(tmp_path, text.replace("INPUT", start)), times, TIGHT)
    other = simulate(
        written(tmp_path, text.replace("INPUT", "q: {type: rotary, pivot: O, arm: A, free: true, start: 0}")),
        times, TIGHT,
    )  # fmt: skip
    assert found.status is Status.OK
    assert np.abs(found.nodes[0] - other.nodes[0]).max() < 1e-8


@pytest.mark.parametrize("start", [60, 5])
def test_a_parallelogram_goes_straight_through_its_flat_positions(start, tmp_path):
    """Both cranks stay parallel: q'' = -g m cos q / J with J = 5/3 for unit bars of unit mass.

    From 5 deg it passes them slowly, with some steps close to them.
    """
    x, y = math.cos(math.radians(start)), math.sin(math.radians(start))
    text = f"""
nodes: {{O: [0, 0], P: [2, 0], A: [{x!r}, {y!r}], B: [{2 + x!r}, {y!r}]}}
ground: [O, P]
links: {{crank: [O, A], coupler: [A, B], rocker: [P, B]}}
actuators: {{q: {{type: rotary, pivot: O, arm: A, free: true, start: {start}, speed: 0}}}}
masses: {{crank: {{mass: 1, inertia: 0.08333333333333333}}, rocker: {{mass: 1, inertia: 0.08333333333333333}},
  coupler: {{mass: 2, inertia: 0.6666666666666666}}}}
gravity: [0, -9.81]
"""
    times = np.linspace(0.0, 3.0, 31)
    found = simulate(written(tmp_path, text), times, Settings(rtol=1e-10), compiled)
    inertia, moment = 2.0 / 3.0 + 2.0, 9.81 * (0.5 + 0.5 + 2.0)
    expected = solve_ivp(
        lambda _, y: [y[1], -moment * math.cos(y[0]) / inertia], (0.0, 3.0), [math.radians(start), 0.0], "DOP853",
        times, rtol=1e-13, atol=1e-13,
    ).y  # fmt: skip
    assert found.status is Status.OK
    assert len(found.time) == len(times)
    assert expected[0].min() < -3.0  # it passes 0 and comes near -180 deg
    assert np.abs(found.inputs[0, 0] - expected[0]).max() < 1e-7


def test_the_limit_of_a_law_ends_the_motion(tmp_path):
    """A five-bar whose driven input goes out of reach: the rows up to the limit are kept."""
    text = """
duration: 1
nodes: {O: [0, 0], A: [1, 0], B: [1.5, 1], C: [3, 1], P: [3, 0]}
ground: [O, P]
links: {one: [O, A], two: [A, B], three: [B, C], four: [P, C]}
actuators:
  drive: {type: linear, nodes: [O, B], law: {from: 1.8027756377319946, to: 2.4}}
  loose: {type: rotary, pivot: P, arm: C, free: true, start: 90}
masses: {four: {mass: 50, inertia: 10}}
"""
    times = np.linspace(0.0, 1.0, 11)
    found = simulate(written(tmp_path, text), times)
    assert found.status is Status.LIMIT
    assert found.events[-1].kind == "limit"
    assert 0.0 < found.end < 1.0
    assert len(found.time) == np.sum(times <= found.end)
    reach = 1.0 + math.hypot(0.5, 1.0)  # O, A, B in line
    assert found.events[-1].inputs[0] * found.mechanism.dynamics.metre == pytest.approx(reach, abs=1e-4)


# -- laws ---------------------------------------------------------------------------------------------------

FREE = ("crank_rocker", "slider_crank", "whitworth", "crank_shaper", "stephenson_3_far", "watt_2", "klann", "jansen",
        "peaucellier", "double_butterfly", "scotch_yoke", "five_bar", "elliptic_trammel",
        "gim_fig11", "excavator", "platform_3rrr", "platform_3rpr")  # fmt: skip


def span_of(mechanism):
    """Return the time of a free fall over a fifth of the size [s]."""
    return math.sqrt(0.4 * mechanism.size * mechanism.scale / 9.81)


@pytest.mark.few
@pytest.mark.parametrize("stem", FREE)
def test_a_free_motion_needs_no_effort_and_keeps_its_energy(stem):
    """Inverse dynamics of the simulated motion: independent positions, efforts 0, powers in balance."""
    mechanism = released(stem)
    times = np.linspace(0.0, span_of(mechanism), 12)
    found = simulate(mechanism, times, Settings(rtol=1e-10), compiled)
    assert len(found.time) > 3
    forces = inverse_dynamics(statics(mechanism), found.course(), every=True)
    good = forces.good
    assert good.sum() > 3
    weight = 9.81 * len(mechanism.members)
    for k in range(len(mechanism.actuators)):
        if forces.statics.surplus == 0:
            assert np.abs(forces.effort(k)[good]).max() < 1e-6 * weight * max(1.0, mechanism.size * mechanism.scale)
    assert np.abs(forces.loads.kinetic - found.energy[0])[good].max() <= 1e-9 * np.abs(found.energy[:2]).max()
    assert np.abs(forces.loads.potential - found.energy[1])[good].max() <= 1e-9 * np.abs(found.energy[:2]).max()
    assert found.worst_drift < 1e-7


@pytest.mark.parametrize("stem", ["crank_rocker", "whitworth", "watt_2", "klann", "five_bar"])
def test_the_motion_is_reversible(stem):
    mechanism = released(stem)
    end = 0.5 * span_of(mechanism)
    there = simulate(mechanism, np.array([0.0, end]), TIGHT, compiled)

    def reverse(data):
        for k, (name, actuator) in enumerate(data["actuators"].items()):
            value, speed = (mechanism.value_to_file(k, there.inputs[order, k, -1:])[0] for order in (0, 1))
            actuator["start"], actuator["speed"] = float(value), -float(speed)
            assert name == mechanism.actuators[k].name

    back = simulate(released(stem, reverse), np.array([0.0, end]), TIGHT, compiled)
    assert np.abs(back.inputs[0, :, -1] - there.inputs[0, :, 0]).max() < 1e-8
    assert np.abs(back.inputs[1, :, -1]).max() < 1e-7


def test_masses_and_gravity_scale(watt):
    """Masses times k do not change the motion; gravity times k makes it sqrt(k) times as fast."""

    def heavier(data):
        for mass in data["masses"].values():
            mass["mass"] *= 7.0
            mass["inertia"] *= 7.0

    def stronger(data):
        data["gravity"] = [0.0, -4.0 * 9.81]

    times = np.linspace(0.0, 1.0, 6)
    plain_run = simulate(watt, times, TIGHT, compiled)
    heavy = simulate(changed(MODELS / "watt_durango.yaml", None, heavier), times, TIGHT, compiled)
    fast = simulate(changed(MODELS / "watt_durango.yaml", None, stronger), 0.5 * times, TIGHT, compiled)
    assert np.abs(heavy.inputs - plain_run.inputs).max() < 1e-9
    assert np.abs(heavy.energy - 7.0 * plain_run.energy).max() < 1e-9
    assert np.abs(fast.inputs[0] - plain_run.inputs[0]).max() < 1e-9
    assert np.abs(fast.inputs[1] - 2.0 * plain_run.inputs[1]).max() < 1e-8


def test_the_effort_of_a_driven_input_beside_a_free_one(tmp_path):
    """The shoulder of a double pendulum follows a law, the elbow swings: energy and inverse dynamics agree."""
    text = DOUBLE.replace(
        "one: {type: rotary, pivot: O, arm: A, free: true, start: 10}",
        "one: {type: rotary, pivot: O, arm: A, law: {from: 10, to: 200, profile: cycloidal}}",
    )
    mechanism = written(tmp_path, text)
    found = simulate(mechanism, np.linspace(0.0, 1.0, 21), TIGHT)
    forces = reactions(found)
    assert np.abs(forces.effort(1)).max() < 1e-9
    assert np.abs(forces.effort(0) - found.efforts[0]).max() < 1e-9
    assert found.worst_drift < 1e-9
    assert np.abs(found.energy[3]).max() > 1.0


# -- errors and the command ------------------------------------------------------------------------------------


def test_the_command_writes_report_table_and_picture(tmp_path):
    from typer.testing import CliRunner

    from gimcli.cli import app

    model = str(MODELS / "watt_durango.yaml")
    done = CliRunner().invoke(
        app, ["simulate", model, "--time", "2", "--dt", "0.1", "-o", str(tmp_path), "--json", "--reactions"]
    )
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert report["status"] == "ok"
    assert report["energy_drift"] < 1e-9
    least, greatest = report["reachable"]["crank_angle"][0]  # over the rows, none of which is exactly at the standstill
    assert least == pytest.approx(120.0)
    assert STANDSTILL - 1.0 < greatest < STANDSTILL
    assert report["open"] == []
    assert report["events"][0]["kind"] == "standstill"
    assert report["events"][0]["at"]["crank_angle"] == pytest.approx(STANDSTILL, abs=1e-7)
    with (tmp_path / "watt_durango.simulation.csv").open() as handle:
        rows = list(csv.DictReader(handle))
    assert len(rows) == 21
    assert float(rows[5]["energy.kinetic"]) == pytest.approx(reference("watt_six_bar_W1.csv")["T"][5], abs=1e-6)
    assert abs(float(rows[5]["O2.fx"]) - reference("watt_six_bar_W1.csv")["FO2x"][5]) < 1e-4
    assert (tmp_path / "watt_durango.simulation.png").stat().st_size > 10_000


@pytest.mark.parametrize("wrong", [["--time", "0"], ["--dt", "-1"], ["--rtol", "2"], ["--step", "0"]])
def test_values_out_of_range_are_rejected(wrong, tmp_path):
    from typer.testing import CliRunner

    from gimcli.cli import app

    done = CliRunner().invoke(app, ["simulate", str(MODELS / "watt_durango.yaml"), "-o", str(tmp_path), *wrong])
    assert isinstance(done.exception, UsageError)


@pytest.mark.parametrize("method", ["dop853", "rk4", "euler"])
def test_a_pendulum_at_rest_in_equilibrium_stays_at_rest(method, tmp_path):
    """Every row is solved: the rod hangs straight down and no torque acts."""
    text = (
        "units: {length: m}\nnodes: {O: [0, 0], A: [0, -1]}\nground: [O]\nlinks: {rod: [O, A]}\n"
        "actuators: {swing: {type: rotary, pivot: O, arm: A, free: true, start: -90, speed: 0}}\n"
        "masses: {rod: {mass: 1, inertia: 0.1, centre: [0.5, 0]}}\ngravity: [0, -9.81]\n"
    )
    found = simulate(written(tmp_path, text), np.linspace(0.0, 2.0, 11), Settings(method), compiled)
    assert found.status is Status.OK
    assert len(found.time) == 11
    assert found.end == 2.0
    np.testing.assert_allclose(found.inputs[0], -np.pi / 2.0, rtol=0.0, atol=1e-12)
