"""The dynamic sections of the model file: error messages, and compilation to SI units."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gimcli import ModelError, load
from gimcli.dynamic_data import TIME
from gimcli.model.json_schema import json_schema

TOP = """\
nodes: {O: [0, 0], G: [3, 0], A: [0, 1], B: [3, 2], K: [9, 9]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B], rocker: [G, B]}
actuators:
  motor: {type: rotary, pivot: O, arm: A%s}
"""
FILE = TOP % ""


def motor(text):
    return TOP % f", {text}"


def freed(text):
    return motor(f"free: true, {text}")


# name: (text, line:column, fragments of the message)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "t.csv").write_text("x,factor\n0,0\n90,2\n180,1\n")
    (tmp_path / "back.csv").write_text("2,1\n1,1\n")
    return tmp_path


def loaded(folder, text):
    (folder / "m.yaml").write_text(text)
    return load(folder / "m.yaml")


def test_an_invalid_part_is_reported_once(folder):
    """References to an invalid actuator or spring are not reported as further errors."""
    text = motor("law: {from: x, to: 3}") + "loads: {f: {on: rod, torque: 3, table: t.csv, over: motor}}\n"
    with pytest.raises(ModelError) as caught:
        loaded(folder, text + "springs: {s: {nodes: [O, B], stiffness: x}}\n")
    assert len(str(caught.value).splitlines()) == 2, caught.value


def test_all_dynamic_sections_are_compiled_to_si_units(folder):
    text = """\
units: {length: mm, angle: deg, mass: g}
nodes: {O: [100, 0], G: [3100, 0], A: [100, 1000], B: [3100, 2000]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B], rocker: [G, B]}
actuators:
  motor: {type: rotary, pivot: O, arm: A, free: true, start: 45, speed: 90, effort: {stall: 8, idle: 1800}}
masses: {rod: {mass: 1500, inertia: 0.2}, crank: {mass: 1, centre: [250, 50]}}
gravity: [0, -9.81]
loads:
  push: {on: rod, at: [1600, 1500], follower: [3, 4], table: t.csv, over: motor}
  twist: {on: crank, torque: 5, table: t.csv}
springs:
  coil: {nodes: [O, B], stiffness: 200, free: 500}
  torsion: {pivot: A, arm: B, reference: O, stiffness: 3, free: 30}
