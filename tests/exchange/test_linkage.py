"""Files of Linkage: positions and motions against values decoded by hand from the text, and closed forms."""

from __future__ import annotations

import random
from contextlib import suppress

import numpy as np
import pytest

import gimcli
from gimcli.exchange.assembling import model_of
from gimcli.exchange.linkage import read, recognises

INCH = 96.0  # units of the file

CRANK_ROCKER = """<linkage2>
\t<program zoom="1"xoffset="3" yoffset="1" scalefactor="1.000000" units="Inches"/>
\t<connector id="0" selected="false" layer="16"x="0.000000" y="0.000000" anchor="true" input="true" rpm="15.000000"/>
\t<connector id="1" layer="16" x="0.000000" y="96.000000"/>
\t<connector id="2" name="coupler "end" & <pin>" layer="16" x="288.000000" y="192.000000"/>
\t<connector id="3" layer="16" x="384.000000" y="0.000000" anchor="true"/>
\t<connector id="4" layer="16" x="96.000000" y="192.000000" draw="true"/>
\t<connector id="5" layer="1" x="10.000000" y="20.000000"/>
\t<Link id="0" layer="16">
\t\t<connector id="0"/>
\t\t<connector id="1"/>
\t</Link>
\t<Link id="1" name="rod" layer="16">
\t\t<connector id="1"/>
\t\t<connector id="2"/>
\t\t<connector id="4"/>
\t\t<fastenconnector id="77"/>
\t</Link>
\t<Link id="1" layer="16">
\t\t<connector id="2"/>
\t\t<connector id="3"/>
\t</Link>
\t<Link id="9" layer="1" measurementelement="true">
\t\t<connector id="5"/>
\t</Link>
</linkage2>
"""


def file_of(*lines: str, units: str = "Inches") -> str:
    return "\n".join(["<linkage2>", f'<program units="{units}"/>', *lines, "</linkage2>"])


def pin(ident: int, x: float, y: float, more: str = "") -> str:
    return f'<connector id="{ident}" layer="16" x="{x * INCH}" y="{y * INCH}" {more}/>'


def slider(ident: int, x: float, y: float, first: int, second: int, more: str = "") -> str:
    limits = f'<slidelimit id="{first}"/><slidelimit id="{second}"/>'
    return pin(ident, x, y, f'slider="true" {more}').replace("/>", f">{limits}</connector>")


def link(ident: int, *pins: int, more: str = "") -> str:
    return f'<Link id="{ident}" {more}>' + "".join(f'<connector id="{k}"/>' for k in pins) + "</Link>"


ROD = [pin(0, 0, 0, 'anchor="true"'), pin(1, 4, 0), pin(2, 4, 3, 'anchor="true"'), link(0, 1, 2)]


def loaded(text: str, tmp_path):
    path = tmp_path / "mechanism.linkage2"
    path.write_text(text, encoding="cp1252")
    return gimcli.load(path)


def upper(a: complex, ra: float, b: complex, rb: float) -> complex:
    """The point at two distances, to the left of the line from a to b."""
    d = abs(b - a)
    x = (ra**2 - rb**2 + d**2) / (2 * d)
    return a + (b - a) / d * (x + 1j * np.sqrt(ra**2 - x**2))


def test_a_badly_formed_file_is_read_and_the_motor_turns_clockwise(tmp_path):
    m = loaded(CRANK_ROCKER, tmp_path)
    t = gimcli.trace(m, steps=8)
    assert m.length_unit == "in"
    assert m.duration == pytest.approx(60 / 15)
    for k, (x, y) in enumerate(t.xy["B"]):  # 15 turns a minute, clockwise, from the drawn position straight up
        assert complex(x, y) == pytest.approx(np.exp(1j * np.radians(90 - 45 * k)), abs=1e-12)
        c = upper(complex(x, y), np.hypot(3, 1), 4, np.hypot(1, 2))
        assert t.xy['coupler "end" & <pin>'][k] == pytest.approx([c.real, c.imag], abs=1e-9)
        drawn = (complex(1, 2) - 1j) / (complex(3, 2) - 1j)  # of E against the rod from B to the coupler's end
        e = complex(x, y) + drawn * (c - complex(x, y))
        assert t.xy["E"][k] == pytest.approx([e.real, e.imag], abs=1e-9)
    assert len(m.left_out) == 1


