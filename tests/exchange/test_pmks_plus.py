"""PMKS+: positions are closed forms of coordinates that are decoded here by a few lines of their own.

Numbers of the format are in base 64 and in thousandths; `decoded` reads them independently of the reader.
"""

from __future__ import annotations

import cmath
import math
from pathlib import Path

import numpy as np
import pytest
from damaged_texts import changed, cut, with_numbers

import gimcli
from gimcli import ModelError
from gimcli.exchange.assembling import model_of
from gimcli.exchange.pmks_plus_codec import checked_body, digest, stamped
from gimcli.exchange.registry import draft_of

DATA = Path(__file__).parent / "data"
FILES = sorted(DATA.glob("pmks_plus_*.pmks"))
ALPHABET = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-"


def payload(name):
    return (DATA / f"pmks_plus_{name}.pmks").read_text(encoding="utf-8").strip()


def decoded(name):
    """Return the places of the joints: thousandths in base 64, a leading 0 is the minus sign."""

    def number(text):
        sign, digits = (-1, text[1:]) if text[0] == "0" and len(text) > 1 else (1, text)
        return sign * sum(ALPHABET.index(c) * 64**k for k, c in enumerate(reversed(digits))) / 1000

    records = payload(name).split("..", 1)[0].split(".")[4:]
    return {r.split(",")[0][1:]: complex(*map(number, r.split(",")[2:4])) for r in records}


def draft(text):
    found = draft_of(text, "a.pmks")
    assert found is not None
    return found


def loaded(name):
    return gimcli.load(DATA / f"pmks_plus_{name}.pmks")


def circles(a, ra, b, rb, near):
    """Return the point at distances ra, rb from a, b that is nearer to a third point."""
    d = abs(b - a)
    along = (ra**2 - rb**2 + d**2) / (2 * d)
    ends = [a + (along + 1j * side * np.sqrt(ra**2 - along**2)) * (b - a) / d for side in (1, -1)]
    return min(ends, key=lambda z: abs(z - near))


def at(mechanism, node, **inputs):
    return complex(*gimcli.solve(mechanism, **inputs).xy[node])


def drawn(mechanism, name):
    return mechanism.inputs_to_file(mechanism.drawn_inputs)[name]


def test_the_four_bar_turns_clockwise_at_20_rpm():
    p, m = decoded("four_bar"), loaded("four_bar")
    assert p["A"] == complex(-3.129, -2.014)  # 0mv, 0VU by hand: -(48 64 + 57), -(31 64 + 30)
    assert m.duration == pytest.approx(3)
    start = drawn(m, "motor")
    assert gimcli.trace(m, steps=2)["motor"] == pytest.approx([start, start - 180, start - 360])
    for turn in (0, -40, -200):
        b = p["A"] + (p["B"] - p["A"]) * cmath.exp(1j * math.radians(turn))
        c = at(m, "C", motor=start + turn)
        assert abs(c - b) == pytest.approx(abs(p["C"] - p["B"]), abs=1e-9)
        assert abs(c - p["D"]) == pytest.approx(abs(p["C"] - p["D"]), abs=1e-9)
    assert m.dynamics.inertias[0].mass == pytest.approx(1e-3)  # 1 g in drawings in cm
    assert m.dynamics.gravity == -9.80665j


def test_the_slider_keeps_its_height():
    p, m = decoded("slider_crank"), loaded("slider_crank")
    for turn in (0, 75, 250):
        b = p["A"] + (p["B"] - p["A"]) * cmath.exp(1j * math.radians(turn))
        rise = p["C"].imag - b.imag
        expected = complex(b.real + math.sqrt(abs(p["C"] - p["B"]) ** 2 - rise**2), p["C"].imag)
        assert at(m, "C", motor=drawn(m, "motor") + turn) == pytest.approx(expected, abs=1e-9)


def test_the_pin_slides_in_a_turning_lever():
    p, m = decoded("whitworth"), loaded("whitworth")
    for turn in (0, 100, 230):
        pin = p["B"] * cmath.exp(1j * math.radians(turn))
        ray = (pin - p["C"]) / abs(pin - p["C"])
        expected = p["C"] + abs(p["D"] - p["C"]) * ray
        assert at(m, "D", motor=drawn(m, "motor") + turn) == pytest.approx(expected, abs=2e-3)


def test_the_yoke_is_a_slide_that_does_not_turn():
    m = loaded("scotch_yoke")
    for angle in (0, 63, 170):
        found = gimcli.solve(m, motor=angle)
        assert complex(*found.xy["C"]) == pytest.approx(complex(math.cos(math.radians(angle)), -2), abs=1e-9)


