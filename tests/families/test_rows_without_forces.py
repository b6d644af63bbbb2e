"""Designs whose rates or forces are not determined in rows in which they are asked for: a status, and no number.

A crank press with friction in its guide alone. The rod pushes with S under an angle b to the guide, S cos b = W + mu N
and N = S sin b: the ram slides only if mu |tan b| < 1, and the torque is then W dx/dt / (1 - mu |tan b|).
"""

import math

import numpy as np
import pytest

import gimcli
from gimcli.families.family import Family
from gimcli.fitting.conditions import DesignQuantities

PRESS = """
units: {length: mm, angle: deg}
parameters: {mu: 0}
nodes: {O: [0, 0], A: [0, 100], B: [282.842712474619, 0], C: [382.842712474619, 0], G: [300, 0], H: [450, 0]}
ground: [O, G, H]
links: {crank: {nodes: [O, A], length: 100}, rod: {nodes: [A, B], length: 300}, ram: {nodes: [B, C], length: 100}}
prismatic: {guide: {nodes: [B, C], guide: [G, H]}}
actuators: {motor: {pivot: O, arm: A, law: {from: 182, to: 358}}}
trace: [C]
loads: {work: {on: C, force: [-1000, 0]}}
friction: {guide: {mu: mu, length: 120}}
"""
STEPS = 44  # a row every 4 degrees
SLIDES, JAMS = (0.0, 1.0, 2.0), (3.0, 4.0)
LEAST = math.sqrt(8.0)  # 1 / tan(asin(100 / 300)): from this mu on it jams at 270 degrees


def torque(mu, motor):
    """The torque [N m]; NaN where it jams."""
    t = np.radians(motor)
    root = np.sqrt(0.3**2 - (0.1 * np.sin(t)) ** 2)
    speed = -0.1 * np.sin(t) - 0.1**2 * np.sin(t) * np.cos(t) / root
    rest = 1.0 - mu * np.abs(0.1 * np.sin(t) / root)
    return np.where(rest > 0.0, 1000.0 * speed / rest, np.nan)


ROWS = np.linspace(182.0, 358.0, STEPS + 1)


@pytest.fixture(scope="module")
def press():
    return gimcli.loads(PRESS)


def test_a_number_of_a_jamming_press_is_empty_and_has_the_status_of_its_rows(press):
    keep = ["max(motor.effort)", "mean(|motor.effort|)", "integral(motor.effort)", "argmin(-motor.effort)", "solved"]
    found = gimcli.sweep(press, {"mu": [*SLIDES, *JAMS]}, steps=STEPS, keep=keep)
    own = [torque(mu, ROWS) for mu in SLIDES]
    expected = [[t.max(), t.mean(), np.trapezoid(t, ROWS), ROWS[t.argmax()], 45] for t in own]
    expected += [[np.nan] * 4 + [45]] * len(JAMS)
    assert found[keep] == pytest.approx(np.array(expected), rel=1e-9, nan_ok=True)
    for mu, status in zip(found["mu"], found.status, strict=True):
        words = gimcli.forces(press.with_({"mu": mu}), STEPS).status
        assert status == next((word for word in words if word != "ok"), "ok")
    assert (found.solved, found.counts) == (3, {"ok": 3, "no-solution": 2})


def test_only_rows_that_are_asked_for_count(press):
    keep = ["at(motor.effort, motor=200)", "range(C.x)"]
    found = gimcli.sweep(press, {"mu": [*SLIDES, *JAMS]}, steps=STEPS, keep=keep)
    assert found[keep[0]] == pytest.approx([float(torque(mu, 200.0)) for mu in (*SLIDES, *JAMS)], rel=1e-9)
    assert set(found.status) == {"ok"}
    found = gimcli.sweep(press, {"mu": [2.0, 3.0]}, steps=STEPS, keep=["at(motor.effort, motor=271)", "range(C.x)"])
    assert found["at(motor.effort, motor=271)"] == pytest.approx([float(torque(2.0, 271.0)), np.nan], nan_ok=True)
    assert found.status.tolist() == ["ok", "no-solution"]


def test_whole_columns_have_the_rows_that_are_known(press):
    found = gimcli.sweep(press, {"mu": [2.0, 3.0]}, steps=STEPS, keep="motor.effort", rows=True)
    assert found.curves["motor.effort"] == pytest.approx(torque(np.array([[2.0], [3.0]]), ROWS), rel=1e-9, nan_ok=True)
    assert found.status[:: STEPS + 1].tolist() == ["ok", "no-solution"]


