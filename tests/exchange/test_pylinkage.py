"""Files of pylinkage: positions against those that the program itself computed, and closed forms."""

from __future__ import annotations

import json
import math
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from damaged_texts import changed, cut, with_numbers

import gimcli
from gimcli.exchange.assembling import model_of
from gimcli.exchange.pylinkage import read, recognises

DATA = Path(__file__).parent / "data"
MECHANISM = DATA / "pylinkage_tracker.json"  # written by release 1.3.0
LINKAGE = DATA / "pylinkage_linkage.json"  # written by release 0.8.0

STEP_20 = {  # positions after 20 steps, computed by release 1.3.0
    "coupler.1_rocker.0": (1.3751382662460507, -1.4526186280900473),
    "coupler.0_crank.tip": (-0.6662760212798248, 0.7457052121767197),
    "P": (0.822503413220791, 0.5625774005040337),
}
STEP_10 = {  # positions after 10 steps, computed by release 0.8.0
    "C": (0.5403023058681398, -0.8414709848078964), "B": (1.7895650806182375, 0.7203684818543103),
    "F": (1.1807746157066947, 2.2139422980682113), "G": (3.178586529581066, 0.5866243743707135),
    "E": (3.0206578590337028, 4.583505475306685),
}  # fmt: skip


def joint(ident: str, x: float, y: float, kind: str = "revolute", **more) -> dict:
    return {"id": ident, "type": kind, "position": [x, y], **more}


def link(ident: str, *joints: str, kind: str = "link", **more) -> dict:
    return {"id": ident, "type": kind, "joints": list(joints), **more}


def driver(*joints: str, kind: str = "driver", speed: float = 0.1, start: float = 0.0, **more) -> dict:
    own = {"angular_velocity": speed, "initial_angle": start, "motor_joint": joints[0], **more}
    return link("crank", *joints, kind=kind, **own)


def file_of(joints: list[dict], links: list[dict]) -> str:
    return json.dumps({"name": "test", "joints": joints, "links": links, "ground": "ground"})


GROUND = [joint("O", 0, 0, "ground"), joint("Q", 4, 0, "ground")]
FRAME = link("ground", "O", "Q", kind="ground")
CRANK = [*GROUND, joint("A", 1, 0)]


def loaded(text: str, tmp_path):
    path = tmp_path / "mechanism.json"
    path.write_text(text)
    return gimcli.load(path)


def test_a_mechanism_moves_as_in_the_program():
    m = gimcli.load(MECHANISM)
    assert m.name == "tr"
    assert m.duration == pytest.approx(2 * math.pi / 0.1)  # a turn at 0.1 rad per step, a step per second
    p = gimcli.solve(m, motor=math.degrees(0.3 + 20 * 0.1))
    assert {name: p.xy[name] for name in STEP_20} == {n: pytest.approx(xy, abs=1e-9) for n, xy in STEP_20.items()}
    t = gimcli.trace(m, steps=4)
    assert t["motor"] == pytest.approx(math.degrees(0.3) + 90 * np.arange(5))


def test_a_linkage_of_an_older_release_moves_as_in_the_program():
    m = gimcli.load(LINKAGE)
    p = gimcli.solve(m, motor=math.degrees(-10 * 0.1))
    assert {name: p.xy[name] for name in STEP_10} == {n: pytest.approx(xy, abs=1e-9) for n, xy in STEP_10.items()}
    t = gimcli.trace(m, steps=2)
    assert t["motor"] == pytest.approx([0, -180, -360])
    assert m.duration == pytest.approx(2 * math.pi / 0.1)


def test_a_pin_slides_on_its_line(tmp_path):
    slide = joint("S", 1, 4, "prismatic", axis=[0, 2], line_point=[1, -5])
    text = file_of([*GROUND, joint("A", 1, 0), slide], [FRAME, driver("O", "A"), link("rod", "A", "S")])
    t = gimcli.trace(loaded(text, tmp_path), steps=6)
    a = np.exp(1j * np.radians(60 * np.arange(7)))
    assert t.xy["S"][:, 0] == pytest.approx(np.ones(7))
    assert t.xy["S"][:, 1] == pytest.approx(a.imag + np.sqrt(16 - (1 - a.real) ** 2))


@pytest.mark.parametrize(("speed", "first", "last"), [(0.05, 0.5, 1.5), (-0.05, 1.5, 0.5)])
def test_an_arc_driver_makes_one_swing(tmp_path, speed, first, last):
    crank = driver("O", "A", kind="arc_driver", speed=speed, start=0.8, arc_start=0.5, arc_end=1.5)
    text = file_of([*GROUND, joint("A", math.cos(0.8), math.sin(0.8))], [FRAME, crank])
    t = gimcli.trace(loaded(text, tmp_path), steps=2)
    assert t.mechanism.duration == pytest.approx(20)
    assert np.radians(t["motor"][[0, -1]]) == pytest.approx([first, last])