def test_the_cylinder_retracts_to_its_mount():
    """Mount G (3, 0), boom O-C of length 4: the rod end comes nearer to G by the distance that the piston moves."""
    p, m = decoded("cylinder_boom"), loaded("cylinder_boom")
    along = abs(p["P"] - p["G"])
    assert m.duration == pytest.approx(0.9 * along, rel=1e-3)  # 1 cm/s
    assert gimcli.trace(m, steps=1)["drive"] == pytest.approx([along, 0.1 * along], abs=2e-3)
    assert any("stroke of the cylinder" in sentence for sentence in m.left_out)
    for back in (0.0, 0.7, 1.9):
        reach = abs(p["C"] - p["G"]) - back
        expected = circles(p["O"], 4.0, p["G"], reach, p["C"])
        assert at(m, "C", drive=drawn(m, "drive") - back) == pytest.approx(expected, abs=3e-3)


def test_each_machine_has_its_own_speed():
    """10, -8 and 12 revolutions per minute; the time is that of one revolution of the fastest."""
    m = loaded("three_machines")
    assert m.duration == pytest.approx(5)
    end = gimcli.trace(m, steps=1)
    turned = [end[f"motor_{name}"][1] - end[f"motor_{name}"][0] for name in "AEH"]
    assert turned == pytest.approx([300, -240, 360])


def test_welded_bars_are_one_body():
    data = model_of(draft(payload("bell_crank")))
    assert data["elements"] == {"CDE": ["C", "D", "E"]}
    assert list(data["links"]) == ["AB", "BC", "EF", "FG"]


def test_a_ladder_slides_on_both_walls():
    """Length sqrt 2; the input moves the foot A along x by a tenth of the size, the other end goes down the wall."""
    m = loaded("elliptical_trammel")
    assert any("stroke" in sentence for sentence in m.left_out)
    for back in (0.0, 0.1):
        x = 1 - back
        expected = complex(0, math.sqrt(2 - x * x))
        assert at(m, "B", drive=drawn(m, "drive") - back) == pytest.approx(expected, abs=1e-9)


def test_an_input_between_two_links_turns_one_against_the_other():
    p, m = decoded("oscillating_fan"), loaded("oscillating_fan")
    found = gimcli.solve(m, motor=drawn(m, "motor") - 50)
    a, c, d = (complex(*found.xy[name]) for name in "ACD")
    turned = cmath.phase((d - c) / (a - c) / ((p["D"] - p["C"]) / (p["A"] - p["C"])))
    assert math.degrees(turned) == pytest.approx(-50, abs=1e-9)


def test_forces_come_over_with_their_direction():
    """The records `2F1,...,16K,1Jo,16K,14A,-UW` and `3F2,...,uG,132,kD,t4,hyW`: F1 keeps its direction, F2 turns."""
    loads = model_of(draft(payload("crane")))["loads"]
    assert loads["F1"] == {"on": "Jib", "at": [4.5, 5.362], "force": pytest.approx([0, -260])}  # -UW: 260 000
    along = complex(46 * 64 + 13, 55 * 64 + 4) - complex(56 * 64 + 16, 4096 + 3 * 64 + 2)
    found = complex(*loads["F2"]["follower"])
    assert abs(found) == pytest.approx((43 * 4096 + 60 * 64 + 32) / 1000)  # hyW
    place = {node: complex(*xy) for node, xy in model_of(draft(payload("crane")))["nodes"].items()}
    ray = (place["C"] - place["O"]) / abs(place["C"] - place["O"])  # the first two joints of the jib
    assert found * ray == pytest.approx(abs(found) * along / abs(along))


def test_masses_are_in_grams_in_drawings_in_centimetres():
    """`mr0` is 200 000 thousandths, `1E8` 5000 and `2IV0` 600 000: 200 g, 5 kg cm^2, and 600 g at the slider."""
    data = model_of(draft(payload("punch_press")))
    assert data["units"] == {"length": "cm", "mass": "g"}
    assert data["masses"]["Crank"] == {"mass": 200, "inertia": pytest.approx(5e-4), "centre": [0.6, 0.0]}
    assert data["masses"]["C"] == {"mass": 600}
    assert data["gravity"] == [0, -9.80665]
    assert sum(inertia.mass for inertia in loaded("punch_press").dynamics.inertias) == pytest.approx(1.1)


ADDRESS = "https://app.pmksplus.com/?" + payload("slider_crank")


