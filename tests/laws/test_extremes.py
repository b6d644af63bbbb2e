"""Extreme mechanisms: nearly singular, very long, very far from the origin, contradictory, impossible to assemble.

Expected values are closed forms, evaluated with 40 digits where rounding errors would matter. The accepted error is the
larger one of the tolerance and the effect of rounded dimensions on the position.
"""

from __future__ import annotations

import copy
import time

import numpy as np
import pytest
from extreme_cases import (
    TOLERANCE,
    U,
    crank_angle,
    drawn,
    exact_ray,
    link,
    meet,
    near_change_point,
    rotary,
    scissor,
    slider_crank,
    slider_driven,
    slider_place,
    stretched,
    third_crank,
    tried,
    walker,
    windows,
)
from mpmath import mp, mpc, mpf
from specifications import four_bar, ray, read, run, size, worst

from gimcli import GimError


def good(m):
    return np.flatnonzero(np.array(m.status) == "ok")


def limit(m, name="motor"):
    """Return the value of the input at the limit of the motion."""
    return m.value[name][0] + (m.value[name][-1] - m.value[name][0]) * m.motion.limit


# --- X01, X02: change points, nearly and exactly ---------------------------------------------------------


@pytest.mark.few(16)
@pytest.mark.parametrize("steps", [180, 179, 7, 1])
@pytest.mark.parametrize("ends", [(90, 270), (270, 90), (179, 181)])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("delta", [1e-3, 1e-5, 1e-6, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12])
def test_x01_near_a_change_point_the_branch_is_kept(delta, side, ends, steps):
    spec, frame = near_change_point(delta, side, *ends)
    m = run(spec, steps)
    for k in good(m):
        b, h = meet(exact_ray(m.value["motor"][k]), 3, frame, 2, side)
        assert abs(mpc(m.z["B"][k]) - b) <= max(TOLERANCE * size(spec), 40 * U * 1.2 / h)
    for k in set(range(len(m.status))) - set(good(m)):  # only where rounding errors alone reach the tolerance
        _, h = meet(exact_ray(m.value["motor"][k]), 3, frame, 2, side)
        assert m.status[k] == "singular"
        assert 40 * U * 1.2 / h > 0.1 * TOLERANCE * size(spec)


X01 = {1e-3: 0.0489869369526, 1e-6: 0.00154919324822, 1e-9: 4.89897968795e-05, 1e-12: 1.54926219905e-06}
X01_BOUND = {1e-3: 5.43895982204e-14, 1e-6: 1.71995011398e-12, 1e-9: 5.43895982204e-11, 1e-12: 1.71995011398e-09}


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("delta", X01)
def test_x01_height_of_the_table(delta, side):
    spec, _ = near_change_point(delta, side, 90, 180)
    m = run(spec, 90)
    if X01_BOUND[delta] > TOLERANCE:
        assert m.status[-1] == "singular"
        m = run(spec, 90, tolerance=1e-8)
    assert m.status[-1] == "ok"
    height = m.z["B"][-1].imag * side
    assert abs(height - X01[delta]) <= X01_BOUND[delta] + 1e-12 * X01[delta] + TOLERANCE * size(spec)
    assert height > 0


@pytest.mark.few(4)
@pytest.mark.parametrize("steps", [180, 179, 7, 1])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("delta", [-1e-3, -1e-6, -1e-9, -1e-12])
def test_x01_the_limit_is_reported(delta, side, steps):
    spec, frame = near_change_point(delta, side, 90, 270)
    d = mpf(frame)
    angle = mp.degrees(mp.acos((1 + d**2 - 25) / (2 * d)))
    m = run(spec, steps)
    assert np.all(m.value["motor"][good(m)] <= float(angle) + 1e-8)
    assert "unreachable" in m.status
    assert abs(limit(m) - angle) <= np.degrees(max(1e-8, 20 * U / np.radians(180 - float(angle))))


