"""Dynamics of gears that the linkage turns: forces, reduced inertia, free motion and vibrations, by closed forms."""

import numpy as np
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
