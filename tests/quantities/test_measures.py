"""Instant centres, curvatures, transmission angles, advantages and swept areas, compared with closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from bundled import MODELS, run_model

from gimcli import load
from gimcli.mechanism import Member
from gimcli.motion.motion import Motion, stream, trace
from gimcli.quantities import area as sweeping_area
from gimcli.quantities.area import swept_area, union_area
from gimcli.quantities.centre import instant_centre
from gimcli.quantities.kinds import KINDS, quantities_of
from gimcli.quantities.motion_table import Record
from gimcli.quantities.state import MotionState
from gimcli.rates.path_derivatives import PathDerivatives, input_path
from gimcli.status import Status

TRANSLATING = ("parallelogram", "parallelogram_third_crank", "scotch_yoke", "swing", "rack_lift", "double_pendulum")
"""Models without three members whose centres are all at a finite distance."""


def derivatives_of(name, steps=72, **more):
    return PathDerivatives(run_model(name, steps, **more).motion)


def values(measure, path):
    state = MotionState(path.motion)
    return [state.value(measure, k) for k in range(len(measure.heads))]


def whole(measure, path):
    """Return the results of a measure for a whole motion."""
    record = Record([measure])
    record.add(MotionState(path.motion, memory=record.memory))
    return measure.whole(MotionState(path.motion, memory=record.memory), record.ranges)


def recorded(record, piece):
    """Add the next piece of a motion to a record; return its columns."""
    state = MotionState(piece, memory=record.memory)
    record.add(state)
    return [state.value(measure, k) for measure in record.measures for k in range(len(measure.heads))]


def values_of(derivatives, spec):
    """Return the columns of one measure by the last part of their names."""
    (measure,) = quantities_of(derivatives.mechanism, spec)
    found = dict(zip((h.name for h in measure.heads), values(measure, derivatives), strict=True))
    return {name.removeprefix(spec).lstrip("."): column for name, column in found.items()}


def moving_at(rates, mechanism, member, place):
    """Return the velocity of the point of a member at a position."""
    if member == 0:
        return np.zeros(len(place), dtype=complex)
    node = mechanism.members[member].nodes[0]
    return rates.nodes[1, node] + 1j * rates.angular(member)[0] * (place - rates.nodes[0, node])


# --- instant centres -------------------------------------------------------------------------------------


@pytest.mark.few
def test_both_members_have_the_same_velocity_at_their_centre(model):
    mechanism = load(model)
    derivatives = PathDerivatives(trace(mechanism, 24))
    for i, j in combinations(range(len(mechanism.members)), 2):
        place = instant_centre(derivatives.along, i, j)
        known = np.abs(place) < 30.0 * mechanism.size  # rounding errors grow with the distance
        one, other = (moving_at(derivatives.along, mechanism, m, place)[known] for m in (i, j))
        fastest = max(1.0, np.nanmax(np.abs(derivatives.along.nodes[1])))
        assert np.max(np.abs(one - other), initial=0.0) < 1e-9 * fastest


@pytest.mark.few
def test_the_three_centres_of_any_three_members_are_on_a_line(model):
    """Kennedy's theorem. Source: Norton, Design of Machinery, section 6.3."""
    mechanism = load(model)
    derivatives = PathDerivatives(trace(mechanism, 16))
    centre = {p: instant_centre(derivatives.along, *p) for p in combinations(range(len(mechanism.members)), 2)}
    seen = 0
    for i, j, k in combinations(range(len(mechanism.members)), 3):
        a, b, c = centre[i, j], centre[j, k], centre[i, k]
        near = np.maximum(np.maximum(np.abs(a), np.abs(b)), np.abs(c)) < 30.0 * mechanism.size
        # twice the triangle's area, and its change by an error of 1e-9 sizes in a corner
        twice = np.abs((np.conj(b - a) * (c - a)).imag)[near]
        longest = (np.abs(b - a) + np.abs(c - a) + mechanism.size)[near]
        assert np.max(twice / longest, initial=0.0) < 1e-8 * mechanism.size
        seen += near.sum()
    assert seen or len(mechanism.members) < 3 or model.stem in TRANSLATING


def test_the_centre_of_a_coupler_is_the_intersection_of_crank_and_rocker():
    """Crank-rocker 40, 120, 80, 100: lines O2-A and O4-B, and for crank and rocker lines A-B and O2-O4."""
    run = run_model("crank_rocker", 90)
    derivatives = PathDerivatives(run.motion)
    o2, o4, a, b = (run.xy(n) for n in ("O2", "O4", "A", "B"))

    def meeting(p, q, r, s):
        return p + (q - p) * (np.conj(s - r) * (r - p)).imag / (np.conj(s - r) * (q - p)).imag

    for spec, expected in (
        ("centre:frame/coupler", meeting(o2, a, o4, b)),
        ("centre:crank/rocker", meeting(a, b, o2, o4)),
    ):
        got = values_of(derivatives, spec)
        off = np.abs(got["x"] + 1j * got["y"] - expected) / np.maximum(np.abs(expected), 100.0)
        near = np.abs(expected) < 1e4
        assert near.sum() > 80
        assert np.max(off[near]) < 1e-10


def test_the_centrodes_of_an_elliptic_trammel_are_cardan_circles():
    """Elliptic trammel, bar L = 2.5: centrodes are circles of radius L about O and of L/2 about the bar's middle."""
    derivatives = derivatives_of("elliptic_trammel", 72)
    got = values_of(derivatives, "centre:frame/bar")
    assert np.abs(got["x"] + 1j * got["y"]) == pytest.approx(np.full(73, 2.5), abs=1e-13)
    assert np.abs(got["bar.x"] - 1.25 + 1j * got["bar.y"]) == pytest.approx(np.full(73, 1.25), abs=1e-13)