def test_x01_limits_of_the_table():
    for delta, angle in ((-1e-3, 177.1351274), (-1e-6, 179.9094074)):
        assert abs(limit(run(near_change_point(delta, 1, 90, 270)[0], 18)) - angle) <= 6e-8


@pytest.mark.parametrize("steps", [180, 179, 7])
@pytest.mark.parametrize("side", [1, -1])
def test_x01_an_exact_change_point_is_reported_and_passed(side, steps):
    spec, frame = near_change_point(0.0, side, 90, 270)
    m = run(spec, steps)
    assert set(m.status) == {"ok"}
    assert m.motion.bridged == pytest.approx([0.5], abs=1e-6)
    for k, angle in enumerate(m.value["motor"]):
        if abs(angle - 180) > 1:
            b, _ = meet(exact_ray(angle), 3, frame, 2, side if angle < 180 else -side)
            assert abs(mpc(m.z["B"][k]) - b) <= TOLERANCE * size(spec)


@pytest.mark.parametrize("crossed", [False, True])
def test_x02_through_the_flat_parallelogram(crossed):
    """The velocity ratio of follower and crank is 1, or if crossed -2 at 0 deg and -1/2 at 180 deg."""
    b = 3 + ray(50)
    if crossed:
        b = ray(50) + ((3 - ray(50)) / abs(3 - ray(50))) ** 2 * 3
    spec = drawn(four_bar(1, 3, 1, 3), A=ray(50), B=b) | {"actuators": rotary(-1, 1)}
    m = run(spec, 200)
    rate = np.diff(np.unwrap(np.angle(m.z["B"] - 3))) / np.diff(np.radians(m.value["motor"]))
    assert rate[99:101] == pytest.approx(-2 if crossed else 1, rel=1e-6)
    m = run(spec | {"actuators": rotary(179, 181)}, 200)
    rate = np.diff(np.unwrap(np.angle(m.z["B"] - 3))) / np.diff(np.radians(m.value["motor"]))
    assert rate[99:101] == pytest.approx(-0.5 if crossed else 1, rel=1e-6)


# --- X03: a nearly stretched dyad ------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14])
def test_x03_nearly_stretched(gap, method, tmp_path):
    position, z = tried(stretched(gap), tmp_path, method=method)
    apex, h = meet(0, 1, 2 - gap, 1)
    if method == "gim":
        allowed = 4 * TOLERANCE / h
    else:
        allowed = max(8 * U / gap * h, 2 * TOLERANCE)
        assert gap < 1e-11 or position.status.word == "ok"
    if position.status.word == "ok":
        assert abs(mpc(z["C"]) - apex) <= allowed


@pytest.mark.few(6)
@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
@pytest.mark.parametrize("gap", [-1e-2, -1e-6, -1e-8, -1e-9])
def test_x03_out_of_reach(gap, method, tmp_path):
    position, _ = tried(stretched(gap), tmp_path, method=method, sweeps=3000)
    assert position.status.word in ("not-assembled", "not-converged", "stalled", "singular")
    assert position.worst in ("left", "right")


@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
def test_x03_exactly_stretched(method, tmp_path):
    position, z = tried(stretched(0.0), tmp_path, method=method, sweeps=3000)
    assert position.status.word != "ok" or abs(z["C"] - 1) <= 2 * TOLERANCE


# --- X04, X05, X06: long, small, far ---------------------------------------------------------------------


@pytest.mark.parametrize("steps", [360, 7])
def test_x04_rod_a_million_times_the_crank(steps):
    m = run(slider_crank(1e6, 0, 360), steps)
    assert set(m.status) == {"ok"}
    exact = [slider_place(angle, 1e6) for angle in m.value["motor"]]
    assert max(abs(mpf(x) - e) for x, e in zip(m.z["B"].real, exact, strict=True)) <= 16 * U * 1e6
    if steps == 360:
        table = {1: 0.999847695004, 90: -5e-7, 179: -0.999847695309}
        for row, x in table.items():
            assert abs(m.z["B"][row].real - 1e6 - x) <= 1e-9
        assert abs(np.ptp(m.z["B"].real) - 2) <= 1e-9


