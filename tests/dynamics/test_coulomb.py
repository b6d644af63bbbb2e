"""Dry friction in `gim forces`: closed forms, laws, limits, and an independent formulation in body coordinates."""

from __future__ import annotations

import json
import math
from itertools import product

import numpy as np
import pytest
from body_coordinates import Block, Bodies, Pin, Slot
from bundled import MODELS
from heavy_models import motion_forces, on, weighted
from in_process import gim

import gimcli
from gimcli import ModelError
from gimcli.dynamics.coulomb_solver import FrictionStatus, FrictionSystem, solve_friction
from gimcli.dynamics.efficiency import row_efficiency, self_locking
from gimcli.dynamics.force_motion import ForceMotion
from gimcli.dynamics.statics import statics
from gimcli.motion.motion import stream, trace

MU = 0.1
SINE = MU / math.sqrt(1 + MU**2)  # a pin of radius rho / SINE has the friction circle rho


def moved(text, steps):
    motion = trace(gimcli.loads(text), steps)
    return motion, motion_forces(motion)


def friction_circle(mu, radius):
    return radius * math.sin(math.atan(mu))


def test_the_friction_circle():
    """The pin of radius 5 and mu = 3/4 has a circle of radius 3."""
    friction = gimcli.loads(CRANK % (0, 90) + "friction: {A: {mu: 0.75, radius: 5}}").dynamics.frictions[0]
    assert friction.circle / friction.radius == pytest.approx(0.6, rel=1e-15)


# --- slider-crank with friction circles: closed form -----------------------------------------------------

R, ROD, LOAD, RHO_O, RHO_A, RHO_B = 0.1, 0.3, -1000.0, 0.004, 0.004, 0.003
CRANK = """\
nodes: {O: [0, 0], A: [0.1, 0], B: [0.4, 0], C: [0.6, 0], G: [0, 0], H: [1, 0]}
ground: [O, G, H]
links: {crank: [O, A], rod: [A, B], ram: [B, C]}
prismatic: {guide: {nodes: [B, C], guide: [G, H]}}
actuators: {motor: {pivot: O, arm: A, law: {from: %s, to: %s}}}
loads: {press: {on: C, force: [-1000, 0]}}
"""
DRY = f"""\
friction:
  O: {{mu: 0.1, radius: {RHO_O / SINE!r}}}
  A: {{mu: 0.1, radius: {RHO_A / SINE!r}}}
  B: {{mu: 0.1, radius: {RHO_B / SINE!r}}}
  guide: {{mu: 0.1, length: 30}}
"""


def closed_form(t, w):
    """Return torque and rod force of the massless slider-crank, moving slowly with the sense w."""
    b = -np.arcsin(R * np.sin(t) / ROD)
    rate = -R * np.cos(t) / (ROD * np.cos(b))
    slide = -R * np.sin(t) - ROD * np.sin(b) * rate
    s1, s2, s3 = np.sign(w * (rate - 1)), np.sign(w * rate), np.sign(w * slide)
    tau = -np.arcsin((s1 * RHO_A + s2 * RHO_B) / ROD)
    ways = [b + np.pi - tau, b + tau]
    forces = [-LOAD / (np.cos(g) - MU * np.abs(np.sin(g)) * s3) for g in ways]
    g, rod = (np.where(forces[0] > 0, x, y) for x, y in (ways, forces))
    return rod * (R * np.sin(g - t) - s1 * RHO_A + w * RHO_O), rod


@pytest.mark.parametrize("sense", [1, -1])
def test_friction_circles_of_a_slider_crank(sense):
    _, found = moved(CRANK % (-3, -3 + sense * 360) + DRY, 36)
    t = found.course.inputs[0]
    torque, rod = closed_form(t, sense)
    assert np.all(found.good)
    assert found.effort(0) == pytest.approx(torque, rel=1e-12)
    pin = next(p for p in found.statics.pins if found.mechanism.nodes[p.node] == "A")
    assert np.abs(found.pin(pin, 2)) == pytest.approx(rod, rel=1e-12)
    assert np.max(found.dry.residual) < 1e-14


