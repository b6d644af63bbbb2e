"""Efforts that hold one position at rest: closed forms, very slow motions, loads over the time, refusals."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim

import gimcli

ARM = """
units: {length: mm}
nodes: {O: [0, 0], A: [400, 0], B: [700, 0]}
ground: [O]
links: {upper: [O, A], fore: [A, B]}
actuators:
  shoulder: {pivot: O, arm: A}
  elbow: {pivot: A, arm: B, reference: O}
masses: {upper: {mass: 3, inertia: 0.1}, fore: {mass: 2, inertia: 0.1}, B: 1.5}
gravity: [0, -9.81]
dampers: {grease: {pivot: O, arm: A, damping: 50}}
"""


@pytest.mark.parametrize(("one", "two"), [(30.0, 140.0), (-70.0, 250.0), (90.0, 180.0)])
def test_an_arm_with_two_motors_and_no_laws(one, two):
    """The elbow carries the moment of the forearm, the shoulder that of everything; the angle at A is from A -> O."""
    found = gimcli.holding_forces(gimcli.loads(ARM), shoulder=one, elbow=two)
    fore = math.radians(one + 180.0 + two)
    a, b = 0.4 * math.cos(math.radians(one)), 0.3 * math.cos(fore)
    elbow = 9.81 * (2 * b / 2 + 1.5 * b)
    assert found["elbow.effort"] == pytest.approx(elbow, abs=1e-12)
    assert found["shoulder.effort"] == pytest.approx(elbow + 9.81 * a * (3 / 2 + 2 + 1.5), abs=1e-12)
    assert (found["O.fx"][0], found["O.fy"][0]) == pytest.approx((0.0, 9.81 * 6.5), abs=1e-12)
    assert found.forces["O"] == (pytest.approx(9.81 * 6.5j, abs=1e-12), "N")
    assert (found.status, found.answered, found.reason, found.open) == ("ok", True, "", [])


@pytest.mark.parametrize("name", ["engine", "lift_table", "shaper", "garage_door", "toggle_clamp"])
def test_a_very_slow_motion_has_the_same_forces(name):
    model = gimcli.load(MODELS / f"{name}.yaml")
    slow = gimcli.forces(model.with_({"duration": 1e10}), 5)
    (actuator,) = (a.name for a in model.actuators)
    forces = [column for column in slow if column.endswith((".fx", ".fy", ".effort", ".normal", ".moment"))]
    scale = max(np.max(np.abs(slow[column])) for column in forces)
    for row in (1, 3):
        still = gimcli.holding_forces(model, {actuator: slow[actuator][row]})
        for column in forces:
            assert still[column][0] == pytest.approx(slow[column][row], abs=1e-7 * scale), column


def test_a_load_over_the_time(tmp_path):
    (tmp_path / "push.csv").write_text("0,0\n2,1\n")
    text = ARM.replace("masses", "loads: {push: {on: B, force: [0, -10], table: push.csv}}\nmasses")
    (tmp_path / "arm.yaml").write_text(text)
    model = gimcli.load(tmp_path / "arm.yaml")
    empty, half = (gimcli.holding_forces(model, elbow=180, time=time) for time in (0.0, 1.0))
    assert half["O.fy"] - empty["O.fy"] == pytest.approx(5.0)
    assert half["time"] == 1.0


def test_dry_friction_gives_a_range():
    """The limits at rest are between those of the motions in both directions, without the inertia forces."""
    found = gimcli.holding_forces(gimcli.load("crank_press"), crank_angle=60)
    least, greatest = (found[f"crank_angle.effort.{end}"][0] for end in ("least", "greatest"))
    assert found.status == "standstill"
    assert found.answered
    press = gimcli.load("crank_press")
    free = press.with_({name: 0.0 for name in press.written.dimensions if name.endswith(".mu")})
    without = gimcli.holding_forces(free, crank_angle=60)["crank_angle.effort"][0]
    assert least < without < greatest


def test_the_command_prints_and_reports_one_position(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = gim("forces", MODELS / "lift_table.yaml", "--at", "cylinder=0.5", "--json", "-o", "p.png", "-o", "p.csv")
    assert done.code == 0
    own = done.json["forces"]["cylinder.effort"]
    assert own["unit"] == "N"
    assert done.json["forces"]["T"]["magnitude"] == pytest.approx(abs(done.json["forces"]["T"]["y"]))
    assert (tmp_path / "p.csv").read_text().splitlines()[1].split(",")[2] == repr(own["value"])
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads(done.text)["inputs"] == {"cylinder": 0.5}
    printed = gim("forces", MODELS / "lift_table.yaml", "--at", "cylinder=0.5")
    assert "cylinder.effort" in printed.text
    assert "wrote" not in printed.text


def test_quantities_of_one_position(tmp_path, monkeypatch):
    """The amount of a pin force is that of its components, in the report, in the terminal and as a column."""
    monkeypatch.chdir(tmp_path)
    words = ("forces", MODELS / "lift_table.yaml", "--at", "cylinder=0.5", "-m", "|L.f|", "-m", "cylinder.effort / 2")
    done = gim(*words, "--json", "-o", "p.csv")
    pin, effort = (done.json["forces"][name] for name in ("L", "cylinder.effort"))
    found = {name: one["value"] for name, one in done.json["measures"].items()}
    assert found == pytest.approx({"|L.f|": math.hypot(pin["x"], pin["y"]), "cylinder.effort / 2": effort["value"] / 2})
    head, row = (line.split(",") for line in (tmp_path / "p.csv").read_text().splitlines())
    assert float(row[head.index("|L.f|")]) == found["|L.f|"]
    assert "|L.f| [N]" in gim(*words).text


@pytest.mark.parametrize(("more", "words"), [
    (["--at", "cylinder=0.5", "--steps", "9"], "--steps is for a motion"),
    (["--at", "cylinder=0.5", "--full"], "--full is for a motion"),
    (["--time", "1"], "add --at"),
    (["--at", "piston=0.5"], "no actuator 'piston'"),
])  # fmt: skip
def test_options_that_do_not_belong_together_are_refused(more, words):
    done = gim("forces", MODELS / "lift_table.yaml", *more)
    assert done.code == 2
    assert words in done.error


def test_a_position_that_is_not_assembled_has_a_reason():
    done = gim("forces", MODELS / "lift_table.yaml", "--at", "cylinder=5")
    assert done.code == 5
    assert "instead of 5 m" in done.text