def test_fixed_and_moving_centrode_agree_in_each_row():
    derivatives = derivatives_of("crank_rocker", 36)
    got, z = values_of(derivatives, "centre:crank/rocker"), derivatives.motion.z
    mechanism = derivatives.mechanism
    for member in mechanism.members[1:4:2]:
        first, second = (mechanism.to_file(z[n]) for n in member.nodes)
        local = got[f"{member.name}.x"] + 1j * got[f"{member.name}.y"]
        place = first + local * (second - first) / np.abs(second - first)
        assert np.max(np.abs(place - got["x"] - 1j * got["y"])) < 1e-9 * np.max(np.abs(place))


def test_a_centrode_does_not_depend_on_the_law():
    """A quintic law is at rest at both ends: the centres are the same as for uniform speed."""
    laws = [{"motor": {"from": 0, "to": 90, **more}} for more in ({}, {"profile": "quintic"})]
    even, slow = (values_of(derivatives_of("crank_rocker", 2, laws=law), "centre:frame/coupler") for law in laws)
    for column in even:
        assert slow[column] == pytest.approx(even[column], rel=1e-9)


def test_a_constant_law_has_centres_too():
    still = values_of(derivatives_of("crank_rocker", 1, laws={"motor": {"from": 40, "to": 40}}), "centre:frame/coupler")
    moving = values_of(
        derivatives_of("crank_rocker", 1, laws={"motor": {"from": 40, "to": 41}}), "centre:frame/coupler"
    )
    assert still["x"][0] == pytest.approx(moving["x"][0], rel=1e-12)


def mechanism_place(derivatives, name):
    return derivatives.mechanism.to_file(derivatives.motion.z[derivatives.mechanism.nodes.index(name)])


def test_centres_at_infinity_are_empty():
    """The coupler of a parallelogram only translates; crank and rocker have no relative rotation."""
    derivatives = derivatives_of("parallelogram", 8, laws={"motor": {"from": 10, "to": 90}})
    names = [m.name for m in derivatives.mechanism.members[1:]]
    lost = values_of(derivatives, f"centre:frame/{names[1]}")
    assert np.isnan(lost["x"]).all()
    assert np.isfinite(values_of(derivatives, f"centre:frame/{names[0]}")["x"]).all()


def test_members_at_rest_for_an_instant_have_a_centre():
    """Watt II at a dead centre of its first loop: the second loop is at rest too, with a smooth centrode."""
    mechanism = load(MODELS / "watt_2.yaml")
    motor = mechanism.actuators[0].name
    a, b, c, d = _first_loop(mechanism)
    dead = math.degrees(math.acos((d**2 + (a + b) ** 2 - c**2) / (2 * d * (a + b))))
    base = math.degrees(np.angle(mechanism.drawn[mechanism.nodes.index("O4")] - mechanism.drawn[0]))
    middle = {}
    for h in (0.0, 0.01, 0.02):
        derivatives = derivatives_of(
            "watt_2", 2, laws={motor: {"from": base + dead - h - 1.0, "to": base + dead - h + 1.0}}
        )
        got = values_of(derivatives, "centre:frame/drag_link")
        middle[h] = complex(got["x"][1], got["y"][1])
        if h == 0.0:
            assert np.max(np.abs(derivatives.along.nodes[1, mechanism.nodes.index("B"), 1])) < 1e-10
    # a one-sided difference extrapolated to the dead centre: third order in 0.01 deg
    assert abs(middle[0.0] - (2 * middle[0.01] - middle[0.02])) < 1e-4 * abs(middle[0.0] - mechanism.origin)
    assert abs(middle[0.01] - middle[0.02]) > 1e-7


def _first_loop(mechanism):
    """Crank, coupler, side O4-B of the bell crank, and frame; normal frame."""
    member = {m.name: m for m in mechanism.members}
    node = mechanism.nodes.index
    crank, coupler = (m for m in mechanism.members[1:3])
    bell = member["bell_crank"]
    a, b = (abs(m.shape[1] - m.shape[0]) for m in (crank, coupler))
    c = abs(bell.local(node("B")) - bell.local(node("O4")))
    d = abs(mechanism.drawn[node("O4")] - mechanism.drawn[0])
    return a, b, c, d


def test_members_without_relative_velocity_for_an_instant():
    """Body 1 turns about 0 by s, body 2 relative to it about c by s^2: at s = 0 they move together, the centre is c."""
    c, p, q = 0.7 + 0.4j, np.array([0.3 + 0.1j, 1.1 - 0.2j]), np.array([0.2 - 0.5j, 1.5 + 0.6j])
    z, v = np.concatenate([p, q]), 1j * np.concatenate([p, q])
    a = np.concatenate([-p, -q + 2j * (q - c)])
    bodies = [Member("one", (0, 1), p), Member("two", (2, 3), q)]
    mechanism = replace(load(MODELS / "crank_rocker.yaml"), members=(Member("ground", (), np.zeros(0)), *bodies))
    turning = {1: np.array([[1.0], [0.0]]), 2: np.array([[1.0], [2.0]])}
    nodes = np.array([z, v, a])[:, :, None]
    found = instant_centre(SimpleNamespace(mechanism=mechanism, nodes=nodes, angular=turning.get), 1, 2)
    assert found[0] == pytest.approx(c, abs=1e-12)


