"""PMKS text and addresses: positions are closed forms of the dimensions in the text, read by eye."""

from __future__ import annotations

import numpy as np
import pytest
from damaged_texts import changed, cut, with_numbers

import gimcli
from gimcli import ModelError
from gimcli.exchange import pmks_text
from gimcli.exchange.assembling import model_of
from gimcli.exchange.registry import draft_of

FOUR_BAR = """mech=
ground,crank,R,0,0,0,ffft
crank,coupler,R,2,0,0,tfff
coupler,rocker,R,2,6,0,ffff
rocker,ground,R,8,0,0,ffff
coupler,R,5,3,0,tfff
"""
SLOTTED_LEVER = "gnd input r 0 0 | lever input rp 2 0 0 | lever gnd r 5 0 | lever r -4 0"


def draft(text):
    found = draft_of(text, "a.txt")
    assert found is not None
    return found


def motion(text, **inputs):
    return gimcli.solve(gimcli.load(model_of(draft(text))), **inputs)


def circles(a, ra, b, rb, side):
    """Return the point at distances ra, rb from a, b, to the left (1) or right (-1) of the way from a to b."""
    d = abs(b - a)
    along = (ra**2 - rb**2 + d**2) / (2 * d)
    return a + (along + 1j * side * np.sqrt(ra**2 - along**2)) * (b - a) / d


def test_the_four_bar_moves_as_two_circles_intersect():
    """Lengths 2, 6, 6 sqrt 2, frame 8; the tracer is (3, -3) along and across the coupler from (2, 0) to (2, 6)."""
    for angle in (0, 50, 130, 290):
        found = motion(FOUR_BAR, motor=angle)
        b = 2 * np.exp(1j * np.radians(angle))
        c = circles(b, 6, 8, 6 * np.sqrt(2), 1)
        assert complex(*found.xy["C"]) == pytest.approx(c, abs=1e-9)
        assert complex(*found.xy["E"]) == pytest.approx(b + (3 - 3j) * (c - b) / 6, abs=1e-9)


def test_the_tracer_moves_as_pmks_computed_it():
    """Positions of D by the crank's turn from its drawn angle [deg], computed with PMKS and confirmed with MATLAB.

    Source: github.com/PMKS-Web/PMKS_Verification, reference-data/v1/cases/slider_crank_tracer/pmks/points/D.csv.
    """
    text = "ground AB R 0 0|AB BCD R 4 2|ground BCD RP 12 0 0|BCD R 20 2".replace("|", "\n")
    expected = {
        0: (20, 2), 10: (19.535511228477723, 1.3216859262485514), 60: (15.419776361327257, -0.6761448229137148),
        117: (12.346996860947183, 1.3301978797961416),
    }  # fmt: skip
    mechanism = gimcli.load(model_of(draft(text)))
    start = mechanism.inputs_to_file(mechanism.drawn_inputs)["motor"]
    for turn, place in expected.items():
        assert gimcli.solve(mechanism, motor=start + turn).xy["D"] == pytest.approx(place, abs=1e-9)


def test_names_traces_and_bodies_come_over():
    data = model_of(draft(FOUR_BAR))
    assert data["ground"] == ["A", "D"]
    assert data["links"] == {"crank": ["A", "B"], "coupler": ["B", "C"], "rocker": ["C", "D"]}
    assert data["points"] == {"E": {"on": "coupler", "at": [5, 3]}}
    assert data["trace"] == ["B", "E"]
    assert data["actuators"] == {"motor": {"type": "rotary", "pivot": "A", "arm": "B", "law": {"by": 360}}}


def test_the_slot_belongs_to_the_link_that_is_named_first():
    """The lever turns about (5, 0) towards the pin at 2 exp(i angle); its tracer is at 9 from the pivot."""
    for angle in (0, 77, 200):
        pin = 2 * np.exp(1j * np.radians(angle))
        found = motion(SLOTTED_LEVER, motor=angle)
        assert complex(*found.xy["D"]) == pytest.approx(5 + 9 * (pin - 5) / abs(pin - 5), abs=1e-9)


