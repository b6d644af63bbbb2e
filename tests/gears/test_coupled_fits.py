"""Fits with inputs that follow others: the design of the targets, and goals where a linkage turns gears."""

import numpy as np
import pytest
from coupled_models import apex, five_bar, rack, with_gears

import gimcli

TURN = np.radians(np.arange(10.0, 351.0, 20.0))
PLACES = apex(TURN, 2.0, 60.0)
LENGTHS = {"b1": (3.0, 4.0), "b2": (2.5, 3.5)}


@pytest.mark.parametrize("timing", ["given", "step", "free"])
def test_targets_of_a_five_bar_are_passed_by_its_own_design(timing):
    m = gimcli.load(five_bar(1.97, 55.0, b=(3.4, 3.1)))
    through = {"x": PLACES.real, "y": PLACES.imag} | ({} if timing == "free" else {"input": np.degrees(TURN)})
    vary = {**LENGTHS, "second.ratio": (1.9, 2.1), "second.phase": (40.0, 80.0)}
    found = gimcli.fit(m, vary, through=through, timing=timing, starts=4)
    assert list(found.dimensions.values()) == pytest.approx([3.5, 3.0, 2.0, 60.0], abs=1e-8)
    t = gimcli.trace(found.mechanism, steps=36)
    assert np.max(abs(t.xy["P"] @ [1, 1j] - apex(np.radians(t["motor"]), 2.0, 60.0))) < 1e-7


def test_the_ratio_of_a_gear_is_fitted():
    gear = {"mesh": {"members": ["crank", "other"], "pivots": ["O", "Q"], "ratio": 1.1, "type": "belt"}}
    m = gimcli.load(with_gears(five_bar(2.0, 60.0), gear))
    turn = TURN[:9]
    through = {"x": apex(turn, 1.2, 60.0).real, "y": apex(turn, 1.2, 60.0).imag, "input": np.degrees(turn)}
    found = gimcli.fit(m, {"mesh.ratio": (1.05, 1.35)}, through=through, starts=4)
    assert found.dimensions["mesh.ratio"] == pytest.approx(1.2, abs=1e-9)


def test_a_goal_of_a_pinion_that_the_linkage_turns():
    """The pinion of radius 20 turns by 150 deg for a stroke, 2 crank, of 20 rad(150)."""
    found = gimcli.fit(gimcli.load(rack()), {"crank": (22.0, 30.0)}, goal="(range(mesh) - 150)**2", starts=3)
    assert found.dimensions["crank.length"] == pytest.approx(10.0 * np.radians(150.0), abs=1e-4)


def test_targets_of_a_point_on_a_pinion_that_the_linkage_turns():
    """The tip of the pinion turns by the stroke over the radius: crank, rod and pitch radius are found again."""
    turn = np.radians(np.arange(5.0, 180.0, 25.0))
    slider = 26.0 * np.cos(turn) + np.sqrt(104.0**2 - (26.0 * np.sin(turn)) ** 2)
    tip = 150.0 + 20.0j + 20.0j * np.exp(1j * (slider - 130.0) / 22.0)
    through = {"x": tip.real, "y": tip.imag, "input": np.degrees(turn)}
    vary = {"crank": (22.0, 32.0), "rod": (95.0, 110.0), "mesh.radii.0": (18.0, 25.0)}
    found = gimcli.fit(gimcli.load(rack()), vary, through=through, point="T", starts=1)
    assert list(found.dimensions.values()) == pytest.approx([26.0, 104.0, 22.0], abs=1e-6)
