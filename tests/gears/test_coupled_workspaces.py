"""Workspaces where inputs follow others or the linkage turns gears, by closed forms."""

import numpy as np
import pytest
import yaml
from bundled import MODELS
from coupled_models import apex, five_bar, rack

import gimcli

TURN = {"from": 0, "to": 360}


def arm(ratio, second=TURN, lengths=(10.0, 40.0, 10.0)):
    """Return an arm of three links: fore turns against upper by a ratio times the angle of upper against base."""
    a, b, c = np.cumsum(lengths)
    return {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [a, 0], "B": [b, 0], "C": [c, 0]},
        "ground": ["O"],
        "links": {"base": ["O", "A"], "upper": ["A", "B"], "fore": ["B", "C"]},
        "actuators": {
            "one": {"pivot": "O", "arm": "A", "law": TURN},
            "two": {"pivot": "A", "arm": "B", "reference": "O", "law": second},
            "three": {"pivot": "B", "arm": "C", "reference": "A", "follows": "two", "ratio": ratio,
                      "phase": 180.0 - 180.0 * ratio},
        },
        "trace": ["C"],
    }  # fmt: skip


def test_a_link_that_stays_parallel_to_the_base():
    found = gimcli.workspace(gimcli.load(arm(-1.0)))
    assert found.complete
    assert found.report()["area"] == pytest.approx(np.pi * (60.0**2 - 20.0**2), rel=1e-8)
    assert found.report()["holes"] == 1


def test_a_link_of_a_given_direction_moves_on_a_circle():
    found = gimcli.workspace(gimcli.load(arm(-1.0)), orientation={"fore": 90.0}).report()
    (path,) = found["paths"]
    assert path["closed"]
    assert path["length"] == pytest.approx(80.0 * np.pi, rel=1e-7)
    assert path["bounds"]["x"] == pytest.approx([-40.0, 40.0], abs=1e-6)
    assert path["bounds"]["y"] == pytest.approx([-20.0, 60.0], abs=1e-6)


@pytest.mark.parametrize(("ratio", "reach"), [(np.sqrt(2.0), 90.0), (2.0, 180.0), (-0.5, 180.0), (1.5, 120.0)])
def test_an_arm_with_a_gear_reaches_an_annulus(ratio, reach):
    """Its radii are the least and the greatest distance of the end from the base over the range of the second motor."""
    found = gimcli.workspace(gimcli.load(arm(ratio, {"from": 180.0 - reach, "to": 180.0 + reach})))
    turn = np.radians(np.linspace(-reach, reach, 1_000_001))
    far = abs(10.0 + np.exp(1j * turn) * (40.0 + 10.0 * np.exp(1j * ratio * turn)))
    assert found.complete
    assert found.report()["area"] == pytest.approx(np.pi * (far.max() ** 2 - far.min() ** 2), rel=1e-7)


def hand_on_a_pinion():
    """Return an arm of 10 at the end of a pinion of 50 that the linkage turns by a rack."""
    data = rack(50.0)
    data["nodes"]["U"] = [160, 100]
    data["links"]["arm"] = ["T", "U"]
    data["actuators"]["motor"]["law"] = {"from": 60, "to": 120}
    data["actuators"]["hand"] = {"pivot": "T", "arm": "U", "reference": "Q", "law": TURN}
    return gimcli.load(data)


def pinion(motor):
    """Return the direction of the pinion of 50 at angles of the motor [rad]."""
    bar = 30.0 * np.cos(motor) + np.sqrt(100.0**2 - (30.0 * np.sin(motor)) ** 2)
    return 1j * np.exp(1j * (bar - 130.0) / 50.0)


def test_the_grid_of_an_arm_on_a_pinion_that_the_linkage_turns():
    found = gimcli.workspace(hand_on_a_pinion(), "U", grid=7).arrays()
    motor, hand = (np.radians(found[f"input_{name}"]) for name in ("motor", "hand"))
    assert np.degrees(motor) == pytest.approx(np.linspace(60.0, 120.0, 7))
    assert np.degrees(hand) == pytest.approx(np.arange(7) * 360.0 / 7)
    turned = pinion(motor)[:, None]
    place = 150.0 + 50.0j + turned * (50.0 - 10.0 * np.exp(1j * hand))
    assert found["x"][0] + 1j * found["y"][0] == pytest.approx(place, abs=1e-9)


def test_a_grid_of_the_motor_that_turns_a_pinion():
    """Its line is followed from the value closest to the drawing, which is at none of the values."""
    data = rack(50.0)
    data["actuators"]["motor"]["law"] = {"from": 30, "to": 200}
    found = gimcli.workspace(gimcli.load(data), grid=11).arrays()
    place = 150.0 + 50.0j + 50.0 * pinion(np.radians(np.linspace(30.0, 200.0, 11)))
    assert found["x"][0] + 1j * found["y"][0] == pytest.approx(place, abs=1e-9)


