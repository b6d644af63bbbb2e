"""PMKS JSON: the same mechanisms as text, with angles in radians and speeds in revolutions per minute."""

from __future__ import annotations

import json
from math import pi

import numpy as np
import pytest
from damaged_texts import changed, cut, with_numbers

import gimcli
from gimcli import ModelError
from gimcli.exchange.assembling import model_of
from gimcli.exchange.registry import draft_of


def joint(x, y, links, kind="R", angle=0.0, visible=False):
    return {"X": x, "Y": y, "Angle": angle, "TypeOfJoint": kind, "Links": links, "PositionVisible": visible}


SLIDER_CRANK = {
    "Joints": [
        joint(0, 0, ["ground", "crank"]),
        joint(2, 0, ["crank", "rod"], visible=True),
        joint(2 + 4 * np.sqrt(2), 4 * np.sqrt(2), ["ground", "rod"], "RP", pi / 4),
        joint(3, 1, ["rod"]),
    ],
    "Links": [{"Name": "crank"}, {"Name": "rod"}],
    "Name": "slider-crank",
    "DrivingIndex": 0,
    "InputSpeed": -30.0,
}


def test_the_slider_runs_along_its_line_at_45_degrees():
    """Crank 2, rod 8; the line passes through the initial slider at 45 degrees, so through (2, 0)."""
    found = draft_of(json.dumps(SLIDER_CRANK), "a.pmks")
    assert found is not None
    mechanism = gimcli.load(model_of(found))
    assert mechanism.name == "slider-crank"
    assert mechanism.duration == pytest.approx(2)  # half a revolution per second, clockwise
    assert gimcli.trace(mechanism, steps=2)["motor"] == pytest.approx([0, -180, -360])
    for angle in (0, 60, 200):
        pin = 2 * np.exp(1j * np.radians(angle))
        ray = np.exp(1j * pi / 4)
        local = (pin - 2) / ray
        end = 2 + (local.real + np.sqrt(64 - local.imag**2)) * ray
        solved = gimcli.solve(mechanism, motor=angle)
        assert complex(*solved.xy["C"]) == pytest.approx(end, abs=1e-9)
        rod = np.exp(1j * (np.angle(end - pin) - pi / 4))  # turned from its initial direction, 45 degrees
        assert complex(*solved.xy["D"]) == pytest.approx(pin + (1 + 1j) * rod, abs=1e-9)


def test_damaged_files_are_models_or_model_errors():
    text = json.dumps(SLIDER_CRANK, indent=1)
    deep = '{"Joints": ' + "[" * 100_000
    for damaged in [*cut(text), *changed(text, 150), *with_numbers(text), deep, '{"Joints": [' + "9" * 5000 + "]}"]:
        try:
            found = draft_of(damaged, "a.pmks")
            if found is not None:
                model_of(found)
        except ModelError:
            pass


def test_a_coordinate_that_makes_the_angle_of_a_link_underflow_is_refused():
    data = {**SLIDER_CRANK, "Joints": [SLIDER_CRANK["Joints"][0], joint(1e300, 1e-300, ["crank", "rod"])]}
    with pytest.raises(ModelError, match="at most 1e"):
        gimcli.load(model_of(draft_of(json.dumps(data), "f")))
