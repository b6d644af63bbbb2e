"""Dynamics of coupled inputs and gears: closed forms, and body coordinates with all multipliers."""

import numpy as np
import pytest
from geared_models import bodies, five_bar, state, train
from scipy.integrate import solve_ivp

import gimcli
from gimcli import GimError
from gimcli.dynamics.small_motions import linearised
from gimcli.motion.linked_inputs import followed

FREE = {"pivot": "O", "arm": "A", "free": True}


def pendulums(ratio, geared, start=-90.0):
    """Return two hanging bars of 1 m, 1 kg and 0.6 m, 0.5 kg, whose angles change in the given ratio."""
    data = {
        "units": {"length": "m", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [0, -1], "Q": [3, 0], "B": [3, -0.6]},
        "ground": ["O", "Q"], "links": {"one": ["O", "A"], "two": ["Q", "B"]},
        "actuators": {"motor": {**FREE, "start": start}},
        "masses": {"one": {"mass": 1, "inertia": 1 / 12}, "two": {"mass": 0.5, "inertia": 0.015}},
        "gravity": [0, -9.81], "trace": ["B"],
    }  # fmt: skip
    if geared:
        data["gears"] = {"mesh": {"members": ["one", "two"], "pivots": ["O", "Q"], "ratio": -ratio}}
    else:
        follower = {"pivot": "Q", "arm": "B", "follows": "motor", "ratio": ratio, "phase": 90.0 * ratio - 90.0}
        data["actuators"]["second"] = follower
    return data


@pytest.mark.parametrize("geared", [False, True])
@pytest.mark.parametrize(("ratio", "omega"), [(-1.0, 4.026343338311588), (-2.0, 4.338376612041303)])
def test_frequency_of_geared_pendulums(ratio, omega, geared):
    m = gimcli.load(pendulums(ratio, geared))
    found = linearised(m, m.drawn, m.drawn_inputs, m.drivers)
    assert np.isclose(found.stiffness[0, 0] / found.mass[0, 0], omega**2, rtol=1e-13)
    assert np.allclose(found.input_rates, [[1.0, ratio]])


@pytest.mark.parametrize("geared", [False, True])
def test_reduced_inertia_and_motion_of_geared_pendulums(geared):
    ratio, start = -2.0, np.radians(-60.0)
    m = gimcli.load(pendulums(ratio, geared, -60.0))
    inertia = 1 / 3 + ratio**2 * 0.06
    assert np.allclose(gimcli.reduce(m, steps=3)["J"], inertia, rtol=1e-13)
    found = gimcli.simulate(m, 2.0, dt=0.05)

    def slope(_, y):
        torque = -9.81 * (0.5 * np.cos(y[0]) + ratio * 0.15 * np.cos(ratio * y[0] + np.pi * ratio / 2 - np.pi / 2))
        return [y[1], torque / inertia]

    exact = solve_ivp(slope, (0.0, 2.0), [start, 0.0], "DOP853", found["time"], rtol=1e-12, atol=1e-12)
    assert np.allclose(np.radians(found["motor"]), exact.y[0], atol=1e-8)
    assert np.max(abs(found["energy.drift"])) < 1e-8


@pytest.mark.parametrize("kind", ["external", "internal", "belt", "crossed"])
def test_acceleration_of_a_gear_train(kind):
    data = train(type=kind, ratio=0.5)
    data["actuators"]["motor"] = {**FREE, "effort": {"constant": 4.0}}
    data["masses"] = {"one": {"mass": 1, "inertia": 0.02, "centre": [0, 0]}}
    data["masses"]["two"] = {"mass": 1, "inertia": 0.1, "centre": [0, 0]}
    ratio = 0.5 if kind in ("internal", "belt") else -0.5
    found = gimcli.simulate(gimcli.load(data), 1.0, dt=0.5, reactions=True)
    gain = (4.0 + ratio * 3.0) / (0.02 + ratio**2 * 0.1)
    assert np.allclose(np.radians(found["motor.acceleration"]), gain)
    assert np.allclose(np.radians(found["mesh.speed"]), ratio * gain * found["time"])
    torque = 0.1 * ratio * gain - 3.0
    if kind in ("external", "internal"):
        radius = 0.06 if kind == "external" else 0.18
        assert np.allclose(found["mesh.tangential"], torque / radius)
    else:
        assert np.allclose(found["mesh.torque"], torque)