TABLE = {
    30: (-53.70449272677806, -76.34812752417136), 60: (-89.63827444792689, -115.1444280789914),
    120: (-61.52842517764716, -82.2180463966746), 240: (82.2180463966746, 61.52842517764716),
    300: (115.1444280789914, 89.63827444792689),
}  # fmt: skip
"""Torques at w = 1 and w = -1, computed with 40 digits."""


@pytest.mark.parametrize("degrees", TABLE)
def test_the_digits_of_the_slider_crank(degrees):
    for sense, torque in zip((1, -1), TABLE[degrees], strict=True):
        _, found = moved(CRANK % (degrees, degrees + sense * 10) + DRY, 1)
        assert found.effort(0)[0] == pytest.approx(torque, rel=1e-13)
        assert found.dry.hold[:, 0, 0] == pytest.approx(sorted(TABLE[degrees]), rel=1e-13)


def test_the_guide_reaction_of_the_slider_crank():
    _, found = moved(CRANK % (60, 70) + DRY, 1)
    pin = next(p for p in found.statics.pins if found.mechanism.nodes[p.node] == "B")
    assert found.normal("guide")[0] == pytest.approx(268.8027139140414, rel=1e-13)
    assert found.pin(pin, 3)[0] == pytest.approx(973.1197286085959 - 268.8027139140414j, rel=1e-13)


def test_the_crank_is_locked_near_the_dead_centres():
    """The load drives the crank from 0 to 180 deg, and cannot below 4.445... and above 173.410... deg."""
    found = ForceMotion(gimcli.loads(CRANK % (0.5, 179.5) + DRY), 359)
    found.take(trace(gimcli.loads(CRANK % (0.5, 179.5) + DRY), 358))
    (first, end), (again, last) = found.friction.locked
    assert (first, end, again, last) == pytest.approx((0.5, 4.44518241716349, 173.410088246875554, 179.5), abs=1e-3)


def test_the_reversed_motion_mirrored_has_the_reversed_torque():
    _, one = moved(CRANK % (10, 350) + DRY, 34)
    _, two = moved(CRANK % (-10, -350) + DRY, 34)
    good = one.good & two.good
    assert good.sum() > 30
    assert one.effort(0)[good] == pytest.approx(-two.effort(0)[good], rel=1e-13)


def test_rows_at_a_standstill_have_limits():
    """At the dead centre the slider stands; at rest all pairs stand, and the holding range is that of both senses."""
    _, found = moved(CRANK % (0, 120) + DRY, 2)
    assert found.dry.codes.tolist() == [FrictionStatus.STANDSTILL, 0, 0]
    assert np.isnan(found.effort(0)[0])
    near = [closed_form(np.array(t), 1)[0] for t in (-1e-9, 1e-9)]
    assert found.dry.effort[:, 0, 0] == pytest.approx(sorted(near), rel=1e-6)
    _, found = moved((CRANK % (60, 110)).replace("to: 110", "to: 110, profile: quintic") + DRY, 2)
    assert found.dry.codes.tolist() == [FrictionStatus.STANDSTILL, 0, FrictionStatus.STANDSTILL]
    assert found.dry.effort[:, 0, 0] == pytest.approx((TABLE[60][1], TABLE[60][0]), rel=1e-12)
    assert found.dry.hold[:, 0, 0] == pytest.approx((TABLE[60][1], TABLE[60][0]), rel=1e-12)


@pytest.mark.parametrize("pairs", [1, 2, 3])
def test_all_solutions_of_sliding_pairs_are_found(pairs):
    """phi = |x| in random systems, most of which do not contract: each combination of signs is a linear system."""
    random, rows = np.random.default_rng(5), 60
    known = random.normal(size=(rows, pairs))
    reach = random.normal(size=(rows, pairs, pairs)) * random.uniform(0.2, 1.5, size=(rows, 1, 1))
    forms = np.zeros((2, pairs, pairs), dtype=complex)
    forms[0] = np.eye(pairs)
    senses = random.choice([-1.0, 1.0], (rows, pairs))
    least, greatest, codes = solve_friction(FrictionSystem(known, reach, forms), senses)
    word = [FrictionStatus.NO_SOLUTION, FrictionStatus.SLIDING, FrictionStatus.SEVERAL]
    for r in range(rows):
        every = [(s, np.linalg.solve(np.eye(pairs) - reach[r] * (senses[r] * s), known[r]))
                 for s in map(np.array, product((-1, 1), repeat=pairs))]  # fmt: skip
        own = np.array([x for signs, x in every if np.all(signs * x >= 0.0)])
        assert codes[r] == word[min(len(own), 2)]
        if len(own):
            assert least[r] == pytest.approx(own.min(axis=0), rel=1e-9, abs=1e-12)
            assert greatest[r] == pytest.approx(own.max(axis=0), rel=1e-9, abs=1e-12)
    assert set(codes.tolist()) == set(map(int, word))