def test_a_pin_of_the_crank_named_first_slides_the_other_way():
    """Here the slot is in the crank along x: the lever's pin, 3 from (5, 0), stays on the ray of the crank."""
    text = "ground input R 0 0 | input lever RP 2 0 0 | lever ground R 5 0"
    found = motion(text, motor=20)
    ray = np.exp(1j * np.radians(20))
    along = 5 * ray.real - np.sqrt(9 - (5 * ray.imag) ** 2)
    assert complex(*found.xy["B"]) == pytest.approx(along * ray, abs=1e-9)


@pytest.mark.parametrize("links", ["slider ground", "ground slider"])
def test_a_sliding_block_is_the_input(links):
    """Slider along 60 degrees through (1, 2); rod 5, rocker 4 about (6, -1). Both orders of the links are one pair."""
    elbow = circles(1 + 2j, 5, 6 - 1j, 4, 1)
    text = f"s=2\n{links},P,1,2,60\nslider,rod,R,1,2\nrod,rocker,R,{elbow.real!r},{elbow.imag!r}\nrocker,ground,R,6,-1"
    found = draft(text)
    mechanism = gimcli.load(model_of(found))
    start = gimcli.solve(mechanism)
    drawn = mechanism.inputs_to_file(mechanism.drawn_inputs)["motor"]
    moved = gimcli.solve(mechanism, motor=drawn + 0.3)
    block = complex(1, 2) + 0.3 * np.exp(1j * np.pi / 3)
    nodes = [name for name in ("A", "B") if name in moved.xy]
    assert complex(*start.xy["C"]) == pytest.approx(elbow, abs=1e-9)
    assert complex(*moved.xy[nodes[-1]]) == pytest.approx(block, abs=1e-9)
    assert complex(*moved.xy["C"]) == pytest.approx(circles(block, 5, 6 - 1j, 4, 1), abs=1e-9)
    size = np.hypot(6 - min(1, elbow.real), max(elbow.imag, 2) + 1)
    assert found.duration == pytest.approx(0.1 * size / 2)  # a stroke of a tenth of the size, at 2 per second
    assert any("stroke" in sentence for sentence in found.left_out)


def test_a_block_between_two_moving_links_does_not_turn():
    """The bar slides along the crank: its end stays at 1 across the slot and at the arm.s length from (9, 0)."""
    text = "ground crank R 0 0 0 ffft|crank bar P 2 0 0|bar arm R 4 1|arm ground R 9 0"
    found = motion(text, motor=20)
    ray = np.exp(1j * np.radians(20))
    reach = abs(4 + 1j - 9)  # of the arm
    pin = complex(*found.xy["C"])
    assert (pin / ray).imag == pytest.approx(1, abs=1e-9)
    assert abs(pin - 9) == pytest.approx(reach, abs=1e-9)


def test_three_links_share_one_pin():
    data = model_of(draft("0 a R 0 0|a b c R 3 0|b 0 R 5 2|c 0 R 5 -2"))
    assert data["links"] == {"a": ["A", "B"], "b": ["B", "C"], "c": ["B", "D"]}
    assert gimcli.mobility(gimcli.load(data)).mobility == 0


@pytest.mark.parametrize(
    ("marks", "driver"),
    [("", "A"), ("0 ffff|ffff|0 ffft", "C"), ("0 ----|----|0 ---+", "C"), ("||0,False,False,False,True", "C")],
)
def test_the_driver_is_marked_or_the_first_joint_of_two_links(marks, driver):
    marks = [*marks.split("|"), "", "", ""]
    rows = ["point R 1 1", "ground a R 0 0", "a b R 1 0", "b ground R 2 1"][1:]
    text = "\n".join(f"{row} {mark}" for row, mark in zip(rows, marks, strict=False))
    assert draft(text).turns[0].at == driver