def test_a_weight_on_a_belt_hoist_falls():
    data = {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [20, 0], "Q": [300, 0], "B": [300, 30], "G": [350, -300], "H": [350, 0],
                  "U": [350, -200], "V": [350, -170]},
        "ground": ["O", "Q", "G", "H"], "links": {"motor wheel": ["O", "A"], "drum": ["Q", "B"], "load": ["U", "V"]},
        "prismatic": {"rope": {"nodes": ["U", "V"], "guide": ["G", "H"]}},
        "actuators": {"motor": FREE},
        "gears": {
            "belt": {"type": "belt", "members": ["motor wheel", "drum"], "pivots": ["O", "Q"], "radii": [30, 90]},
            "rope": {"type": "rack", "members": ["drum", "load"], "pivots": ["Q"], "radii": [50]},
        },
        "masses": {
            "motor wheel": {"mass": 1, "inertia": 0.002, "centre": [0, 0]},
            "drum": {"mass": 1, "inertia": 0.03, "centre": [0, 0]}, "load": {"mass": 8, "centre": [0, 0]},
        },
        "gravity": [0, -9.81], "trace": ["U"],
    }  # fmt: skip
    data["gears"]["hoist"] = data["gears"].pop("rope")
    m = gimcli.load(data)
    found = gimcli.simulate(m, 0.5, dt=0.1, reactions=True)
    third = 1.0 / 3.0
    inertia = 0.002 + third**2 * 0.03 + (third * 0.05) ** 2 * 8.0
    gain = -third * 0.05 * 8.0 * 9.81 / inertia
    assert np.allclose(np.radians(found["motor.acceleration"]), gain)
    assert np.allclose(found["hoist.tangential"], 8.0 * (9.81 + third * 0.05 * gain))
    assert np.allclose(found["belt.tension"], -0.002 * gain / 0.03)
    assert np.max(abs(found["energy.drift"])) < 1e-10 * np.max(found["energy.kinetic"])


def test_a_fast_follower_stays_a_dependent_variable():
    data = pendulums(30.0, geared=False, start=-80.0)
    found = gimcli.simulate(gimcli.load(data), 1.0, dt=0.1)
    assert not [e for e in found.events if e["kind"] == "dead point"]
    assert np.max(abs(found["energy.drift"])) < 1e-7


@pytest.mark.parametrize(("ratio", "internal"), [(1.0, False), (0.5, False), (2.0, True)])
def test_a_released_geared_five_bar_against_body_coordinates(ratio, internal):
    data = five_bar(type="internal" if internal else "external", ratio=ratio)
    data["actuators"]["motor"] = {**FREE, "start": 0, "speed": 90}
    m = gimcli.load(data)
    found, other = gimcli.simulate(m, 0.5, dt=0.1, reactions=True), bodies(ratio, internal)
    t = gimcli.trace(gimcli.load(five_bar(type=data["gears"]["mesh"]["type"], ratio=ratio)), steps=12)
    q, v, _ = state(other, t, 0, np.pi / 2.0)
    own = len(q)
    path = solve_ivp(
        lambda _, y: [*y[own:], *other.accelerations(y[:own], y[own:])], (0.0, 0.5), [*q, *v], "DOP853", found["time"],
        rtol=1e-11, atol=1e-12,
    ).y  # fmt: skip
    assert np.allclose(np.radians(found["motor"]), path[2], atol=1e-7)
    assert np.allclose(np.radians(found["motor.speed"]), path[own + 2], atol=1e-6)
    for k in range(len(found["time"])):
        y = path[:, k]
        pins, (tooth,), torque = other.forces(y[:own], y[own:], other.accelerations(y[:own], y[own:]), 1)
        assert abs(torque) < 1e-8
        assert abs(found["motor.effort"][k]) < 1e-5
        assert np.isclose(found["mesh.tangential"][k], tooth * np.cos(np.radians(20.0)), rtol=1e-5, atol=1e-5)
        assert np.isclose(found["O.fx"][k] + 1j * found["O.fy"][k], pins[0], rtol=1e-5, atol=1e-5)


