"""Mechanisms written for PMKS and PMKS+ and read back move like the original."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import gimcli
from gimcli import ModelError
from gimcli.exchange.assembling import model_of
from gimcli.exchange.draft import Draft
from gimcli.exchange.drawn_linkage import DrawnLinkage
from gimcli.exchange.pmks_plus import PROGRAM, PlusDraft, payload_of
from gimcli.exchange.pmks_plus_writer import PlusDrawing
from gimcli.exchange.registry import draft_of
from gimcli.shipped import names

DATA = Path(__file__).parent / "data"
MODELS = names()
LOCKED = "dixon_k33"
"""Moves at its exact dimensions only: three decimals of PMKS+ lock it, as the writer warns."""

OFFSET = float(np.imag(40 * np.conj((70 + 10j) / abs(70 + 10j))))  # of the pin from the line A-B

CROSSED = {
    "name": "crank with a slot over a fixed pin",
    "units": {"length": "mm"},
    "nodes": {"O": [0, 0], "A": [20, 0], "B": [90, 10], "P": [60, 0]},
    "ground": ["O", "P"],
    "links": {"crank": ["O", "A"], "blade": ["A", "B"]},
    "prismatic": {"slot": {"node": "P", "guide": ["A", "B"], "offset": OFFSET}},
    "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
}
BLOCK = {
    "name": "block with two pins",
    "units": {"length": "in"},
    "nodes": {
        "O": [0, 0],
        "A": [2, 0],
        "B": [9, 0],
        "C": [11, 0],
        "G": [20, 0],
        "D": [11, 3],
        "E": [14, 4],
        "F": [17, 5],
    },
    "ground": ["O", "G", "E", "F"],
    "links": {"crank": ["O", "A"], "rod": ["A", "B"], "slider": ["B", "C"], "arm": ["C", "D"]},
    "prismatic": {
        "slide": {"nodes": ["B", "C"], "guide": ["O", "G"]},
        "wall": {"node": "D", "guide": ["E", "F"]},
    },
    "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"by": -180}}},
    "duration": 2,
}
LIFT = {
    "name": "lift driven by its height",
    "nodes": {"L": [0, 0], "F": [1.5, 0], "V": [0, 1], "R": [1.04, 0], "T": [1.04, 0.6], "M": [0.52, 0.3]},
    "ground": ["L", "F", "V"],
    "elements": {"rising": ["L", "M", "T"]},
    "links": {"falling": ["M", "R"]},
    "prismatic": {"floor": {"node": "R", "guide": ["L", "F"]}},
    "actuators": {"height": {"type": "linear", "node": "T", "guide": ["L", "V"], "law": {"from": 0.6, "to": 0.9}}},
}
FEED = {
    "name": "rod pushed by its pin in a slot",
    "units": {"length": "ft"},
    "nodes": {"A": [1, 0], "B": [0, 1], "O": [0, 0], "X": [4, 0], "C": [-1, 2]},
    "ground": ["O", "X", "C"],
    "links": {"rod": ["A", "B"], "arm": ["B", "C"]},
    "prismatic": {"slide": {"node": "A", "guide": ["O", "X"]}},
    "actuators": {"feed": {"type": "linear", "node": "A", "guide": ["O", "X"], "law": {"by": -0.3}}},
}
OWN = {"crossed": CROSSED, "block": BLOCK, "lift": LIFT, "feed": FEED}


def mechanism(name):
    return gimcli.load(OWN[name]) if name in OWN else gimcli.load(name)


def drawn_linkage(m):
    found = gimcli.solve(m)
    return DrawnLinkage(m, np.array([complex(*found.xy[name]) for name in m.nodes]), PROGRAM)


def same_motion(m, back: Draft, factor, tolerance):
    """Compare all nodes that both have, at the rows of a motion; inputs are relative to the start."""
    rows = gimcli.trace(m, steps=4)
    data = model_of(back)
    uniform = True
    for actuator, (name, own) in zip(m.actuators, data["actuators"].items(), strict=True):
        change = rows[actuator.name] - rows[actuator.name][0]
        uniform &= np.allclose(change, np.linspace(0, change[-1], 5))
        unit = 1.0 if actuator.rotary and m.angle_unit == "deg" else np.degrees(1) if actuator.rotary else factor
        by = math.copysign(change[-1] * unit, own["law"]["by"])  # the direction is that of the speed in the file
        data["actuators"][name] = {**own, "law": {"by": by}}
    copy = gimcli.load(data)
    again = gimcli.trace(copy, steps=4)
    known, places = (np.array([one.xy[node] @ [1.0, 1.0j] for node in one.mechanism.nodes]) for one in (again, rows))
    known /= factor
    compared = [k for k in ((0, 1, 2, 3, 4) if uniform else (0, 4)) if rows.status[k] == "ok"]
    assert len(compared) > 1
    for node, path in zip(m.nodes, places, strict=True):
        starts = abs(known[:, 0] - path[0])
        near = known[starts <= starts.min() + 2 * tolerance][:, compared]
        # guides of the ground, and tracers, have no node; another one may be near them at the start
        if starts.min() > 2 * tolerance or m.nodes.index(node) in m.members[0].nodes:
            continue
        assert abs(near - path[compared]).max(axis=1).min() <= tolerance, node
    return copy


@pytest.mark.few(12)
@pytest.mark.parametrize("name", [*OWN, *MODELS])
def test_pmks_text_keeps_all_digits(name):
    m = mechanism(name)
    if len(m.actuators) > 1:
        with pytest.raises(ModelError):
            gimcli.convert(m, "pmks")
        return
    found = gimcli.convert(m, "pmks")
    copy = same_motion(m, draft_of(found.text, name), 1.0, 1e-9 * m.size * m.scale)
    sentences = " ".join(found.left_out)
    assert copy.duration == pytest.approx(m.duration) or "the law of" in sentences


@pytest.mark.few(12)
@pytest.mark.parametrize("name", [*OWN, *MODELS])
def test_the_drawing_for_pmks_plus_is_the_same_mechanism(name):
    """Before its numbers are rounded to thousandths."""
    m = mechanism(name)
    drawing = PlusDrawing(drawn_linkage(m))
    same_motion(m, PlusDraft(drawing.document, name).draft, drawing.factor, 1e-8 * m.size * m.scale)


@pytest.mark.few(12)
@pytest.mark.parametrize("name", [*OWN, *MODELS])
def test_an_address_keeps_thousandths(name):
    m = mechanism(name)
    drawing = PlusDrawing(drawn_linkage(m))
    back = draft_of(gimcli.convert(m, "pmks+").text, name)
    size = m.size * m.scale
    for joint in drawing.document.joints:
        place = back.joints.get(joint.name)
        if place is not None and [one.name for one in drawing.document.joints].count(joint.name) == 1:
            assert abs(complex(*place) - complex(joint.x, joint.y)) <= 0.00071
    if name == LOCKED:
        assert any("lock" in sentence for sentence in drawing.drawn.left_out)
        return
    same_motion(m, back, drawing.factor, 2e-3 * size)


def test_a_file_has_what_the_address_has_behind_the_question_mark():
    m = gimcli.load("crank_rocker")  # which has a point P, as the types of PMKS text are named
    text = gimcli.convert(m, "pmks+file").text
    assert text.strip() == payload_of(gimcli.convert(m, "pmks+").text)
    assert draft_of(text, "a.pmks").program == PROGRAM


def test_masses_forces_and_units_come_back():
    """Numbers by hand: 2 lb are 907.18474 g, 0.5 kg m^2 are 5000 kg cm^2, the force turns with the rod."""
    data = {
        **{key: value for key, value in BLOCK.items() if key in ("nodes", "ground", "actuators")},
        "units": {"length": "mm", "mass": "lb"},
        "links": {"crank": ["O", "A"], "rod": ["A", "B"]},
        "prismatic": {"slide": {"node": "B", "guide": ["O", "G"]}},
        "masses": {"rod": {"mass": 2, "inertia": 0.5, "centre": [3, 1]}},
        "gravity": [0, -9.81],
        "loads": {"push": {"on": "rod", "at": [5, 0], "follower": [0, 12]}, "twist": {"on": "rod", "torque": 3}},
    }
    found = gimcli.convert(gimcli.load(data), "pmks+")
    assert any("twist" in sentence and "torque" in sentence for sentence in found.left_out)
    back = model_of(draft_of(found.text, "x"))
    assert back["units"] == {"length": "cm", "mass": "g"}
    rod = back["masses"]["rod"]
    assert rod["mass"] == pytest.approx(907.185, abs=1e-3)
    assert rod["inertia"] == pytest.approx(0.5)
    assert rod["centre"] == pytest.approx([0.3, 0.1])
    assert back["loads"] == {"push": {"on": "rod", "at": [0.5, 0.0], "follower": pytest.approx([0, 12])}}
    assert back["gravity"] == [0, -9.80665]


def test_the_mass_of_a_slider_comes_back():
    original = (DATA / "pmks_plus_punch_press.pmks").read_text(encoding="utf-8")
    again = gimcli.convert(gimcli.load(model_of(draft_of(original, "x"))), "pmks+").text
    first, second = (model_of(draft_of(text, "x")) for text in (original, again))
    assert second["masses"].keys() == first["masses"].keys() == {"Crank", "Connecting rod", "C"}
    for name, own in first["masses"].items():
        assert second["masses"][name]["mass"] == pytest.approx(own["mass"])
        assert second["masses"][name].get("inertia") == pytest.approx(own.get("inertia"))
    assert second["loads"]["F1"]["force"] == pytest.approx(first["loads"]["F1"]["force"])


def test_a_point_mass_at_a_pin_is_joined_to_a_link():
    """2 kg in the middle of 0.4 m and 1 kg at the end: centre at 0.8/3, inertia 2 (0.2 - c)^2 + (0.4 - c)^2."""
    data = {
        "nodes": {"O": [0, 0], "A": [0.4, 0], "B": [1, 0.3], "P": [1, 0]}, "ground": ["O", "P"],
        "links": {"crank": ["O", "A"], "rod": ["A", "B"], "arm": ["B", "P"]},
        "masses": {"crank": {"mass": 2, "inertia": 0, "centre": [0.2, 0]}, "A": {"mass": 1}}, "gravity": [0, -9.81],
        "loads": {"pull": {"on": "B", "force": [3, 4]}},
    }  # fmt: skip
    back = model_of(draft_of(gimcli.convert(gimcli.load(data), "pmks+").text, "x"))
    centre = 0.8 / 3
    inertia = 2 * (0.2 - centre) ** 2 + (0.4 - centre) ** 2
    expected = {"mass": 3, "inertia": pytest.approx(inertia, abs=1e-3), "centre": pytest.approx([centre, 0], abs=1e-3)}
    assert back["masses"] == {"crank": expected}
    assert back["loads"]["pull"] == {"on": "rod", "at": [1.0, 0.3], "force": pytest.approx([3, 4])}


def test_cylinders_keep_their_strokes():
    """The laws of the excavator run from 185 to 140, 145 to 210 and 125 to 160 cm, all in the same time."""
    m = gimcli.load("excavator")
    back = model_of(draft_of(gimcli.convert(m, "pmks+").text, "x"))
    assert [own["law"]["by"] for own in back["actuators"].values()] == pytest.approx([-45, 65, 35], abs=5e-3)
    assert back["duration"] == pytest.approx(m.duration, rel=1e-3)


@pytest.mark.parametrize("change", [-30, 25])
def test_a_cylinder_moves_to_the_end_of_its_law(change):
    data = {
        "units": {"length": "mm"}, "nodes": {"O": [0, 0], "P": [-40, 0], "A": [60, 80]}, "ground": ["O", "P"],
        "links": {"boom": ["O", "A"]}, "duration": 2,
        "actuators": {"ram": {"type": "linear", "nodes": ["P", "A"], "law": {"by": change}}},
    }  # fmt: skip
    back = model_of(draft_of(gimcli.convert(gimcli.load(data), "pmks+").text, "x"))
    assert next(iter(back["actuators"].values()))["law"]["by"] == pytest.approx(change / 10, abs=2e-3)
    assert back["duration"] == pytest.approx(2, abs=2e-3)


def test_names_that_the_formats_cannot_hold_are_changed():
    data = {
        "nodes": {"O, left": [0, 0], "A.1": [1, 0], "Ä*~": [3, 1], "P": [4, 0]},
        "ground": ["O, left", "P"],
        "links": {"ground link": ["O, left", "A.1"], "0": ["A.1", "Ä*~"], "arm": ["Ä*~", "P"]},
        "actuators": {"motor": {"type": "rotary", "pivot": "O, left", "arm": "A.1", "law": {"by": 40}}},
    }
    m = gimcli.load(data)
    for to in ("pmks", "pmks+"):
        same_motion(m, draft_of(gimcli.convert(m, to).text, "x"), 1.0 if to == "pmks" else 100.0, 2e-3)


def test_the_speed_of_a_law_is_written():
    m = gimcli.load({**BLOCK, "duration": 0.5})  # half a revolution backwards in half a second: -60 rpm
    assert gimcli.convert(m, "pmks").text.startswith("set=s-60\n")
    back = draft_of(gimcli.convert(m, "pmks+").text, "x")
    assert back.duration == pytest.approx(1)
    assert back.turns[0].keys["law"]["by"] == pytest.approx(-360)


def test_the_mass_of_a_piston_and_a_force_at_a_node_come_back():
    """PMKS+ has the mass of a block, and forces on links; the crank torque is that of the original."""
    engine = gimcli.loads("""
units: {length: cm}
nodes: {O: [0, 0], A: [5, 0], B: [25, 0], G: [100, 0]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B]}
prismatic: {slide: {node: B, guide: [O, G]}}
actuators: {motor: {pivot: O, arm: A, law: {rate: 60 rpm}}}
masses: {B: 0.8, A: 0.2}
loads: {gas: {on: B, force: [-100, 0]}}
""")
    sent = gimcli.convert(engine, to="pmks+")
    assert not [sentence for sentence in sent.left_out if "mass" in sentence]  # that of A belongs to the crank
    back = gimcli.forces(gimcli.load(sent.text.strip()), steps=6)
    own = gimcli.forces(engine, steps=6)
    assert back["motor.effort"] == pytest.approx(own["motor.effort"], abs=1e-9)