@pytest.mark.parametrize("side", [1, -1])
def test_x04_short_links_with_long_ones(side):
    """1e-3 : 1e3 : 1e3 : 0.9e-3 is a double crank."""
    b, _ = meet(1e-3j, 1e3, 0.9e-3, 1e3, side)
    spec = drawn(four_bar(1e-3, 1e3, 1e3, 0.9e-3), A=1e-3j, B=b) | {"actuators": rotary(90, 450)}
    for tolerance in (TOLERANCE, 1e-8, 1e-5):  # rounding of a long length moves B by 1e-7
        m = run(spec, 72, tolerance=tolerance)
        for k in good(m):
            b, _ = meet(mpf(1e-3) * exact_ray(m.value["motor"][k]), 1e3, 0.9e-3, 1e3, side)
            assert abs(mpc(m.z["B"][k]) - b) <= tolerance * size(spec)
        assert set(m.status) <= {"ok", "singular"}
    assert set(m.status) == {"ok"}


@pytest.mark.parametrize("factor", [1e-9, 2.0**-30, 2.0**30, 1e9, 1e-30, 1e30])
def test_x05_the_unit_of_length_does_not_matter(factor):
    def norton(factor):
        b, _ = meet(40j, 120, 100, 80)
        lengths = (length * factor for length in (40, 120, 80, 100))
        return drawn(four_bar(*lengths), A=40j * factor, B=complex(b) * factor) | {"actuators": rotary(0, 360)}

    here, there = run(norton(1.0), 72), run(norton(factor), 72)
    assert set(here.status) == set(there.status) == {"ok"}
    assert list(here.motion.work) == list(there.motion.work)
    exact = factor == 2.0 ** round(np.log2(factor))
    assert np.max(abs(there.z["B"] / factor - here.z["B"])) <= (0.0 if exact else 1e-13 * 100)
    b, _ = meet(40 * exact_ray(40), 120, 100, 80)
    assert abs(mpc(here.z["B"][8]) - b) <= 1e-13 * 100


@pytest.mark.parametrize("given", [True, False])
def test_x06_far_from_the_origin(given):
    far = 1e8 - 1e8j
    spec = four_bar(1, 2.5, 2.5, 2)
    nodes = {"O2": far, "O4": far + 2, "A": far + 1j, "B": far + 2 + 2.5j}
    if not given:
        spec["links"] = {name: {"nodes": value["nodes"]} for name, value in spec["links"].items()}
    spec = drawn(spec | {"nodes": nodes}) | {"actuators": rotary(90, 450)}
    spec["points"] = {"P": {"on": "coupler", "local": [5, 0]}}
    m = run(spec, 72)
    assert set(m.status) == {"ok"}
    t = np.radians(m.value["motor"])
    root = 2 * np.sqrt((5 + np.cos(t)) / (5 - 4 * np.cos(t)))
    p = 2 + np.sin(t) * root + 1j * (2 - np.cos(t)) * root
    ulp = 1.490116119e-08
    assert np.max(abs(m.z["P"] - far - p)) <= ulp
    z = dict(zip(m.motion.mechanism.nodes, m.motion.mechanism.scale * m.motion.z, strict=True))
    inside = 2 * z["B"] - z["A"]
    assert np.max(abs(inside - p)) <= 1e-13 * 5


# --- X07, X08, X19: sliders ------------------------------------------------------------------------------


@pytest.mark.few(8)
@pytest.mark.parametrize("steps", [60, 59, 7, 1])
@pytest.mark.parametrize("delta", [1e-3, 1e-6, 1e-9, 1e-12])
def test_x07_guide_nearly_perpendicular_to_the_rod(delta, steps):
    offset = 2.0 - delta
    spec = slider_crank(3, -60, -120, offset=offset, at=np.radians(-60.0))
    m = run(spec, steps)
    for k in good(m):
        x = slider_place(m.value["motor"][k], 3, offset)
        slide = x - exact_ray(m.value["motor"][k]).real
        assert abs(mpf(m.z["B"][k].real) - x) <= max(TOLERANCE * size(spec), 40 * U / slide)
    for k in set(range(len(m.status))) - set(good(m)):  # only where rounding errors alone reach the tolerance
        slide = slider_place(m.value["motor"][k], 3, offset) - exact_ray(m.value["motor"][k]).real
        assert m.status[k] == "singular"
        assert 40 * U / slide > 0.1 * TOLERANCE * size(spec)


