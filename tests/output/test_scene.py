"""The items that are drawn of a mechanism: their places follow the nodes in every position."""

from __future__ import annotations

import numpy as np
import pytest
from bundled import FILES
from strut import STRUT

import gimcli
from gimcli.output.anchors import Anchor
from gimcli.output.scene import Scene


@pytest.fixture(scope="module")
def strut():
    mechanism = gimcli.loads(STRUT)
    motion = gimcli.trace(mechanism, 2)
    return Scene(mechanism, np.array([motion.xy[n] @ [1, 1j] for n in mechanism.nodes]).T)


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
    for slider in scene.sliders:
        reach = [np.ravel((z[n] - scene.ends(slider, z)[0]) / (scene.ends(slider, z)[1] - scene.ends(slider, z)[0]))
                 for z in scene.poses for n in slider.nodes]  # fmt: skip
        assert np.all(np.abs(np.imag(reach)) < 1e-7)
        assert np.min(np.real(reach)) > -1e-9
        assert np.max(np.real(reach)) < 1 + 1e-9


def test_carried_places_turn_with_the_arm(strut):
    quarter = strut.poses[2]  # the arm points upwards
    assert strut.place(strut.centres[0], quarter) == pytest.approx(-20 + 100j)
    assert strut.place(strut.loads[0].at, quarter) == pytest.approx(300j)
    assert strut.turn(1, quarter) == pytest.approx(1j)


def test_springs_and_dampers_with_the_same_ends_are_side_by_side(strut):
    coil, bush, shock = strut.elements
    assert coil.ends == shock.ends == (Anchor(2), Anchor(3))
    assert (coil.lane, shock.lane, bush.lane) == (-0.5, 0.5, 0.0)
    assert bush.pivot == 0
    arm, reference = (strut.place(end, strut.poses[2]) for end in bush.ends)
    assert np.angle(arm) == pytest.approx(np.pi / 2)
    assert np.angle(reference) == pytest.approx(0.0)


def test_loads_are_relative_to_the_largest(strut):
    tyre, side, brake = strut.loads
    assert tyre.force == pytest.approx(1j)
    assert not tyre.follower
    assert side.force * strut.turn(1, strut.poses[2]) == pytest.approx(0.5j)
    assert side.follower
    assert brake.torque == -1.0


def test_a_pivot_that_carries_only_a_spring_is_supported_from_above(strut):
    assert {support.node: support.upward for support in strut.supports} == {0: False, 2: True}
