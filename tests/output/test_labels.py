"""Names of nodes: the printed letters overlap no others, and are near their node or joined to it by a line."""

from __future__ import annotations

import numpy as np
import pytest
from bundled import FILES
from canvases import canvas_of
from drawn_styles import strokes
from matplotlib.backends.backend_agg import FigureCanvasAgg

import gimcli
from gimcli.output.drawing import motion_picture, position_picture
from gimcli.output.labels import Labels
from gimcli.output.picture import Frame, Picture
from gimcli.output.style import LEADER, LINK, PIN

NEAR = 14.0
"""Largest distance of a name from its node without a line [pt]."""


def printed_boxes(picture):
    """Return the names and their boxes (left, right, bottom, top) in points, as matplotlib measures the letters."""
    canvas = canvas_of(FigureCanvasAgg, picture)
    (axes,) = canvas.figure.axes
    points, renderer = 72.0 / canvas.figure.dpi, canvas.get_renderer()
    found = [(text.get_text(), text.get_window_extent(renderer)) for text in axes.texts]
    pixels = axes.transData.transform
    return {
        name: np.array([b.x0, b.x1, b.y0, b.y1]) * points for name, b in found
    }, lambda z: pixels([[z.real, z.imag]])[0] * points


def distance(box, at):
    """Return the distance of a point from a box, 0 inside."""
    return float(np.hypot(*(max(low - x, 0.0, x - high) for low, high, x in zip(box[::2], box[1::2], at, strict=True))))


def assert_names_are_clear(picture, places):
    boxes, on_paper = printed_boxes(picture)
    assert set(boxes) == set(places)
    names = list(boxes)
    for k, a in enumerate(names):
        for b in names[:k]:
            one, two = boxes[a], boxes[b]
            apart = one[0] >= two[1] or two[0] >= one[1] or one[2] >= two[3] or two[2] >= one[3]
            assert apart, (a, b)
    leaders = [[on_paper(z) for z in path] for path in strokes(picture).get(LEADER, ())]
    for name, box in boxes.items():
        at = on_paper(places[name])
        led = any(np.hypot(*(start - at)) < 5.0 and distance(box, end) < 4.5 for start, end in leaders)
        assert led or distance(box, at) <= NEAR, name
    frame = picture.frame
    low, high = on_paper(frame.low), on_paper(frame.high)
    for name, box in boxes.items():
        inside = low[0] <= box[0], box[1] <= high[0], low[1] <= box[2], box[3] <= high[1]
        assert all(inside), name


@pytest.mark.few
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_names_in_the_drawing_of_each_model(path):
    mechanism = gimcli.load(path)
    z = mechanism.to_file(mechanism.drawn)
    picture = position_picture(mechanism, z, "", {})
    points = {p.name for p in mechanism.points}
    places = dict(zip(mechanism.nodes, z, strict=True))
    places |= {name: anchored(mechanism, z, name) for name in points}
    assert_names_are_clear(picture, places)


def anchored(mechanism, z, name):
    """Return the place of a carried point, from the two nodes of its member that are farthest apart in its shape."""
    point = next(p for p in mechanism.points if p.name == name)
    member = mechanism.members[point.member]
    shape, nodes = member.shape * mechanism.scale, z[list(member.nodes)]
    if point.member == 0:
        return point.local * mechanism.scale + mechanism.origin
    far = int(np.argmax(np.abs(shape - shape[0])))
    turn = (nodes[far] - nodes[0]) / (shape[far] - shape[0]) if far else 1.0
    return complex(nodes[0] + turn * (point.local * mechanism.scale - shape[0]))


@pytest.mark.parametrize("name", ["ten_bar", "excavator", "jansen", "double_butterfly", "floating_hexagon"])
def test_names_among_paths_and_light_poses(name):
    path = next(path for path in FILES if path.stem == name)
    mechanism = gimcli.load(path)
    motion = gimcli.trace(mechanism, 8)
    poses = np.array([motion.xy[n] @ [1, 1j] for n in mechanism.nodes]).T
    poses = poses[np.isfinite(poses).all(axis=1)]
    places = {n: complex(z) for n, z in zip(mechanism.nodes, poses[0], strict=True)}
    places |= {p.name: anchored(mechanism, poses[0], p.name) for p in mechanism.points}
    curves = {n: motion.xy[n] @ [1, 1j] for n in mechanism.traced}
    assert_names_are_clear(motion_picture(mechanism, poses, curves, ""), places)


def picture_of(width):
    return Picture("", Frame(0j, complex(width, width), width, width))


def test_a_name_avoids_the_lines_that_leave_its_node():
    """A link to the right and one upwards: the name is to the left or below."""
    picture = picture_of(2.0)
    picture.draw(LINK, [1 + 1j, 2 + 1j], [1 + 1j, 1 + 2j], [1 + 1j, 2 + 2j])
    picture.draw(PIN, 1 + 1j)
    labels = Labels(picture)
    labels.beside(1 + 1j, "A")
    labels.write()
    (text,) = picture.texts
    assert text.at.real < 1.0 or text.at.imag < 1.0
    assert not text.halo
    assert LEADER not in strokes(picture)


def test_names_of_many_nodes_at_one_place_are_joined_to_it_by_lines():
    picture = picture_of(4.0)
    picture.draw(PIN, 2 + 2j)
    labels = Labels(picture)
    for k in range(30):
        labels.beside(2 + 2j, f"long name {k}")
    labels.write()
    assert len(strokes(picture)[LEADER]) >= 15
    assert_names_are_clear(picture, {f"long name {k}": 2 + 2j for k in range(30)})


def test_a_name_over_lines_has_a_light_edge():
    picture = picture_of(1.0)
    for y in np.linspace(0.02, 0.98, 40):
        picture.draw(LINK, [1j * y, 1 + 1j * y])
    labels = Labels(picture)
    labels.beside(0.5 + 0.5j, "A")
    labels.write()
    assert picture.texts[0].halo
