"""Sweeps and sensitivities where the linkage turns gears, by closed forms and by differences."""

import numpy as np
import pytest
from coupled_models import rack, sun_and_planet

import gimcli
from tests.gears.test_linked_gears import complex_of, driven_apex


def place(turn, crank):
    return crank * np.cos(turn) + np.sqrt(100.0**2 - (crank * np.sin(turn)) ** 2)


TURN = np.radians(np.linspace(0.0, 720.0, 73))


def test_a_sweep_over_the_crank():
    keep = ["range(mesh)", "at(mesh, motor=45)", "max(pinion.omega)"]
    found = gimcli.sweep(gimcli.load(rack()), {"crank": "20:30:5"}, steps=72, keep=keep)
    for k, crank in enumerate(found["crank.length"]):
        x = place(TURN, crank)
        assert np.isclose(found["range(mesh)"][k], np.degrees(np.ptp(x) / 20.0), atol=1e-9)
        wanted = 90.0 + np.degrees((place(np.pi / 4.0, crank) - 130.0) / 20.0)
        assert np.isclose(found["at(mesh, motor=45)"][k], wanted, atol=1e-8)
        slope = -crank * np.sin(TURN) * (1.0 + crank * np.cos(TURN) / np.sqrt(1e4 - (crank * np.sin(TURN)) ** 2))
        assert np.isclose(found["max(pinion.omega)"][k], np.degrees(np.max(slope) / 20.0 * 4.0 * np.pi), rtol=1e-9)


def test_a_sweep_over_the_radius_keeps_columns():
    notes = []
    found = gimcli.sweep(
        gimcli.load(rack()), {"mesh.radii.0": [18.0, 20.0, 22.0]}, steps=72, keep=["mesh"], rows=True,
        notify=notes.append,
    )  # fmt: skip
    for curve, radius in zip(found.curves["mesh"], (18.0, 20.0, 22.0), strict=True):
        assert np.allclose(curve, 90.0 + np.degrees((place(TURN, 30.0) - 130.0) / radius), atol=1e-8)
    assert not any("no length" in note for note in notes)


def test_sensitivities_of_a_pinion_to_the_crank_and_its_radius():
    by = ["crank.length", "mesh.radii.0"]
    found = gimcli.sensitivity(gimcli.load(rack()), of=["T.x", "pinion.omega"], by=by, steps=72)
    slope = np.cos(TURN) - 30.0 * np.sin(TURN) ** 2 / np.sqrt(1e4 - (30.0 * np.sin(TURN)) ** 2)
    angle = (place(TURN, 30.0) - 130.0) / 20.0  # T.x = 150 - r sin(angle), with the pitch radius and |QT| = 20
    assert np.allclose(found["T.x/crank.length"], -np.cos(angle) * slope, atol=1e-10)
    assert np.allclose(found["T.x/mesh.radii.0"], np.cos(angle) * angle, atol=1e-10)
    assert np.allclose(found["pinion.omega/mesh.radii.0"], -found["pinion.omega"] / 20.0, atol=1e-9)


def test_sensitivity_of_a_sun_gear_to_the_ratio():
    """sun = (1 + ratio) crank - ratio rod; angles count their full turns, from the drawing on."""
    found = gimcli.sensitivity(gimcli.load(sun_and_planet()), of=["S.x"], by=["mesh.ratio"], steps=24)
    t = gimcli.trace(gimcli.load(sun_and_planet()), steps=24)
    crank = np.radians(t["motor"])
    rod = np.angle(complex_of(t, "B") - 100.0 * np.exp(1j * crank)) - np.pi / 2.0
    assert np.allclose(found["S.x/mesh.ratio"], -40.0 * np.sin(2.0 * crank - rod) * (crank - rod), atol=1e-8)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["b1.length", "crank.length", "mesh.ratio"])
def test_sensitivities_with_a_gear_inside_a_loop_are_differences_of_motions(name):
    m, of = gimcli.load(driven_apex()), ["A.x", "B.x", "B.vx", "crank.alpha"]
    found = gimcli.sensitivity(m, of=of, by=[name], steps=6)
    value = m.written.dimension(name).value
    errors = []
    for h in (2e-3, 1e-3):
        more, less = (gimcli.trace(m.with_({name: value + k * h}), steps=6, derivatives=2) for k in (1, -1))
        errors.append([np.max(abs((more[q] - less[q]) / (2.0 * h) - found[f"{q}/{name}"])) for q in of])
    assert np.all(np.array(errors[1]) < 1e-2)
    assert np.allclose(np.divide(*errors), 4.0, rtol=0.1)  # of second order


def test_the_sensitivity_to_the_input_of_a_driver():
    found = gimcli.sensitivity(gimcli.load(rack()), motor=40.0, of=["mesh"], by=["motor"])
    turn, h = np.radians(40.0), 1e-5
    slope = (place(turn + h, 30.0) - place(turn - h, 30.0)) / (2.0 * h) / 20.0
    assert np.isclose(found.derivatives["mesh"]["motor"], slope, rtol=1e-8)


@pytest.mark.parametrize("given", [{"steps": 8}, {"motor": 40.0}], ids=["motion", "position"])
def test_the_spread_of_random_designs_is_that_of_the_pinion(given):
    """Only the crank differs, by deviations of 0.1: the pinion turns by these times the slope of the rack."""
    data = rack() | {"tolerances": {"crank.length": 0.3}}
    found = gimcli.sensitivity(gimcli.load(data), of=["mesh", "pinion.omega"], samples=40, **given)
    turn = np.radians(np.linspace(0.0, 720.0, 9) if "steps" in given else np.array([40.0]))
    root = np.sqrt(1e4 - (30.0 * np.sin(turn)) ** 2)
    slope = np.degrees(np.cos(turn) - 30.0 * np.sin(turn) ** 2 / root) / 20.0
    ratio = found.sampled.deviation[0] / abs(slope)
    assert np.allclose(ratio, ratio[0], rtol=1e-3)  # the same designs in all rows
    assert 0.07 < ratio[0] < 0.13
    lengths = (30.1, 29.9)
    each = [-c * np.sin(turn) * (1.0 + c * np.cos(turn) / np.sqrt(1e4 - (c * np.sin(turn)) ** 2)) for c in lengths]
    rate = np.degrees(abs(np.subtract(*each)) / 0.2 / 20.0 * 4.0 * np.pi)
    moves = rate > 1.0
    assert np.allclose(found.sampled.deviation[1][moves], (rate * ratio[0])[moves], rtol=1e-3)