def test_a_follower_moves_through_the_dead_points_of_its_driver():
    """A slider-crank whose input is the slider, and a wheel whose angle follows the slider."""
    data = {
        "units": {"length": "m", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [0.06, 0.08], "S": [0.35, 0], "E": [1, 0], "Q": [0, 0.3], "B": [0.1, 0.3]},
        "ground": ["O", "E", "Q"], "links": {"crank": ["O", "A"], "rod": ["A", "S"], "wheel": ["Q", "B"]},
        "prismatic": {"guide": {"node": "S", "guide": ["O", "E"]}},
        "actuators": {
            "slide": {"node": "S", "guide": ["O", "E"], "free": True, "start": 0.35, "speed": -0.5},
            "turn": {"pivot": "Q", "arm": "B", "follows": "slide", "ratio": 500},
        },
        "masses": {
            "crank": {"mass": 1, "inertia": 0.01}, "rod": {"mass": 0.5, "inertia": 0.004},
            "wheel": {"mass": 1, "inertia": 0.0002, "centre": [0, 0]},
        },
        "gravity": [0, -9.81], "trace": ["S"],
    }  # fmt: skip
    found = gimcli.simulate(gimcli.load(data), 3.0, dt=0.1)
    assert set(found["status"]) == {"ok"}
    assert sum(e["kind"] == "dead point" for e in found.events) > 2
    assert np.allclose(found["turn"] - found["turn"][0], 500.0 * (found["slide"] - 0.35), atol=1e-8)
    assert np.max(abs(found["energy.drift"])) < 1e-7


# --- gears that the linkage turns ---------------------------------------------------------------------


def pinion_on_a_slider_crank():
    """Return a slider-crank whose slider is a rack with a pinion of 20 mm; only crank and pinion have inertia."""
    return {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [30, 0], "B": [130, 0], "C": [160, 0], "G": [-200, 0], "H": [300, 0],
                  "Q": [150, 20], "T": [150, 40]},
        "ground": ["O", "G", "H", "Q"],
        "links": {"crank": ["O", "A"], "rod": ["A", "B"], "bar": ["B", "C"], "pinion": ["Q", "T"]},
        "prismatic": {"slide": {"nodes": ["B", "C"], "guide": ["G", "H"]}},
        "actuators": {
            "motor": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 360}, "free": True, "start": 20, "speed": 200}
        },
        "gears": {"mesh": {"type": "rack", "members": ["pinion", "bar"], "pivots": ["Q"], "radii": [20]}},
        "masses": {
            "crank": {"mass": 1, "inertia": 0.002, "centre": [0, 0]},
            "pinion": {"mass": 1, "inertia": 0.001, "centre": [0, -15]},
        },
        "gravity": [0, -9.81], "trace": ["T"],
    }  # fmt: skip


def rack_rate(turn):
    """Return the derivative of the slider's place by the angle of the crank, in radii of the pinion."""
    return (-30.0 * np.sin(turn) - 900.0 * np.sin(turn) * np.cos(turn) / np.sqrt(1e4 - (30 * np.sin(turn)) ** 2)) / 20.0


