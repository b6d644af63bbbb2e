"""Mean, RMS, least and greatest values, work and mean bearing loads, compared with closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bundled import MODELS
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

import gimcli
from gimcli.dynamics.force_motion import RowIntegrals
from gimcli.motion.motion import PIECE

TURN = 2.0 * math.pi
MASS, RADIUS, SPEED, GRAVITY = 2.0, 0.3, 4.0 * math.pi, 9.81  # kg, m, rad/s: a turn in 0.5 s
PUSH, WEIGHT = MASS * RADIUS * SPEED**2, MASS * GRAVITY


def rotating(gravity=GRAVITY, law="{from: 7, to: 367}"):
    """Return a point mass at the end of a massless crank."""
    return gimcli.loads(f"""
units: {{length: mm}}
nodes: {{O: [0, 0], A: [300, 0]}}
ground: [O]
links: {{crank: [O, A]}}
actuators: {{motor: {{pivot: O, arm: A, law: {law}}}}}
duration: 0.5
masses: {{A: {MASS}}}
gravity: [0, {-gravity}]
""")


def mean(function):
    """Return the mean of a function of the angle over a turn."""
    return quad(function, 0.0, TURN, epsabs=1e-12, epsrel=1e-13, limit=200)[0] / TURN


def test_the_force_of_a_rotating_mass_is_constant():
    found = gimcli.forces(rotating(gravity=0.0), 24)
    one, bearing = found.statistics["O"], found.bearings["O"]
    assert (one.mean, one.rms, one.peak.value) == pytest.approx((PUSH, PUSH, PUSH), rel=1e-13)
    assert (one.least.time, one.greatest.time, one.part) == (0.0, 0.0, 1.0)
    assert (bearing.ball, bearing.roller) == pytest.approx((PUSH, PUSH), rel=1e-13)
    assert (bearing.speed, bearing.turns) == pytest.approx((120.0, 1.0))


@pytest.mark.parametrize("steps", [24, 25])
def test_the_weight_of_a_rotating_mass(steps):
    """|F|^2 = P^2 + W^2 - 2 P W sin(angle): the mean over a period is exact, extremes are found between the rows."""
    found = gimcli.forces(rotating(), steps)
    force, torque = found.statistics["O"], found.statistics["motor.effort"]
    assert force.rms == pytest.approx(math.hypot(PUSH, WEIGHT), rel=1e-13)
    assert force.mean == pytest.approx(mean(lambda q: abs(PUSH - 1j * WEIGHT * np.exp(-1j * q))), rel=1e-12)
    assert (force.greatest.value, force.least.value) == pytest.approx((PUSH + WEIGHT, PUSH - WEIGHT), rel=1e-12)
    assert (force.greatest.inputs["motor"], force.least.inputs["motor"]) == pytest.approx((270.0, 90.0), abs=1e-4)
    assert force.greatest.time == pytest.approx((270.0 - 7.0) / 720.0, abs=1e-7)
    assert (torque.mean, torque.rms) == pytest.approx((0.0, WEIGHT * RADIUS / math.sqrt(2)), abs=1e-12)
    assert (torque.greatest.value, torque.least.value) == pytest.approx((WEIGHT * RADIUS, -WEIGHT * RADIUS), rel=1e-12)
    assert {round(torque.greatest.inputs["motor"], 4) % 360, round(torque.least.inputs["motor"], 4)} == {0.0, 180.0}
    for load, p in ((found.bearings["O"].ball, 3.0), (found.bearings["O"].roller, 10 / 3)):
        expected = mean(lambda q, p=p: abs(PUSH - 1j * WEIGHT * np.exp(-1j * q)) ** p) ** (1 / p)
        assert load == pytest.approx(expected, rel=1e-12)
    assert found.report()["closed"]


def test_the_work_of_a_turn():
    """The torque m g r cos(angle) does 2 m g r upwards, and takes as much downwards."""
    work = gimcli.forces(rotating(), 360).work
    assert work["motor.effort"].positive == pytest.approx(2 * WEIGHT * RADIUS, rel=1e-6)
    assert work["motor.effort"].negative == pytest.approx(-2 * WEIGHT * RADIUS, rel=1e-6)
    assert work["motor.effort"].net == pytest.approx(0.0, abs=1e-12)
    assert work["gravity"].positive == pytest.approx(-work["motor.effort"].negative, rel=1e-12)


def test_an_open_motion():
    """Quintic law: torque J a (60 t - 180 t^2 + 120 t^3), with the extremes at t = (3 -+ sqrt 3) / 6."""
    found = gimcli.forces(rotating(0.0, "{from: 0, to: 360, profile: quintic}"), 60)
    torque, scale = found.statistics["motor.effort"], MASS * RADIUS**2 * TURN / 0.25
    assert (torque.mean, torque.rms) == pytest.approx((0.0, scale * math.sqrt(120 / 7)), rel=1e-5, abs=1e-10 * scale)
    assert torque.greatest.value == pytest.approx(scale * 10 / math.sqrt(3), rel=1e-12)
    assert torque.greatest.time == pytest.approx(0.5 * (3 - math.sqrt(3)) / 6, abs=1e-7)
    assert torque.least.time == pytest.approx(0.5 * (3 + math.sqrt(3)) / 6, abs=1e-7)
    energy = 0.5 * MASS * RADIUS**2 * (1.875 * TURN / 0.5) ** 2  # at the middle, where the speed is greatest
    assert found.work["motor.effort"].positive == pytest.approx(energy, rel=1e-5)
    assert found.work["motor.effort"].net == pytest.approx(0.0, abs=1e-6 * energy)


def slider_crank(rod):
    return gimcli.loads(f"""
