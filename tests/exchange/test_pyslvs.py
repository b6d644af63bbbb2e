"""Files and expressions of Pyslvs: positions against values decoded by hand from the text, and closed forms."""

from __future__ import annotations

import random
from contextlib import suppress

import numpy as np
import pytest

import gimcli
from gimcli.exchange.assembling import model_of
from gimcli.exchange.pyslvs import read, recognises

FOUR_BAR = """# a crank-rocker
M[
  J[R, color[Green], P[0.0, 0.0], L[ground, crank]],
  J[R, color[(10, 20, 30)], P[0, 1], L[crank, rod]],
  J[R, P[3, 2], L[rod, rocker]], J[R, P[4, 0], L[ground, rocker]],
  J[R, color[Blue], P[1, 2], L[rod]],  # draws a path
  J[R, P[9, 9], L[]],
] # the end, M[J["""


def saved(mechanism: str, inputs: str = "", more: str = "") -> str:
    """The text of a file as the program writes it, its keys in alphabetical order."""
    lines = ["file_type: 0", "input:" if inputs else "", inputs, "links:", "  ground: White", "  crank: Blue"]
    lines += [f"mechanism: {mechanism}" if mechanism else "", more, "pyslvs_ver: 22.7.0"]
    return "\n".join(line for line in lines if line) + "\n"


ONE_LINE = " ".join(line.split("#")[0].strip() for line in FOUR_BAR.splitlines()).strip()
PAIR = "- - 0\n  - 1"
CRANK = "J[R, P[0, 0], L[ground, L1]], J[R, P[0, 1], L[L1, L2]]"


def loaded(text: str, tmp_path):
    path = tmp_path / "drawing.pyslvs"
    path.write_text(text)
    return gimcli.load(path)


def left(a: complex, ra: float, b: complex, rb: float) -> complex:
    """The point at two distances, to the left of the line from a to b."""
    d = abs(b - a)
    x = (ra**2 - rb**2 + d**2) / (2 * d)
    return a + (b - a) / d * (x + 1j * np.sqrt(ra**2 - x**2))


def points(trace, name: str) -> np.ndarray:
    return trace.xy[name] @ [1, 1j]


@pytest.mark.parametrize("text", [
    saved(ONE_LINE, PAIR),
    saved(ONE_LINE.replace("J[R, P[3, 2]", "\n  J[R, P[3, 2]"), PAIR),  # a folded line
    f"{{input: [[0, 1]], mechanism: '{ONE_LINE}', path: {{a: [[[0, 1]]]}}, pyslvs_ver: '20.08.0'}}",
    saved(ONE_LINE, "- - 1\n  - 0\n  - 90.0"),
])  # fmt: skip
def test_a_four_bar_turns_once_counter_clockwise(tmp_path, text):
    t = gimcli.trace(loaded(text, tmp_path), steps=8)
    b = 1j * np.exp(1j * np.radians(45 * np.arange(9)))
    assert points(t, "Point1") == pytest.approx(b, abs=1e-9)
    c = np.array([left(one, np.hypot(3, 1), 4, np.hypot(1, 2)) for one in b])
    assert points(t, "Point2") == pytest.approx(c, abs=1e-9)
    assert points(t, "Point4") == pytest.approx(b + (1 + 1j) / (3 + 1j) * (c - b), abs=1e-9)
    assert t["motor"] == pytest.approx(90 + 45 * np.arange(9))  # the angle of Point0 -> Point1


def test_an_expression_alone_has_no_input(tmp_path):
    m = loaded(FOUR_BAR, tmp_path)
    assert gimcli.mobility(m).mobility == 1
    assert m.drawn[m.nodes.index("Point2")] * m.scale == pytest.approx(3 + 2j - m.origin)


def test_the_block_of_a_p_joint_does_not_turn(tmp_path):
    text = f"M[{CRANK}, J[P, A[30], P[4, 1], L[ground, L3]], J[R, P[4, 2], L[L3, L2]], J[R, P[5, 1], L[L3]]]"
    t = gimcli.trace(loaded(saved(text, PAIR), tmp_path), steps=6)
    b = 1j * np.exp(1j * np.radians(60 * np.arange(7)))
    u = np.exp(1j * np.radians(30))  # the pin of rod and block moves along this direction from 4 + 2i
    along = ((b - (4 + 2j)) / u).real
    across = ((b - (4 + 2j)) / u).imag
    s = along + np.sqrt(17 - across**2)
    assert points(t, "Point3") == pytest.approx(4 + 2j + s * u, abs=1e-9)
    assert points(t, "Point2") == pytest.approx(4 + 1j + s * u, abs=1e-9)
    assert points(t, "Point4") == pytest.approx(5 + 1j + s * u, abs=1e-9)


def test_a_slot_of_a_moving_link_slides_over_a_pin_of_the_ground(tmp_path):
    text = f"M[{CRANK}, J[RP, A[0], P[4, 0.5], L[L2, ground]], J[R, P[-1, 1], L[L2]]]"
    t = gimcli.trace(loaded(saved(text, PAIR), tmp_path), steps=6)
    b = 1j * np.exp(1j * np.radians(60 * np.arange(7)))
    pin = 4 + 0.5j  # 0.5 to the right of the line through Point1 that is parallel to the slot
    turn = np.angle(pin - b) + np.arcsin(0.5 / abs(pin - b))
    assert points(t, "Point1") == pytest.approx(b, abs=1e-9)
    assert points(t, "Point3") == pytest.approx(b - np.exp(1j * turn), abs=1e-9)


