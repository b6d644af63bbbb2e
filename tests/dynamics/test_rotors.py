"""The rotor of a motor behind an actuator: closed forms of two inertias, a screw, and balances of power and energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bundled import MODELS

import gimcli
from gimcli import ModelError

TURN = 2.0 * math.pi
DISC, ROTOR, RATIO = 0.3, 2e-4, -40.0  # kg m^2, kg m^2


def disc(law="law: {from: 0, to: 360, profile: quintic}", rotor=f"{{inertia: {ROTOR}, ratio: {RATIO}}}", more=""):
    """Return a disc on a shaft, driven by a motor with a gear."""
    return gimcli.loads(f"""
units: {{length: mm}}
nodes: {{O: [0, 0], A: [100, 0]}}
ground: [O]
links: {{disc: [O, A]}}
actuators: {{motor: {{pivot: O, arm: A, {law}, rotor: {rotor}}}}}
duration: 0.5
masses: {{disc: {{mass: 1, inertia: {DISC}, centre: [0, 0]}}}}
{more}""")


def gain(steps):
    """Return the acceleration of the quintic law [rad/s^2]: 60 t - 180 t^2 + 120 t^3 by the turn and T^2."""
    t = np.linspace(0.0, 1.0, steps + 1)
    return TURN * (60 * t - 180 * t**2 + 120 * t**3) / 0.25


def test_the_rotor_adds_its_inertia_times_the_square_of_the_ratio():
    found = gimcli.forces(disc(), 24)
    assert found["motor.effort"] == pytest.approx((DISC + ROTOR * RATIO**2) * gain(24), abs=1e-10)
    assert found["O.fx"] == pytest.approx(0.0, abs=1e-12)
    assert np.max(np.abs(found["power.error"])) < 1e-10


def test_the_rotor_alone_is_enough_for_forces_and_belongs_to_the_kinetic_energy():
    text = "units: {length: m}\nnodes: {O: [0, 0], A: [1, 0]}\nground: [O]\nlinks: {arm: [O, A]}\nactuators: {motor: "
    model = gimcli.loads(text + "{pivot: O, arm: A, law: {from: 0, to: 90}, rotor: {inertia: 0.5, ratio: 3}}}\n")
    found = gimcli.forces(model, 4)
    assert found["energy.kinetic"] == pytest.approx(0.5 * 0.5 * 9 * (TURN / 4) ** 2)
    assert gimcli.reduce(model, steps=4)["J"] == pytest.approx(4.5)


def test_the_reduced_inertia_and_a_simulated_start():
    """A constant torque on two inertias: the angle is T t^2 / (2 J)."""
    free = "free: true, law: {from: 0, to: 360}, start: 0, effort: 5"
    model = disc(free)
    whole = DISC + ROTOR * RATIO**2
    assert gimcli.reduce(model, steps=6)["J"] == pytest.approx(whole, rel=1e-13)
    found = gimcli.simulate(model, duration=0.4, dt=0.1, reactions=True)
    t = found["time"]
    assert np.radians(found["motor"]) == pytest.approx(5.0 * t**2 / (2 * whole), rel=1e-9, abs=1e-12)
    assert found["energy.kinetic"] == pytest.approx(0.5 * (5.0 * t) ** 2 / whole, rel=1e-9, abs=1e-12)
    assert found["motor.effort"] == pytest.approx(5.0)  # at the input, with what accelerates the rotor


def test_a_pendulum_with_a_rotor_swings_as_a_longer_one():
    """A point mass on a massless rod: w^2 = m g l / (m l^2 + J n^2) for small angles; the energy is conserved."""
    model = gimcli.loads("""
units: {length: m}
nodes: {O: [0, 0], A: [0, -0.5]}
ground: [O]
links: {rod: [O, A]}
actuators:
  q: {pivot: O, arm: A, free: true, start: -89.9, rotor: {inertia: 0.01, ratio: 6}, law: {from: -90, to: -80}}