def test_the_first_angle_of_a_driver_counts_not_its_position():
    data = model_of(read(file_of(CRANK, [FRAME, driver("O", "A", start=math.pi / 2)]), "f"))
    assert data["actuators"]["motor"]["law"] == {"from": pytest.approx(90), "to": pytest.approx(450)}
    data = model_of(read(file_of(CRANK, [FRAME, driver("O", "A", start=4 * math.pi)]), "f"))
    assert data["actuators"]["motor"]["law"] == {"by": pytest.approx(360)}


def test_two_drivers_run_until_both_are_back():
    joints = [*CRANK, joint("B", 5, 0)]
    second = {**driver("Q", "B", speed=-0.15), "id": "other"}
    data = model_of(read(file_of(joints, [FRAME, driver("O", "A"), second]), "f"))
    laws = {name: own["law"]["by"] for name, own in data["actuators"].items()}
    assert laws == {"motor_crank": pytest.approx(720), "motor_other": pytest.approx(-1080)}
    assert data["duration"] == pytest.approx(4 * math.pi / 0.1)


def test_trackers_are_points_or_joints_of_their_link():
    second = joint("P", 0.5, 0.5, "tracker", ref_joint1_id="O", ref_joint2_id="A", distance=0.5**0.5, angle=math.pi / 4)
    data = model_of(read(file_of([*CRANK, second], [FRAME, driver("O", "A")]), "f"))
    assert data["points"]["P"] == {"on": "crank", "at": pytest.approx([0.5, 0.5])}
    rod = link("rod", "P", "Q")
    data = model_of(read(file_of([*CRANK, second], [FRAME, driver("O", "A"), rod]), "f"))
    assert data["elements"]["crank"] == ["O", "A", "P"]
    assert data["links"]["rod"] == ["P", "Q"]
    loose = {**second, "ref_joint1_id": "Q"}
    draft = read(file_of([*CRANK, loose], [FRAME, driver("O", "A")]), "f")
    assert [line.split(" is ")[0] for line in draft.left_out] == ["tracker P"]
    free = joint("P", 7, 8, "tracker", ref_joint1_id="", ref_joint2_id="")
    data = model_of(read(file_of([*CRANK, free], [FRAME, driver("O", "A")]), "f"))
    assert data["points"]["P"] == {"on": "ground", "at": [7, 8]}


def test_names_that_the_program_invents_are_replaced():
    fixed = {"inline": True, "type": "Static", "x": 0, "y": 0, "name": "140621573593344"}
    crank = {"type": "Crank", "name": "140621573593345", "x": 0, "y": 2, "joint0": fixed, "distance": 1, "angle": 0.3}
    data = model_of(read(json.dumps({"name": "140621573593346", "joints": [crank]}), "f"))
    assert data["nodes"] == {"fixed": [0, 0], "joint1": [0, 1]}
    assert "name" not in data


def older(**more) -> str:
    """A linkage of two fixed joints, a crank of length 1 on the first and one more joint."""
    fixed = [{"type": "Static", "name": "O", "x": 0, "y": 0}, {"type": "Static", "name": "Q", "x": 4, "y": 0}]
    crank = {"type": "Crank", "name": "A", "x": 1, "y": 0, "joint0": {"ref": "O"}, "distance": 1, "angle": 0.1}
    return json.dumps({"name": "x", "joints": [{"name": "B", **more}, *fixed, crank]})


A, O, Q = {"ref": "A"}, {"ref": "O"}, {"ref": "Q"}


def test_distances_count_and_coordinates_choose():
    for y, side in ((1, 1), (-1, -1)):
        text = older(type="Pivot", x=9, y=y, joint0=A, joint1=Q, distance0=2.5, distance1=2)
        x = (2.5**2 - 2**2 + 3**2) / 6
        assert model_of(read(text, "f"))["nodes"]["B"] == pytest.approx([1 + x, side * math.sqrt(2.5**2 - x**2)])
    text = older(type="Linear", x=9, y=0, joint0=A, joint1=O, joint2=Q, revolute_radius=3)
    data = model_of(read(text, "f"))
    assert data["nodes"]["B"] == pytest.approx([4, 0])
    assert data["prismatic"]["slot_B"] == {"node": "B", "guide": ["O", "Q"]}


REFUSED = {
    "digits": (file_of([joint("A", 1, 2)], []).replace("[1,", "[" + "9" * 5000 + ","), "0.position.0: expected a num"),
    "many": (file_of([joint(str(k), k, 0) for k in range(600)], []), "more than 500 entries"),
    "deep": ('{"joints": [{"type": "ground"}], "x": ' + "[" * 100_000, "nested too deeply"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_converted_is_refused_by_name(name):
    text, message = REFUSED[name]
    assert recognises(text)
    with pytest.raises(gimcli.ModelError, match=message):
        model_of(read(text, "f"))


def test_other_texts_are_not_recognised():
    for text in ("", "{}", '{"joints": []}', '{"Joints": [{"TypeOfJoint": "R"}]}', '["joints"]', "joints: [type]"):
        assert not recognises(text)


@pytest.mark.parametrize("path", [MECHANISM, LINKAGE])
def test_damaged_texts_give_a_model_or_an_error(path):
    text = path.read_text()
    for damaged in [*cut(text, 200), *changed(text, 150), *with_numbers(text)]:
        with suppress(gimcli.ModelError):
            model_of(read(damaged, "f"))