# --- knee, drawer, wedge: closed forms -------------------------------------------------------------------

KNEE = """\
nodes: {{O: [0, 0], K: [{x}, {y}], B: [{x2}, 0], C: [{x3}, 0], G: [0, 0], H: [1, 0], V: [{x}, -1], W: [{x}, 1]}}
ground: [O, G, H, V, W]
links: {{one: {{nodes: [O, K], length: 0.1}}, two: {{nodes: [K, B], length: 0.1}}, ram: [B, C]}}
prismatic: {{guide: {{nodes: [B, C], guide: [G, H]}}}}
actuators: {{push: {{node: K, guide: [V, W], law: {{by: {by}}}}}}}
loads: {{work: {{on: C, force: [-1000, 0]}}}}
friction:
  O: {{mu: 0.1, radius: {radius}}}
  K: {{mu: 0.1, radius: {radius}}}
  B: {{mu: 0.1, radius: {radius}}}
"""


@pytest.mark.parametrize(("alpha", "opening", "closing"), [
    (10, 0.1149998379, 0.2389680269), (5, 0.02723713655, 0.1483772414), (3.5, None, None), (3.4, None, None),
])  # fmt: skip
def test_a_knee_with_friction_circles(alpha, opening, closing):
    """Force of the knee 2 F tan(alpha +- tau), tau = asin(2 rho / L): locked for alpha <= tau = 3.4398... deg."""
    x, y = 0.1 * math.cos(math.radians(alpha)), 0.1 * math.sin(math.radians(alpha))
    tau = math.asin(2 * 0.003 / 0.1)
    for way, expected in ((1, opening), (-1, closing)):
        text = KNEE.format(x=x, y=y, x2=2 * x, x3=2 * x + 0.1, by=way * 1e-4, radius=0.003 / SINE)
        _, found = moved(text, 1)
        tilted = math.tan(math.radians(alpha) - way * tau)
        assert tilted == pytest.approx(expected or tilted, rel=1e-9)
        assert found.effort(0)[0] == pytest.approx(-2000 * tilted, rel=1e-11)
        assert self_locking(found.dry)[0] == (math.radians(alpha) <= tau)


DRAWER = """\
nodes: {B: [0, 0], C: [1, 0], D: [0.2, 0.35], G: [0, 0], H: [9, 0], E: [0, 0.35], F: [9, 0.35]}
ground: [G, H, E, F]
elements: {drawer: [B, C, D]}
prismatic: {guide: {nodes: [B, C], guide: [G, H]}}
actuators: {hand: {node: D, guide: [E, F], law: {by: 0.5}}}
loads: {load: {on: drawer, at: [0, 0], force: [%s, 0]}}
friction: {guide: {mu: %s, length: 0.4}}
"""


def test_a_drawer_locks_at_half_the_guided_length_over_the_offset():
    """Pushed 0.35 beside a guide of 0.4: F = W / (1 - 2 mu e / l), and none from mu = l / (2 e) = 0.5714... on."""
    for mu in (0.1, 0.5, 0.571):
        _, found = moved(DRAWER % (-20, mu), 1)
        assert found.effort(0) == pytest.approx(20 / (1 - 2 * mu * 0.35 / 0.4), rel=1e-10)
    for mu in (0.572, 0.7, 2):
        _, found = moved(DRAWER % (-20, mu), 1)
        assert found.dry.codes.tolist() == [FrictionStatus.NO_SOLUTION] * 2
        assert np.all(np.isnan(found.effort(0)))