def test_millimetres_are_the_default_and_lengths_are_those_that_the_program_shows(tmp_path):
    m = loaded(CRANK_ROCKER.replace(' units="Inches"', ""), tmp_path)
    assert m.length_unit == "mm"
    assert gimcli.solve(m).xy["B"] == pytest.approx([0, 25.4])


def test_a_slider_between_limits_of_a_turning_link(tmp_path):
    text = file_of(
        pin(0, 0, 0, 'anchor="true" input="true" rpm="-10"'), slider(1, 0, 1, 2, 3),
        pin(2, 0, -2, 'anchor="true"'), pin(3, 0, 3), link(0, 0, 1), link(1, 2, 3),
    )  # fmt: skip
    t = gimcli.trace(loaded(text, tmp_path), steps=12)
    assert t.mechanism.duration == pytest.approx(6)
    for k in range(13):  # the slot turns about (0, -2) and passes through the crank's end
        b = 1j * np.exp(1j * np.radians(30 * k))
        assert t.xy["B"][k] == pytest.approx([b.real, b.imag], abs=1e-9)
        d = -2j + 5 * (b + 2j) / abs(b + 2j)
        assert t.xy["D"][k] == pytest.approx([d.real, d.imag], abs=1e-9)


@pytest.mark.parametrize(
    ("more", "first", "last", "duration"),
    [
        ('throw="96" cpm="15"', 4, 5, 2),
        ('throw="96" cpm="-10"', 4, 3, 3),
        ('throw="96" cpm="15" startoffset="24"', 3.75, 4.75, 2),
        ('throw="96" cpm="15" startoffset="168"', 4.75, 3.75, 2),  # 1.75 of a cycle of 2: on its way back
    ],
)
def test_an_actuator_is_one_stroke_of_its_throw(tmp_path, more, first, last, duration):
    m = loaded(file_of(*ROD, link(5, 0, 1, more=f'name="ram" actuator="true" {more}')), tmp_path)
    t = gimcli.trace(m, steps=4)
    assert m.duration == pytest.approx(duration)
    assert t["ram"][[0, -1]] == pytest.approx([first, last])
    assert np.hypot(*t.xy["B"].T)[[0, -1]] == pytest.approx([first, last])


@pytest.mark.parametrize(("rpm", "offset", "first", "last"), [(10, 0, 0, -90), (-10, 0, 0, 90), (10, 30, 30, -60)])
def test_a_motor_with_a_limit_angle_makes_one_swing(tmp_path, rpm, offset, first, last):
    motor = f'anchor="true" input="true" rpm="{rpm}" limitangle="90" startoffset="{offset}"'
    t = gimcli.trace(loaded(file_of(pin(0, 0, 0, motor), pin(1, 2, 0), link(0, 0, 1)), tmp_path), steps=4)
    assert t.mechanism.duration == pytest.approx(90 / 60)
    assert t["motor"][[0, -1]] == pytest.approx([first, last])


def test_several_motors_run_until_all_are_back_at_their_start(tmp_path):
    arms = [pin(0, 0, 0, 'anchor="true" input="true" rpm="15"'), pin(1, 1, 0), link(0, 0, 1)]
    arms += [pin(2, 5, 0, 'anchor="true" input="true" rpm="-10"'), pin(3, 6, 0), link(1, 2, 3)]
    data = model_of(read(file_of(*arms), "f"))
    assert data["duration"] == 12
    assert {name: own["law"]["by"] for name, own in data["actuators"].items()} == {"motor_A": -1080, "motor_C": 720}
    arms = [line.replace('rpm="15"', 'rpm="15.7"') for line in arms]  # a common period of 600 s: the slower turns once
    data = model_of(read(file_of(*arms), "f"))
    assert data["duration"] == 6
    assert data["actuators"]["motor_A"]["law"]["by"] == pytest.approx(-6 * 6 * 15.7)


