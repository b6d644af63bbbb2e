"""Positions of mechanisms whose inputs follow others, against closed forms of geared five-bars and gear trains."""

import json

import numpy as np
import pytest
from coupled_models import PLANETARY, apex, five_bar, with_gears

import gimcli
from gimcli import GimError


@pytest.mark.parametrize("ratio", [2.0, -1.0, 1.0, 0.5, -2.5])
def test_a_five_bar_whose_second_crank_follows_the_first(ratio):
    m = gimcli.load(five_bar(ratio, 60.0))
    t = gimcli.trace(m, steps=72)
    exact = apex(np.radians(t["motor"]), ratio, 60.0)
    assert set(t.status) == {"ok"}
    assert np.max(abs(t.xy["P"] @ [1, 1j] - exact)) < 1e-13
    assert np.allclose(t["second"], ratio * t["motor"] + 60.0, atol=1e-12)


def test_velocities_and_accelerations_of_a_following_crank():
    m = gimcli.load(five_bar(2.0, 60.0))
    t = gimcli.trace(m, steps=36, derivatives=2)
    turn, h, w = np.radians(t["motor"]), 1e-4, 2.0 * np.pi
    ahead, here, behind = (apex(turn + k * h, 2.0, 60.0) for k in (1, 0, -1))
    assert np.allclose(t["P.vx"] + 1j * t["P.vy"], (ahead - behind) / (2.0 * h) * w, atol=1e-6)
    assert np.allclose(t["P.ax"] + 1j * t["P.ay"], (ahead - 2.0 * here + behind) / h**2 * w**2, atol=1e-4)


def test_equal_cranks_that_turn_oppositely_draw_a_straight_line():
    data = five_bar(-1.0, 180.0, a=(1.0, 1.0), b=(3.0, 3.0), drawn=(1.5, 2.0))
    data["nodes"]["P"] = [1.5, np.sqrt(9.0 - 0.25)]
    t = gimcli.trace(gimcli.load(data), steps=720)
    x, y = t.xy["P"].T
    assert np.max(abs(x - 1.5)) < 1e-13
    assert abs(y.min() - 1.3228756555322953) < 1e-4
    assert abs(y.max() - 3.70809924354783147) < 1e-4


def test_equal_cranks_that_turn_alike_draw_a_circle():
    data = five_bar(1.0, 0.0, a=(1.0, 1.0), b=(3.0, 3.0), drawn=(2.5, 2.6))
    t = gimcli.trace(gimcli.load(data), steps=72)
    assert np.max(abs(abs(t.xy["P"] @ [1, 1j] - complex(1.5, np.sqrt(9.0 - 2.25))) - 1.0)) < 1e-13


def test_an_actuator_follows_through_another():
    data = five_bar(2.0, 60.0)
    data["actuators"]["second"] |= {"follows": "middle", "ratio": -0.5, "phase": 75.0}
    data["nodes"] |= {"R": [6, 0], "S": [6, 1]}
    data["ground"] = ["O", "Q", "R"]
    data["links"]["idler"] = ["R", "S"]
    data["actuators"]["middle"] = {"pivot": "R", "arm": "S", "follows": "motor", "ratio": -4.0, "phase": 30.0}
    t = gimcli.trace(gimcli.load(data), steps=24)
    assert np.max(abs(t.xy["P"] @ [1, 1j] - apex(np.radians(t["motor"]), 2.0, 60.0))) < 1e-13


@pytest.mark.parametrize("profile", ["uniform", "quintic", "harmonic"])
def test_the_law_of_the_leader_decides(profile):
    data = five_bar(2.0, 60.0, law={"from": 0, "to": 360, "profile": profile})
    t = gimcli.trace(gimcli.load(data), steps=30)
    assert np.allclose(t["second"], 2.0 * t["motor"] + 60.0, atol=1e-11)


def test_designs_with_other_ratios():
    m = gimcli.load(five_bar(2.0, 60.0))
    own = m.with_({"second.ratio": -1.0, "second.phase": 50.0})
    t = gimcli.trace(own, steps=12)
    assert np.max(abs(t.xy["P"] @ [1, 1j] - apex(np.radians(t["motor"]), -1.0, 50.0))) < 1e-13


def test_the_input_of_a_follower_cannot_be_given():
    m = gimcli.load(five_bar(2.0, 60.0))
    assert abs(gimcli.solve(m, motor=45).xy["P"] @ [1, 1j] - apex(np.pi / 4.0, 2.0, 60.0)) < 1e-13
    with pytest.raises(GimError):
        gimcli.solve(m, second=45)


# --- gears ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "ratio"), [("external", -0.5), ("internal", 0.5), ("belt", 0.5), ("crossed", -0.5)]
)  # fmt: skip
def test_wheels_turn_by_their_type(kind, ratio):
    gear = {"members": ["crank", "other"], "pivots": ["O", "Q"], "type": kind, "ratio": 0.5}
    t = gimcli.trace(gimcli.load(with_gears(five_bar(2.0, 60.0), {"mesh": gear})), steps=24)
    assert np.max(abs(t.xy["P"] @ [1, 1j] - apex(np.radians(t["motor"]), ratio, 60.0))) < 1e-12
    assert np.allclose(t["mesh"], 60.0 + ratio * t["motor"])


