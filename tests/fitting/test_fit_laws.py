"""Fits whose law varies: what is reported is what an own trace of the written text gives."""

import math
import signal

import numpy as np
import pytest

from gimcli import fit, load, loads, trace
from gimcli.families.design_state import position_items
from gimcli.families.family import Family
from gimcli.fitting.motion_quantity import MotionQuantity

MODEL = """
units: {length: mm}
parameters: {s: 200, w: 100}
nodes: {O2: [0, 0], O4: [100, 0], A: [40, 0], B: [136, 71]}
ground: [O2, O4]
links:
  crank: {nodes: [O2, A], length: 40}
  coupler: {nodes: [A, B], length: 120}
  rocker: {nodes: [O4, B], length: 80}
actuators: {motor: {pivot: O2, arm: A, law: {from: s, by: w}}}
points: {P: {on: coupler, local: [60, 40]}}
"""


def position(degrees, crank=40.0):
    """Return the place of P, and the direction of the coupler [deg], from two circles."""
    a = crank * np.exp(1j * np.radians(degrees))
    d = 100.0 - a
    along = (abs(d) ** 2 + 120.0**2 - 80.0**2) / (2.0 * abs(d))
    direction = d / abs(d) * (along + 1j * np.sqrt(120.0**2 - along**2)) / 120.0
    return a + direction * (60.0 + 40.0j), np.degrees(np.angle(direction))


def written(tmp_path, text=MODEL):
    path = tmp_path / "law.yaml"
    path.write_text(text)
    return load(path)


def own_distances(found, targets):
    """Return the distances of the targets from the positions of P that the written text has at the reported inputs."""
    text = found.model().text
    own = loads(text)
    first, last = (float(v) for v in np.degrees(own.actuators[0].law(np.array([0.0, 1.0]))))
    assert np.all((found["motor"] >= min(first, last) - 1e-9) & (found["motor"] <= max(first, last) + 1e-9))
    distances = []
    for u, target in zip(found["motor"], targets, strict=True):
        rows = trace(own.with_({"s": first, "w": u - first}), 90) if abs(u - first) > 1e-9 else trace(own, 90)
        xy = rows.xy["P"][-1 if abs(u - first) > 1e-9 else 0]
        distances.append(abs(complex(*xy) - target))
    return np.array(distances)


def test_start_of_the_law_is_found_and_not_determined(tmp_path):
    """P of a known crank at 60 to 150 deg; the law is 100 deg long, so that it may start from 50 to 60 deg."""
    targets, _ = position(np.array([60.0, 90.0, 120.0, 150.0]))
    xy = np.column_stack((targets.real, targets.imag))
    found = fit(written(tmp_path), {"s": (0, 300), "crank": (30, 50)}, xy, starts=1000)
    assert found.dimensions["crank.length"] == pytest.approx(40.0, abs=1e-9)
    assert 50.0 - 1e-7 <= found.dimensions["s"] <= 60.0 + 1e-7
    assert found.rms < 1e-9
    assert found["motor"] == pytest.approx([60, 90, 120, 150], abs=1e-6)
    assert found.undetermined == ("s",)
    assert np.max(own_distances(found, targets)) < 1e-7


def test_derivatives_by_ends_of_the_law_are_those_of_two_circles():
    """The derivative by the start, at a part of the law, is that by the angle; by the width, that part of it."""
    family = Family(loads(MODEL), ["s", "w", "crank"])
    quantity = MotionQuantity(family, position_items(family.mechanism, "P.x"), along_law=True)
    part, h = np.array([0.0, 0.3, 1.0]), 1e-4
    rates = quantity.rates(np.array([[30.0, 150.0, 42.0]]), np.radians(200.0 + 100.0 * part)[None])
    at = 30.0 + 150.0 * part
    by_degree = (position(at + h, 42.0)[0].real - position(at - h, 42.0)[0].real) / (2 * h)
    by_crank = (position(at, 42.0 + h)[0].real - position(at, 42.0 - h)[0].real) / (2 * h)
    assert rates.values[0, :, 0] == pytest.approx(position(at, 42.0)[0].real, abs=1e-9)
    assert rates.by_dimension[0, :, 0] == pytest.approx(
        np.column_stack((by_degree, part * by_degree, by_crank)), abs=1e-6
    )
    assert rates.by_input[0, :, 0] == pytest.approx(by_degree * 1.5 * 180.0 / np.pi, abs=1e-5)


