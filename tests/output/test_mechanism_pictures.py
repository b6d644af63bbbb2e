"""What is drawn of a mechanism: groups in their colours, numbered moves, circuits, springs, loads, centres of mass."""

from __future__ import annotations

import numpy as np
import pytest
from bundled import MODELS
from drawn_styles import areas, strokes
from strut import STRUT

import gimcli
from gimcli.output.circuits import _alike
from gimcli.output.curves import overlap
from gimcli.output.drawing import motion_picture
from gimcli.output.picture import Sheet
from gimcli.output.style import CENTRE, GHOST, LOAD, PALETTE, SPRING, curve_pen, group_colour, tint
from gimcli.output.symbols import CENTRE_RADIUS, COIL, LANE, LONGEST


def load(name):
    return gimcli.load(MODELS / f"{name}.yaml")


# ---------------------------------------------------------------- groups and sequences


@pytest.fixture(scope="module")
def jansen():
    """The groups of Jansen's leg: the crank m, then the dyads (j, bde), (k, c) and (f, g)."""
    return gimcli.groups(load("jansen")).picture().pictures


def test_links_have_the_colour_of_their_group(jansen):
    """The links are recognised by their lengths, Jansen's numbers m, j, k, c and f."""
    drawing = jansen[0]
    for number, length in ((1, 15.0), (2, 50.0), (3, 61.9), (3, 39.3), (4, 39.4)):
        found = [pen.color for pen, paths in strokes(drawing).items() for path in paths if len(path) == 2 and
                 abs(abs(path[1] - path[0]) - length) < 0.01]  # fmt: skip
        assert found == [group_colour(number)], length
    plates = {fill.edge: fill.face for fill in areas(drawing) if fill.edge in PALETTE}
    assert plates == {group_colour(k): tint(group_colour(k)) for k in (2, 4)}


def test_each_link_has_the_number_of_its_group(jansen):
    """The numbers remain where a print has no colours."""
    rings = sorted(text.text for text in jansen[0].texts if text.ring)
    assert rings == ["1", "2", "2", "3", "3", "4", "4"]
    assert [name for name, _ in jansen[0].legend] == [
        "1: driving link, turning (m)", "2: dyad RRR (j, bde)", "3: dyad RRR (k, c)", "4: dyad RRR (f, g)",
    ]  # fmt: skip
    boxes = [fill.edge for fill, boxes in areas(jansen[1]).items() for _ in boxes if fill.edge in PALETTE]
    assert boxes == [group_colour(k) for k in (1, 2, 3, 4)]


def test_neighbouring_groups_differ_in_grey():
    grey = [np.dot([int(c[k : k + 2], 16) for k in (1, 3, 5)], [0.299, 0.587, 0.114]) for c in PALETTE]
    assert min(abs(np.diff(grey))) > 12.0


@pytest.mark.parametrize("name", ["jansen", "double_butterfly", "ten_bar"])
def test_every_move_has_its_number_on_the_mechanism_and_in_the_table(name):
    found = gimcli.sequence(load(name))
    drawing, table = found.picture().pictures
    count = len(found["node"])
    names = {*found.mechanism.nodes, *(p.name for p in found.mechanism.points)}
    numbers = [n for text in drawing.texts if text.text not in names for n in text.text.split(", ")]
    assert sorted(map(int, numbers)) == list(range(1, count + 1))
    lines = [text.text for text in table.texts]
    rows = zip(found["node"], found["about"], found["constraint"], strict=True)
    assert lines == [
        f"{k}  {node} about {', '.join(about.split())}: {constraint}"
        for k, (node, about, constraint) in enumerate(rows, 1)
    ]


# ---------------------------------------------------------------- circuits


DOUBLE_CRANK = {
    "nodes": {"O": [0, 0], "C": [1, 0], "A": [0, 3], "B": [3, 3.5]},
    "ground": ["O", "C"],
    "links": {"crank": ["O", "A"], "coupler": ["A", "B"], "follower": ["C", "B"]},
    "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"by": 360}}},
    "trace": ["A", "B"],
}
"""The frame is the shortest link, 1 + 4.04 < 3 + 3.05: both cranks turn fully on both circuits (Grashof)."""


def test_paths_that_are_the_same_on_all_circuits_are_not_drawn():
    """All nodes of a double crank have the same circles on both circuits: these are side by side, without paths."""
    content = gimcli.circuits(gimcli.load(DOUBLE_CRANK), values=8).picture()
    assert content.columns == 2
    assert [panel.title for panel in content.pictures] == ["circuit 1", "circuit 2"]
    assert not any(curve_pen(0) in strokes(panel) for panel in content.pictures)


def test_circuits_with_different_paths_are_in_one_picture():
    content = gimcli.circuits(load("crank_rocker"), values=8).picture()
    assert isinstance(content, Sheet)
    assert not content.columns
    assert [name for name, _ in content.pictures[0].legend] == ["P, circuit 1", "P, circuit 2"]


def test_the_same_path_in_other_points_or_the_other_direction_is_found():
    turn = np.exp(1j * np.linspace(0.0, 2 * np.pi, 361))
    later = np.exp(1j * (np.linspace(0.0, 2 * np.pi, 500) + 0.7))
    arc = np.exp(1j * np.linspace(0.0, 3.0, 200))
    assert _alike([turn, later, turn[::-1], arc, 1.1 * turn]) == [[0, 1, 2], [3], [4]]
    assert _alike([np.full(5, 2 + 1j)] * 3) == [[0, 1, 2]]