def test_motors_and_actuators_run_until_the_first_reversal(tmp_path):
    more = [pin(5, 9, 0, 'anchor="true" input="true" rpm="5"'), pin(6, 9, 1), link(7, 5, 6)]
    data = model_of(read(file_of(*ROD, *more, link(5, 0, 1, more='actuator="true" throw="96" cpm="10"')), "f"))
    assert data["duration"] == 3  # half of 6 s
    assert data["actuators"]["motor"]["law"]["by"] == pytest.approx(-5 * 6 * 3)
    assert data["actuators"]["actuator6"]["law"]["by"] == pytest.approx(1)


def test_an_input_moved_by_hand_is_constant_beside_others(tmp_path):
    more = [pin(5, 9, 0, 'anchor="true" input="true" rpm="5"'), pin(6, 9, 1), link(7, 5, 6)]
    ram = link(5, 0, 1, more='name="ram" actuator="true" alwaysmanual="true" throw="96" cpm="10"')
    draft = read(file_of(*ROD, *more, ram), "f")
    assert model_of(draft)["actuators"]["ram"]["law"] == {"by": 0}
    assert any("ram is moved by hand" in sentence for sentence in draft.left_out)


def test_fastened_links_are_one_body(tmp_path):
    text = file_of(
        pin(0, 0, 0, 'anchor="true" input="true" rpm="15"'), pin(1, 1, 0), pin(2, 0, 2), pin(3, 2, 2),
        link(0, 0, 1), link(1, 0, 2, more='fastenlink="2"'), link(2, 2, 3, more='fastenlink="1"'),
    )  # fmt: skip
    data = model_of(read(text, "f"))  # link2 and link3 are fastened; the motor turns link1 and link2 together
    assert data["elements"] == {"link1+link2+link3": ["A", "B", "C", "D"]}
    assert "links" not in data


def test_points_that_are_fastened_are_carried_and_drawn(tmp_path):
    point = '<connector id="9" layer="1" x="96" y="288" draw="true" fastenlink="0"/>'
    text = file_of(pin(0, 0, 0, 'anchor="true" input="true" rpm="15"'), pin(1, 1, 0), link(0, 0, 1), point)
    t = gimcli.trace(loaded(text, tmp_path), steps=4)
    assert t.xy["J"][1] == pytest.approx([3, -1])  # (1, 3) turned clockwise by 90 degrees
    text = file_of(pin(0, 0, 0, 'anchor="true" input="true" rpm="15"'), pin(1, 1, 0, 'draw="true"'), link(0, 0, 1))
    assert model_of(read(text, "f"))["trace"] == ["B"]


def ratio(a, b, sizes, kind="gears", more=""):
    wheels = "".join(f'<link id="{k}" size="{size}"/>' for k, size in zip((a, b), sizes, strict=True))
    return f'<ratios><ratio type="{kind}" {more}>{wheels}</ratio></ratios>'


ARM = [pin(0, 0, 0, 'anchor="true" input="true" rpm="15"'), pin(1, 1, 0), link(0, 0, 1), link(5, 0, more='gear="true"')]
WHEEL = [pin(2, 5, 0, 'anchor="true"'), pin(3, 5, 2), link(1, 2, more='fastenlink="2" gear="true"'), link(2, 2, 3)]


@pytest.mark.parametrize(("kind", "sense"), [("gears", -1), ("chain", 1)])
def test_gears_turn_oppositely_and_wheels_of_a_chain_alike(kind, sense, tmp_path):
    """By Simulator.cpp: the turns are inversely proportional to the sizes."""
    m = loaded(file_of(*ARM, *WHEEL, ratio(5, 1, (1, 2), kind)), tmp_path)
    t = gimcli.trace(m, steps=12)
    turned = np.exp(sense * 0.5j * -2 * np.pi * np.arange(13) / 12)  # clockwise at positive speeds
    assert np.allclose(t.xy["D"] @ [1, 1j], 5 + 2j * turned)
    assert (m.gears[0].radii is None) == (kind == "chain")  # sizes of a chain are a ratio


def test_the_sizes_of_a_chain_may_be_radii(tmp_path):
    more = ratio(5, 1, (0.5 * INCH, INCH), "chain", 'sizeassize="true"')
    m = loaded(file_of(*ARM, *WHEEL, more), tmp_path)
    assert np.multiply(m.gears[0].radii, m.scale) == pytest.approx([0.5, 1.0])


