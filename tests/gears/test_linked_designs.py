"""Sweeps where the linkage turns a pinion: designs of a slider-crank with a rack, by its closed form."""

import numpy as np
from coupled_models import rack

import gimcli


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