def test_a_drawer_that_is_pulled_along_can_jam_in_two_ways():
    """20 N in the direction of motion: F (1 - k) = -20 with F > 0, or F (1 + k) = -20 with F < 0; k = 2 mu e / l."""
    k = 2 * 0.8 * 0.35 / 0.4
    _, found = moved(DRAWER % (20, 0.8), 1)
    assert found.dry.codes.tolist() == [FrictionStatus.SEVERAL] * 2
    assert found.dry.effort[:, 0, 0] == pytest.approx((-20 / (1 + k), -20 / (1 - k)))
    assert np.all(np.isnan(found.effort(0)))


WEDGE = """\
nodes: {{A: [0, 0], B: [1, 0], I: [0, -0.2], J: [{c}, {e}], P: [{px}, {py}], Q: [{px}, {qy}], G: [0, 0], H: [9, 0],
        U: [{px}, 0], V: [{px}, 9]}}
ground: [G, H, U, V]
elements: {{wedge: [A, B, I, J]}}
links: {{follower: [P, Q]}}
prismatic:
  floor: {{nodes: [A, B], guide: [G, H]}}
  face: {{node: P, guide: [I, J]}}
  upright: {{nodes: [P, Q], guide: [U, V]}}
actuators: {{push: {{node: A, guide: [G, H], law: {{by: {by}}}}}}}
loads: {{weight: {{on: Q, force: [0, -100]}}}}
friction: {{floor: {{mu: {mu}, length: 1000}}, face: {{mu: {mu}}}}}
"""


@pytest.mark.parametrize(("alpha", "phi", "lift", "out", "share"), [
    (10, 6, 0.3918496210244844, -0.03517742332216605, 0.4499863499866632),
    (15, 8, 0.5650156509119962, -0.01775627379948686, 0.4742332216791231),
])  # fmt: skip
def test_a_wedge_lifts_a_weight(alpha, phi, lift, out, share):
    """P / W = tan(alpha + phi) + tan phi; pushed out by tan(alpha - phi) - tan phi."""
    a, mu = math.radians(alpha), math.tan(math.radians(phi))
    c, s = math.cos(a), math.sin(a)
    place = dict(c=c, e=s - 0.2, px=0.5 * c, py=0.5 * s - 0.2, qy=0.5 * s + 1, mu=mu)
    _, found = moved(WEDGE.format(by=-0.1, **place), 1)
    assert np.abs(found.effort(0)) == pytest.approx(100 * lift, rel=1e-12)
    assert row_efficiency(found) == pytest.approx(share, rel=1e-12)
    assert found.dry.hold[:, 0, 0] == pytest.approx((-100 * lift, -100 * out), rel=1e-12)
    assert np.all(self_locking(found.dry)) == (alpha <= 2 * phi)
    _, back = moved(WEDGE.format(by=0.1, **place), 1)
    assert back.effort(0) == pytest.approx(-100 * out, rel=1e-12)


INCLINE = """\
nodes: {{A: [{c}, {s}], B: [{c2}, {s2}], G: [0, 0], H: [{c9}, {s9}]}}
ground: [G, H]
links: {{block: [A, B]}}
prismatic: {{slope: {{nodes: [A, B], guide: [G, H]}}}}
actuators: {{rope: {{node: A, guide: [G, H], law: {{by: 0.5}}}}}}
masses: {{block: {{mass: 5, inertia: 0}}}}
gravity: [0, -9.81]
friction: {{slope: {{mu: {mu}, length: 2}}}}
"""


