"""Hodographs of pin forces in the frame and in a member, with the input along them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gimcli

MODEL = """
units: {length: mm}
nodes: {O: [0, 0], A: [300, 0]}
ground: [O]
links: {crank: [O, A]}
actuators: {motor: {pivot: O, arm: A, law: {from: 10, to: 370}}}
masses: {A: 2}
gravity: [0, -9.81]
"""


def test_a_rotating_mass_in_the_frame_and_in_the_crank():
    """In the frame a circle of m r w^2 about (0, m g), in the crank one of m g about (-m r w^2, 0)."""
    found = gimcli.forces(gimcli.loads(MODEL), 72, plot="hodograph:O,hodograph:O@crank")
    still, turned = found.graphs()
    push, weight = 2 * 0.3 * (2 * math.pi) ** 2, 2 * 9.81
    assert np.hypot(still.curves[0].x, still.curves[0].y - weight) == pytest.approx(push)
    assert np.hypot(turned.curves[0].x + push, turned.curves[0].y) == pytest.approx(weight)
    texts = [mark.text for mark in still.marks]
    assert texts == [f"{angle}°" for angle in range(30, 361, 30)]
    for mark in still.marks:
        angle = math.radians(float(mark.text[:-1]))
        force = weight * 1j - push * complex(math.cos(angle), math.sin(angle))
        assert abs(mark.place - force) < 1e-3 * push  # between two rows
        assert abs((mark.normal.conjugate() * (force - weight * 1j)).real) > 0.99 * abs(mark.normal) * push


def test_a_pin_of_several_members_and_the_marks_over_time(tmp_path):
    model = gimcli.load("excavator")
    found = gimcli.forces(model, 24, plot="hodograph:H@boom")
    (graph,) = found.graphs()
    assert 2 <= len(graph.marks) <= 13
    found.save(tmp_path / "p.png", tmp_path / "p.svg", tmp_path / "p.pdf")
    assert (tmp_path / "p.svg").read_text(encoding="utf-8").startswith("<?xml")