def test_a_train_on_an_arm_about_a_fixed_gear(tmp_path):
    """The arrangement of a sample of the program: a chain from a fixed wheel keeps the next one from turning."""
    text = file_of(
        pin(0, 0, 0, 'anchor="true" input="true" rpm="3"'), pin(1, 6, 0), pin(2, 9, 0), pin(3, 9, 2),
        pin(4, -3, 0, 'anchor="true"'), link(0, 0, 1, 2), link(1, 0, more='fastenconnector="4" gear="true"'),
        link(2, 1, more='gear="true"'), link(3, 2, more='fastenlink="4" gear="true"'), link(4, 2, 3),
        "<ratios>", ratio(2, 3, (8, 1))[8:-9], ratio(1, 2, (25, 25), "chain")[8:-9], "</ratios>",
    )  # fmt: skip
    t = gimcli.trace(loaded(text, tmp_path), steps=30)
    arm = np.exp(-2j * np.pi * np.arange(31) / 30)
    assert np.allclose(t.xy["B_mark"] @ [1, 1j] - t.xy["B"] @ [1, 1j], 8 / 3)  # of radius 3 * 8 / 9
    assert np.allclose(t.xy["D"] @ [1, 1j], 9 * arm + 2j * arm**9)  # relative to the arm -8 times its -1


def test_gears_without_a_link_between_them_and_gears_that_nothing_turns_are_left_out(tmp_path):
    free = [pin(6, 8, 0, 'anchor="true"'), pin(7, 9, 0, 'anchor="true"'), link(6, 6, more='gear="true"'),
            link(7, 7, more='gear="true"')]  # fmt: skip
    left_out = loaded(file_of(*ARM[:3], *free, ratio(6, 7, (1, 1))), tmp_path).left_out
    assert any("link7, link8" in line for line in left_out)
    loose = [pin(2, 5, 0), pin(3, 5, 2), link(1, 2, more='fastenlink="2" gear="true"'), link(2, 2, 3)]
    left_out = read(file_of(*ARM, *loose, ratio(5, 1, (1, 2))), "f").left_out
    assert any("link6 and link2" in line for line in left_out)
    for sizes in ((1, 0), (1, "")):
        with pytest.raises(gimcli.ModelError):
            read(file_of(*ARM, *WHEEL, ratio(5, 1, sizes)), "f")


REFUSED = {
    "pins": ("".join(pin(k, 1, k) for k in range(10, 600)), "connectors: more than 500 entries"),
    "links": ("".join(link(k, 0, 1) for k in range(10, 600)), "Links: more than 500 entries"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_converted_is_refused_by_name(name):
    own, message = REFUSED[name]
    with pytest.raises(gimcli.ModelError, match=message):
        model_of(read(file_of(*ROD, own), "f"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<linkage2>" + "<a/>" * 60_000 + "</linkage2>", "more than 50000 tags"),
    ],
)
def test_older_empty_and_hostile_files_are_refused(text, message):
    assert recognises(text)
    with pytest.raises(gimcli.ModelError, match=message):
        model_of(read(text, "f"))


def test_other_texts_are_not_recognised():
    for text in ("", "nodes:\n  A: [0, 0]", "<svg></svg>", "<linkage2x/>", "M[J[R]]", '{"linkage2": 1}'):
        assert not recognises(text)


def test_every_truncation_is_an_error_that_names_the_file():
    for end in range(len("<linkage2"), len(CRANK_ROCKER) - len("</linkage2>\n") + 10):
        with pytest.raises(gimcli.ModelError, match="f:"):
            read(CRANK_ROCKER[:end], "f")


def test_random_changes_give_a_model_or_an_error():
    chance = random.Random(15)
    signs = '<>"/= 0159.-eaX&\n'
    for _ in range(400):
        text = list(CRANK_ROCKER)
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(11, len(text))
            text[at : at + chance.randint(0, 3)] = chance.choice(signs)
        with suppress(gimcli.ModelError):
            model_of(read("".join(text), "f"))