@pytest.mark.parametrize(("slope", "phi", "locked"), [(10, 15, True), (10, 5, False), (-10, 15, True), (0, 15, False)])
def test_a_block_on_a_slope(slope, phi, locked):
    """Held by m g (sin a -+ mu cos a); locked if a < phi. On a level guide nothing drives it: it is not locked."""
    a, mu = math.radians(slope), math.tan(math.radians(phi))
    c, s = math.cos(a), math.sin(a)
    mechanism = gimcli.loads(INCLINE.format(c=c, s=s, c2=2 * c, s2=2 * s, c9=9 * c, s9=9 * s, mu=mu))
    found = ForceMotion(mechanism, 5)
    forces = found.take(trace(mechanism, 4))
    weight = 5 * 9.81
    ends = weight * (s - mu * c), weight * (s + mu * c)
    assert forces.dry.hold[:, 0] == pytest.approx(np.tile(ends, (5, 1)).T, rel=1e-12)
    assert forces.effort(0) == pytest.approx(ends[1], rel=1e-12)
    assert self_locking(forces.dry).tolist() == [locked] * 5
    assert bool(found.friction.locked) is locked


def test_a_motion_that_jams_ends_with_a_status(tmp_path):
    (tmp_path / "m.yaml").write_text(DRAWER % (-20, 0.7))
    ran = gim("forces", tmp_path / "m.yaml", "-n", "4", "-o", tmp_path / "m.csv")
    assert ran.code == 5
    assert "no-solution: jamming" in ran.text
    assert "however large the effort" in ran.text
    rows = (tmp_path / "m.csv").read_text().splitlines()[1:]
    assert [row.rpartition(",")[2] for row in rows] == ["no-solution"] * 5


# --- an independent formulation --------------------------------------------------------------------------


def law(t):
    return math.radians(21 + 200 * t)


def compared(text, bodies, steps=6):
    """Compare the efforts of a motion in 1 s with those of body coordinates."""
    motion, found = moved(text, steps)
    assert np.all(found.good)
    guess = bodies.start
    for k, t in enumerate(motion.time):
        effort, _, guess = bodies.effort(t, guess)
        assert found.effort(0)[k] == pytest.approx(effort, rel=2e-8, abs=1e-8)


def test_a_slider_crank_in_body_coordinates():
    """With masses and weight, an offset guide and two contacts that bear a moment."""
    text = CRANK.replace("[0.4, 0], C: [0.6, 0]", "[0.398, 0.03], C: [0.598, 0.03]") % (21, 221)
    text = text.replace("guide: [G, H]}", "guide: [G, H], offset: 0.03}")
    text = text.replace("rod: [A, B]", "rod: {nodes: [A, B], length: 0.3}") + DRY.replace("length: 30", "length: 0.12")
    text += "masses: {crank: {mass: 2, inertia: 0.01}, rod: {mass: 1, inertia: 0.02}, ram: {mass: 3, inertia: 0}}\n"
    text += "gravity: [0, -9.81]\n"
    a = math.radians(21)
    pin = 0.1 * np.exp(1j * a)
    b = pin.real + math.sqrt(0.09 - (0.03 - pin.imag) ** 2) + 0.03j
    middles = [(pin / 2, a), ((pin + b) / 2, np.angle(b - pin)), (b + 0.1, 0.0)]
    bodies = Bodies(
        np.array([value for z, angle in middles for value in (z.real, z.imag, angle)]),
        [Pin(0, 0, 1, -0.05, RHO_O), Pin(1, 0.05, 2, -0.15, RHO_A), Pin(2, 0.15, 3, -0.1, RHO_B),
         Block(0, 0.03j, 1, 3, 0, MU, 0.12)],
        (1, law), [(3, 0.1, LOAD + 0j)], {1: (2, 0.01), 2: (1, 0.02), 3: (3, 0)}, -9.81j,
    )  # fmt: skip
    compared(text, bodies)