def test_inertia_of_a_pinion_on_the_rack_of_a_slider_crank():
    found = gimcli.reduce(gimcli.load(pinion_on_a_slider_crank()), steps=24)
    turn = np.radians(found["q"])
    about = 0.001 + 0.015**2  # of the pinion about its pivot
    assert set(found["status"]) == {"ok"}
    assert np.allclose(found["J"], 0.002 + about * rack_rate(turn) ** 2, rtol=1e-10)
    place = 30.0 * np.cos(turn) + np.sqrt(1e4 - (30.0 * np.sin(turn)) ** 2) - 130.0
    height = 15e-3 * np.sin(place / 20.0)  # of the centre of mass, which is drawn to the right of Q -> T
    assert np.allclose(found["V"] - found["V"][0], 9.81 * (height - height[0]), atol=1e-12)


def test_motion_of_a_pinion_on_the_rack_of_a_slider_crank():
    found = gimcli.simulate(gimcli.load(pinion_on_a_slider_crank()), 1.5, dt=0.05, reactions=True)
    turn, speed = np.radians(found["motor"]), np.radians(found["motor.speed"])
    inertia = 0.002 + (0.001 + 0.015**2) * rack_rate(turn) ** 2
    assert np.allclose(found["energy.kinetic"], 0.5 * inertia * speed**2, rtol=1e-8)
    assert np.max(abs(found["energy.drift"])) < 1e-9
    assert np.max(abs(found["motor.effort"])) < 1e-10  # inverse dynamics of the motion: the motor is free
    assert np.allclose(np.radians(found["mesh.speed"]), rack_rate(turn) * speed, atol=1e-8)


def test_stiffness_with_a_pinion_on_the_rack_of_a_slider_crank():
    m = gimcli.load(pinion_on_a_slider_crank())
    inputs, at = followed(m, np.radians([60.0, 0.0])), gimcli.solve(m, motor=60)
    z = (np.array([at.xy[name] @ [1, 1j] for name in m.nodes]) - m.origin) / m.scale
    near, found = linearised(m, z, inputs, (0,)), gimcli.reduce(m, steps=6)
    assert np.isclose(near.mass[0, 0], found["J"][1], rtol=1e-10)
    assert np.isclose(near.effort[0], found["tau"][1], rtol=1e-9)
    assert np.isclose(near.stiffness[0, 0], -found["dtau_dq"][1], rtol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 20.0])
def test_dry_friction_at_the_pivot_of_a_gear(angle):
    """The tooth force enters the friction of the pivot; its part across the pivots is refused."""
    data = {
        "nodes": {"O": [0, 0], "A": [0.1, 0], "Q": [0.3, 0], "B": [0.4, 0]}, "ground": ["O", "Q"],
        "links": {"one": ["O", "A"], "two": ["Q", "B"]},
        "actuators": {"motor": {"pivot": "O", "arm": "A", "free": True, "speed": 1000}},
        "gears": {"mesh": {"members": ["one", "two"], "pivots": ["O", "Q"], "ratio": 0.5, "pressure_angle": angle}},
        "masses": {"one": {"mass": 1, "inertia": 0.01, "centre": [0, 0]},
                   "two": {"mass": 2, "inertia": 0.02, "centre": [0, 0]}},
        "friction": {"Q": {"mu": 0.1, "radius": 0.02}}, "gravity": [0, -9.81],
    }  # fmt: skip
    if angle:
        with pytest.raises(GimError):
            gimcli.simulate(gimcli.load(data), duration=0.1)
        return
    found = gimcli.simulate(gimcli.load(data), duration=0.1)
    half = 0.5 * 0.1 * 0.02 / np.sqrt(1.01)  # friction radius, per turn of the first wheel
    slowing = half * 2.0 * 9.81 / (0.01 + 0.25 * 0.02 + half * 0.01 / 0.1)  # the tooth force lifts the second wheel
    assert np.allclose(np.radians(found["motor.acceleration"]), -slowing, rtol=1e-6)
