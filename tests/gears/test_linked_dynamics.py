"""Dynamics of gears that the linkage turns: forces, reduced inertia, free motion and vibrations, by closed forms."""

import numpy as np
import pytest
from coupled_models import rack

import gimcli


def heavy(free=None, **more):
    data = rack()
    data["masses"] = {
        "pinion": {"mass": 1.0, "inertia": 0.01, "centre": [0, 0]},
        "crank": {"mass": 1.0, "inertia": 0.02, "centre": [0, 0]},
    }
    if free is not None:
        data["actuators"]["motor"] = {"pivot": "O", "arm": "A", "free": True, **free}
    return {**data, **more}


def slope(turn):
    """Return the turns of the pinion per turn of the crank: x'(crank)/radius."""
    return (
        -30.0 * np.sin(turn) - 900.0 * np.sin(turn) * np.cos(turn) / np.sqrt(1e4 - 900.0 * np.sin(turn) ** 2)
    ) / 20.0


def test_the_reduced_inertia_has_that_of_the_pinion():
    found = gimcli.reduce(gimcli.load(heavy()), steps=24)
    assert np.allclose(found["J"], 0.02 + 0.01 * slope(np.radians(found["q"])) ** 2, rtol=1e-12)


def test_a_brake_on_the_pinion_is_felt_at_the_crank():
    data = heavy(loads={"brake": {"on": "pinion", "torque": -3.0}})
    del data["masses"]
    found = gimcli.forces(gimcli.load(data), steps=24)
    turn = np.radians(found["motor"])
    assert np.allclose(found["motor.effort"], 3.0 * slope(turn), atol=1e-11)
    assert np.allclose(abs(found["mesh.tangential"]), 3.0 / 0.02, rtol=1e-9)
    assert np.max(abs(found["power.error"])) < 1e-10


def test_the_kinetic_energy_of_a_free_motion_is_constant():
    found = gimcli.simulate(gimcli.load(heavy({"start": 30, "speed": 600})), duration=1.0)
    turn, speed = np.radians(found["motor"]), np.radians(found["motor.speed"])
    energy = 0.5 * (0.02 + 0.01 * slope(turn) ** 2) * speed**2
    first = 0.5 * (0.02 + 0.01 * slope(np.radians(30.0)) ** 2) * np.radians(600.0) ** 2
    assert found.complete
    assert np.max(turn) > 2.0 * np.pi
    assert np.allclose(energy, first, rtol=1e-8)


def test_a_torsion_spring_on_the_pinion_vibrates_with_both_inertias():
    """omega^2 = k n^2/(J1 + n^2 J2) where the spring is relaxed (n turns of the pinion per turn of the crank)."""
    data = heavy({"start": 60}, springs={"coil": {"pivot": "Q", "arm": "T", "stiffness": 2.0}})
    angle = (30.0 * 0.5 + np.sqrt(1e4 - 675.0) - 130.0) / 20.0 + np.pi / 2.0
    data["springs"]["coil"]["free"] = float(np.degrees(angle))
    n = slope(np.pi / 3.0)
    found = gimcli.modes(gimcli.load(data))
    assert np.allclose(found["omega"][0], np.sqrt(2.0 * n**2 / (0.02 + 0.01 * n**2)), rtol=1e-9)


def energy(found):
    turn, speed = np.radians(found["motor"]), np.radians(found["motor.speed"])
    return 0.5 * (0.02 + 0.01 * slope(turn) ** 2) * speed**2


@pytest.mark.few(2)
@pytest.mark.parametrize("integrator", ["rk45", "radau", "lsoda", "rk4"])
def test_every_integrator_keeps_the_energy(integrator):
    found = gimcli.simulate(gimcli.load(heavy({"start": 30, "speed": 600})), duration=0.2, integrator=integrator)
    assert np.allclose(energy(found), energy(found)[0], rtol=1e-7)


@pytest.mark.parametrize("integrator", ["euler", "euler-exact"])
def test_steps_of_the_input_are_of_first_order(integrator):
    """The error of the energy is in proportion to the step."""
    m, errors = gimcli.load(heavy({"start": 30, "speed": 600})), []
    for step in (0.02, 0.01):
        found = gimcli.simulate(m, duration=0.2, integrator=integrator, step=step)
        errors.append(np.max(abs(energy(found) / energy(found)[0] - 1.0)))
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


def test_dry_friction_beside_a_pinion_that_the_linkage_turns():
    """The motion is that of a slider-crank whose slider has the mass J/r^2 of the pinion besides."""
    friction = {"O": {"mu": 0.1, "radius": 5}, "A": {"mu": 0.1, "radius": 4}, "B": {"mu": 0.2, "radius": 3}}
    geared = heavy({"start": 30, "speed": 600}, friction=friction)
    plain = {**geared, "ground": ["O", "G", "H"], "trace": ["A"]}
    del plain["gears"]
    plain["nodes"] = {n: at for n, at in geared["nodes"].items() if n not in "QT"}
    plain["links"] = {n: own for n, own in geared["links"].items() if n != "pinion"}
    slider_mass = {"mass": 0.01 / 0.02**2, "inertia": 0.1, "centre": [10, 0]}
    plain["masses"] = {"crank": geared["masses"]["crank"], "bar": slider_mass}
    one, other = (gimcli.simulate(gimcli.load(data), duration=0.5) for data in (geared, plain))
    assert one["motor.speed"][-1] < 590.0
    assert np.allclose(one["motor"], other["motor"], atol=1e-4)