def test_a_four_bar_in_body_coordinates():
    """The pin at B, with its load, is fixed to the rod, the first of its two members."""
    text = """\
nodes: {O: [0, 0], A: [0.1, 0], B: [0.35, 0.3], D: [0.4, 0]}
ground: [O, D]
links: {crank: {nodes: [O, A], length: 0.1}, rod: {nodes: [A, B], length: 0.4}, rocker: {nodes: [D, B], length: 0.3}}
actuators: {motor: {pivot: O, arm: A, law: {from: 21, to: 221}}}
loads: {drag: {on: B, force: [200, -500]}, twist: {on: rod, torque: 20}}
friction:
  {O: {mu: 0.2, radius: 0.03}, A: {mu: 0.3, radius: 0.02}, B: {mu: 0.2, radius: 0.025}, D: {mu: 0.4, radius: 0.03}}
"""
    circle = [friction_circle(mu, r) for mu, r in ((0.2, 0.03), (0.3, 0.02), (0.2, 0.025), (0.4, 0.03))]
    start = [0.047, 0.017, 0.35, 0.2, 0.18, 0.7, 0.4, 0.15, 1.6]
    bodies = Bodies(
        np.array(start),
        [Pin(0, 0, 1, -0.05, circle[0]), Pin(1, 0.05, 2, -0.2, circle[1]), Pin(2, 0.2, 3, 0.15, circle[2]),
         Pin(0, 0.4, 3, -0.15, circle[3])],
        (1, law), [(2, 0.2, 200 - 500j), (2, None, 20)],
    )  # fmt: skip
    compared(text, bodies)


def test_a_pin_in_a_moving_slot_in_body_coordinates():
    """A crank-shaper: the slot is in the lever, beside its pivot."""
    text = """\
nodes: {O: [0, 0.3], A: [0.1, 0.3], P: [0, 0], Q: [0.5, 0.9]}
ground: [O, P]
links: {crank: {nodes: [O, A], length: 0.1}, lever: {nodes: [P, Q], length: 1}}
prismatic: {slot: {node: A, guide: [P, Q], offset: -0.02}}
actuators: {motor: {pivot: O, arm: A, law: {from: 21, to: 221}}}
loads: {drag: {on: Q, force: [100, -30]}}
friction: {O: {mu: 0.2, radius: 0.03}, P: {mu: 0.4, radius: 0.03}, slot: {mu: 0.25}}
"""
    start = [0.047, 0.317, 0.35, 0.14, 0.47, 1.3]
    bodies = Bodies(
        np.array(start),
        [Pin(0, 0.3j, 1, -0.05, friction_circle(0.2, 0.03)), Pin(0, 0, 2, -0.5, friction_circle(0.4, 0.03)),
         Slot(2, -0.5 - 0.02j, 1, 1, 0.05, 0.25)],
        (1, law), [(2, 0.5, 100 - 30j)],
    )  # fmt: skip
    compared(text, bodies)


def test_the_holding_range_has_no_inertia():
    """A fast motion and a slow one have the same; in the slow one the effort is an end of it."""
    masses = "masses: {crank: {mass: 2, inertia: 0.01}, rod: {mass: 1, inertia: 0.02}}\ngravity: [0, -9.81]\n"
    text = CRANK % (25, 65) + DRY + masses + "duration: "
    (_, slow), (_, fast) = moved(text + "1e6\n", 4), moved(text + "0.01\n", 4)
    assert fast.dry.hold == pytest.approx(slow.dry.hold, rel=1e-9)
    assert slow.effort(0) == pytest.approx(slow.dry.hold[1, 0], rel=1e-9)
    assert np.max(np.abs(fast.effort(0) - slow.effort(0))) > 10.0


HOOK = """\
nodes: {O: [0, 0], A: [0, 1], B: [2, 0], D: [3, 2], E: [3, 0], G: [9, 0]}
ground: [O, E, G]
links: {crank: [O, A], rod: [A, B], arm: [B, D]}
prismatic: {slide: {node: B, guide: [O, G]}, hook: {node: D, guide: [E, G], offset: 2}}
actuators: {motor: {pivot: O, arm: A, law: {by: %s}}}
loads: {push: {on: arm, at: [2.5, 1], force: [-10, -40]}}
friction: {slide: {mu: 0.2}}
"""


@pytest.mark.parametrize("by", [20, -20])
def test_the_forces_on_a_pin_in_a_slot_balance(by):
    """The forces of the links on the pin add up to the normal force, and mu times it against the motion."""
    _, found = moved(HOOK % by, 4)
    force = on(found, "B", "rod") + on(found, "B", "arm")
    assert force.imag == pytest.approx(found.normal("slide"), rel=1e-12)
    assert force.real == pytest.approx(math.copysign(0.2, by) * np.abs(found.normal("slide")), rel=1e-12)


# --- laws on many models ---------------------------------------------------------------------------------


