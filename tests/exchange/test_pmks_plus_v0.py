"""Addresses of PMKS+ from 2020 to 2023: a slider-crank in closed form, in the three variants of the format."""

from __future__ import annotations

import math

import pytest
from damaged_texts import changed, cut, with_numbers

import gimcli
from gimcli import ModelError
from gimcli.exchange.assembling import model_of
from gimcli.exchange.registry import draft_of

NINE = (
    "https://pmksplus.mech.website/linkages/?"
    "j=A,0,0,AB,R,t,0,0.001,t,%0AB,2,0,AB%7CBC,R,f,0,0.001,f,%0AC,6,3,BC%7CCD,R,f,0,0.001,f,%0AD,6,3,CD,P,t,0,0.001,f,"
    "&l=AB,1,0.5,1,0,A%7CB,,line%0ABC,2,0.5,4,1.5,B%7CC,,line%0ACD,0,0,0,0,C%7CD,,line"
    "&f=F1,BC,4,1.5,4,0.5,t,t,10&pp=&tp=&s=10,true,false,cm"
)
EIGHT = NINE.replace(",0.001", "")
TYPED = EIGHT.replace("AB,1,0.5", "AB,R,1,0.5").replace("BC,2,0.5", "BC,R,2,0.5").replace("CD,0,0", "CD,P,0,0")


def draft(text):
    found = draft_of(text, "<address>")
    assert found is not None
    return found


@pytest.mark.parametrize("address", [NINE, EIGHT, TYPED])
def test_the_slider_moves_at_height_3(address):
    """Crank 2, rod 5, offset 3: x = 2 cos + sqrt(25 - (3 - 2 sin)^2)."""
    mechanism = gimcli.load(address)
    assert mechanism.duration == pytest.approx(6)  # 10 revolutions per minute
    assert gimcli.trace(mechanism, steps=1)["motor"] == pytest.approx([0, 360])
    for angle in (0, 40, 160, 300):
        sine, cosine = math.sin(math.radians(angle)), math.cos(math.radians(angle))
        expected = (2 * cosine + math.sqrt(25 - (3 - 2 * sine) ** 2), 3)
        assert gimcli.solve(mechanism, motor=angle).xy["C"] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("address", [NINE, EIGHT, TYPED])
def test_the_block_of_the_slider_is_not_a_link(address):
    data = model_of(draft(address))
    assert list(data["links"]) == ["AB", "BC"]
    assert list(data["nodes"]) == ["A", "B", "C", "C_from", "C_to"]


def test_masses_and_forces_come_over():
    data = model_of(draft(NINE))
    assert data["units"] == {"length": "cm", "mass": "g"}
    assert data["masses"]["AB"] == {"mass": 1, "inertia": pytest.approx(5e-5), "centre": [1, 0]}
    assert data["loads"]["F1"] == {"on": "BC", "at": [4, 1.5], "force": [0, -10]}
    assert data["gravity"] == [0, -9.80665]


def test_settings_turn_it_clockwise_without_gravity_in_inches():
    data = model_of(draft(NINE.replace("10,true,false,cm", "30,false,true,in")))
    assert data["actuators"]["motor"]["law"] == {"by": -360}
    assert data["duration"] == 2
    assert data["units"] == {"length": "in", "mass": "lb"}
    assert "gravity" not in data
    assert data["loads"]["F1"]["force"] == [0, pytest.approx(-44.482216152605)]  # 10 lbf


def test_blocks_of_2021_have_no_mass():
    """The slider-crank of the program's templates of 2021: c stays at y = 0.15, rod of the distance of b and c."""
    mechanism = gimcli.load(
        "https://pmks.mech.website/?j=a,-1.76,-1.99,ab,R,t,Null,t%0Ab,0.52,1.95,ab%7Cbc,R,f,Null,f%0A"
        "c,2.54,0.15,bc%7Ccd,R,f,Null,f%0Ad,2.54,0.15,cd,P,t,0,f%0A"
        "&l=ab,R,1,1,-0.62,-0.020000000000000018,a%7Cb,,line,0.52,-1.99,0.52,1.95,-1.76,1.95,-1.76,-1.99%0A"
        "bc,R,1,1,1.53,1.05,b%7Cc,,line,2.54,1.95,2.54,0.15,0.52,0.15,0.52,1.95%0A"
        "cd,P,Null,Null,Null,Null,c%7Cd,,Null,Null,Null,Null,Null,Null,Null,Null,Null%0A&f=&s=10,false,false,cm"
    )
    assert mechanism.duration == pytest.approx(6)
    start = mechanism.inputs_to_file(mechanism.drawn_inputs)["motor"]
    crank = complex(-1.76, -1.99) + complex(2.28, 3.94) * complex(math.cos(0.1), math.sin(0.1))
    along = math.sqrt(2.02**2 + 1.8**2 - (crank.imag - 0.15) ** 2)
    found = gimcli.solve(mechanism, motor=start + math.degrees(0.1)).xy["c"]
    assert found == pytest.approx((crank.real + along, 0.15), abs=1e-9)


def test_damaged_addresses_are_models_or_model_errors():
    for damaged in [*cut(NINE), *changed(NINE, 200), *with_numbers(NINE)]:
        try:
            found = draft_of(damaged, "<address>")
            if found is not None:
                model_of(found)
        except ModelError:
            pass
