"""Drawn gears: circles that touch, belts that are tangent, racks in contact, marks that turn; by plane geometry."""

import json
import re

import ezdxf
import numpy as np
import pytest
from drawn_styles import strokes
from in_process import gim

import gimcli
from gimcli.output import style
from gimcli.output.drawing import motion_picture
from gimcli.output.gear_symbols import belt_path
from gimcli.output.scene import Scene


def scene_of(name, steps=24):
    mechanism = gimcli.load(name)
    motion = gimcli.trace(mechanism, steps)
    return Scene(mechanism, np.stack([motion.xy[node] @ [1.0, 1.0j] for node in mechanism.nodes], axis=1))


def length(path):
    return np.sum(np.abs(np.diff(path)))


@pytest.mark.parametrize(("crossed", "sense"), [(False, 1.0), (True, -1.0)])
def test_the_length_of_a_belt_agrees_with_the_closed_form(crossed, sense):
    """Source: Shigley, Mechanical Engineering Design, section 17-2, equations for open and crossed belts."""
    r, s, away = 30.0, 12.0, 100.0
    path = belt_path((r, s), crossed, away, count=4001)
    lean = np.arcsin((r - sense * s) / away)
    exact = 2.0 * away * np.cos(lean) + r * (np.pi + 2 * lean) + s * (np.pi - sense * 2 * lean)
    assert length(path) == pytest.approx(exact, rel=1e-6)


def test_the_strands_of_an_open_belt_do_not_cross_and_those_of_a_crossed_one_do():
    for crossed in (False, True):
        path = belt_path((20.0, 10.0), crossed, 100.0, count=33)
        ends = path[[32, 33]], path[[65, 66]]
        assert [end.imag.prod() < 0 for end in ends] == [crossed, crossed]


def test_a_train_has_each_circle_once_and_they_touch():
    scene = scene_of("planetary_gear")
    sun, planet, ring = scene.gears
    assert [(w.radius, style.RIM in {stroke.style for stroke in w.strokes}) for w in (sun, planet, ring)] == [
        (pytest.approx(20), False), (pytest.approx(20), False), (pytest.approx(60), True)]  # fmt: skip
    apart = np.abs(scene.place(planet.seat.at, scene.poses) - scene.place(sun.seat.at, scene.poses))
    assert np.allclose(apart, sun.radius + planet.radius)
    assert np.allclose(apart, ring.radius - planet.radius)
    shown = scene.extent()
    assert (shown.real.min(), shown.imag.max()) == (pytest.approx(-60), pytest.approx(60))


def test_the_pitch_line_of_a_rack_touches_the_pinion_in_every_pose():
    scene = scene_of("rack_lift")
    pinion, line = scene.gears
    first, second = (scene.place(end, scene.poses) for end in line.ends)
    pivot = scene.place(pinion.seat.at, scene.poses)
    away = ((pivot - first) * np.conj(second - first) / np.abs(second - first)).imag
    assert np.allclose(np.abs(away), 30.0)
    assert np.allclose([first.real, second.real], 30.0)  # on the side of the rack
    contact = pivot + 30.0
    assert np.all((contact - first).imag * (contact - second).imag <= -29.9 * 29.9)  # a radius beyond on both sides


def test_marks_turn_with_the_wheel_and_a_fixed_ring_has_none():
    scene = scene_of("cardan_gear")
    picture = motion_picture(scene.mechanism, scene.poses, {}, "")
    assert len(strokes(picture)[style.RIM]) == 1
    assert len(strokes(picture)[style.TICK]) == 3  # of the planet
    assert len(strokes(picture)[style.PITCH]) == 2
    turned = motion_picture(scene.mechanism, scene.poses[6:7], {}, "")  # crank at 90 deg, planet at -90 deg
    marks = [np.array(strokes(one)[style.TICK])[:, 0] - at for one, at in ((picture, 40), (turned, 40j))]
    assert np.allclose(np.sort_complex(marks[1]), np.sort_complex(-1j * marks[0]))


def test_nothing_is_drawn_of_a_belt_by_its_ratio_and_no_arrow_of_what_gears_turn():
    scene = scene_of("belt_drive", 4)
    wheels, belts = scene.gears[:-3], {gear.name: gear for gear in scene.gears[-3:]}
    assert {wheel.name for wheel in wheels if wheel.radius} == set(belts) == {"belt", "twist", "chain"}
    assert [drive.name for drive in scene.drives] == ["motor"]
    assert [drive.name for drive in scene_of("deltoid", 4).drives] == ["motor", "second"]
    first, second = (complex(scene.place(end, scene.poses[0])) for end in belts["chain"].ends)
    near, far = np.split(belts["chain"].strokes[0].lengths[:-1], 2)
    assert np.abs(near) == pytest.approx(15 * 12.7 / (2 * np.pi))
    assert np.abs(far - abs(second - first)) == pytest.approx(30 * 12.7 / (2 * np.pi))


def test_each_gear_has_a_layer_with_circles_in_true_size(tmp_path):
    gim("solve", "geared_five_bar", "-o", tmp_path / "g.dxf")
    found = ezdxf.readfile(tmp_path / "g.dxf").modelspace().query('CIRCLE[layer=="gear mesh"]')
    assert sorted((c.dxf.radius, c.dxf.center.x) for c in found) == [pytest.approx((20, 60)), pytest.approx((40, 0))]


def test_svg_pictures_and_pages_have_the_gears(tmp_path):
    gim("trace", "belt_drive", "--steps", "4", "-o", tmp_path / "b.svg", "-o", tmp_path / "b.html")
    assert all(f'id="gear:{name}"' in (tmp_path / "b.svg").read_text() for name in ("belt", "twist", "chain"))
    page = (tmp_path / "b.html").read_text()
    scene = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])["scene"]
    dashed = [one for one in scene["strong"] if one.get("dash") == list(style.PITCH.dash)]
    assert len(dashed) == sum(gear.radius > 0.0 for gear in scene_of("belt_drive", 4).gears)
