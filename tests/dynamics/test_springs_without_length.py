"""Springs of free length 0, also where their ends meet: the force is the vector k (a - b); closed forms."""

import math

import numpy as np
import pytest

import gimcli

G = 9.81

LAMP = f"""
nodes: {{O: [0, 0], H: [0, 0.4], A: [0.4, 0]}}
ground: [O, H]
links: {{arm: [O, A]}}
actuators: {{q: {{pivot: O, arm: A, law: {{from: 80, to: 100}}, free: true, start: 60}}}}
masses: {{A: 2}}
gravity: [0, -{G}]
springs: {{s: {{nodes: [H, A], stiffness: 100, free: 0}}}}
"""
RAIL = """
nodes: {O: [0, 0], H: [0.5, 0], X: [1, 0], A: [0.5, 0]}
ground: [O, X, H]
prismatic: {slide: {node: A, guide: [O, X]}}
actuators: {q: {node: A, guide: [O, X], law: {from: 0.3, to: 0.7}, free: true, start: 0.3}}
masses: {A: 4}
springs: {s: {nodes: [H, A], stiffness: 100, free: 0}}
"""
PENDULUMS = f"""
nodes: {{O: [0, 0], A: [0.6, 0], B: [1, 0], C: [1.3, 0], D: [0.6, -0.4]}}
ground: [O]
links: {{one: [O, A], two: [A, B]}}
elements: {{plate: [A, C, D]}}
actuators: {{q: {{pivot: O, arm: A}}, r: {{pivot: A, arm: B, reference: O}}, t: {{pivot: A, arm: D, reference: O}}}}
masses: {{B: 2, D: 1.5}}
gravity: [0, -{G}]
springs: {{s: {{nodes: [B, D], stiffness: 30, free: 0}}}}
"""


def potential(q):
    return 7.848 * np.sin(q) + 16 * (1 - np.sin(q))


@pytest.mark.parametrize("ends", ["[H, A]", "[A, H]"])
def test_a_balanced_lamp(ends):
    lamp = gimcli.loads(LAMP.replace("[H, A]", ends))
    found = gimcli.modes(lamp, q=90)
    assert found["omega"] == pytest.approx([5.04727649], abs=1e-8)
    assert found["modal_stiffness"] == pytest.approx([8.152], rel=1e-13)
    reduced, angles = gimcli.reduce(lamp, steps=4), np.radians([80, 85, 90, 95, 100])
    assert reduced["V"] == pytest.approx(potential(angles), rel=1e-13)
    assert reduced["tau"] == pytest.approx((16 - 7.848) * np.cos(angles), abs=1e-13)
    assert gimcli.forces(lamp, steps=4)["q.effort"] == pytest.approx(-(16 - 7.848) * np.cos(angles), abs=1e-13)
    found = {one["stability"]: one["inputs"]["q"] for one in gimcli.equilibrium(lamp).equilibria}
    assert found == {"stable": pytest.approx(90), "unstable": pytest.approx(-90)}


def test_a_block_on_a_rail():
    rail = gimcli.loads(RAIL)
    assert gimcli.modes(rail, q=0.5)["omega"] == pytest.approx([5], rel=1e-14)
    assert gimcli.forces(rail, steps=4)["q.effort"] == pytest.approx([-20, -10, 0, 10, 20], abs=1e-13)
    motion = gimcli.simulate(rail, 3.0)
    assert motion["q"] == pytest.approx(0.5 - 0.2 * np.cos(5 * motion["time"]), abs=1e-7)


@pytest.mark.parametrize("ends", ["[B, D]", "[D, B]"])
def test_both_ends_move(ends):
    """Two pendulums on one pin of a third link: V, and the efforts as its derivatives; at r = t the ends meet."""
    mechanism = gimcli.loads(PENDULUMS.replace("[B, D]", ends))
    for r, t in ((-90.0, -90.0), (-60.0, -90.0), (10.0, 200.0)):
        one, two = 0.4 * np.exp(1j * math.radians(r)), 0.4 * np.exp(1j * math.radians(t))
        found = gimcli.holding_forces(mechanism, q=0, r=r - 180, t=t - 180)
        pull = 30 * (two - one)
        assert found["t.effort"] == pytest.approx([(two.conjugate() * (1.5j * G + pull)).imag], abs=1e-12)
        assert found["r.effort"] == pytest.approx([(one.conjugate() * (2j * G - pull)).imag], abs=1e-12)


def test_the_law_of_a_free_length_above_0_is_kept():
    """With a free length the direction of the force is not determined where the ends meet."""
    rail = gimcli.loads(RAIL.replace("free: 0}", "free: 0.1}"))
    assert list(gimcli.forces(rail, steps=4)["status"]).count("ok") == 4