def test_pivots_are_centres():
    derivatives = derivatives_of("crank_rocker", 12)
    got, b = (
        values_of(derivatives, "centre:coupler/rocker"),
        derivatives.motion.z[derivatives.mechanism.nodes.index("B")],
    )
    place = derivatives.mechanism.to_file(b)
    assert np.max(np.abs(got["x"] + 1j * got["y"] - place)) < 1e-9
    assert got["coupler.x"] == pytest.approx(np.full(13, 120.0))
    assert np.max(np.abs(got["coupler.y"])) < 1e-9
    derivatives = derivatives_of(
        "crank_rocker", 1, laws={"motor": {"from": 1e-6, "to": 90}}
    )  # almost no relative rotation
    place, got = mechanism_place(derivatives, "B"), values_of(derivatives, "centre:coupler/rocker")
    assert np.max(np.abs(got["x"] + 1j * got["y"] - place)) < 1e-11


# --- curvature -------------------------------------------------------------------------------------------


def test_the_curvature_of_an_ellipse():
    """P is 1 behind A: semi-axes 3.5 and 1; radius (a^2 sin^2 + b^2 cos^2)^(3/2) / (a b), centre on the evolute."""
    run = run_model("elliptic_trammel", 72)
    got, p, a, b = values_of(PathDerivatives(run.motion), "curvature:P"), run.xy("P"), 3.5, 1.0
    t = np.arctan2(p.imag / b, p.real / a)
    assert np.abs(got["radius"]) == pytest.approx((a**2 * np.sin(t) ** 2 + b**2 * np.cos(t) ** 2) ** 1.5 / (a * b))
    assert got["centre.x"] == pytest.approx((a**2 - b**2) / a * np.cos(t) ** 3, abs=1e-12)
    assert got["centre.y"] == pytest.approx((b**2 - a**2) / b * np.sin(t) ** 3, abs=1e-12)
    turning = np.sign(np.diff(np.unwrap(np.angle(p))))
    assert set(np.sign(got["radius"])) == set(turning), "positive to the left of the motion"
    assert got["curvature"] == pytest.approx(1.0 / got["radius"])


def test_the_curvature_of_a_rocker_at_its_dead_centres():
    """At the rocker's dead centres B is at rest: crank and coupler in line (law of cosines). The radius stays 80."""
    stretched, folded = (math.acos((100**2 + r**2 - 80**2) / (2 * 100 * r)) for r in (160.0, 80.0))
    dead = [math.degrees(stretched), math.degrees(folded) + 180.0]
    run = run_model("crank_rocker", 1, laws={"motor": {"from": dead[0], "to": dead[1]}})
    derivatives = PathDerivatives(run.motion)
    speed = np.abs(derivatives.along.point("B")[1])
    assert np.max(speed) < 1e-12, "both rows are dead centres"
    got = values_of(derivatives, "curvature:B")
    assert np.abs(got["radius"]) == pytest.approx([80.0, 80.0], rel=1e-6)
    assert got["centre.x"] == pytest.approx([100.0, 100.0], abs=1e-4)
    assert got["centre.y"] == pytest.approx([0.0, 0.0], abs=1e-4)


def test_the_curvature_of_a_slider_at_its_dead_centres():
    """Crank 1, rod 3 and no offset: B is at rest at 0 and 180 deg; its radius is infinite everywhere."""
    run = run_model("slider_crank", 8, laws={"motor": {"from": 0, "to": 360}}, change=_no_offset)
    got = values_of(PathDerivatives(run.motion), "curvature:B")
    assert np.isinf(got["radius"]).all()
    assert (got["curvature"] == 0.0).all()
    assert np.isnan(got["centre.x"]).all()


def test_the_curvature_of_a_slider_on_an_inclined_line():
    """A curvature that is only rounding counts as 0."""
    run = run_model("slider_crank", 8, laws={"motor": {"from": 33, "to": 393}}, change=_slanting)
    got = values_of(PathDerivatives(run.motion), "curvature:B")
    assert np.abs(PathDerivatives(run.motion).along.point("B")[1][[0, 4, 8]]) == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.isinf(got["radius"]).all()


def _no_offset(data):
    data["nodes"] |= {"G": [1, 0], "H": [5, 0], "B": [3.5, 0]}


def _slanting(data):
    turn = np.exp(1j * np.radians(33.0))
    data["nodes"] |= {n: [float((r * turn).real), float((r * turn).imag)] for n, r in (("G", 1), ("H", 5), ("B", 3.5))}


def test_the_radius_at_a_cusp_is_0():
    """The middle of the trammel's moving centrode's rim draws straight lines; other points have no cusp.

    A point at the pole has a cusp: here the coupler point of a four-bar at the pole of one row.
    """
    start = derivatives_of("crank_rocker", 1, laws={"motor": {"from": 60, "to": 61}})
    pole = values_of(start, "centre:frame/coupler")
    place = [float(pole[f"coupler.{axis}"][0]) for axis in "xy"]
    run = run_model(
        "crank_rocker",
        1,
        laws={"motor": {"from": 60, "to": 61}},
        change=lambda d: d["points"].update(C={"on": "coupler", "local": place}),
    )
    got = values_of(PathDerivatives(run.motion), "curvature:C")
    assert got["radius"][0] == 0.0
    assert got["centre.x"][0] == pytest.approx(float(pole["x"][0]), rel=1e-9)
    assert 0.0 < abs(got["radius"][1]) < math.inf


