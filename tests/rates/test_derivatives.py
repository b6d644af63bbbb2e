"""Velocities, accelerations and jerks compared with closed forms, differences of positions and rigid-body motion."""

import mpmath as mp
import numpy as np
import pytest
from bundled import MODELS, run_model
from mp_derivatives import exact
from rated import rated

from gimcli import load
from gimcli.motion.motion import trace
from gimcli.quantities.motion_table import motion_table
from gimcli.rates.derivatives import rates


def moving(name, steps, order):
    mechanism = load(MODELS / f"{name}.yaml")
    motion = trace(mechanism, steps)
    return mechanism, motion, rates(mechanism, motion.time, motion.z, order)


def slider(t):
    """Return the slider of a slider-crank: crank 1, rod 3, offset 0.5; 50 to 410 deg in 1 s."""
    angle = mp.radians(50 + 360 * t)
    return mp.cos(angle) + mp.sqrt(9 - (mp.sin(angle) - mp.mpf("0.5")) ** 2) + mp.mpf("0.5") * 1j


def rocker(t):
    """Return the rocker pin of Norton's four-bar 40, 120, 80, 100 [mm]; crank from 0 to 360 deg in 1 s."""
    crank = 40 * mp.expjpi(2 * t)
    arm = 100 - crank
    far = abs(arm)
    along = (120**2 - 80**2 + far**2) / (2 * far)
    return crank + arm / far * (along + 1j * mp.sqrt(120**2 - along**2))


@pytest.mark.parametrize(("name", "point", "form"), [("slider_crank", "B", slider), ("crank_rocker", "B", rocker)])
def test_closed_forms(name, point, form):
    mechanism, motion, found = moving(name, 24, 3)
    actual = found.point(point) * mechanism.scale
    actual[0] += mechanism.origin
    for k, time in enumerate(motion.time):
        expected = exact(form, time, 3)
        assert np.max(np.abs(actual[:, k] - expected) / np.maximum(np.abs(expected), 1.0)) < 1e-10


def test_the_angular_velocities_of_a_four_bar_agree_with_freudenstein():
    """omega4 = omega2 a sin(theta2 - theta3) / (c sin(theta4 - theta3)). Source: Norton, Design of Machinery, 6.18."""
    mechanism, motion, found = moving("crank_rocker", 90, 1)
    z = {name: motion.z[k] for k, name in enumerate(mechanism.nodes)}
    number = {member.name: k for k, member in enumerate(mechanism.members)}
    crank, coupler, rod = z["A"] - z["O2"], z["B"] - z["A"], z["B"] - z["O4"]
    t2, t3, t4 = (np.angle(v) for v in (crank, coupler, rod))
    w2 = found.angular(number["crank"])[0]
    assert w2 == pytest.approx(2.0 * np.pi, abs=1e-12)
    w4 = w2 * 40.0 * np.sin(t2 - t3) / (80.0 * np.sin(t4 - t3))
    w3 = w2 * 40.0 * np.sin(t4 - t2) / (120.0 * np.sin(t3 - t4))
    assert np.max(np.abs(found.angular(number["rocker"])[0] - w4)) < 1e-11
    assert np.max(np.abs(found.angular(number["coupler"])[0] - w3)) < 1e-11


@pytest.mark.few
def test_differences_of_positions_agree_with_the_expected_order(model):
    """Central differences over two and four neighbours: errors fall by 4 and 16 when the step is halved."""
    if model.stem == "pick_and_place":
        pytest.skip("a law through the rows of a table has no continuous acceleration")
    mechanism = load(model)
    found = {}
    for steps in (1000, 2000):
        motion = trace(mechanism, steps)
        r, h = rates(mechanism, motion.time, motion.z, 2), mechanism.duration / steps
        y, v = r.nodes[0], r.nodes[1]
        two = (y[:, 3:-1] - y[:, 1:-3]) / (2.0 * h)
        four = (8.0 * (y[:, 3:-1] - y[:, 1:-3]) - (y[:, 4:] - y[:, :-4])) / (12.0 * h)
        second = (v[:, 3:-1] - v[:, 1:-3]) / (2.0 * h)
        inner = (slice(None), slice(2, -2))
        every = slice(None, None, steps // 1000)  # the same times
        found[steps] = [
            np.nanmean(np.abs(d - e[inner])[:, every]) / np.nanmax(np.abs(e))
            for d, e in ((two, v), (four, v), (second, r.nodes[2]))
        ]
        assert np.count_nonzero(np.isnan(v[0])) <= np.count_nonzero(~motion.good) + 4  # singular rows only
    for coarse, fine, order in zip(found[1000], found[2000], (2, 4, 2), strict=True):
        assert fine < 1e-11 or coarse / fine > 0.5 * 2**order


@pytest.mark.few
def test_velocities_of_the_nodes_of_a_member_are_those_of_a_rigid_body(model):
    """v_B - v_A = i omega (B - A), a_B - a_A = (i alpha - omega^2) (B - A), and its derivative."""
    mechanism = load(model)
    motion = trace(mechanism, 60)
    r = rates(mechanism, motion.time, motion.z, 3)
    for index, member in enumerate(mechanism.members[1:], start=1):
        w, a, j = r.angular(index)
        for node in member.nodes[1:]:
            p, v, acceleration, jerk = r.nodes[:, node] - r.nodes[:, member.nodes[0]]
            turned = (1j * w * p, (1j * a - w**2) * p, (1j * j - 3.0 * w * a - 1j * w**3) * p)
            for actual, expected in zip((v, acceleration, jerk), turned, strict=True):
                most = np.nanmax(np.abs(expected), initial=1.0)
                assert np.nanmax(np.abs(actual - expected), initial=0.0) < 1e-8 * most


def test_rates_are_in_real_time_and_in_the_files_units():
    """Twice the duration gives half the velocity, a quarter of the acceleration and an eighth of the jerk."""
    slow = run_model("crank_rocker", 12, change=lambda data: data.update(duration=2)).motion
    fast = run_model("crank_rocker", 12).motion
    one, two = (rated(m, 3) for m in (fast, slow))
    for label, factor in (("vx", 2.0), ("ay", 4.0), ("jx", 8.0)):
        assert one.floats(f"P.{label}") == pytest.approx(factor * two.floats(f"P.{label}"), rel=1e-9, abs=1e-6)
    assert one.floats("crank.omega") == pytest.approx(360.0, abs=1e-9)
    units = {column.name: column.unit for column in one.columns}
    assert (units["P.vx"], units["P.ax"], units["crank.alpha"]) == ("mm/s", "mm/s^2", "deg/s^2")


def test_a_singular_position_has_no_velocity():
    """At the flat parallelogram two velocities satisfy the equations: the cells are empty."""
    motion = run_model("parallelogram", 8, laws={"motor": {"from": -90, "to": 270}}).motion
    assert motion.good.all()
    found = rates(motion.mechanism, motion.time, motion.z, 2)
    flat = np.abs(np.sin(motion.inputs[0])) < 1e-9
    assert flat.sum() == 2
    assert np.array_equal(np.isnan(found.nodes[1].real).all(axis=0), flat)


def test_columns_of_rates_are_optional():
    motion = run_model("crank_rocker", 6).motion
    plain, order = motion_table(motion), rated(motion, 2)
    assert not any(".v" in name or "omega" in name for name in plain.names)
    new = [name for name in order.names if name not in plain.names]
    assert new[:4] == ["P.vx", "P.vy", "P.ax", "P.ay"]
    assert {"crank.omega", "coupler.alpha"} <= set(new)
    assert order.names[-3:] == ("residual", "sweeps", "status")