@pytest.mark.parametrize("delta", [1e-3, 1e-6, 1e-9, 1e-12])
def test_x07_table(delta):
    table = {1e-3: 0.0774532116829, 1e-6: 0.00244948953866, 1e-9: 7.74596669177e-05, 1e-12: 2.44948974278e-06}
    spec = slider_crank(3, -60, -90, offset=2.0 - delta, at=np.radians(-60.0))
    m = run(spec, 30)
    if delta == 1e-12:  # rounding errors alone are 4 U / x = 1.8e-10 or more
        assert m.status[-1] == "singular"
        m = run(spec, 30, tolerance=1e-8)
    assert m.status[-1] == "ok"
    assert m.z["B"][-1].real > 0
    rounding = 1e-11 + 4 * U / table[delta]  # the offset 2 - delta is rounded
    assert abs(m.z["B"][-1].real - table[delta]) <= rounding + TOLERANCE * 6


@pytest.mark.few(2)
@pytest.mark.parametrize("delta", [-1e-3, -1e-6, -1e-9, -1e-12])
def test_x07_the_limit_is_reported(delta):
    offset = 2.0 - delta
    m = run(slider_crank(3, -60, -120, offset=offset, at=np.radians(-60.0)), 60)
    angle = mp.degrees(mp.asin(mpf(offset) - 3))
    assert np.all(m.value["motor"][good(m)] >= float(angle) - 1e-8)
    assert "unreachable" in m.status
    assert abs(limit(m) - angle) <= np.degrees(max(1e-8, 20 * U / np.radians(90 + float(angle))))


@pytest.mark.parametrize("steps", [20, 19, 7, 2])
def test_x08_rows_beyond_the_dead_centre_are_not_solved(steps):
    m = run(slider_driven({"from": 3.9, "to": 4.1}), steps)
    x = m.value["table"]
    for k in good(m):
        assert x[k] <= 4 + 1e-12
        angle = crank_angle(min(x[k], 4.0))
        near = max(TOLERANCE * 6, 8 * U / mp.sqrt(max(4 - mpf(x[k]), mpf(U))))
        assert abs(mpc(m.z["A"][k]) - mp.expj(angle)) <= near
    assert all(status != "ok" for status, value in zip(m.status, x, strict=True) if value > 4 + 1e-12)
    assert all(np.isnan(m.z["A"][k]) == (m.status[k] != "ok") for k in range(steps + 1))
    assert abs(limit(m, "table") - 4) <= 1e-8


def test_x08_table():
    table = {3.9: 0.391444339002, 3.99: 0.122602407622, 3.9999: 0.0122475762949, 3.99999999: 0.000122474487267}
    for x, angle in table.items():
        m = run(slider_driven({"from": 3.8, "to": x}), 3)
        assert m.status[-1] == "ok"
        assert abs(np.angle(m.z["A"][-1]) - angle) <= max(6e-12, 16 * U / angle)


@pytest.mark.parametrize("steps", [40, 39, 10, 6])
def test_x08_to_the_dead_centre_and_back(steps):
    """3.9 -> 4 -> 3.9: after the dead centre there are two motions; the result must be one of them."""
    m = run(slider_driven({"profile": {"polynomial": [3.9, 0.4, -0.4]}}), steps)
    sides = []
    for k in good(m):
        x = min(m.value["table"][k], 4.0)
        angle = float(crank_angle(x))
        near = max(TOLERANCE * 6, 8 * U / np.sqrt(max(4 - x, U)))
        found = float(np.angle(m.z["A"][k]))
        assert min(abs(found - angle), abs(found + angle)) <= near
        if abs(angle) > 1e-6:
            sides.append((m.value["table"][k] < 4 and k > steps / 2, np.sign(found)))
    assert len({side for after, side in sides if not after}) == 1
    assert len({side for after, side in sides if after}) <= 1
    assert "not-converged" not in m.status


