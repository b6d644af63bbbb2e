"""SVG files: one group for each member, pair, node and curve, with its name."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim
from matplotlib.backends.backend_agg import FigureCanvasAgg

import gimcli
from gimcli.output import write
from gimcli.output.axes import PartNames
from gimcli.output.figure import drawn
from gimcli.output.printed import Printed
from gimcli.output.workspace import workspace_picture

SVG = "{http://www.w3.org/2000/svg}"


def groups(path):
    """Return the groups by identifier; every identifier of the file is used once."""
    found = [part for part in ElementTree.parse(path).iter() if part.get("id") is not None]
    names = [part.get("id") for part in found]
    assert len(names) == len(set(names))
    return {part.get("id"): part for part in found if part.tag == f"{SVG}g"}


def ends(group):
    """Return the first two points of a group's path, in the file's coordinates."""
    numbers = re.findall(r"-?[\d.]+", next(group.iter(f"{SVG}path")).get("d"))
    x1, y1, x2, y2 = map(float, numbers[:4])
    return complex(x1, -y1), complex(x2, -y2)


def test_a_motion_has_a_group_for_each_part(tmp_path):
    gimcli.trace(gimcli.load(MODELS / "crank_rocker.yaml"), steps=36).save(tmp_path / "m.svg")
    found = set(groups(tmp_path / "m.svg"))
    named = {name for name in found if ":" in name}
    assert named == {
        "member:crank", "member:coupler", "member:rocker", "actuator:motor", "node:O2", "node:O4", "node:A", "node:B",
        "point:P", "curve:P", "curve:B", "light-position:1", "light-position:2", "light-position:3",
    }  # fmt: skip
    assert "frame" in found


def test_a_group_has_the_lines_of_its_member(tmp_path):
    """The lengths in the file have the ratio 40 : 80 of the links; the crank has the direction of its input."""
    gimcli.solve(gimcli.load(MODELS / "crank_rocker.yaml"), motor=70).save(tmp_path / "m.svg")
    found = groups(tmp_path / "m.svg")
    (o2, a), (o4, b) = ends(found["member:crank"]), ends(found["member:rocker"])
    assert abs(b - o4) / abs(a - o2) == pytest.approx(2.0, rel=1e-5)
    assert np.degrees(np.angle(a - o2)) == pytest.approx(70.0, abs=1e-3)


def test_pairs_springs_and_other_parts_have_groups(tmp_path):
    gimcli.solve(gimcli.load(MODELS / "crank_shaper.yaml")).save(tmp_path / "m.svg")
    assert {"pair:slot", "member:arm", "member:crank", "frame"} <= set(groups(tmp_path / "m.svg"))
    circle, mechanism = np.exp(2j * np.pi * np.arange(12) / 12), gimcli.load(MODELS / "crank_rocker.yaml")
    region = workspace_picture(mechanism, None, {"outer": [circle], "inner": [circle / 2]}, ("B", None), None, "region")
    write(region, tmp_path / "w.svg")
    assert {"boundary", "region", "inner-curves"} <= set(groups(tmp_path / "w.svg"))


def test_a_part_of_several_panels_has_a_number(tmp_path):
    assert gim("solve", MODELS / "crank_rocker.yaml", "--all", "-o", tmp_path / "m.svg").code == 0
    assert {"member:crank", "member:crank-2", "node:A-2"} <= set(groups(tmp_path / "m.svg"))


NAMES = ["crank 1", 'a<b&"c"', "é-ü", "50%", "член", "_x0020_"]


@pytest.mark.parametrize("name", NAMES)
def test_names_with_other_letters_are_valid(name, tmp_path):
    data = {
        "nodes": {"O": [0, 0], "A": [1, 0]}, "ground": ["O"], "links": {name: ["O", "A"]},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
    }  # fmt: skip
    gimcli.solve(gimcli.load(data)).save(tmp_path / "m.svg")
    (member,) = (own for own in groups(tmp_path / "m.svg") if own.startswith("member:"))
    assert re.fullmatch(r"[\w.:-]+", member)


def test_other_letters_become_their_numbers():
    names = PartNames()
    assert names.of("member:crank 1") == "member:crank_x0020_1"
    assert names.of("member:a/b") == "member:a_x002F_b"
    assert [names.of("member:k"), names.of("member:k")] == ["member:k", "member:k-2"]


def test_groups_change_the_drawing_little():
    """Only light poses may cover each other in another order."""
    picture = gimcli.solve(gimcli.load(MODELS / "whitworth.yaml")).picture()

    def pixels(grouped):
        with drawn(FigureCanvasAgg, Printed(picture, dpi=60, grouped=grouped)) as canvas:
            canvas.draw()
            return np.asarray(canvas.buffer_rgba(), dtype=float)

    assert np.mean(np.abs(pixels(True) - pixels(False)) > 30) < 1e-3
