"""Mechanisms that are tangent in every position are solved, with a status that says so."""

from __future__ import annotations

import numpy as np
import pytest

import gimcli
from gimcli.status import Status

RAILS = """
nodes: {L: [0, 0], l: [0, 1], R: [1.2, 0], r: [1.2, 1], A: [0, 0.3], B: [1.2, 0.3]}
ground: [L, l, R, r]
links: {bar: [A, B]}
prismatic: {left: {node: A, guide: [L, l]}, right: {node: B, guide: [R, r]}}
actuators: {lift: {node: A, guide: [L, l], law: {from: 0.3, to: 0.8}}}
"""
CIRCLES = """
nodes: {O: [0, 0], A: [1, 0], B: [3, 0]}
ground: [O]
links: {inner: [O, A], bar: {nodes: [A, B], length: 2}, outer: {nodes: [O, B], length: 3}}
actuators: {motor: {pivot: O, arm: A, law: {from: 0, to: 360}}}
"""


@pytest.mark.parametrize("steps", [1, 7, 360])
def test_a_bar_as_long_as_the_distance_of_its_rails_stays_horizontal(steps):
    found = gimcli.trace(gimcli.loads(RAILS), steps=steps)
    assert set(found["status"]) == {"tangent"}
    assert found.solved == steps + 1
    assert np.max(np.abs(found["B.y"] - found["lift"])) < 1e-8
    assert np.max(np.abs(found["B.x"] - 1.2)) < 1e-8


@pytest.mark.parametrize("steps", [9, 90])
def test_a_bar_between_concentric_circles_stays_radial(steps):
    """OB = 3 is OA + AB = 1 + 2: B is on the ray of A at three times the distance."""
    found = gimcli.trace(gimcli.loads(CIRCLES), steps=steps)
    assert set(found["status"]) == {"tangent"}
    ray = np.exp(1j * np.radians(found["motor"]))
    assert np.max(np.abs(found["B.x"] + 1j * found["B.y"] - 3 * ray)) < 1e-8


def test_one_position_is_solved_and_says_what_it_is():
    found = gimcli.solve(gimcli.loads(RAILS), lift=0.7)
    assert found.status == "tangent"
    assert found.answered
    assert found.xy["B"] == pytest.approx([1.2, 0.7], abs=1e-8)
    assert found.reason == Status.TANGENT.text


def test_mobility_does_not_promise_other_positions():
    assert gimcli.mobility(gimcli.loads(RAILS)).status == "tangent"


def test_a_longer_bar_is_regular_and_a_shorter_one_is_not_assembled():
    longer = gimcli.trace(gimcli.loads(RAILS.replace("[A, B]", "{nodes: [A, B], length: 1.21}")), steps=4)
    assert set(longer["status"]) == {"ok"}
    shorter = gimcli.trace(gimcli.loads(RAILS.replace("[A, B]", "{nodes: [A, B], length: 1.19}")), steps=4)
    assert set(shorter["status"]) == {"not-assembled"}


def test_a_limit_is_not_tangent():
    """A stretched dyad is tangent in one position: behind it nothing is assembled."""
    limit = """
nodes: {O: [0, 0], C: [3, 0], A: [-1, 0], B: [1, 0]}
ground: [O, C]
links: {crank: [O, A], rod: {nodes: [A, B], length: 2}, rocker: {nodes: [B, C], length: 2}}
actuators: {motor: {pivot: O, arm: A, law: {from: 180, to: 90}}}
"""
    assert set(gimcli.trace(gimcli.loads(limit), steps=4)["status"]) == {"ok"}


def test_sweeps_have_the_rows_that_are_tangent():
    got = gimcli.sweep(gimcli.loads(RAILS), {"lift.to": [0.7, 0.8]}, steps=12, keep=["solved", "max(B.y)"])
    assert got["solved"].tolist() == [13.0, 13.0]
    assert got["max(B.y)"] == pytest.approx([0.7, 0.8], abs=1e-8)
    assert list(got.status) == ["tangent", "tangent"]
    assert got.solved == 2