def test_the_euler_savary_equation():
    """Points of a coupler on one ray from the pole: (1/r_A - 1/r_C) sin(psi) is the same for all rays: 1/diameter.

    r from the pole to the point and to its centre of curvature. Source: Hartenberg & Denavit, Kinematic Synthesis of
    Linkages, section 7.3.
    """
    local = {"P1": [60, 40], "P2": [20, -30], "P3": [100, 80], "P4": [-40, 10]}
    run = run_model(
        "crank_rocker",
        24,
        change=lambda d: d["points"].update({n: {"on": "coupler", "local": at} for n, at in local.items()}),
    )
    derivatives = PathDerivatives(run.motion)
    pole = values_of(derivatives, "centre:frame/coupler")
    p = pole["x"] + 1j * pole["y"]
    rows = []
    for name in local:
        got = values_of(derivatives, f"curvature:{name}")
        ray = run.xy(name) - p
        centre = got["centre.x"] + 1j * got["centre.y"] - p
        along = ray / np.abs(ray)
        r, c = np.abs(ray), (centre * np.conj(along)).real
        assert np.max(np.abs((centre * np.conj(along)).imag) / np.maximum(np.abs(centre), 1.0)) < 1e-8, "on the ray"
        rows.append((along, 1.0 / r - 1.0 / c))
    # (1/r - 1/c) sin(psi) = 1/D and psi measured from the pole tangent: 1/(1/r - 1/c) is linear in the direction
    for row in range(25):
        directions = np.array([[u[row].real, u[row].imag] for u, _ in rows])
        inverse = np.array([1.0 / w[row] for _, w in rows])
        solved, *_ = np.linalg.lstsq(directions[:2], inverse[:2], rcond=None)
        assert directions @ solved == pytest.approx(inverse, rel=1e-7, abs=1e-6)


def test_exact_straight_lines_have_no_curvature():
    for model, point in (("peaucellier", "Q"), ("hart_a_frame", None), ("scott_russell", "P")):
        run = run_model(model, 20)
        names = [point] if point else [p.name for p in run.mechanism.points] or list(run.mechanism.traced)
        got = values_of(PathDerivatives(run.motion), f"curvature:{names[0]}")
        size = run.mechanism.size * run.mechanism.scale
        assert np.nanmax(np.abs(got["curvature"])) * size < 1e-9
        assert np.isfinite(got["curvature"]).sum() > 10


@pytest.mark.few
def test_curvature_agrees_with_a_circle_through_neighbours(model):
    """Independent of derivatives: the circle through three close positions, error of second order."""
    mechanism = load(model)
    motion = trace(mechanism, 800)
    derivatives = PathDerivatives(motion)
    point = mechanism.traced[0]
    got = values_of(derivatives, f"curvature:{point}")["curvature"][1:-1] * mechanism.scale
    p = derivatives.along.point(point)[0]
    a, b, c = p[:-2], p[1:-1], p[2:]
    with np.errstate(all="ignore"):
        near = 2.0 * (np.conj(b - a) * (c - b)).imag / (np.abs(b - a) * np.abs(c - b) * np.abs(c - a))
    step = np.abs(c - a)
    known = np.isfinite(near) & np.isfinite(got) & (step > 1e-5)
    assert known.sum() >= 50
    error = np.abs(near - got)[known] / np.maximum(1.0, np.abs(got[known]))
    assert np.median(error) < 5e-4


def test_curvature_where_several_inputs_start_from_rest():
    """Two inputs with the same profile: the path is the same as at uniform speed."""
    laws = [
        {"motor_1": {"from": 60, "to": 80, **more}, "motor_2": {"from": 120, "to": 90, **more}}
        for more in ({}, {"profile": "quintic"}, {"profile": "cubic"})
    ]
    names = [a.name for a in load(MODELS / "five_bar.yaml").actuators]
    runs = [
        derivatives_of("five_bar", 2, laws=dict(zip(names, law.values(), strict=True))) for law in laws
    ]  # fmt: skip
    point = runs[0].mechanism.traced[0]
    even, *slow = (values_of(s, f"curvature:{point}") for s in runs)
    for other in slow:
        assert other["radius"] == pytest.approx(even["radius"], rel=1e-7)
        assert other["centre.x"] == pytest.approx(even["centre.x"], rel=1e-7)


def test_curvature_with_different_profiles_of_the_inputs():
    """One of two inputs slows down; compared with the circle through three close positions."""
    names = [a.name for a in load(MODELS / "five_bar.yaml").actuators]
    laws = {names[0]: {"by": 25, "profile": "cubic"}, names[1]: {"by": -20}}
    derivatives = derivatives_of("five_bar", 400, laws=laws)
    point = derivatives.mechanism.traced[0]
    p = derivatives.along.point(point)[0]
    a, b, c = p[:-2], p[1:-1], p[2:]
    near = 2.0 * (np.conj(b - a) * (c - b)).imag / (np.abs(b - a) * np.abs(c - b) * np.abs(c - a))
    got = values_of(derivatives, f"curvature:{point}")["curvature"][1:-1] * derivatives.mechanism.scale
    known = np.isfinite(got) & np.isfinite(near)
    assert known.sum() > 100
    assert np.max(np.abs(near - got)[known]) < 1e-4 * np.max(np.abs(got[known]))