def test_p_joints_of_three_links_make_one_body_of_the_blocks():
    block = "J[P, A[0], P[4, 0], L[L1, L2, L3]], J[R, P[4, 1], L[L2, L4]], J[R, P[5, 0], L[L3]]"
    data = model_of(read(f"M[J[R, P[0, 0], L[ground, L1]], {block}, J[R, P[9, 0], L[ground, L4]]]", "f"))
    assert data["elements"]["L2"][:2] == ["Point1", "Point2"]  # and a node along the slot
    assert data["points"] == {"Point3": {"on": "L2", "at": [5, 0]}}


def test_sliding_inputs_and_further_inputs_are_named(tmp_path):
    text = "M[J[RP, A[90], P[0, 0], L[ground, L1]], J[R, P[3, 4], L[L1, L2]], J[R, P[6, 0], L[ground, L2]]]"
    draft = read(saved(text, "- - 0\n  - 0\n- - 2\n  - 1"), "f")
    data = model_of(draft)
    travel = 0.1 * np.hypot(6, 4)
    assert data["actuators"]["slide"]["law"] == {"by": pytest.approx(travel)}
    assert data["actuators"]["motor_2"]["law"] == {"by": 0}
    assert [line.split(":")[0] for line in draft.left_out] == [
        "slide (input Point0->Point0) moves by 0.72111", "motor_2 (input Point2->Point1) is constant"
    ]  # fmt: skip
    t = gimcli.trace(loaded(saved(text, "- - 0\n  - 0"), tmp_path), steps=2)
    assert points(t, "Point0") == pytest.approx([0, 0.5j * travel, 1j * travel], abs=1e-9)


def test_a_point_that_is_driven_is_a_joint():
    text = (
        "M[J[R, P[0, 0], L[ground, L1]], J[R, P[1, 0], L[L1, L2]], J[R, P[2, 2], L[L1]], J[R, P[1, 5], L[L2, ground]]]"
    )
    data = model_of(read(saved(text, "- - 0\n  - 2"), "f"))
    assert data["actuators"]["motor"]["arm"] == "Point2"
    assert data["elements"]["L1"] == ["Point0", "Point1", "Point2"]


def test_the_angle_of_an_input_is_that_of_its_two_joints():
    text = "M[J[R, P[0, 0], L[ground, L1]], J[R, P[1, 0], L[L1, L2]], J[R, P[0, 9], L[L1, L3]], J[R, P[5, 0], L[L2]]]"
    data = model_of(read(saved(text, PAIR), "f"))
    assert data["actuators"]["motor"]["arm"] == "Point1"  # not Point2, which is farther from the pivot
    slot = "M[J[R, P[0, 0], L[ground, L1]], J[RP, A[0], P[1, 0], L[L1, L2]], J[R, P[5, 0], L[L2, ground]]]"
    with pytest.raises(gimcli.ModelError):  # Point1 moves along the slot of L1
        read(saved(slot, PAIR), "f")


def test_stored_mechanisms_and_other_data_are_named():
    more = "path:\n  record:\n  - - - 0.0\n      - 1.0\nbackground:\n  background: x\n"
    more += f"storage:\n  second: {ONE_LINE}\n  third: M[]"
    draft = read(saved(ONE_LINE, PAIR, more), "f")
    assert len(draft.left_out) == 3
    assert draft.left_out[2].endswith(": second, third")
    draft = read(saved("M[]", PAIR, more), "f")
    assert draft.name == "second"
    assert len(draft.joints) == 5  # and one point
    assert not draft.turns


def test_a_file_without_inputs_names_one():
    assert read(FOUR_BAR, "f").left_out == [
        "the file has no inputs; add one, such as `motor: {type: rotary, pivot: Point0, arm: Point1}` in `actuators`"
    ]


REFUSED = {
    "M[" + "J[R, P[0, 1], L[ground]]," * 600 + "]": "more than 500 joints",
    saved(ONE_LINE, more="a: &x [1, 1]\nb: &y [*x, *x]\n" + "c: [" + "*y, " * 30_000 + "*y]"): "too many",
    "€\x04\x95pyslvs_ver": "a Pyslvs file in the binary format pickle is not read; open it with Pyslvs",
    "SQLite format 3\x00...CREATE TABLE commitmodel": "binary format SQLite",
}


@pytest.mark.parametrize("text", REFUSED, ids=range(len(REFUSED)))
def test_what_cannot_be_converted_is_refused_by_name(text):
    assert recognises(text)
    with pytest.raises(gimcli.ModelError, match=REFUSED[text]):
        model_of(read(text, "f"))


def test_other_texts_are_not_recognised():
    for text in ("", "nodes:\n  A: [0, 0]", "M = 5", '{"mechanism": "M"}', "name: M[J[R", "SQLite format 3", "Mx[J["):
        assert not recognises(text)


@pytest.mark.parametrize("text", [FOUR_BAR, saved(ONE_LINE, PAIR), f"{{input: [[0, 1]], mechanism: '{ONE_LINE}'}}"])
def test_damaged_texts_give_a_model_or_an_error(text):
    for end in range(len(text)):
        with suppress(gimcli.ModelError):
            model_of(read(text[:end], "f"))
    chance = random.Random(15)
    for _ in range(200):
        signs = list(text)
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(len(text))
            signs[at : at + chance.randint(0, 3)] = chance.choice("[](),:'-0159. e{}JMRPLA\n#")
        with suppress(gimcli.ModelError):
            model_of(read("".join(signs), "f"))


def test_a_truncated_expression_is_an_error():
    for end in range(2, FOUR_BAR.index("] # the end")):
        if recognises(FOUR_BAR[:end]):
            with pytest.raises(gimcli.ModelError, match="f:"):
                read(FOUR_BAR[:end], "f")