def test_an_address_is_read_like_a_file():
    assert model_of(draft(ADDRESS)) == model_of(draft(payload("slider_crank")))
    spaces = "https://app.pmksplus.com/?" + payload("three_machines").replace(" ", "%20")
    assert model_of(draft(spaces)) == model_of(draft(payload("three_machines")))


def test_the_digest_is_that_of_fowler_noll_and_vo():
    """FNV-1a of `foobar` is 0xbf9cf968 (test vector of its authors), here in base 62."""
    value = 0
    for character in digest("foobar"):
        value = value * 62 + ALPHABET.index(character)
    assert value == 0xBF9CF968


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_files_have_the_checks_that_the_program_wrote(path):
    text = path.read_text(encoding="utf-8").strip()
    body = checked_body(text, "a.pmks")
    assert stamped(body).startswith(text)


def test_every_change_of_one_character_is_detected():
    start, text = "https://app.pmksplus.com/?", payload("scotch_yoke")
    assert "*" in text
    for k in range(len(text)):
        with pytest.raises(ModelError):
            draft_of(start + text[:k] + ("A" if text[k] != "A" else "B") + text[k + 1 :], "a")


@pytest.mark.parametrize("end", [5, 40, 100, -1, -3, -6])
def test_a_truncated_address_is_refused(end):
    with pytest.raises(ModelError):
        draft_of(ADDRESS[: 26 + end] if end > 0 else ADDRESS[:end], "a.pmks")


WATT = (
    "https://app.pmksplus.com/?0P.SS.K,0.101.MA,A,0wS,0bg,0.GB,B,0gW,EE,0.GC,C,Oi,6k,0.GD,D,03m,_g,0.GE,E,1FO,1I_,0."
    "GF,F,1-C,qM,0.KG,G,1oO,0ss,0..YRAB,AB,Fe,Fe,0oU,0Bk,c5cae9,A,B,,.YRBCD,BCD,Fe,Fe,07C,Rt,303e9f,B,C,D,,."
    "YRDE,DE,Fe,Fe,bq,18q,0d125a,D,E,,.YREF,EF,Fe,Fe,1dI,13g,B2DFDB,E,F,,.YRFCG,FCG,Fe,Fe,1Om,1Q,26A69A,F,C,G,,...JGp"
)
"""The address of README of PMKS+, written in 2024: three enums, one decimal, no digest."""


def test_the_six_bar_moves_as_pmks_computed_it():
    """Positions of E by the crank's turn from its drawn angle [deg], computed with PMKS and confirmed with MATLAB.

    Source: github.com/PMKS-Web/PMKS_Verification, reference-data/v1/cases/watt_i/pmks/joints/E.csv.
    """
    mechanism = gimcli.load(WATT)
    start = drawn(mechanism, "motor")
    expected = {
        -5: (5.1305912844631374, 4.1635309288268632), -3: (5.1312401105150336, 4.7382193529414218),
        0: (5.08, 5.31), 2: (5.0193064678985992, 5.6429062136048129), 5: (4.8332738548746113, 6.2015139976270781),
    }  # fmt: skip
    for turn, place in expected.items():
        assert gimcli.solve(mechanism, motor=start + turn).xy["E"] == pytest.approx(place, abs=1e-6)


def edited(old, new, name="slider_crank"):
    return stamped(checked_body(payload(name), "a").replace(old, new, 1))


def test_a_speed_of_zero_is_reported():
    found = draft(edited(".K,0.", ".0,0.", "four_bar"))
    assert found.turns[0].keys == {"law": {"by": 360}}
    assert any("zero" in sentence for sentence in found.left_out)


def test_a_drawing_without_an_input_names_one():
    """The records of this drawing: A is fixed, and AB joins it to B; the first flags of A (driven, fixed) are 6."""
    found = draft(edited(".6A,A", ".4A,A", "four_bar"))
    assert not found.turns
    assert any("pivot: A, arm: B" in sentence for sentence in found.left_out)


def test_numbers_with_all_digits_replace_those_in_thousandths():
    found = draft(edited(".N_", ".N_.PJA~0~-3.0821234,JA,KJB~d"))
    assert found.joints["A"] == (-3.0821234, -0.038)
    assert not found.left_out


def test_damaged_texts_are_models_or_model_errors():
    for name in ("cylinder_boom", "punch_press", "bell_crank"):
        body = checked_body(payload(name), "a")
        for text in [*cut(body, 100), *changed(body, 200), *with_numbers(body)[:200]]:
            for damaged in (text, stamped(text)):
                try:
                    found = draft_of(damaged, "a.pmks")
                    if found is not None:
                        model_of(found)
                except ModelError:
                    pass