def dry(mu, viscous=0.0, size=None):
    """Return a change of a model's data: dry friction in all its pairs."""

    def rubbed(data):
        given = [xy for xy in data["nodes"].values() if isinstance(xy, list)]
        own = size or float(np.ptp(np.array(given, dtype=float), axis=0).max())
        parts = [*data.get("links", {}).values(), *data.get("elements", {}).values(), data["ground"]]
        held = [set(v.get("nodes", []) if isinstance(v, dict) else v) for v in parts]
        used = dict.fromkeys(n for h in held for n in h)
        data["friction"] = {
            n: {"mu": mu, "radius": 0.01 * own, "viscous": viscous}
            for n in sorted(used)
            if sum(n in h for h in held) > 1
        }
        for name, pair in data.get("prismatic", {}).items():
            data["friction"][name] = {"mu": mu, "viscous": viscous, **({"length": own} if "nodes" in pair else {})}

    return rubbed


@pytest.mark.few
def test_the_power_balances_in_every_row(model):
    """Dry and viscous friction together; redundant models are refused, as are pivots of gears."""
    motion = trace(weighted(model, dry(0.05, 0.3)), 24)
    if statics(motion.mechanism).surplus or motion.mechanism.gears:
        with pytest.raises(ModelError):
            motion_forces(motion)
        return
    found = motion_forces(motion)
    if found.dry is None:
        assert not found.mechanism.dynamics.frictions  # all members are joined by actuators
        return
    counts = np.bincount(found.dry.codes, minlength=5)
    assert counts[FrictionStatus.NOT_CONVERGED] == 0
    good = found.good
    assert good.sum() > 0.6 * motion.good.sum()
    powers = [found.drive_power, found.loads.kinetic_rate, *found.loads.power.values()]
    assert np.max(np.abs(found.power_error[good])) < 1e-9 * max(np.max(np.abs(p[good])) for p in powers)
    assert np.all(found.loads.power["friction"][good] < 0.0)
    assert np.max(found.dry.residual) < 1e-12


@pytest.mark.parametrize("stem", ["crank_rocker", "slider_crank", "crank_shaper", "scotch_yoke"])
def test_without_friction_the_limit_is_the_old_program(stem):
    plain = motion_forces(trace(weighted(MODELS / f"{stem}.yaml"), 24))
    errors = []
    for mu in (1e-3, 1e-6, 1e-13):
        found = motion_forces(trace(weighted(MODELS / f"{stem}.yaml", dry(mu)), 24))
        good = found.good & plain.good
        assert good.sum() > 18
        errors.append(np.max(np.abs(found.effort(0) - plain.effort(0))[good]) / np.max(np.abs(plain.effort(0)[good])))
    assert errors[0] / errors[1] == pytest.approx(1000, rel=0.05)
    assert errors[2] < 1e-11
    none = motion_forces(trace(weighted(MODELS / f"{stem}.yaml", dry(0.0)), 24))
    assert none.dry is None
    assert np.array_equal(none.unknowns, plain.unknowns, equal_nan=True)


def test_pieces_of_a_motion_give_the_same_works():
    mechanism = gimcli.load("crank_press")
    whole, pieces = ForceMotion(mechanism, 101), ForceMotion(mechanism, 101)
    whole.take(trace(mechanism, 100))
    for piece in stream(mechanism, 100, rows=17):
        pieces.take(piece)
    assert pieces.friction.works == pytest.approx(whole.friction.works, rel=1e-12)
    assert pieces.friction.efficiency == pytest.approx(whole.friction.efficiency, rel=1e-12)
    assert np.array(pieces.friction.locked) == pytest.approx(np.array(whole.friction.locked))
    lost = sum(whole.friction.lost.values())
    assert whole.friction.works["crank_angle"] + whole.friction.works["loads"] == pytest.approx(lost, rel=1e-12)


def test_the_command_reports_friction(tmp_path):
    report = json.loads(gim("forces", "crank_press", "--steps", "100", "--json", "--no-png", "-o", tmp_path).text)
    assert report["status"] == "ok"
    assert 0.8 < report["friction"]["efficiency"] < 0.9