def test_paths_that_overlap_are_drawn_the_first_one_widest():
    arc, more = (np.exp(1j * np.linspace(low, high, 200)) for low, high in ((0.0, 2.0), (1.5, 3.0)))
    assert overlap(arc, more, 1e-3)
    assert overlap(more, arc, 1e-3)
    assert not overlap(arc, 1.01 * more, 1e-3)
    assert not overlap(arc, np.linspace(0.0, 3.0, 200) + 0j, 1e-3)
    mechanism = gimcli.load(DOUBLE_CRANK)
    curves = {"one": arc, "two": more, "three": more}
    z = mechanism.to_file(mechanism.drawn)
    pens = [key for _, key in motion_picture(mechanism, z, curves, "", nested=True).legend]
    assert all(np.diff([pen.width for pen in pens]) < -1.0)


def test_a_simulation_draws_the_mechanism_above_its_graphs():
    found = gimcli.simulate(load("watt_durango"), 0.2, dt=0.05)
    drawing, *graphs = found.picture().pictures
    assert drawing.labels == ("x [m]", "y [m]")
    assert len(strokes(drawing)[GHOST]) > 0
    assert [name for name, _ in drawing.legend] == list(found.mechanism.traced)
    assert len(graphs) == 3


# ---------------------------------------------------------------- springs, dampers, loads, centres of mass


@pytest.fixture(scope="module")
def strut():
    """The arm is horizontal: A (0, 0), E (180, 0), B (300, 0); the strut goes from S (60, 380) to E."""
    return gimcli.solve(gimcli.loads(STRUT)).picture()


def test_a_spring_and_a_damper_are_beside_the_line_of_their_ends(strut):
    first, second, pt = 60 + 380j, 180 + 0j, strut.frame.point
    along = (second - first) / abs(second - first)
    offset = [((path - first) / along).imag / pt for path in strokes(strut)[SPRING] if len(path) > 2]
    coil = next(path for path, aside in zip(
        [p for p in strokes(strut)[SPRING] if len(p) > 2], offset, strict=True) if np.ptp(aside) > 1.9 * COIL and
        abs(aside.mean() + LANE / 2) < 1.0)  # fmt: skip
    ends = first - 1j * along * LANE / 2 * pt, second - 1j * along * LANE / 2 * pt
    np.testing.assert_allclose(coil[[0, -1]], ends, atol=1e-9 * abs(second - first))
    lines = [path for path in strokes(strut)[SPRING] if len(path) == 2]
    starts = {complex(np.round(path[0], 6)) for path in lines}
    assert {60 + 380j, 180 + 0j} <= starts


def test_a_force_begins_at_its_point_in_its_direction(strut):
    (up, right), pt = [path for path in strokes(strut)[LOAD] if len(path) == 2], strut.frame.point
    assert up[0] == right[0] == pytest.approx(300.0)
    assert np.angle(up[-1] - up[0]) == pytest.approx(np.pi / 2)
    assert np.angle(right[-1] - right[0]) == pytest.approx(0.0, abs=1e-9)
    assert 0.8 * LONGEST * pt < abs(up[-1] - up[0]) <= LONGEST * pt
    assert abs(right[-1] - right[0]) < 0.8 * abs(up[-1] - up[0])


def test_a_torque_is_an_arc_in_its_sense_about_the_middle_of_its_member(strut):
    (arc,) = [path for path in strokes(strut)[LOAD] if len(path) > 2]
    about = arc - 160.0  # the mean of A, B and E
    assert np.ptp(np.abs(about[:-1])) < 1e-9
    assert np.all(np.diff(np.unwrap(np.angle(about[:-1]))) < 0.0)


def test_a_centre_of_mass_is_where_the_file_says(strut):
    (circle,) = areas(strut)[CENTRE]
    np.testing.assert_allclose(np.abs(circle - (100 + 20j)), CENTRE_RADIUS * strut.frame.point, rtol=1e-9)


def test_a_spiral_spring_goes_from_its_reference_to_its_arm_without_a_jump():
    """The spring of the snap hinge at B is between the members B-C and B-A, in every position of the motion."""
    mechanism = load("snap_hinge")
    motion = gimcli.trace(mechanism, 24)
    turns = []
    for k in range(25):
        shown = [motion.xy[name] @ [1, 1j] for name in mechanism.nodes]
        poses = np.roll(np.array(shown).T, -k, axis=0)
        picture = motion_picture(mechanism, poses, {}, "")
        (spiral,) = strokes(picture)[SPRING]
        a, b, c = (complex(motion.xy[name][k] @ [1, 1j]) for name in "ABC")
        ends = (spiral[[0, -1]] - b) / np.abs(spiral[[0, -1]] - b)
        expected = sorted([(a - b) / abs(a - b), (c - b) / abs(c - b)], key=np.angle)
        np.testing.assert_allclose(sorted(ends, key=np.angle), expected, atol=1e-6)
        turns.append(float(np.sum(np.diff(np.unwrap(np.angle(spiral - b))))))
    assert np.max(np.abs(np.diff(turns))) < np.pi
