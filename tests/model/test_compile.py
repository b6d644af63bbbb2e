"""Compilation of a model to a mechanism: scale, units, signs, initial values."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
from bundled import EXPLICIT, FILES

from gimcli import load
from gimcli.mechanism import FRAME
from gimcli.model.json_schema import json_schema
from gimcli.model.source import read_source

PLAIN = """\
units: {length: mm}
nodes: {O: [100, 200], G: [400, 200], A: [100, 300], B: [400, 400]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B], rocker: {nodes: [G, B], length: 210}}
actuators:
  motor: {type: rotary, pivot: O, arm: A, law: {from: 90, to: 135}}
"""


@pytest.fixture
def compiled(tmp_path):
    def load_text(text, **files):
        for name, data in files.items():
            (tmp_path / f"{name}.csv").write_text(data)
        path = tmp_path / "m.yaml"
        path.write_text(text)
        return load(path)

    return load_text


def node(mechanism, name):
    return complex(mechanism.drawn[mechanism.nodes.index(name)])


def member(mechanism, name):
    return next(m for m in mechanism.members if m.name == name)


def law_ends(actuator):
    return actuator.law(np.array([0.0, 1.0])).tolist()


# -- scale and units -------------------------------------------------------------------------


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_the_scale_is_a_power_of_two_and_the_size_about_1(path):
    mechanism = load(path)
    assert math.frexp(mechanism.scale)[0] == 0.5
    assert 0.7 <= mechanism.size <= 1.5
    assert abs(complex(mechanism.drawn[mechanism.members[FRAME].nodes[0]])) < 1e-15


@pytest.mark.parametrize("path", EXPLICIT, ids=lambda p: p.stem)
def test_initial_positions_convert_back_to_the_files_coordinates(path):
    mechanism = load(path)
    data = read_source(path).data["nodes"]
    given = [k for k, xy in enumerate(data.values()) if isinstance(xy, list)]  # the others have no coordinates
    places = np.array([complex(*xy) for xy in data.values() if isinstance(xy, list)])
    assert np.max(np.abs(mechanism.to_file(mechanism.drawn)[given] - places)) <= 4e-16 * np.max(np.abs(places))


def test_values_of_actuators_convert_back_to_the_files_units(compiled):
    mechanism = compiled(PLAIN + "  jack: {type: linear, nodes: [O, B], law: {from: 300, to: 350}}\n")
    assert mechanism.value_from_file(0, 90.0) == pytest.approx(math.pi / 2, rel=1e-15)
    assert mechanism.value_from_file(1, 300.0) * mechanism.scale == 300.0
    values = np.array([-720.0, 0.0, 33.3])
    for k in (0, 1):
        there = np.array([mechanism.value_from_file(k, v) for v in values])
        assert mechanism.value_to_file(k, there) == pytest.approx(values, rel=1e-15)


def test_radians(compiled):
    text = PLAIN.replace("length: mm", "length: mm, angle: rad").replace("from: 90, to: 135", "from: 1.5, to: 2.5")
    assert law_ends(compiled(text).actuators[0]) == [1.5, 2.5]


def test_scaling_and_shifting_a_file_by_powers_of_two_changes_nothing(compiled):
    one = compiled(PLAIN)
    text = PLAIN.replace("[100, 200]", "[0, 0]").replace("[400, 200]", "[1200, 0]").replace("[100, 300]", "[0, 400]")
    other = compiled(text.replace("[400, 400]", "[1200, 800]").replace("210", "840"))
    assert np.array_equal(one.drawn, other.drawn)
    assert other.scale == 4.0 * one.scale
    for a, b in zip(one.members[1:], other.members[1:], strict=True):
        assert np.array_equal(a.shape, b.shape)


def test_unused_nodes_are_left_out(compiled):
    mechanism = compiled(PLAIN.replace("O: [100, 200]", "Z: [1e6, 1e6], O: [100, 200], Y: [0, 0]"))
    assert mechanism.nodes == ("O", "G", "A", "B")
    assert mechanism.traced == ("A", "B")


# -- members ---------------------------------------------------------------------------------


def test_a_given_length_replaces_the_one_from_the_coordinates(compiled):
    mechanism = compiled(PLAIN)
    assert member(mechanism, "rocker").shape.tolist() == [0.0, 210.0 / mechanism.scale]
    drawn = math.hypot(300.0, 100.0) / mechanism.scale
    assert abs(member(mechanism, "rod").shape[1]) == pytest.approx(drawn, rel=1e-15)


def test_an_element_with_a_shape_does_not_depend_on_the_coordinates(compiled):
    shape = "{A: [10, 10], B: [10, 13], C: [6, 10]}"  # A to B points up: C lies 4 to the left
    for drawing in ("A: [0, 1], B: [9, 9], C: [5, 5]", "A: [0, 1], B: [0, 1], C: [0, 1]"):
        mechanism = compiled(
            f"nodes: {{O: [0, 0], {drawing}}}\nground: [O]\nlinks: {{l: {{nodes: [O, A], length: 1}}}}\n"
            f"elements: {{e: {{nodes: [A, B, C], shape: {shape}}}}}\n"
        )
        got = member(mechanism, "e").shape * mechanism.scale
        assert got == pytest.approx([0, 3, 4j], abs=1e-14)


def test_an_element_keeps_its_orientation(compiled):
    mechanism = compiled("nodes: {A: [0, 0], B: [0, 2], C: [1, 1]}\nground: [A]\nelements: {e: [A, B, C]}\n")
    assert member(mechanism, "e").shape * mechanism.scale == pytest.approx([0, 2, 1 - 1j], abs=1e-15)


def test_a_held_member_keeps_its_initial_position(compiled):
    mechanism = compiled(
        "nodes: {A: [5, 1], B: [5, 4], C: [3, 2], D: [9, 9]}\nground: {member: h}\n"
        "elements: {h: [A, B, C]}\nlinks: {a: [B, D]}\n"
        "points: {P: {on: h, local: [1, 2]}, Q: {on: h, at: [7, 7]}, R: {on: ground, at: [7, 7]}}\n"
    )
    frame = mechanism.members[FRAME]
    assert mechanism.floating
    assert frame.name == "h"
    assert [m.name for m in mechanism.members] == ["h", "a"]
    assert mechanism.to_file(frame.shape) == pytest.approx([5 + 1j, 5 + 4j, 3 + 2j], abs=1e-14)
    places = mechanism.to_file(np.array([p.local for p in mechanism.points]))  # local to the frame: as drawn
    assert places == pytest.approx([3 + 2j, 7 + 7j, 7 + 7j], abs=1e-14)


def test_a_held_member_of_given_length_keeps_its_first_node_and_direction(compiled):
    mechanism = compiled(
        "nodes: {A: [5, 1], B: [5, 4], D: [9, 9]}\nground: {member: h}\n"
        "links: {h: {nodes: [A, B], length: 10}, a: [B, D]}\n"
    )
    assert mechanism.to_file(mechanism.members[FRAME].shape) == pytest.approx([5 + 1j, 5 + 11j], abs=1e-14)


# -- slides and points -----------------------------------------------------------------------


@pytest.mark.parametrize(("guide", "place"), [("[O, G]", 0.3 + 2j), ("[G, O]", 0.3 - 2j), ("[O, U]", -2 + 0.3j)])
def test_an_offset_lies_to_the_left_of_the_guides_direction(guide, place, compiled):
    mechanism = compiled(
        "nodes: {O: [0, 0], G: [4, 0], U: [0, 4], A: [1, 1], B: [2, 2]}\nground: [O, G, U]\n"
        f"links: {{c: [O, A], r: [A, B]}}\nprismatic: {{s: {{node: B, guide: {guide}, offset: 2}}}}\n"
    )
    (slide,) = mechanism.slides
    away = place / mechanism.scale - slide.point
    assert (away * slide.along.conjugate()).imag == pytest.approx(0.0, abs=1e-15)  # on the line
    assert abs(slide.along) == pytest.approx(1.0, rel=1e-15)


def test_a_prismatic_pair_of_a_member_is_two_slides(compiled):
    mechanism = compiled(
        "nodes: {O: [0, 0], G: [4, 0], A: [1, 1], B: [2, 1]}\nground: [O, G]\nlinks: {r: [A, B]}\n"
        "prismatic: {s: {nodes: [A, B], guide: [O, G], offset: 1}}\n"
    )
    assert [mechanism.nodes[s.node] for s in mechanism.slides] == ["A", "B"]
    assert {s.pair for s in mechanism.slides} == {"s"}
    assert len({s.name for s in mechanism.slides}) == 2


def test_points_at_and_local_agree(compiled):
    text = PLAIN + "points: {P: {on: rod, at: [160, 380]}, Q: {on: rod, local: [LOCAL]}}\n"
    along = (300 + 100j) / abs(300 + 100j)
    local = (60 + 80j) / along
    mechanism = compiled(text.replace("LOCAL", f"{local.real!r}, {local.imag!r}"))
    p, q = (p.local for p in mechanism.points)
    assert p == pytest.approx(q, rel=1e-14)
    assert p * mechanism.scale == pytest.approx(local, rel=1e-14)


def test_default_of_trace(compiled):
    assert compiled(PLAIN).traced == ("A", "B")
    assert compiled(PLAIN + "points: {P: {on: rod, local: [1, 2]}}\n").traced == ("P",)
    assert compiled(PLAIN + "points: {P: {on: rod, local: [1, 2]}}\ntrace: [B]\n").traced == ("B",)


# -- actuators -------------------------------------------------------------------------------

FOUR = """\
nodes: {O: [0, 0], G: [3, 0], A: [0, 2], B: [3, 4]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B], rocker: [G, B]}
actuators:
"""

DRAWN = {  # the actuator, its drawn value in the file's units
    "angle from the frame": ("{type: rotary, pivot: O, arm: A}", 90.0),
    "angle of the other crank": ("{type: rotary, pivot: G, arm: B}", 90.0),
    "angle from a frame node": ("{type: rotary, pivot: O, arm: A, reference: G}", 90.0),
    "angle between moving members": (
        "{type: rotary, pivot: A, arm: B, reference: O}",
        90.0 + math.degrees(math.atan2(2, 3)),
    ),
    "the same, seen from the other member": (
        "{type: rotary, pivot: A, arm: O, reference: B}",
        -90.0 - math.degrees(math.atan2(2, 3)),
    ),
    "distance": ("{type: linear, nodes: [O, B]}", 5.0),
    "travel": ("{type: linear, node: B, guide: [O, G]}", 3.0),
    "travel in the opposite direction": ("{type: linear, node: B, guide: [G, O]}", 0.0),
    "travel on a moving guide": ("{type: linear, node: B, guide: [O, A]}", 4.0),
}  # fmt: skip


@pytest.mark.parametrize("case", DRAWN)
def test_initial_values(case, compiled):
    text, value = DRAWN[case]
    mechanism = compiled(f"{FOUR}  m: {text}\n")
    (actuator,) = mechanism.actuators
    got = float(mechanism.value_to_file(0, np.array([actuator.drawn]))[0])
    assert got == pytest.approx(value, abs=1e-13)
    start, end = mechanism.value_to_file(0, np.array(law_ends(actuator)))
    turn = 360.0 if actuator.rotary else 0.0
    assert start == pytest.approx(value, abs=1e-13)
    assert end == pytest.approx(value + turn, abs=1e-13)


@pytest.mark.parametrize("case", DRAWN)
def test_an_increment_starts_at_the_initial_value(case, compiled):
    text, value = DRAWN[case]
    mechanism = compiled(f"{FOUR}  m: {text[:-1]}, law: {{by: 1.5, profile: cubic}}}}\n")
    ends = mechanism.value_to_file(0, np.array(law_ends(mechanism.actuators[0])))
    assert ends == pytest.approx([value, value + 1.5], abs=1e-13)


def test_the_initial_value_of_a_rotary_actuator_is_the_angle_between_its_rays(compiled):
    mechanism = compiled(f"{FOUR}  m: {{type: rotary, pivot: A, arm: B, reference: O}}\n")
    (actuator,) = mechanism.actuators
    rays = [node(mechanism, n) - node(mechanism, "A") for n in ("B", "O")]
    assert actuator.drawn == pytest.approx(cmath.phase(rays[0] / rays[1]), abs=1e-15)
    assert mechanism.members[actuator.members[0]].name == "rod"
    assert mechanism.members[actuator.guide].name == "crank"


@pytest.mark.parametrize(
    "profile", ["uniform", "cubic", "quintic", "cycloidal", "harmonic", "{polynomial: [0, 0.5, 0.5]}"]
)
def test_ends_of_a_law_are_exact(profile, compiled):
    mechanism = compiled(
        f"{FOUR}  m: {{type: rotary, pivot: O, arm: A, law: {{from: 33.3, to: 400.1, profile: {profile}}}}}\n"
        f"  n: {{type: linear, nodes: [O, B], law: {{from: 4.7, to: 5.9, profile: {profile}}}}}\n"
    )
    degree = math.pi / 180.0
    assert law_ends(mechanism.actuators[0]) == [33.3 * degree, 400.1 * degree]
    back = mechanism.value_to_file(1, np.array(law_ends(mechanism.actuators[1])))
    assert back.tolist() == [4.7, 5.9]


def test_an_absolute_polynomial(compiled):
    mechanism = compiled(f"{FOUR}  m: {{type: rotary, pivot: O, arm: A, law: {{polynomial: [90, 10, 20]}}}}\n")
    values = mechanism.value_to_file(0, mechanism.actuators[0].law(np.array([0.0, 0.5, 1.0])))
    assert values == pytest.approx([90.0, 100.0, 120.0], rel=1e-14)


def test_a_table_sets_values_and_duration(compiled):
    text = f"{FOUR}  m: {{type: rotary, pivot: O, arm: A, law: {{table: t.csv}}}}\n"
    mechanism = compiled(text, t="time,angle\n2,90\n3,120\n4.5,100\n")
    assert mechanism.duration == 2.5
    values = mechanism.value_to_file(0, mechanism.actuators[0].law(np.array([0.0, 0.4, 1.0])))
    assert values == pytest.approx([90.0, 120.0, 100.0], rel=1e-14)


def test_duration(compiled):
    assert compiled(PLAIN).duration == 1.0
    assert compiled(PLAIN + "duration: 2.5\n").duration == 2.5


# -- the JSON Schema -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def validator():
    jsonschema = pytest.importorskip("jsonschema")
    schema = json_schema()
    kind = jsonschema.validators.validator_for(schema)
    kind.check_schema(schema)
    return kind(schema)


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_the_json_schema_accepts_the_models(path, validator):
    assert list(validator.iter_errors(read_source(path).data)) == []


WRONG = {
    "top": lambda data: data.update(lnks={}),
    "link": lambda data: data["links"]["crank"].update(lenght=3),
    "law": lambda data: data["actuators"]["motor"]["law"].update(profle="cubic"),
    "law as in python": lambda data: data["actuators"]["motor"]["law"].update(from_=3),
    "no ground": lambda data: data.pop("ground"),
    "negative length": lambda data: data["links"]["crank"].update(length=-1),
    "three nodes in a link": lambda data: data["links"].update(crank=["A", "B", "C"]),
    "unknown profile": lambda data: data["actuators"]["motor"]["law"].update(profile="cubik"),
    "truth value as a coordinate": lambda data: data["nodes"].update(A=[0, True]),
}


@pytest.mark.parametrize("case", WRONG)
def test_the_json_schema_rejects(case, validator):
    data = read_source(next(p for p in FILES if p.stem == "crank_rocker")).data
    WRONG[case](data)
    assert list(validator.iter_errors(data)) != []


@pytest.mark.parametrize("law", [
    {"from": 1, "to": 2, "profile": "cubic"}, {"by": 1, "polynomial": [0, 1]}, {"table": "t.csv"}, {},
    {"profile": {"polynomial": [1, 2]}},
])  # fmt: skip
def test_the_json_schema_accepts_every_form_of_a_law(law, validator):
    data = read_source(next(p for p in FILES if p.stem == "crank_rocker")).data
    data["actuators"]["motor"]["law"] = law
    data["links"] |= {"more": [1, "B"], "long": {"nodes": [1, "B"], "length": 3}}
    data["name"] = 2024
    data["ground"] = {"member": "coupler"}
    assert list(validator.iter_errors(data)) == []