def test_the_driver_may_stand_in_the_header():
    assert draft("d=2\nground,a,R,0,0\na,b,R,1,0\nb,ground,R,2,1").turns[0].at == "C"


def test_an_address_has_a_speed_in_revolutions_per_minute():
    address = (
        "http://example.org/~someone/pmks.html?set=s-12|f5&ts=M1,1&mech="
        "ground%20crank%20R%200%200%20ffft|crank%20rod%20R%202%200|rod%20ground%20RP%205%200%200%20+---|"
    )
    mechanism = gimcli.load(address)
    assert mechanism.duration == pytest.approx(5)
    assert gimcli.trace(mechanism, steps=4)["motor"] == pytest.approx([0, -90, -180, -270, -360])
    assert len(mechanism.left_out) == 1


FIXED = "ground,a,R,0,0\nground,a,R,1,0\nground,a,P,2,0,0,{}\nground,b,R,3,0,0,{}\nb,c,R,4,0\nc,ground,R,5,1"


def test_a_slot_between_fixed_links_is_left_out():
    """Link a has two pins on the ground."""
    found = draft(FIXED.format("ffff", "ffft"))
    data = model_of(found)
    assert "prismatic" not in data
    assert list(data["links"]) == ["b", "c"]
    assert any("slide_C" in sentence for sentence in found.left_out)


def test_a_speed_of_zero_is_reported():
    found = draft("s=0\nground,a,R,0,0\na,b,R,1,0\nb,ground,R,2,1")
    assert found.duration is None
    assert any("zero" in sentence for sentence in found.left_out)


def test_a_file_without_a_speed_has_the_default_of_pmks():
    """10 revolutions per minute; 10 lengths per second, here over a tenth of the size 5."""
    assert draft("ground,a,R,0,0\na,b,R,1,0\nb,ground,R,2,1").duration == pytest.approx(6)
    assert draft("a,ground,P,0,0\na,b,R,0,0\nb,ground,R,4,3").duration == pytest.approx(0.05)


def test_all_names_of_the_ground_are_the_ground():
    for name in ("0", "gnd", "Grnd", "grond", "gound", "groud", "GROUND", "ground_1"):
        assert model_of(draft(f"{name},a,R,0,0\na,b,R,1,0\nb,{name},R,2,1"))["ground"] == ["A", "C"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 a R 0 0\n" * 501, "more than 500 joints are too many"),
        ("0 a R 0 0\n" + " ".join(f"l{k}" for k in range(3000)) + " R 1 1", "more than 500 links are too many"),
    ],
)
def test_faults_are_reported_with_their_lines(text, message):
    with pytest.raises(ModelError, match=message.replace("(", r"\(")):
        draft_of(text, "a.txt")


def test_other_texts_are_not_of_this_format():
    for text in (
        "",
        "\n\n",
        "nodes: {A: [0, 0]}",
        '{"Joints": []}',
        "<program/>",
        "M[J[R, A[0]]]",
        "R",
        "https://x.org/",
    ):
        assert not pmks_text.recognises(text)


def test_damaged_texts_are_models_or_model_errors():
    address = "http://x.org/p?set=s5|e1&mech=" + "|".join(FOUR_BAR.split()[1:])
    for text in (FOUR_BAR, SLOTTED_LEVER.replace("|", "\n"), address):
        for damaged in [*cut(text), *changed(text, 150), *with_numbers(text)]:
            try:
                found = draft_of(damaged, "a.txt")
                if found is not None:
                    model_of(found)
            except ModelError:
                pass


def test_many_joints_are_converted():
    rows = [f"l{k} l{k + 1} R {k} {k % 7}" for k in range(499)]
    assert len(model_of(draft("\n".join(["ground l0 R -1 0", *rows])))["links"]) == 499