units: {{length: m}}
nodes: {{O: [0, 0], A: [0.1, 0], B: [{0.1 + rod}, 0], G: [1, 0]}}
ground: [O, G]
links: {{crank: [O, A], rod: {{nodes: [A, B], length: {rod}}}}}
prismatic: {{guide: {{node: B, guide: [O, G]}}}}
actuators: {{motor: {{pivot: O, arm: A, law: {{from: 11, to: 371}}}}}}
duration: 0.5
masses: {{B: 3}}
""")


def test_a_slider_crank_with_a_long_rod():
    """Harmonic motion: torque m r^2 w^2 sin(2 q) / 2, force in the pin m r w^2 |cos q|, to the ratio of the lengths."""
    found = gimcli.forces(slider_crank(1000.0), 180)
    push = 3 * 0.1 * SPEED**2
    assert found.statistics["A"].rms == pytest.approx(push / math.sqrt(2), rel=1e-3)
    assert found.statistics["A"].mean == pytest.approx(push * 2 / math.pi, rel=1e-3)
    assert found.statistics["motor.effort"].rms == pytest.approx(push * 0.1 / math.sqrt(8), rel=1e-3)
    assert found.work["motor.effort"].positive == pytest.approx(push * 0.1, rel=1e-3)  # two times m r^2 w^2 / 2


def test_a_slider_crank_with_a_short_rod():
    """Acceleration of the slider and speed of the rod in closed form; integrals by adaptive quadrature."""
    rod, push = 0.25, 3 * SPEED**2
    found = gimcli.forces(slider_crank(rod), 180)

    def parts(q):
        """Return the force in the rod [N] and its angular velocity [rad/s]."""
        b, s = math.sqrt(rod**2 - (0.1 * math.sin(q)) ** 2), 0.01 * math.sin(q) * math.cos(q)
        gain = 0.1 * math.cos(q) + (0.01 * math.cos(2 * q) + s**2 / b**2) / b
        return push * gain * rod / b, 0.1 * math.cos(q) / b * SPEED

    top = push * 0.1 * (1 + 0.1 / rod)  # in the outer dead point
    assert found.statistics["A"].greatest.value == pytest.approx(top, rel=1e-12)
    assert found.statistics["A"].greatest.inputs["motor"] == pytest.approx(360.0, abs=1e-4)
    assert found.statistics["A"].rms == pytest.approx(math.sqrt(mean(lambda q: parts(q)[0] ** 2)), rel=1e-12)
    turned = mean(lambda q: abs(SPEED - -parts(q)[1]))
    ball = mean(lambda q: abs(parts(q)[0]) ** 3 * abs(SPEED + parts(q)[1])) / turned
    assert found.bearings["A"].ball == pytest.approx(ball ** (1 / 3), rel=1e-7)
    assert found.bearings["A"].speed == pytest.approx(turned * 30 / math.pi, rel=1e-9)
    least = minimize_scalar(lambda q: -abs(parts(q)[0]), bounds=(2.0, 3.0), method="bounded", options={"xatol": 1e-10})
    assert found.statistics["A"].greatest.value > -least.fun


def test_means_over_a_part_of_the_motion():
    """The law runs beyond the limit at 0.35 m: a third of its time has forces, there a constant one."""
    text = """