def test_three_poses_with_a_varied_law(tmp_path):
    """Poses of a known coupler, from a law whose start and length are not known."""
    inputs = np.array([60.0, 80.0, 110.0])
    targets, angles = position(inputs, 45.0)
    columns = {"x": targets.real, "y": targets.imag, "angle": angles}
    found = fit(written(tmp_path), {"s": (0, 360), "w": (20, 150), "crank": (30, 60)}, columns, starts=1000)
    assert found.rms < 1e-9 * 120.0
    assert found.dimensions["crank.length"] == pytest.approx(45.0, abs=1e-7)
    assert np.max(own_distances(found, targets)) < 1e-7


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(4))
def test_reported_distances_are_those_of_the_written_text(tmp_path, seed):
    """Of targets that no design meets."""
    random = np.random.default_rng(seed)
    targets, _ = position(np.sort(random.uniform(20.0, 170.0, 5)))
    targets = targets + random.normal(size=5) + 1j * random.normal(size=5)
    bounds = {"s": (0, 120), "w": (60, 150), "crank": (30, 50)}
    found = fit(written(tmp_path), bounds, np.column_stack((targets.real, targets.imag)), starts=300)
    assert found.feasible
    own = own_distances(found, targets)
    assert found["distance"] == pytest.approx(own, abs=1e-7)
    assert found.rms == pytest.approx(math.sqrt(np.mean(own**2)), abs=1e-7)


def test_end_at_seconds_and_at_an_interrupt(tmp_path):
    """The best design until then is reported, with the status and the dimensions that stand on a bound."""
    targets, _ = position(np.array([60.0, 90.0, 120.0, 150.0]), 40.0)
    xy = np.column_stack((targets.real, targets.imag))
    bounds = {"s": (0, 300), "crank": (41, 50)}
    late = fit(written(tmp_path), bounds, xy, seconds=0.3)
    assert late.status == "work-limit"
    assert not late.complete
    stopped = fit(
        written(tmp_path), bounds, xy, starts=1000, progress=lambda _: lambda *_: signal.raise_signal(signal.SIGINT)
    )
    assert stopped.status == "interrupted"
    assert stopped.feasible
    assert stopped.on_bounds == ("crank.length",)


BESIDE = (
    MODEL.replace("O4: [100, 0],", "O4: [100, 0], E: [300, 0], F: [310, 0], U: [500, 0], V: [520, 0], W: [510, 1],")
    .replace("ground: [O2, O4]", "ground: [O2, O4, E, U, V]")
    .replace("  crank: {nodes", "  other: [E, F]\n  left: [U, W]\n  right: [W, V]\n  crank: {nodes")
    .replace("from: s, by: w}}}", "from: s, by: w}}, fan: {pivot: E, arm: F, law: {by: 360}}}")
)


@pytest.mark.parametrize("read", [written, lambda _, text: loads(text)])
def test_a_fit_is_of_the_machine_that_has_the_dimensions(tmp_path, read):
    """P of a crank of 40 at four inputs, beside a fan and a strut; the text of the file keeps all of it."""
    inputs = np.array([210.0, 230.0, 250.0, 290.0])
    targets, _ = position(inputs)
    mechanism = read(tmp_path, BESIDE)
    columns = {"x": targets.real, "y": targets.imag, "input": inputs}
    found = fit(mechanism, {"crank": (30, 50)}, columns, starts=200)
    assert found.dimensions["crank.length"] == pytest.approx(40.0, abs=1e-8)
    assert found.rms < 1e-9
    if mechanism.path is not None:
        assert {one.name for one in loads(found.model().text).machines} == {"motor", "fan", "W"}