def test_a_planetary_train_turns_by_the_formula_of_willis():
    t = gimcli.trace(gimcli.load(PLANETARY), steps=36)
    arm = np.radians(t["motor"]) * 40.0 / 140.0
    planet = arm + (0.0 - arm) * 100.0 / 30.0  # relative to the arm the ring turns by -arm
    assert np.max(abs(t.xy["P"] @ [1, 1j] - 35.0 * np.exp(1j * arm))) < 1e-11
    assert np.max(abs((t.xy["T"] - t.xy["P"]) @ [1, 1j] - 12j * np.exp(1j * planet))) < 1e-11


def test_a_differential_adds_its_two_inputs():
    data = {
        **PLANETARY,
        "nodes": {**PLANETARY["nodes"], "R": [0, 50]},
        "links": {**PLANETARY["links"], "ring": ["O", "R"]},
    }
    data["gears"] = {**PLANETARY["gears"], "outer": {**PLANETARY["gears"]["outer"], "members": ["ring", "planet"]}}
    data["actuators"] = {
        "motor": {"pivot": "O", "arm": "S", "law": {"from": 0, "to": 360}},
        "other": {"pivot": "O", "arm": "R", "law": {"from": 90, "to": -30}},
    }
    t = gimcli.trace(gimcli.load(data), steps=36)
    arm = np.radians(40.0 * t["motor"] + 100.0 * (t["other"] - 90.0)) / 140.0
    assert np.max(abs(t.xy["P"] @ [1, 1j] - 35.0 * np.exp(1j * arm))) < 1e-11


@pytest.mark.parametrize("guided", ["carrier", "rack"])
@pytest.mark.parametrize("height", [-20.0, 20.0])
def test_a_pinion_moves_a_rack(guided, height):
    frame, rack = ["G", "H"], ["U", "V"]
    pair = {"nodes": rack, "guide": frame} if guided == "carrier" else {"nodes": frame, "guide": rack}
    data = {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {
            "O": [0, 0], "A": [20, 0], "G": [-100, height], "H": [100, height], "U": [0, height], "V": [30, height],
        },
        "ground": ["O", "G", "H"], "links": {"pinion": ["O", "A"], "bar": rack},
        "prismatic": {"slide": pair},
        "actuators": {"motor": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 360}}},
        "gears": {"mesh": {"type": "rack", "members": ["pinion", "bar"], "pivots": ["O"], "radii": [20]}},
        "trace": ["U"],
    }  # fmt: skip
    t = gimcli.trace(gimcli.load(data), steps=12)
    assert np.allclose(t["U.x"], -height * np.radians(t["motor"]), atol=1e-11)
    assert np.allclose(t["U.y"], height, atol=1e-11)


def driven_rack():
    return {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [20, 0], "G": [-100, -20], "H": [100, -20], "U": [0, -20], "V": [30, -20]},
        "ground": ["O", "G", "H"], "links": {"pinion": ["O", "A"], "bar": ["U", "V"]},
        "prismatic": {"slide": {"nodes": ["U", "V"], "guide": ["G", "H"]}},
        "actuators": {"cylinder": {"node": "U", "guide": ["H", "G"], "law": {"from": 100, "to": 40}}},
        "gears": {"mesh": {"type": "rack", "members": ["pinion", "bar"], "pivots": ["O"], "radii": [20]}},
        "trace": ["A"],
    }  # fmt: skip


def test_a_rack_that_an_actuator_moves_turns_its_pinion():
    t = gimcli.trace(gimcli.load(driven_rack()), steps=12)
    assert np.max(abs(t.xy["A"] @ [1, 1j] - 20.0 * np.exp(1j * (100.0 - t["cylinder"]) / 20.0))) < 1e-11


def test_the_guide_of_a_rack_that_an_actuator_moves_varies():
    """The travel is measured from H: where it is farther away, the pinion has turned more."""
    far = np.array([100.0, 103.0, 108.0])
    found = gimcli.sweep(gimcli.load(driven_rack()), {"H.x": far}, keep=["first(A.x)", "last(A.y)"], steps=12)
    assert np.allclose(found["first(A.x)"], 20.0 * np.cos((far - 100.0) / 20.0), atol=1e-11)
    assert np.allclose(found["last(A.y)"], 20.0 * np.sin((far - 40.0) / 20.0), atol=1e-11)


# --- errors -----------------------------------------------------------------------------------------


def test_a_gear_between_two_driven_cranks_locks():
    data = five_bar(2.0, 60.0)
    data["gears"] = {"mesh": {"members": ["crank", "other"], "pivots": ["O", "Q"], "ratio": 1}}
    with pytest.raises(GimError):
        gimcli.load(data)
    with pytest.raises(GimError):
        gimcli.loads(json.dumps(data))