def test_the_arm_on_a_pinion_that_the_linkage_turns():
    """In each assembly the rack moves the end of a pinion along an arc, around which an arm of 10 turns."""
    found = gimcli.workspace(hand_on_a_pinion(), "U")
    assert found.complete
    length = 60.0 * np.cos(np.radians(60.0))
    assert found.report()["area"] == pytest.approx(2.0 * (2.0 * 10.0 * length + np.pi * 10.0**2), rel=1e-7)
    assert found.report()["regions"] == 2


@pytest.mark.parametrize("every", [False, True])
def test_the_path_of_a_geared_five_bar(every):
    found = gimcli.workspace(gimcli.load(five_bar(2.0, 60.0)), every=every).report()
    turn = np.linspace(0.0, 2.0 * np.pi, 20_001)
    length = np.sum(abs(np.diff(apex(turn, 2.0, 60.0))))
    drawn = next(path for path in found["paths"] if path["drawn"])
    assert drawn["closed"]
    assert drawn["length"] == pytest.approx(length, rel=1e-6)
    assert drawn["inputs"]["motor"]["full_turn"]
    assert found["complete"]


def test_the_path_of_a_five_bar_within_the_range_of_its_motor():
    found = gimcli.workspace(gimcli.load(five_bar(1.97, 60.0, law={"from": 20, "to": 150}))).report()
    path = apex(np.radians(np.linspace(20.0, 150.0, 20_001)), 1.97, 60.0)
    drawn = next(path for path in found["paths"] if path["drawn"])
    assert drawn["length"] == pytest.approx(np.sum(abs(np.diff(path))), rel=1e-6)
    assert [drawn["inputs"]["motor"][end] for end in ("from", "to")] == pytest.approx([20.0, 150.0])


def test_a_range_of_more_than_a_turn_after_which_the_gear_is_elsewhere():
    (path,) = gimcli.workspace(gimcli.load(five_bar(0.5, 60.0, law={"from": 20, "to": 390}))).report()["paths"]
    assert [path["inputs"]["motor"][end] for end in ("from", "to")] == pytest.approx([20.0, 390.0])
    assert [path["inputs"]["second"][end] for end in ("from", "to")] == pytest.approx([70.0, 255.0])


def test_the_arc_of_a_pinion():
    found = gimcli.workspace(gimcli.load(rack()), "T").report()
    assert found["complete"]
    (path,) = found["paths"]
    angle = 90.0 - np.degrees(np.array([0.0, 3.0]))
    assert path["length"] == pytest.approx(120.0, abs=1e-6)  # there and back
    assert path["bounds"]["y"][0] == pytest.approx(20.0 + 20.0 * np.sin(np.radians(angle[1])), abs=1e-6)


@pytest.mark.parametrize(("ratio", "ends", "last"), [
    (2.0, (120.0, 240.0), 240.0), (2.0, (0.0, 360.0), 320.0), (0.5, (0.0, 360.0), 360.0), (0.5, (0.0, 720.0), 640.0),
])  # fmt: skip
def test_the_grid_of_an_arm_with_a_gear(ratio, ends, last):
    """All values of both motors; a law has no end value if the gear is back there."""
    law = dict(zip(("from", "to"), ends, strict=True))
    found = gimcli.workspace(gimcli.load(arm(ratio, law)), grid=9).arrays()
    assert sorted(found) == ["input_one", "input_two", "x", "y"]
    assert found["input_two"] == pytest.approx(np.linspace(ends[0], last, 9))
    upper, base = np.exp(1j * np.radians(found["input_two"] - 180.0)), np.exp(1j * np.radians(found["input_one"]))
    fore = np.exp(1j * ratio * np.radians(found["input_two"] - 180.0))
    place = base[:, None] * (10.0 + upper * (40.0 + 10.0 * fore))
    assert found["x"][0] + 1j * found["y"][0] == pytest.approx(place, abs=1e-11)


def test_a_grid_that_is_followed_line_by_line():
    """A link at the end of a crank of 40 turns with it by a ratio; the rest of the linkage has no closed form."""
    data = yaml.safe_load((MODELS / "gim_fig11.yaml").read_text())
    data["nodes"]["G"] = [220, 70]
    data["links"]["DG"] = ["D", "G"]
    data["actuators"]["gear"] = {"pivot": "D", "arm": "G", "reference": "F", "follows": "FD", "ratio": 3.0,
                                 "phase": -90.0}  # fmt: skip
    found = gimcli.workspace(gimcli.load(data), "G", grid=5).arrays()
    assert found["x"].shape == (1, 5, 5)
    assert np.ptp(found["input_OA"]) == pytest.approx(20.0)
    crank = np.radians(found["input_FD"])[:, None] + 0.0 * found["x"][0]
    place = 220.0 + 10.0j + np.exp(1j * crank) * (40.0 - 20.0 * np.exp(1j * (3.0 * crank - np.pi / 2.0)))
    assert found["x"][0] + 1j * found["y"][0] == pytest.approx(place, abs=1e-7)