def test_curvature_is_empty_where_inputs_start_from_rest_with_different_profiles():
    names = [a.name for a in load(MODELS / "five_bar.yaml").actuators]
    laws = {names[0]: {"by": 20, "profile": "cubic"}, names[1]: {"by": -20, "profile": "quintic"}}
    derivatives = derivatives_of("five_bar", 2, laws=laws)
    way = input_path(derivatives.mechanism, derivatives.motion.time)
    assert way.smooth.tolist() == [False, True, False]
    point = derivatives.mechanism.traced[0]
    assert np.isnan(values_of(derivatives, f"curvature:{point}")["radius"]).tolist() == [True, False, True]


# --- transmission angle ----------------------------------------------------------------------------------


def test_the_transmission_angle_of_a_four_bar():
    """cos mu = (b^2 + c^2 - a^2 - d^2 + 2 a d cos theta) / (2 b c). Source: Balli & Chand 2002."""
    run = run_model("crank_rocker", 90)
    (measure,) = quantities_of(run.mechanism, "transmission")
    assert measure.spec == "transmission:coupler/rocker"
    theta, (a, b, c, d) = np.radians(run.value["motor"]), (40.0, 120.0, 80.0, 100.0)
    mu = np.degrees(np.arccos((b**2 + c**2 - a**2 - d**2 + 2 * a * d * np.cos(theta)) / (2 * b * c)))
    for spec in ("transmission", "transmission:B", "transmission:rocker/coupler", "transmission:A/B/O4"):
        (measure,) = quantities_of(run.mechanism, spec)
        assert values(measure, PathDerivatives(run.motion))[0] == pytest.approx(mu, abs=1e-10)
    assert whole(measure, PathDerivatives(run.motion))["worst"] == pytest.approx(min(mu.min(), 180 - mu.max()))


def test_the_transmission_angle_of_a_slider_crank():
    """90 deg minus the pressure angle: sin(pressure) = (r sin theta - e) / l; for both sides of the guide."""
    run = run_model("slider_crank", 90)
    (measure,) = quantities_of(run.mechanism, "transmission")
    assert measure.spec == "transmission:rod/slide"
    pressure = np.degrees(np.arcsin((np.sin(np.radians(run.value["motor"])) - 0.5) / 3.0))
    assert values(measure, PathDerivatives(run.motion))[0] == pytest.approx(90.0 - pressure, abs=1e-10)
    assert whole(measure, PathDerivatives(run.motion))["worst"] == pytest.approx(60.0), (
        "crank at 270 deg: arcsin(1.5 / 3)"
    )


def test_the_transmission_angle_of_a_ram():
    """Excavator: at every ram the law of cosines of the triangle pivot, foot and head of the ram."""
    run = run_model("excavator", 8)
    specs = [m.spec for m in quantities_of(run.mechanism, "transmission")]
    assert specs == [
        f"transmission:{p}" for p in ("boom/boom_ram", "arm/arm_ram", "h_link/bucket_ram", "bucket/side_link")
    ]
    for spec, pivot, foot, head in (("boom_ram/boom", "C", "D", "E"), ("arm/arm_ram", "H", "F", "G")):
        (measure,) = quantities_of(run.mechanism, f"transmission:{spec}")
        p, f, h = (run.xy(name) for name in (pivot, foot, head))
        x, y, w = np.abs(f - h), np.abs(p - h), np.abs(f - p)
        expected = np.degrees(np.arccos((x**2 + y**2 - w**2) / (2 * x * y)))
        assert values(measure, PathDerivatives(run.motion))[0] == pytest.approx(expected, abs=1e-9)


def test_every_output_dyad_has_a_transmission_angle():
    """Jansen's leg: the three dyads of Assur driven by its crank; the ram of Whitworth."""
    named = {
        "jansen": ["j/bde", "k/c", "f/g"],
        "whitworth": ["rod/ram"],
        "watt_2": ["coupler/bell_crank", "drag_link/output"],
        "scott_russell": ["bar/slide"],
        "stephenson_2": ["ad/left", "be/left"],  # strongly coupled group: its pins
    }
    for model, parts in named.items():
        found = [m.spec for m in quantities_of(load(MODELS / f"{model}.yaml"), "transmission")]
        assert found == [f"transmission:{part}" for part in parts]


# --- mechanical advantage --------------------------------------------------------------------------------


def test_the_advantage_of_a_four_bar():
    """omega2 / omega4 = c sin(theta4 - theta3) / (a sin(theta2 - theta3)). Source: Norton, eq. 6.18b and 6.13."""
    run = run_model("crank_rocker", 90)
    o2, o4, a, b = (run.xy(n) for n in ("O2", "O4", "A", "B"))
    t2, t3, t4 = np.angle(a - o2), np.angle(b - a), np.angle(b - o4)
    got = values_of(PathDerivatives(run.motion), "advantage:motor/rocker")
    assert got["ratio"] == pytest.approx(40 * np.sin(t2 - t3) / (80 * np.sin(t4 - t3)), abs=1e-11)
    assert got[""] == pytest.approx(80 * np.sin(t4 - t3) / (40 * np.sin(t2 - t3)), rel=1e-9)