nodes: {O: [0, 0], A: [0, 0.1], B: [0.229, 0], G: [1, 0]}
ground: [O, G]
links: {crank: {nodes: [O, A], length: 0.1}, rod: {nodes: [A, B], length: 0.25}}
prismatic: {guide: {node: B, guide: [O, G]}}
actuators: {jack: {node: B, guide: [O, G], law: {from: 0.25, to: 0.55}}}
loads: {push: {on: B, force: [-7, 0]}}
"""
    found = gimcli.forces(gimcli.loads(text), 300)
    one = found.statistics["jack.effort"]
    assert (one.mean, one.rms) == pytest.approx((7.0, 7.0))
    assert one.part == pytest.approx(1 / 3, abs=0.04)  # without those next to the limit
    assert found.work["load"].negative == pytest.approx(-7.0 * 0.1, rel=0.02)
    assert found.report()["statistics"]["jack.effort"]["part"] == one.part


def test_the_rule_of_the_rows_in_pieces():
    """Pieces of any length give one result, gaps are left out, and a cubic is exact where four rows are known."""
    t = np.linspace(-1.0, 2.0, 31)
    rows = np.array([t**3 - t, np.where(np.abs(t - 0.5) < 0.01, np.nan, t), t - 0.05])
    whole = RowIntegrals(3, signed=1)
    whole.add(rows)
    for lengths in ([1] * 31, [2, 29], [3, 4, 24], [14, 17]):
        pieces = RowIntegrals(3, signed=1)
        for part in np.split(rows, np.cumsum(lengths)[:-1], axis=1):
            pieces.add(part)
        for one in (pieces, whole) if lengths[0] == 14 else (pieces,):
            one.finish(closed=False)
            assert 0.1 * one.net == pytest.approx([2.25, 1.5 - 0.1, 1.35], abs=1e-3)
            assert one.steps.tolist() == [30, 28, 30]
            assert 0.1 * one.positive[0] == pytest.approx(1.95**2 / 2, abs=1e-12)
        if lengths[0] == 14:
            assert pieces.net == pytest.approx(whole.net, rel=1e-13)


@pytest.mark.parametrize("last", [0.0, 1e-17, -1e-17])
def test_a_power_that_is_0_before_it_is_negative_does_no_positive_work(last):
    """Whatever the rounding error of the last 0: the cubic beside the jump is above 0."""
    power = RowIntegrals(1, signed=1)
    power.add(np.array([[0.0, 0.0, 0.0, 0.0, last, -1.0, -1.0, -1.0, -1.0]]))
    power.finish(closed=False)
    assert power.positive.tolist() == [0.0]


@pytest.mark.soak
def test_a_motion_of_several_pieces():
    model = rotating()
    found = gimcli.forces(model, PIECE + 100)
    assert found.statistics["O"].rms == pytest.approx(math.hypot(PUSH, WEIGHT), rel=1e-12)
    assert found.statistics["O"].greatest.value == pytest.approx(PUSH + WEIGHT, rel=1e-12)


def test_the_sum_of_all_work_is_the_change_of_the_kinetic_energy():
    found = gimcli.forces(gimcli.load(MODELS / "toggle_clamp.yaml"), 360)
    kinetic = found["energy.kinetic"]
    work = sum(one.net for one in found.work.values())
    scale = sum(abs(one.positive) + abs(one.negative) for one in found.work.values())
    assert work == pytest.approx(kinetic[-1] - kinetic[0], abs=1e-5 * scale)


def test_the_torque_of_the_rotor():
    found = gimcli.forces(gimcli.load("wiper"), 36)
    assert found["motor.rotor.torque"] == pytest.approx(found["motor.effort"] / 50, rel=1e-13)
    assert found["motor.rotor.speed"] == pytest.approx(60.0 * 50)
    assert found.statistics["motor.rotor.torque"].rms == pytest.approx(found.statistics["motor.effort"].rms / 50)


def test_the_report_has_everything():
    report = gimcli.forces(gimcli.load("engine"), 36).report()
    peak = report["peaks"]["motor.effort" if "motor.effort" in report["peaks"] else "crank_angle.effort"]
    own = report["statistics"]["crank_angle.effort"]
    assert peak["value"] in (own["least"]["value"], own["greatest"]["value"])
    assert set(own) == {"unit", "mean", "rms", "least", "greatest", "part"}
    assert set(report["work"]["damping"]) == {"positive", "negative", "net"}
    assert set(report["bearings"]["B"]) == {"speed", "turns", "ball", "roller"}