def test_conditions_goals_and_optimisers_do_not_choose_such_a_design(press):
    vary = {"mu": [*JAMS, *SLIDES]}
    found = gimcli.sweep(press, vary, steps=STEPS, keep="range(C.x)", where="not (max(motor.effort) < 1)")
    assert (found["mu"].tolist(), found.counts) == ([*SLIDES], {"ok": 3, "no-solution": 2})
    best = gimcli.sweep(press, vary, steps=STEPS, keep="range(C.x)", goal="-max(motor.effort)", best=5)
    assert best["mu"].tolist() == [*SLIDES[::-1]]
    values, statuses = gimcli.evaluator(press, ["mu"], ["max(motor.effort)", "max(C.x)"], STEPS)([[1.0], [3.0]])
    assert statuses.tolist() == ["ok", "no-solution"]
    assert values == pytest.approx(
        np.array([[torque(1.0, ROWS).max(), values[0, 1]], [np.nan, values[0, 1]]]), nan_ok=True
    )
    quantities = DesignQuantities(Family(press, ["mu"]), ["max(motor.effort) > 1"], "-max(motor.effort)")
    assert np.isfinite(quantities.admitted_goals(np.array([[1.0], [3.0]]), STEPS)).tolist() == [True, False]
    assert quantities.hold(np.array([[1.0], [3.0]]), STEPS).tolist() == [True, False]
    margins = quantities.numbers(quantities.margins, np.array([[1.0], [3.0]]))
    assert np.isfinite(margins).tolist() == [[True], [False]]


def test_a_fit_varies_friction_up_to_a_greatest_torque(press):
    """The torque at 270 degrees is 100 N m / (1 - mu / sqrt(8)); that of 360 rows is less than 0.1 % above it."""
    found = gimcli.fit(press, {"mu": (0.5, 2.8)}, goal="-mu", where="max(motor.effort) < 1000", starts=10)
    fine = np.linspace(182.0, 358.0, 361)
    low, high = 0.0, LEAST - 1e-9
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if torque(middle, fine).max() < 1000.0 else (low, middle)
    assert found.dimensions["mu"] == pytest.approx(low, rel=1e-5)


def test_a_fit_varies_masses(press):
    """A counterweight m at 0.1 m balances 1 kg at 0.3 m: m = 3."""
    lever = gimcli.loads("""
units: {length: m, angle: deg}
nodes: {O: [0, 0], G: [1, 0], A: [0.3, 0], B: [-0.1, 0]}
ground: [O, G]
elements: {lever: [O, A, B]}
actuators: {motor: {pivot: O, arm: A, law: {from: 0, to: 90}}}
masses: {A: {mass: 1}, B: {mass: 1.5}}
gravity: [0, -9.81]
""")
    found = gimcli.fit(lever, {"B.mass": (1, 5)}, goal="max(|motor.effort|)", starts=8)
    assert found.dimensions["B.mass"] == pytest.approx(3.0, abs=1e-4)
    notes = []
    gimcli.sweep(lever, {"B.mass": [1, 3]}, steps=4, keep="max(motor.effort)", notify=notes.append)
    assert notes == []


def test_numbers_of_a_motion_in_python_are_empty_too(press):
    jams, slides = press.with_({"mu": 3.0}), press.with_({"mu": 2.0})
    for verb in (gimcli.trace, gimcli.forces):
        assert math.isnan(verb(jams, STEPS)["max(motor.effort)"])
        assert math.isnan(verb(jams, STEPS)["integral(|motor.effort|)"])
        assert verb(jams, STEPS)["max(C.x)"] == pytest.approx(500.0, abs=0.1)
        assert verb(slides, STEPS)["max(motor.effort)"] == pytest.approx(torque(2.0, ROWS).max(), rel=1e-9)


PARALLELOGRAM = """
units: {length: m, angle: deg}
nodes: {A: [0, 0], D: [2, 0], B: [1, 0.5], C: [3, 0.5]}
ground: [A, D]
links: {crank: {nodes: [A, B], length: 1}, coupler: {nodes: [B, C], length: 2}, follower: {nodes: [D, C], length: 1}}
actuators: {motor: {pivot: A, arm: B, law: {from: 90, to: 270}}}
masses: {crank: {mass: 1, inertia: 0}, coupler: {mass: 2, inertia: 0}, follower: {mass: 1, inertia: 0}}
"""


