"""The format as it was first published: every example of it still loads, and means what it meant."""

from pathlib import Path

import pytest

from gimcli import load, loads
from gimcli.mechanism import ANGLE, HEIGHT, SPAN
from gimcli.model.source import read_yaml

BASE = """\
name: Slider-crank with a coupler point
source: where the dimensions come from          # optional, free text
units: {length: mm, angle: deg, mass: kg}       # default: length m, angle deg, mass kg; `unit` = no physical unit

nodes:                    # drawn position
  O: [0, 0]
  A: [20, 0]
  B: [90, 0]
  G: [200, 0]

ground: [O, G]            # nodes fixed to the frame

links:                    # binary members: two nodes
  crank: [O, A]                            # length taken from the drawn position
  rod:   {nodes: [A, B], length: 70}       # or given: then the drawing is only a first guess
"""
MORE = """\
nodes: {C: [50, 30], P: [0, 50], Q: [40, 50], R: [35, 70], S: [5, 72], U: [0, 80], V: [100, 80]}
ground: [O, G, U, V]
"""
BODY = """\
elements:
  body:                                    # or given in the member's own frame: then the drawing is only a first guess
    nodes: [P, Q, R, S]
    shape: {P: [0, 0], Q: [40, 0], R: [35, 20], S: [5, 22]}
"""
PIECES = {
    "element": MORE + "elements:\n  plate: [A, B, C]                         # shape taken from the drawn position\n",
    "element with a shape": MORE + BODY,
    "pin in a slot": "prismatic:\n  slide: {node: B, guide: [O, G]}          # B stays on the line O-G\n",
    "true prismatic pair": MORE + BODY + "prismatic:\n  ram:   {nodes: [P, Q], guide: [U, V]}    # both nodes\n",
    "offset": MORE + BODY + "prismatic:\n  ram:   {nodes: [P, Q], guide: [U, V], offset: -30}\n",
    "rotary": """\
actuators:
  motor:
    type: rotary
    pivot: O                               # angle of the ray pivot -> arm ...
    arm: A
    reference: G                           # ... measured from the ray pivot -> reference
    law: {from: 0, to: 360}
""",
    "distance": MORE + BODY + """\
actuators:
  jack:
    type: linear
    nodes: [O, P]                          # the distance O-P
    law: {from: 100, to: 140, profile: quintic}
""",
    "travel": """\
actuators:
  table:
    type: linear
    node: B                                # the travel of B along a guide
    guide: [O, G]
    law: {from: 60, to: 90}
""",
    "points": """\
points:                   # points carried by a member; they cost nothing in the solution
  P: {on: rod, at: [50, 30]}               # drawn position
  Q: {on: rod, local: [35, 10]}            # along, and to the left of, the member's first node -> second node

trace: [P, B]             # what is written out
duration: 2               # seconds for the whole motion
""",
    "dynamics": """\
masses:
  crank: {mass: 1.0, inertia: 0.0833, centre: [0.5, 0]}   # inertia about the centre of mass, kg m2
gravity: [0, -9.81]                        # m/s2
loads:
  push: {on: rod, at: [90, 0], force: [-50, 0]}            # N, in the frame
  twist: {on: rod, torque: 3}                              # N m
""",
}  # fmt: skip


def joined(piece):
    """Return the mechanism of the first part of the example and a piece of the rest."""
    data = read_yaml(BASE, Path("base")).data
    for key, value in read_yaml(piece, Path("piece")).data.items():
        data[key] = {**data[key], **value} if isinstance(data.get(key), dict) else value
    return load(data)


def test_the_first_part_loads(tmp_path):
    (tmp_path / "model.yaml").write_text(BASE)
    mechanism = load(tmp_path / "model.yaml")
    assert mechanism.nodes == ("O", "A", "B", "G")
    assert mechanism.length_unit == "mm"


@pytest.mark.parametrize("name", PIECES)
def test_a_piece_loads(name):
    joined(PIECES[name])


def test_the_pieces_mean_what_they_meant():
    kinds = {"rotary": ANGLE, "distance": SPAN, "travel": HEIGHT}
    for name, kind in kinds.items():
        (actuator,) = joined(PIECES[name]).actuators
        assert actuator.kind == kind
    assert len(joined(PIECES["true prismatic pair"]).pairs) == 2
    assert joined(PIECES["points"]).duration == 2.0
    assert joined(PIECES["points"]).traced == ("P", "B")


@pytest.mark.parametrize(
    "law",
    [
        "{from: 0, to: 360}", "{by: 30}", "{by: 30, profile: uniform}", "{by: 30, profile: cubic}",
        "{by: 30, profile: quintic}", "{by: 30, profile: cycloidal}", "{by: 30, profile: harmonic}",
        "{polynomial: [0, 30, 40]}", "{table: file.csv}", "{profile: {polynomial: [0, 30, 40]}}",
        "{profile: {table: file.csv}}",
    ],
)  # fmt: skip
def test_a_law_loads(law, tmp_path):
    (tmp_path / "file.csv").write_text("0,0\n2,90\n")
    (tmp_path / "model.yaml").write_text(f"{BASE}actuators: {{m: {{type: rotary, pivot: O, arm: A, law: {law}}}}}\n")
    load(tmp_path / "model.yaml")


def test_a_floating_mechanism_loads():
    mechanism = loads(BASE.replace("ground: [O, G] ", "ground: {member: rod} ") + "prismatic:\n")
    assert mechanism.floating


@pytest.mark.parametrize("long", ["crank: {nodes: [O, A]}", "crank: [O, A]"])
def test_short_and_long_forms_are_the_same(long):
    assert loads(BASE.replace("crank: [O, A]", long)).members[1].name == "crank"