def test_the_advantage_of_a_slider_crank_has_the_unit_of_its_output():
    """dx/dtheta = -r sin(theta) - (r sin(theta) - e) r cos(theta) / sqrt(l^2 - (r sin(theta) - e)^2)."""
    run = run_model("slider_crank", 36, change=lambda d: d["units"].update(length="mm"))
    theta = np.radians(run.value["motor"])
    rise = np.sin(theta) - 0.5
    slope = -np.sin(theta) - rise * np.cos(theta) / np.sqrt(9.0 - rise**2)
    (measure,) = quantities_of(run.mechanism, "advantage:motor/slide")
    advantage, ratio = values(measure, PathDerivatives(run.motion))
    assert ratio == pytest.approx(slope, abs=1e-12)
    assert advantage == pytest.approx(1.0 / slope, rel=1e-9)
    assert [h.unit for h in measure.heads] == ["1/mm", "mm"]
    (path,) = quantities_of(run.mechanism, "advantage:motor/B")
    assert values(path, PathDerivatives(run.motion))[1] == pytest.approx(np.abs(slope), abs=1e-12)


def test_the_advantage_of_each_of_several_inputs():
    """Five-bar: the point's velocity is the sum over the inputs of rate times partial velocity."""
    run = run_model("five_bar", 20)
    derivatives, point = PathDerivatives(run.motion), run.mechanism.traced[0]
    member = next(m.name for m in run.mechanism.members[3:])
    index = [m.name for m in run.mechanism.members].index(member)
    total = sum(
        a.law(run.motion.time, 1) * values_of(derivatives, f"advantage:{a.name}/{member}")["ratio"]
        for a in run.mechanism.actuators
    )
    assert total == pytest.approx(derivatives.timed.angular(index)[0] * run.mechanism.duration, abs=1e-9)
    assert point


def test_a_linear_inputs_advantage_over_a_rotation_is_a_length():
    run = run_model("excavator", 6)
    ram = run.mechanism.actuators[0]
    member = run.mechanism.members[1]
    (measure,) = quantities_of(run.mechanism, f"advantage:{ram.name}/{member.name}")
    unit = run.mechanism.length_unit if run.mechanism.length_unit != "unit" else ""
    assert [h.unit for h in measure.heads] == [unit, f"1/{unit}" if unit else ""]
    advantage, ratio = values(measure, PathDerivatives(run.motion))
    assert advantage * ratio == pytest.approx(np.ones(7))
    sides = [run.motion.z[n] for n in ram.nodes]
    pivots = [n for n in member.nodes if n in run.mechanism.members[0].nodes]
    if pivots:  # the advantage is the lever arm of the ram's force about the pivot
        pivot = run.motion.z[pivots[0]]
        line = (sides[1] - sides[0]) / np.abs(sides[1] - sides[0])
        arm = np.abs((np.conj(line) * (pivot - sides[0])).imag) * run.mechanism.scale
        assert np.abs(advantage) == pytest.approx(arm, rel=1e-9)


@pytest.mark.parametrize(
    ("model", "pair", "offset"),
    [
        ("crank_shaper", "slot", 0.0),
        ("crank_shaper", "slot", 0.1),
        ("whitworth", "slot", -0.2),
        ("scotch_yoke", "slot", 0),
    ],
)
def test_a_block_slides_on_its_moving_guide(model, pair, offset):
    """The sliding velocity agrees with central differences of the travel."""

    def change(data):
        data["prismatic"][pair]["offset"] = offset
        if model == "crank_shaper":  # the first node of the plate moves, not only normal to the slot
            del data["links"]["arm"]
            data["nodes"]["E"] = [1, -1]
            data["elements"] = {"arm": ["E", "C", "D"]}

    run = run_model(model, 720, change=change)
    mechanism, motion = run.mechanism, run.motion
    slide = next(s for s in mechanism.slides if s.pair == pair)
    carrier = mechanism.members[slide.guide]
    a, b = (motion.z[n] for n in carrier.nodes[:2])
    turn = (b - a) / (carrier.shape[1] - carrier.shape[0])
    foot = a + turn * (slide.point - carrier.shape[0])
    travel = ((motion.z[slide.node] - foot) * np.conj(turn * slide.along)).real * mechanism.scale
    speed = (travel[2:] - travel[:-2]) / (motion.inputs[0, 2:] - motion.inputs[0, :-2])
    got = values_of(PathDerivatives(motion), f"advantage:{mechanism.actuators[0].name}/{pair}")["ratio"][1:-1]
    assert np.max(np.abs(speed)) > 0.1
    assert np.max(np.abs(speed - got)) < 2e-3 * np.max(np.abs(speed))


def test_an_output_at_rest_has_an_infinite_advantage():
    dead = math.degrees(math.acos((100**2 + 160**2 - 80**2) / (2 * 100 * 160)))
    got = values_of(
        derivatives_of("crank_rocker", 1, laws={"motor": {"from": dead, "to": 90}}), "advantage:motor/rocker"
    )
    assert got["ratio"][0] == 0.0
    assert np.isposinf(got[""][0])


# --- swept area ------------------------------------------------------------------------------------------


def test_a_crank_sweeps_a_disk_or_a_half_disk():
    for turn, part in ((360.0, 1.0), (90.0, 0.25), (720.0, 1.0)):
        derivatives = derivatives_of("crank_rocker", 60, laws={"motor": {"from": 0, "to": turn}})
        (measure,) = quantities_of(derivatives.mechanism, "area:crank")
        signed = values(measure, derivatives)[0]
        total, disk = whole(measure, derivatives), math.pi * 1600.0
        assert abs(total["area"] - part * disk) <= max(total["error"], 1e-9)
        assert total["error"] < 3e-5 * disk
        assert signed == pytest.approx(np.linspace(0.0, turn / 360.0, 61) * disk, rel=1e-10)
        assert total["signed"] == pytest.approx(turn / 360.0 * disk, rel=1e-10)