dampers: {shock: {nodes: [A, G], damping: 7}}
friction: {A: 0.02}
"""
    mechanism = loaded(folder, text)
    d, names = mechanism.dynamics, [m.name for m in mechanism.members]
    assert d.metre == pytest.approx(mechanism.scale * 1e-3, rel=1e-15)
    rod, crank = d.inertias
    assert (names[rod.member], rod.mass, rod.moment) == ("rod", 1.5, 0.2)
    assert rod.centre * d.metre == pytest.approx(0.5 * math.sqrt(10.0))  # default: the mean of the nodes
    assert crank.mass == pytest.approx(1e-3)
    assert crank.centre * d.metre == pytest.approx(0.25 + 0.05j)
    assert d.gravity == -9.81j
    push, twist = d.loads
    assert push.follows
    assert push.force == 3 + 4j
    assert push.point * d.metre == pytest.approx(0.5 * math.sqrt(10.0))
    assert push.over == 0
    assert push.curve(np.radians([0.0, 90.0, 180.0, 500.0])) == pytest.approx([0.0, 2.0, 1.0, 1.0])
    assert (twist.torque, twist.over) == (5.0, TIME)
    assert twist.curve(np.array([-1.0, 90.0])) == pytest.approx([0.0, 2.0])
    coil, torsion = d.springs
    assert coil.free * d.metre == pytest.approx(0.5)
    assert torsion.free == pytest.approx(math.radians(30))
    gauge = mechanism.gauges[torsion.gauge]
    assert gauge.drawn == pytest.approx(math.atan2(1, 3) + math.pi / 2)  # from A -> O to A -> B
    assert mechanism.nodes[mechanism.gauges[d.dampers[0].gauge].node] == "A"
    assert (d.frictions[0].node, d.frictions[0].damping) == (mechanism.nodes.index("A"), 0.02)
    (release,) = d.releases
    assert release.free
    assert (release.start, release.speed) == pytest.approx((math.pi / 4, math.pi / 2))
    assert (release.effort.constant, release.effort.idle) == pytest.approx((8.0, 10 * math.pi))


def test_a_file_without_dynamic_sections_has_empty_dynamics(folder):
    mechanism = loaded(folder, FILE)
    assert mechanism.dynamics.empty
    assert mechanism.gauges == ()


def test_every_form_of_effort_is_compiled(folder):
    def effort(text):
        (release,) = loaded(folder, freed(text) + "masses: {rod: {mass: 1}}\n").dynamics.releases
        return release.effort

    assert effort("effort: 3").constant == 3.0
    assert effort("effort: {constant: 3}").constant == 3.0
    over_speed = effort("effort: {table: t.csv, over: speed}")
    assert over_speed.over == "speed"
    assert over_speed.curve(np.array([math.pi / 2])) == pytest.approx([2.0])
    over_time = effort("effort: {table: t.csv}")
    assert over_time.curve(np.array([90.0])) == pytest.approx([2.0])


def test_the_json_schema_covers_the_dynamic_sections():
    jsonschema = pytest.importorskip("jsonschema")
    schema = json_schema()
    valid = jsonschema.validators.validator_for(schema)(schema)
    good = {
        "nodes": {"O": [0, 0], "A": [0, 1]}, "ground": ["O"], "links": {"a": ["O", "A"]},
        "actuators": {"m": {"type": "rotary", "pivot": "O", "arm": "A", "free": True, "effort": 3, "start": 4}},
        "springs": {"s": {"pivot": "O", "arm": "A", "stiffness": 3}}, "friction": {"O": 0.1},
        "dampers": {"d": {"nodes": ["O", "A"], "damping": 3}},
        "loads": {"f": {"on": "a", "local": [0, 0], "follower": [1, 2], "table": "t.csv", "over": "m"}},
    }  # fmt: skip
    assert valid.is_valid(good)
    rated = {"pivot": "O", "arm": "A", "law": {"rate": "60 rpm", "turns": 2}}
    assert valid.is_valid({**good, "actuators": {"m": rated}, "masses": {"A": 2, "a": {"mass": 1}}})
    assert not valid.is_valid({**good, "actuators": {"m": {**rated, "law": {"rate": [60]}}}})
    assert not valid.is_valid({**good, "masses": {"A": [2]}})
    point = {"local": [0, 0]}
    assert valid.is_valid({**good, "points": {"P": {"member": "a", **point}}})
    assert not valid.is_valid({**good, "points": {"P": {"member": "a", "on": "a", **point}}})
    assert not valid.is_valid({**good, "points": {"P": point}})
    assert not valid.is_valid({**good, "springs": {"s": {"pivot": "O", "arm": "A"}}})
    assert not valid.is_valid({**good, "friction": {"O": True}})
    assert "N/m" in schema["$defs"]["Spring"]["properties"]["stiffness"]["description"]


ACTING = """\
masses:
  crank: {mass: 1.0, inertia: 0.0833, centre: [0.5, 0]}
gravity: [0, -9.81]
loads:
  push: {on: rod, at: [90, 0], force: [-50, 0]}
  press: {on: slider, local: [0, 0], force: [1, 0], table: press.csv, over: motor}
  screw: {on: rod, torque: 3}
springs:
  coil: {nodes: [A, C], stiffness: 200, free: 100}
  torsion: {pivot: B, arm: A, reference: C, stiffness: 3}
dampers:
  shock: {nodes: [A, C], damping: 15}
friction: {B: 0.02, slide: 5}
"""


def test_all_dynamic_sections_load_together(folder):
    (folder / "press.csv").write_text("angle,force\n0,100\n360,200\n")
    base = """\
units: {length: mm}
nodes: {O: [0, 0], A: [20, 0], B: [90, 0], C: [110, 0], G: [200, 0]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B], slider: [B, C]}
prismatic: {slide: {nodes: [B, C], guide: [O, G]}}
actuators: {motor: {type: rotary, pivot: O, arm: A}}
"""
    dynamics = loaded(folder, base + ACTING).dynamics
    assert [load.name for load in dynamics.loads] == ["push", "press", "screw"]
    assert [spring.name for spring in dynamics.springs] == ["coil", "torsion"]
    assert len(dynamics.frictions) == 2