masses: {A: 2}
gravity: [0, -9.81]
""")
    period = TURN * math.sqrt((2 * 0.25 + 0.36) / (2 * 9.81 * 0.5))
    found = gimcli.simulate(model, duration=period, dt=period / 8, rtol=1e-12)
    assert found["q"][4] + 90.0 == pytest.approx(-0.1, rel=1e-6)  # half a period later
    assert found["q"][-1] + 90.0 == pytest.approx(0.1, rel=1e-6)
    assert np.max(np.abs(found["energy.drift"])) < 1e-12


SLIDER = """
units: {length: mm}
nodes: {G: [0, 0], H: [100, 0], A: [10, 0], B: [30, 0]}
ground: [G, H]
links: {carriage: [A, B]}
prismatic: {guide: {nodes: [A, B], guide: [G, H]}}
actuators: {screw: {node: A, guide: [G, H], law: {from: 0, to: 80, profile: quintic}, rotor: ROTOR}}
duration: 0.5
masses: {carriage: {mass: 4, inertia: 0}}
"""


def test_the_rotor_of_a_screw():
    """A lead of 5 mm: the rotor of J turns by 2 pi / 0.005 rad per m, and adds J times its square to the mass."""
    found = gimcli.forces(gimcli.loads(SLIDER.replace("ROTOR", "{inertia: 1e-5, lead: 5}")), 24)
    added = 1e-5 * (TURN / 0.005) ** 2
    assert found["screw.effort"] == pytest.approx((4 + added) * gain(24) * 0.08 / TURN, abs=1e-9)
    assert np.max(np.abs(found["power.error"])) < 1e-9


@pytest.mark.parametrize("name", ["excavator", "platform_3rpr", "scissor_lift"])
def test_rotors_of_cylinders_and_of_moving_pivots_balance_their_power(name):
    """The rate of the kinetic energy is exact also where the reading is a distance, or measured on a moving member."""
    data = gimcli.load(MODELS / f"{name}.yaml").written.source.data
    data = {**data, "actuators": {
        k: {**a, "rotor": {"inertia": 0.01, **({"ratio": 5} if "pivot" in a else {"lead": 3})}}
        for k, a in data["actuators"].items()
    }}  # fmt: skip
    data.pop("tolerances", None)
    if "masses" not in data:
        data["masses"] = {next(iter({**data.get("links", {}), **data.get("elements", {})})): {"mass": 1, "inertia": 0}}
    if data.get("units", {}).get("length") == "unit":
        data["units"] = {"length": "m"}
    found = gimcli.forces(gimcli.load(data), 24)
    assert np.nanmax(np.abs(found["power.drive"])) > 0.0
    assert found.report()["energy_drift"] < 1e-11
    kinetic = found["energy.kinetic"]
    assert np.ptp(kinetic[np.isfinite(kinetic)]) > 0.0


POLAR = """
units: {length: m}
nodes: {O: [0, 0], A: [1, 0], B: [0.4, 0], G: [0, 2]}
ground: [O, G]
links: {arm: [O, A]}
prismatic: {slide: {node: B, guide: [O, A]}}
actuators:
  turn: {pivot: O, arm: A, law: {from: 0, to: 200, profile: quintic}}
  reach: {node: B, guide: [O, A], law: {from: 0.4, to: 0.9, profile: cycloidal}}
masses: {B: 2}
"""
"""A travel along a guide that turns."""
ROPE = POLAR.replace(
    "reach: {node: B, guide: [O, A], law: {from: 0.4, to: 0.9", "rope: {nodes: [G, B], law: {from: 2.2, to: 1.9"
)
ROPE = ROPE.replace("to: 200", "to: 30").replace("B: [0.4, 0]", "B: [0.92, 0]")
"""A distance of two nodes that both change their direction."""


@pytest.mark.parametrize(("text", "name"), [(POLAR, "reach"), (ROPE, "rope")])
def test_the_effort_of_the_rotor_follows_the_law(text, name):
    """The rotor adds J (2 pi / lead)^2 times the acceleration of its law: sin(2 pi t) 2 pi by the stroke and T^2."""
    bare = gimcli.forces(gimcli.loads(text), 24)
    model = gimcli.loads(text.replace("profile: cycloidal}", "profile: cycloidal}, rotor: {inertia: 0.01, lead: 2}"))
    found, stroke = gimcli.forces(model, 24), 0.5 if name == "reach" else -0.3
    gain = stroke * TURN * np.sin(TURN * np.linspace(0.0, 1.0, 25))
    added = found[f"{name}.effort"] - bare[f"{name}.effort"]
    assert added == pytest.approx(0.01 * (TURN / 2) ** 2 * gain, abs=1e-12)
    assert found["turn.effort"] == pytest.approx(bare["turn.effort"], abs=1e-12)


@pytest.mark.parametrize(("rotor", "words"), [
    ("{inertia: 1, lead: 5}", "`lead` is not of a rotary input"),
    ("{inertia: 1, ratio: 0}", "expected a ratio other than 0"),
    ("{ratio: 5}", "'inertia' is missing"),
    ("{inertia: -1}", "at least 0"),
])  # fmt: skip
def test_an_invalid_rotor_is_refused(rotor, words):
    with pytest.raises(ModelError) as caught:
        disc(rotor=rotor)
    assert words in str(caught.value)


def test_the_numbers_of_a_rotor_are_dimensions():
    assert gimcli.reduce(disc().with_({"motor.rotor.ratio": 10}), steps=2)["J"] == pytest.approx(DISC + 100 * ROTOR)