def ring(data):
    """Return a model: a bar from radius 1 to 3, fixed to the crank."""
    data["nodes"] = {"O": [0, 0], "A": [1, 0], "B": [3, 0]}
    data["ground"] = ["O"]
    data["links"] = {"bar": ["A", "B"], "arm": ["O", "A"], "brace": ["O", "B"]}
    data["actuators"] = {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"from": 0, "to": 360}}}
    data["units"] = {"length": "m"}
    for key in ("prismatic", "points", "trace"):
        data.pop(key, None)


def plate(data):
    ring(data)
    del data["links"]
    data["elements"] = {"plate": ["O", "A", "B", "C"]}
    data["nodes"]["C"] = [2, 1]


def test_a_bar_beside_its_centre_of_rotation_sweeps_an_annulus():
    """The bar as a separate member: pi (9 - 1); also for a bar tangent to the inner circle."""
    run = run_model("slider_crank", 90, change=tangent)
    derivatives = PathDerivatives(run.motion)
    area, error = swept_area(derivatives, ["A", "B"])
    scale = run.mechanism.scale**2
    assert abs(area * scale - math.pi * 4.0) <= error * scale
    assert error * scale < 1e-4 * 4.0 * math.pi


def tangent(data):
    """Return a model: an L-shaped crank O-A-B with A-B tangent to A's circle: length 2, radii 1 and sqrt(5)."""
    ring(data)
    del data["links"]
    data["nodes"] = {"O": [0, 0], "A": [1, 0], "B": [1, 2]}
    data["elements"] = {"crank": ["O", "A", "B"]}


def test_a_plate_sweeps_the_disk_of_its_farthest_corner():
    run = run_model("slider_crank", 90, change=plate)
    (measure,) = quantities_of(run.mechanism, "area:plate")
    total = whole(measure, PathDerivatives(run.motion))
    assert abs(total["area"] - 9.0 * math.pi) <= total["error"]
    assert total["unit"] == "m^2"


def test_a_plate_at_rest_covers_its_own_area():
    """Corners O, B and C at 0, 3 and 2 + i, A on the side O-B: 3/2."""
    run = run_model("slider_crank", 1, change=lambda d: (plate(d), d["actuators"]["motor"].update(law={"by": 0})))
    (measure,) = quantities_of(run.mechanism, "area:plate")
    assert whole(measure, PathDerivatives(run.motion))["area"] == pytest.approx(1.5, rel=1e-5)


def test_a_translating_bar_sweeps_a_parallelogram():
    """A coupler that only translates, over a quarter of a turn: |AB| times the rise of its path across it."""
    run = run_model("parallelogram", 40, laws={"motor": {"from": 20, "to": 80}})
    a, b = (run.xy(n) for n in ("A", "B"))
    (measure,) = quantities_of(run.mechanism, f"area:{_named(run.mechanism, 'A', 'B')}")
    total = whole(measure, PathDerivatives(run.motion))
    along = (b - a)[0]
    area = abs((np.conj(along) * (a[-1] - a[0])).imag)
    # the path is an arc: the areas between arc and chord at both ends of the bar cancel
    assert abs(total["area"] - area) <= max(3.0 * total["error"], 1e-6 * area)


def _named(mechanism, *nodes):
    numbers = {mechanism.nodes.index(n) for n in nodes}
    return next(m.name for m in mechanism.members[1:] if numbers <= set(m.nodes))


def test_the_bar_of_a_trammel_sweeps_an_astroid():
    """Ends on two axes: the envelope is an astroid of area 3 pi L^2 / 8 (without the point beyond the bar)."""
    derivatives = derivatives_of("elliptic_trammel", 120)
    area, error = swept_area(derivatives, ["A", "B"])
    scale = derivatives.mechanism.scale**2
    assert abs(area * scale - 3 * math.pi * 2.5**2 / 8) <= error * scale
    assert error * scale < 3e-4