@pytest.mark.parametrize("direction", [90.0, 89.95, 90.05, -90.0, 269.99999])
def test_x19_steep_guides(direction):
    guide = complex(exact_ray(direction))
    spec = slider_crank(3, direction, direction + 360, direction=guide)
    m = run(spec, 72)
    assert set(m.status) == {"ok"}
    exact = [float(slider_place(angle - direction, 3)) * guide for angle in m.value["motor"]]
    assert np.max(abs(m.z["B"] - exact)) <= 1e-13 * 6


# --- X09: chains -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 10, 100])
def test_x09_scissor(n):
    spec = scissor(n, 1.2, {"from": 1.2, "to": 1.6})
    m = run(spec, 8)
    assert set(m.status) == {"ok"}
    w = m.value["ram"]
    for k in (1, n // 2 or 1, n):
        assert np.max(abs(m.z[f"L{k}"] - 1j * k * np.sqrt(4 - w**2))) <= TOLERANCE * size(spec)
        assert np.max(abs(m.z[f"R{k}"] - w - 1j * k * np.sqrt(4 - w**2))) <= TOLERANCE * size(spec)
    assert abs(m.z[f"L{n}"][0] - 1.6j * n) <= 1.3e-11 * 1.6 * max(n, 10)


@pytest.mark.few(4)
@pytest.mark.parametrize(("n", "ends"), [(2, (12, 166)), (50, (12, 166)), (2, (12, 340)), (50, (12, 340))])
@pytest.mark.parametrize("steps", [40, 7])
def test_x09_windows(n, ends, steps):
    spec = windows(n, *ends)
    m = run(spec, steps)
    for k in range(n + 1):
        z = m.z[f"B{k}"]
        assert np.max(abs(z - k - ray(m.value["motor"]))[good(m)]) <= TOLERANCE * size(spec)
    assert set(m.status) == {"ok"}


# --- X10: mechanisms that cannot be assembled ------------------------------------------------------------


def impossible():
    """Yield a name, a specification, and the constraints that may be reported."""
    spec = drawn(four_bar(1, 1, 1, 4), A=1, B=2.5) | {"actuators": rotary(0, 90)}
    yield "bars too short", spec, {"crank", "coupler", "follower"}
    spec = drawn(four_bar(1, 3, 2, 4.001), A=-1, B=2) | {"actuators": rotary(180, 181)}
    yield "out of reach", spec, {"coupler", "follower"}
    links = {"a": link("O2", "A", 1), "b": link("A", "C", 1), "c": link("O2", "C", 3)}
    spec = drawn({"nodes": {"O2": 0, "G": 5, "A": 1, "C": 2 + 1j}, "ground": ["O2", "G"], "links": links})
    yield "no triangle", spec | {"actuators": rotary(0, 90)}, {"b", "c"}
    links = {"a": link("O2", "A", 1), "b": link("O2", "A", 1.1)}
    spec = drawn({"nodes": {"O2": 0, "G": 5, "A": 1}, "ground": ["O2", "G"], "links": links})
    yield "two lengths", spec | {"actuators": rotary(0, 90)}, {"a", "b"}
    links = {"a": link("O2", "A", 1), "b": link("O2", "G", 4)}
    spec = drawn({"nodes": {"O2": 0, "G": 5, "A": 1}, "ground": ["O2", "G"], "links": links})
    yield "bar on the ground", spec | {"actuators": rotary(0, 90)}, {"b"}


@pytest.mark.few(4)
@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
@pytest.mark.parametrize(("name", "spec", "reported"), list(impossible()), ids=[case[0] for case in impossible()])
def test_x10_mechanisms_that_cannot_be_assembled(name, spec, reported, method, tmp_path):
    begin, refusal = time.monotonic(), ""
    try:
        position, z = tried(spec, tmp_path, method=method, sweeps=2000)
        m = run(spec, 4, method=method, sweeps=2000, jit="off")
    except GimError as error:
        refusal = str(error)
    assert time.monotonic() - begin < 20
    if refusal:
        assert any(f"'{part}'" in refusal for part in reported)
        return
    assert position.status.word != "ok"
    assert position.worst in reported
    assert position.residual.total[0] > 1e-4
    assert not np.any(np.isinf(list(z.values())))
    assert "ok" not in m.status
    assert m.motion.worst in reported
    assert all(np.all(np.isnan(z)) for z in m.z.values())


# --- X12, X13, X14: difficult cases for the iteration ----------------------------------------------------


@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
@pytest.mark.parametrize("start", [2, 1, 3.5, 0, 4])
def test_x12_collinear_start(method, start, tmp_path):
    links = {"left": link("O2", "C", 3), "right": link("D", "C", 3)}
    spec = drawn({"nodes": {"O2": 0, "D": 4, "C": start}, "ground": ["O2", "D"], "links": links})
    first, z = tried(spec, tmp_path, method=method)
    assert first.status.word == "ok"
    assert min(abs(z["C"] - (2 + side * 1j * np.sqrt(5))) for side in (1, -1)) <= 4 * TOLERANCE * 4
    again, _ = tried(spec, tmp_path, method=method)
    assert np.array_equal(first.z, again.z)


@pytest.mark.parametrize("strategy", ["spectral", "classic"])
def test_x13_rows_of_a_divergent_sequence_are_not_ok(strategy):
    spec = read("ten_bar")
    spec = spec | {"actuators": copy.deepcopy(spec["actuators"])}
    next(iter(spec["actuators"].values()))["law"] = {"by": 5}
    m = run(spec, 1, method="gim", strategy=strategy, sweeps=400, tolerance=1e-6, jit="off")
    exact = run(spec, 1)
    rows = good(m)
    assert strategy == "classic" or len(rows) == 2
    for name, z in m.z.items():
        assert np.max(abs(z - exact.z[name])[rows], initial=0.0) <= 1e-4 * size(spec)


@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
def test_x14_three_collinear_pairs_in_an_element(method):
    spec = scissor(2, 1.2, {"from": 1.2, "to": 1.4})
    tolerance = 1e-10
    m = run(spec, 4, method=method, tolerance=tolerance, sweeps=2000, jit="off")
    assert set(m.status) == {"ok"}
    w = m.value["ram"]
    assert np.max(abs(m.z["L2"] - 2j * np.sqrt(4 - w**2))) <= (1e-7 if method == "gim" else 1e-9)


@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
def test_x14_three_collinear_pairs_as_three_distances(method):
    """P is where two circles are tangent: only half the digits are determined, so `ok` needs an accurate position."""
    spec = four_bar(1, 2.5, 2.5, 2)
    spec["links"] |= {"half": link("B", "P", 2.5), "whole": link("A", "P", 5)}
    spec = drawn(spec, A=1j, B=2 + 2.5j, P=4 + 4j) | {"actuators": rotary(90, 100)}
    m = run(spec, 2, method=method, sweeps=2000, jit="off")
    for k in good(m):
        assert abs(m.z["P"][k] - (2 * m.z["B"][k] - m.z["A"][k])) <= (1e-4 if method == "gim" else TOLERANCE * 5)


# --- X15, X16: bifurcations and infinitesimally flexible structures --------------------------------------


@pytest.mark.parametrize("steps", [24, 25])
def test_x15_straight_through_the_bifurcation(steps):
    spec = read("double_butterfly_symmetric")
    m = run(spec, steps)
    assert set(m.status) == {"ok"}
    angle = m.value["motor"]
    p, q, t = (m.z[name] for name in "PQT")
    axis = np.sqrt((q - p) / abs(q - p) * (t - p) / abs(t - p))
    w = m.z["W"] / axis
    assert np.max(abs(w.imag)) <= 1e-9 * size(spec)
    # the mirror image of U is X
    assert np.max(abs(m.z["U"] - axis**2 * m.z["X"].conj())) <= 1e-9 * size(spec)
    turn = np.unwrap(np.angle(t / (4 - 3j)))  # of PST against its drawn shape; passes -65.6 deg
    assert np.ptp(turn) == pytest.approx(np.radians(np.ptp(angle)), abs=1e-9)


def test_x16_an_infinitesimally_flexible_structure_does_not_move():
    nodes = {"O2": 0, "E": 2, "F": 1 + 2j, "A": 6j, "B": 2 + 6j, "C": 1 + 4j}
    links = {"a": link("O2", "A", 6), "b": link("E", "B", 6), "c": link("F", "C", 2)}
    shape = {"A": [0, 0], "B": [2, 0], "C": [1, -2]}
    spec = drawn({"nodes": nodes, "ground": ["O2", "E", "F"], "links": links})
    spec["elements"] = {"top": {"nodes": ["A", "B", "C"], "shape": shape}}
    spec["actuators"] = rotary(90, 70)
    try:
        m = run(spec, 20)
    except GimError:
        return
    rows = good(m)
    assert np.all(abs(m.value["motor"][rows] - 90) < np.degrees(np.sqrt(2 * TOLERANCE)))


# --- X17: large steps, and angles that differ by full turns ----------------------------------------------


@pytest.mark.parametrize("steps", [1, 2, 3, 4, 7])
def test_x17_few_steps_give_the_continuous_motion(steps):
    spec = read("jansen")
    law = {"from": -3.535149589, "to": 905.846274}  # deg: -0.0617 to 15.81 rad
    spec = spec | {"actuators": copy.deepcopy(spec["actuators"])}
    next(iter(spec["actuators"].values()))["law"] = law
    coarse, fine = run(spec, steps), run(spec, 84)
    assert set(coarse.status) == {"ok"}
    for name, z in coarse.z.items():
        if 84 % steps == 0:
            assert np.max(abs(z - fine.z[name][:: 84 // steps])) <= 1e-11 * size(spec)


def test_x17_angles_that_differ_by_full_turns_are_the_same_position():
    b, _ = meet(40j, 120, 100, 80)
    spec = drawn(four_bar(40, 120, 80, 100), A=40j, B=b)
    ends = [run(spec | {"actuators": rotary(*law)}, 5).z["B"] for law in ((359, 1), (-1, 1), (-361, 361), (719, -719))]
    assert np.ptp([z[-1].real for z in ends]) <= 1e-11
    assert np.ptp([z[0].imag for z in ends]) <= 1e-11


# --- X20: redundant constraints --------------------------------------------------------------------------


@pytest.mark.few(12)
@pytest.mark.parametrize("method", ["auto", "newton"])
@pytest.mark.parametrize("make", [third_crank, walker])
@pytest.mark.parametrize("error", [1e-3, -1e-3, 1e-6, -1e-6, 1e-8, 1e-9])
def test_x20_a_contradiction_is_reported(make, error, method):
    try:
        m = run(make(error), 8, method=method)
    except GimError:
        return
    assert "ok" not in m.status
    assert set(m.status) <= {"contradictory", "not-assembled"}


@pytest.mark.few(8)
@pytest.mark.parametrize("method", ["auto", "newton"])
@pytest.mark.parametrize("make", [third_crank, walker])
@pytest.mark.parametrize("error", [0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, -1e-12])
def test_x20_with_an_error_below_the_tolerance_it_moves(make, error, method):
    spec = make(error)
    m = run(spec, 8, method=method)
    assert set(m.status) == {"ok"}
    assert np.max(worst(spec, m)) <= TOLERANCE
    exact = run(make(0.0), 8)
    assert max(np.max(abs(z - exact.z[name])) for name, z in m.z.items()) <= 100 * abs(error) * 6 + 1e-11 * size(spec)