@pytest.mark.parametrize(("steps", "status"), [(12, "singular"), (11, "ok")])
def test_rates_and_forces_are_not_determined_at_a_change_point(steps, status):
    """With 12 steps a row is at 180 degrees, where the cranks are in line with the frame; |C.v| is half a turn / s."""
    m = gimcli.loads(PARALLELOGRAM)
    keep = ["max(|C.v|)", "max(motor.effort)", "min(C.x)"]
    found = gimcli.sweep(m, {"coupler.mass": [2.0, 3.0]}, steps=steps, keep=keep)
    assert found.status.tolist() == [status] * 2
    assert np.isnan(found["max(motor.effort)"]).tolist() == [status != "ok"] * 2
    assert found["max(|C.v|)"] == pytest.approx([math.pi if status == "ok" else np.nan] * 2, nan_ok=True)
    assert gimcli.trace(m, steps)["max(|C.v|)"] == pytest.approx(found["max(|C.v|)"][0], nan_ok=True)
    assert set(gimcli.sweep(m, {"coupler.mass": [2.0]}, steps=steps, keep="min(C.x)").status) == {"ok"}


def test_of_several_columns_a_number_has_all_of_them():
    m = gimcli.load("watt_1")
    t = gimcli.trace(m, 72, measure="transmission")
    columns = t[[name for name in t if name.startswith("transmission")]]
    assert columns.shape == (73, 2)
    assert t["min(transmission)"] == columns.min()
    assert t["max(transmission)"] == columns.max()
    assert t["worst_transmission"] == min(columns.min(), 180.0 - columns.max())


SPRING = """
units: {length: m}
nodes: {O: [0, 0], A: [1, 0], G: [0, 0], H: [9, 0]}
ground: [O, G, H]
prismatic: {guide: {node: A, guide: [G, H]}}
actuators: {ram: {node: A, guide: [G, H], law: {from: 1, to: 3}}}
springs: {s: {nodes: [O, A], stiffness: 5, free: 0}}
"""


def test_numbers_that_are_zero_in_the_file_vary(press):
    """Friction, and a spring of free length 0: F = k (l - free)."""
    for nominal, keep in ((0.0, []), (1.0, ["min(friction.power.guide)"])):
        own = press.with_({"mu": nominal})
        found = gimcli.sweep(own, {"mu": [0.0, 2.0]}, steps=STEPS, keep=["max(motor.effort)", *keep])
        assert found["max(motor.effort)"] == pytest.approx([torque(mu, ROWS).max() for mu in (0.0, 2.0)], rel=1e-9)
    assert np.isnan(found["min(friction.power.guide)"]).tolist() == [True, False]
    spring = gimcli.loads(SPRING)
    swept = gimcli.sweep(spring, {"s.free": [0.0, 0.5]}, steps=4, keep="max(ram.effort)")
    assert swept["max(ram.effort)"] == pytest.approx([15.0, 12.5], rel=1e-12)
    slope = gimcli.sensitivity(spring, {"ram": 2.0}, of="ram.effort", by="s.free")
    assert slope.derivatives["ram.effort"]["s.free"] == pytest.approx(-5.0, rel=1e-12)


def test_forces_on_a_guide_of_the_frame_have_derivatives():
    """Guide through G at an angle a: the spring's length is (c - O.x) cos a, c the place along it; F = k of this."""
    text = SPRING.replace("free: 0", "free: 0.25")
    found = gimcli.sensitivity(gimcli.loads(text), {"ram": 2.0}, of="ram.effort")
    expected = {"O.x": -5.0, "s.stiffness": 1.75, "s.free": -5.0, "ram": 5.0, "H.y": 0.0}
    assert {name: found.derivatives["ram.effort"][name] for name in expected} == pytest.approx(expected, abs=1e-12)
    assert gimcli.sensitivity(gimcli.loads(text), {"ram": 2.0}, of="ram.effort", by="A.x").picture() is None
    engine = gimcli.load("engine")
    own = gimcli.sensitivity(engine, of="crank_angle.effort", by=["G.y", "H.y"], steps=8)
    for name, slope in own.derivatives["crank_angle.effort"].items():
        start, step = engine.written.dimension(name).value, 1e-3
        ends = gimcli.sweep(engine, {name: [start - step, start + step]}, steps=8, keep="crank_angle.effort", rows=True)
        low, high = ends.curves["crank_angle.effort"]
        assert slope == pytest.approx((high - low) / (2.0 * step), rel=1e-5, abs=1e-6)