def test_the_signed_area_is_the_difference_of_the_areas_of_two_paths():
    """Over a turn the coupler's is the area inside B's path (an arc: 0) minus that inside A's: -pi 40^2."""
    derivatives = derivatives_of("crank_rocker", 120)
    (measure,) = quantities_of(derivatives.mechanism, "area:coupler")
    signed = values(measure, derivatives)[0]
    assert signed[-1] == pytest.approx(-math.pi * 1600.0, rel=1e-7)
    coarse = values(quantities_of(derivatives.mechanism, "area:coupler")[0], derivatives_of("crank_rocker", 60))[0]
    off = [abs(s[len(s) // 3] - signed_at_third()) for s in (coarse, signed)]
    assert off[1] < 0.1 * off[0], "fourth order"


def signed_at_third():
    derivatives = derivatives_of("crank_rocker", 1200)
    (measure,) = quantities_of(derivatives.mechanism, "area:coupler")
    return values(measure, derivatives)[0][400]


def test_pieces_give_the_same_results_as_the_whole_motion():
    mechanism = load(MODELS / "crank_rocker.yaml")
    specs = ["area:coupler", "centre:frame/coupler", "curvature:P", "transmission"]
    whole, parts = (Record([q for spec in specs for q in quantities_of(mechanism, spec)]) for _ in range(2))
    one = recorded(whole, trace(mechanism, 50))
    pieces = list(stream(mechanism, 50, rows=7))
    several = [recorded(parts, piece) for piece in pieces]
    for k, column in enumerate(one):
        assert np.concatenate([s[k] for s in several]) == pytest.approx(column, rel=1e-12, abs=1e-9)
    results = [r.results(MotionState(Motion.joined(pieces), memory=r.memory)) for r in (whole, parts)]
    assert results[0].keys() == results[1].keys()
    angle = "transmission:coupler/rocker"
    assert [t[angle]["worst"] for t in results] == pytest.approx(
        [math.degrees(math.acos((14400 + 6400 - 3600) / 19200))] * 2
    )
    for spec in results[0]:
        for name, column in results[0][spec]["columns"].items():
            assert results[1][spec]["columns"][name]["least"] == pytest.approx(column["least"])


def test_infinite_values_are_recorded():
    dead = math.degrees(math.acos((100**2 + 160**2 - 80**2) / (2 * 100 * 160)))
    motion = derivatives_of("crank_rocker", 5, laws={"motor": {"from": dead, "to": 90}}).motion
    record = Record(quantities_of(motion.mechanism, "advantage:motor/rocker"))
    for rows in (np.arange(2), np.arange(2, 6)):
        recorded(record, motion.rows(rows))
    assert record.ranges["advantage:motor/rocker"].infinite


def test_the_union_of_triangles():
    """Two that overlap by half, one inside another, two disjoint, and none."""
    square = np.array([[0, 1, 1 + 1j], [0, 1 + 1j, 1j]])
    assert union_area(square, 500) == pytest.approx(1.0, rel=1e-5)
    assert union_area(np.vstack([square, square + 0.5]), 500) == pytest.approx(1.5, rel=1e-5)
    assert union_area(np.vstack([square, 0.2 + 0.2j + 0.3 * square]), 500) == pytest.approx(1.0, rel=1e-5)
    assert union_area(np.vstack([square, square + 3.0]), 500) == pytest.approx(2.0, rel=1e-5)
    assert union_area(np.zeros((0, 3), dtype=complex), 500) == 0.0
    assert union_area(np.vstack([1j * square, 1j * square + 0.5j]), 500) == pytest.approx(1.5, rel=1e-5)


def test_unsolved_rows_add_no_area():
    """Up to a limit of the input: the rows beyond add nothing and stay empty."""
    derivatives = derivatives_of("crank_rocker", 8)
    gap = derivatives.motion
    z, codes = gap.z.copy(), gap.codes.copy()
    z[:, 4:], codes[4:] = np.nan, int(Status.LIMIT)
    cut = PathDerivatives(Motion(gap.mechanism, gap.time, gap.inputs, z, codes, gap.residual, gap.work, gap.start))
    (measure,) = quantities_of(cut.mechanism, "area:crank")
    signed = values(measure, cut)[0]
    assert np.isnan(signed[4:]).all()
    assert whole(measure, cut)["signed"] == pytest.approx(3 / 8 * math.pi * 1600)
    assert whole(measure, cut)["area"] == pytest.approx(3 / 8 * math.pi * 1600, rel=1e-4)
    codes[:] = int(Status.LIMIT)
    nothing = PathDerivatives(replace(cut.motion, z=np.full_like(z, np.nan), codes=codes))
    assert whole(measure, nothing)["area"] == 0.0


# --- names ----------------------------------------------------------------------------------------------


@pytest.mark.few
def test_every_kind_measures_every_model(model, monkeypatch):
    """Every row is finite, empty or infinite; no structure raises an exception."""
    monkeypatch.setattr(sweeping_area, "FINENESS", replace(sweeping_area.FINENESS, poses=90, lines=64))
    mechanism = load(model)
    motion = trace(mechanism, 6)
    specs = [f"centre:frame/{mechanism.members[1].name}", f"curvature:{mechanism.traced[0]}"]
    specs += [f"advantage:{mechanism.actuators[0].name}/{mechanism.members[-1].name}"]
    specs += [f"area:{mechanism.members[-1].name}"]
    if any(True for _ in _joints(mechanism)):
        specs.append("transmission")
    assert {spec.partition(":")[0] for spec in specs} <= set(KINDS)
    record = Record([q for spec in specs for q in quantities_of(mechanism, spec)])
    assert all(len(values) == 7 for values in recorded(record, motion))
    assert record.results(MotionState(motion, memory=record.memory)).keys() >= set(specs[:4])


def _joints(mechanism):
    from gimcli.quantities.transmission import output_joints

    return output_joints(mechanism)


@pytest.mark.parametrize("rows", [8, 36, 100])
def test_an_area_is_accurate_through_a_change_point(tmp_path, rows):
    """Slider-crank with r = l = 1 over half a turn, through 90 degrees, where no rate is known.

    The rod is half a ladder of 2: it sweeps the region between the crank's circle and its astroid, 5 pi / 8.
    """
    model = tmp_path / "ladder.yaml"
    model.write_text("""
nodes: {O: [0, 0], G: [3, 0], A: [1, 0], B: [2, 0]}
ground: [O, G]
links: {crank: {nodes: [O, A], length: 1}, rod: {nodes: [A, B], length: 1}}
prismatic: {slide: {node: B, guide: [O, G]}}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {from: 0, to: 180}}}
""")
    mechanism = load(model)
    (measure,) = quantities_of(mechanism, "area:rod")
    derivatives = PathDerivatives(trace(mechanism, rows))
    values(measure, derivatives)
    total = whole(measure, derivatives)
    assert total["area"] == pytest.approx(5.0 * math.pi / 8.0, rel=2e-5)
    assert total["signed"] == pytest.approx(-0.5 * math.pi, rel=0.5 / rows**3 + 1e-9)
