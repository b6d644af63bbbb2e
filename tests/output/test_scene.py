"""The symbols of a mechanism: their places follow the nodes in every position."""

from __future__ import annotations

import numpy as np
import pytest
from bundled import FILES
from strut import STRUT

import gimcli
from gimcli.mechanism import FRAME
from gimcli.output import symbols
from gimcli.output.anchors import Anchor
from gimcli.output.scene import Scene


@pytest.fixture(scope="module")
def strut():
    mechanism = gimcli.loads(STRUT)
    motion = gimcli.trace(mechanism, 2)
    return Scene(mechanism, np.array([motion.xy[n] @ [1, 1j] for n in mechanism.nodes]).T)


@pytest.mark.few
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_points_of_members_are_at_their_nodes(path):
    mechanism = gimcli.load(path)
    motion = gimcli.trace(mechanism, 7)
    poses = np.array([motion.xy[n] @ [1, 1j] for n in mechanism.nodes]).T
    scene = Scene(mechanism, poses[np.isfinite(poses).all(axis=1)])
    error = [
        np.max(np.abs(scene.place(scene.on(k, complex(place)), scene.poses) - scene.poses[:, node]))
        for k, member in enumerate(mechanism.members)
        for node, place in zip(member.nodes, member.shape, strict=True)
    ]
    assert max(error) < 1e-8 * mechanism.size * mechanism.scale
    for guide, *_, block in scene.sliders:
        ends = [scene.line(guide.ends, z) for z in scene.poses]
        reach = [(z[pin.node] - first) / (last - first)
                 for z, (first, last) in zip(scene.poses, ends, strict=True) for pin in block.ends]  # fmt: skip
        assert np.all(np.abs(np.imag(reach)) < 1e-7)
        assert np.min(np.real(reach)) > -1e-9
        assert np.max(np.real(reach)) < 1 + 1e-9


def test_carried_places_turn_with_the_arm(strut):
    quarter = strut.poses[2]  # the arm points upwards
    assert strut.place(strut.centres[0].seat.at, quarter) == pytest.approx(-20 + 100j)
    assert strut.place(strut.loads[0].seat.at, quarter) == pytest.approx(300j)
    assert strut.turn(1, quarter) == pytest.approx(1j)


def test_springs_and_dampers_with_the_same_ends_are_side_by_side(strut):
    coil, bush, shock = strut.elements
    assert coil.ends == shock.ends == (Anchor(2), Anchor(3))
    middles = [np.mean(np.imag(one.strokes[-1].points)) for one in (coil, shock)]  # of the coil, and of the piston
    assert middles == [pytest.approx(-0.5 * symbols.LANE), pytest.approx(0.5 * symbols.LANE)]
    pivot, reference, arm = (strut.place(end, strut.poses[2]) for end in bush.ends)
    assert bush.ends[0] == Anchor(0)
    assert np.angle(arm - pivot) == pytest.approx(np.pi / 2)
    assert np.angle(reference - pivot) == pytest.approx(0.0)


@pytest.mark.parametrize(("model", "name"), [("hatch", "strut"), ("suspension", "tyre")])
def test_a_spring_and_a_damper_of_one_name_are_side_by_side(model, name):
    mechanism = gimcli.load(model)
    elements = Scene(mechanism, mechanism.to_file(mechanism.drawn)).elements
    spring, damper = (one for one in elements if one.name == name)
    assert spring.ends == damper.ends
    upper = [max(np.imag(stroke.points).max() for stroke in one.strokes if np.size(stroke.points) > 2)
             for one in (damper, spring)]  # fmt: skip
    assert upper[0] - upper[1] == pytest.approx(symbols.LANE + symbols.CUP - symbols.COIL)


def test_loads_are_relative_to_the_largest(strut):
    tyre, side, brake = strut.loads
    assert tyre.seat.along == pytest.approx(1j)
    assert tyre.seat.member == FRAME
    assert side.seat.along * strut.turn(side.seat.member, strut.poses[2]) == pytest.approx(1j)
    lengths = [
        np.ptp(one.strokes[0].points.real) + symbols.NECK * 7.0 for one in (tyre, side)
    ]  # the line ends in the head
    assert lengths == [pytest.approx(symbols.LONGEST), pytest.approx(0.5 * (symbols.SHORTEST + symbols.LONGEST))]
    first, second = brake.strokes[0].points[:2]
    assert (first.conjugate() * second).imag < 0.0  # clockwise


def test_a_pivot_that_carries_only_a_spring_is_supported_from_above(strut):
    assert {support.seat.at.node: support.aside for support in strut.supports} == {0: -1j, 2: 1j}
