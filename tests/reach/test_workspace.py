"""The region that a point reaches, compared with areas and arcs in closed form and with random positions."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
import yaml
from bundled import MODELS

from gimcli import Mechanism, StructureError, UsageError, load
from gimcli.model.source import read_source
from gimcli.reach.boundary import Workspace, survey
from gimcli.reach.reach import reach


def made(tmp_path: Path, data: dict[str, Any]) -> Mechanism:
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False))
    return load(path)


def five_bar(base: float, arms: Sequence[tuple[float, float]], laws: Sequence[Any] = (None, None)) -> dict[str, Any]:
    """Return a five-bar: two arms (proximal, distal) with pivots at the distance `base` that meet in P."""
    at = complex(0.45 * base, 0.55 * min(sum(a) for a in arms))
    nodes: dict[str, Any] = {"A1": [0.0, 0.0], "A2": [base, 0.0], "P": [at.real, at.imag]}
    links: dict[str, Any] = {}
    for k, (first, second) in enumerate(arms, start=1):
        pivot = complex(0.0 if k == 1 else base, 0.0)
        way = at - pivot
        cosine = (first**2 + abs(way) ** 2 - second**2) / (2.0 * first * abs(way))
        knee = pivot + first * way / abs(way) * cmath.exp(1j * math.acos(max(-1.0, min(1.0, cosine))) * (3 - 2 * k))
        nodes[f"B{k}"] = [knee.real, knee.imag]
        links[f"near_{k}"] = {"nodes": [f"A{k}", f"B{k}"], "length": first}
        links[f"far_{k}"] = {"nodes": [f"B{k}", "P"], "length": second}
    actuators = {
        f"motor_{k}": {"type": "rotary", "pivot": f"A{k}", "arm": f"B{k}"} | ({"law": law} if law else {})
        for k, law in enumerate(laws, start=1)
    }
    return {"units": {"length": "mm"}, "nodes": nodes, "ground": ["A1", "A2"], "links": links, "actuators": actuators}


def two_link_arm(first: float, second: float, laws: Sequence[Any] = (None, None)) -> dict[str, Any]:
    """Return a serial arm; the second motor turns the second link relative to the first."""
    return {
        "nodes": {"O": [0, 0], "A": [first, 0], "P": [first, second]},
        "ground": ["O"],
        "links": {"upper": {"nodes": ["O", "A"], "length": first}, "fore": {"nodes": ["A", "P"], "length": second}},
        "actuators": {
            "shoulder": {"type": "rotary", "pivot": "O", "arm": "A"} | ({"law": laws[0]} if laws[0] else {}),
            "elbow": {"type": "rotary", "pivot": "A", "arm": "P", "reference": "O"}
            | ({"law": laws[1]} if laws[1] else {}),
        },
    }


def lens(r: float, s: float, d: float) -> float:
    """Return the common area of two circles of radii r, s at the distance d (Weisstein, Circle-Circle Intersection)."""
    if d >= r + s:
        return 0.0
    if d <= abs(r - s):
        return math.pi * min(r, s) ** 2
    a = math.acos((d * d + r * r - s * s) / (2.0 * d * r))
    b = math.acos((d * d + s * s - r * r) / (2.0 * d * s))
    root = math.sqrt((-d + r + s) * (d + r - s) * (d - r + s) * (d + r + s))
    return r * r * a + s * s * b - 0.5 * root


def two_rings(base: float, arms: Sequence[tuple[float, float]]) -> float:
    """Return the common area of the rings |r - s| .. r + s about two pivots."""
    (out_1, in_1), (out_2, in_2) = ((r + s, abs(r - s)) for r, s in arms)
    return lens(out_1, out_2, base) - lens(in_1, out_2, base) - lens(out_1, in_2, base) + lens(in_1, in_2, base)


def area(found: Workspace) -> float:
    return found.area * found.task.mechanism.scale**2


def holes(found: Workspace) -> int:
    return sum(loop.area < 0.0 for loop in found.loops)


FIVE_BARS: list[tuple[float, list[tuple[float, float]], int, int]] = [
    (4.0, [(5.0, 6.0), (5.0, 6.0)], 1, 2),  # outer loops, holes
    (4.0, [(5.0, 6.0), (3.0, 5.5)], 1, 2),
    (7.0, [(4.0, 6.5), (3.0, 2.0)], 1, 1),  # one hole is inside, the other crosses the boundary
    (9.0, [(2.0, 5.0), (5.0, 3.0)], 1, 0),
    (1.0, [(6.0, 2.5), (2.0, 6.5)], 1, 1),  # holes about both pivots overlap
    (2.0, [(6.0, 2.0), (4.0, 3.2)], 1, 1),
]


@pytest.mark.few(1)
@pytest.mark.parametrize(("base", "arms", "outer", "hole"), FIVE_BARS)
def test_a_five_bar_reaches_the_intersection_of_two_rings(
    tmp_path: Path, base: float, arms: list[tuple[float, float]], outer: int, hole: int
) -> None:
    found = survey(made(tmp_path, five_bar(base, arms)), "P")
    assert found.complete
    assert area(found) == pytest.approx(two_rings(base, arms), rel=1e-7)
    assert (len(found.loops) - holes(found), holes(found)) == (outer, hole)
    circles = [(k * base, r) for k in (0, 1) for r in (sum(arms[k]), abs(arms[k][0] - arms[k][1]))]
    for edge in found.edges:
        z = found.task.mechanism.to_file(edge.arc.y @ np.array([1.0, 1.0j]))
        assert min(np.abs(np.abs(z - c) - r).max() for c, r in circles) < 1e-10, "knots lie on a circle exactly"


def test_a_two_link_arm_reaches_a_ring(tmp_path: Path) -> None:
    found = survey(made(tmp_path, two_link_arm(3.0, 2.0)), "P")
    assert found.complete
    assert area(found) == pytest.approx(math.pi * (25.0 - 1.0), rel=1e-7)
    assert [loop.area < 0.0 for loop in found.loops] == [False, True]


def test_a_two_link_arm_with_stops_reaches_a_sector_of_a_ring(tmp_path: Path) -> None:
    """The radius follows from the elbow's angle (law of cosines), the area from Pappus' theorem."""
    first, second, turn = 3.0, 2.0, (20.0, 110.0)
    found = survey(
        made(tmp_path, two_link_arm(first, second, ({"from": -40, "to": 60}, {"from": turn[0], "to": turn[1]}))), "P"
    )
    near, far = (first**2 + second**2 - 2.0 * first * second * math.cos(math.radians(a)) for a in turn)
    assert found.complete
    assert area(found) == pytest.approx(0.5 * math.radians(100.0) * (far - near), rel=1e-7)
    assert len(found.loops) == 1
    assert sorted(edge.arc.held[0][0] for edge in found.loops[0].edges) == [0, 0, 1, 1]
    assert not found.inner


def platform(rams: Sequence[tuple[float, float]]) -> dict[str, Any]:
    """Return the bundled 3-RPR with other strokes."""
    data: dict[str, Any] = read_source(MODELS / "platform_3rpr.yaml").data
    for k, (low, high) in enumerate(rams, start=1):
        data["actuators"][f"ram_{k}"]["law"] = {"from": low, "to": high}
    return data


def rings_area(centres: Sequence[complex], radii: Sequence[tuple[float, float]]) -> float:
    """Return the common area of rings, from the arcs of each circle inside the other rings, by Green's theorem."""
    circles = [
        (c, r, sign) for c, pair in zip(centres, radii, strict=True) for r, sign in zip(pair, (-1, 1), strict=True)
    ]
    total = 0.0
    for c, r, sign in circles:
        cuts = []
        for other, s, _ in circles:
            d = abs(other - c)
            if d > 0.0 and abs(r - s) < d < r + s:
                half = math.acos((r * r + d * d - s * s) / (2.0 * r * d))
                cuts += [(cmath.phase(other - c) + turn) % (2.0 * math.pi) for turn in (half, -half)]
        cuts = sorted(cuts) or [0.0]
        for a, b in zip(cuts, [*cuts[1:], cuts[0] + 2.0 * math.pi], strict=True):
            z = c + r * cmath.exp(0.5j * (a + b))
            if all(low <= abs(z - m) <= high for m, (low, high) in zip(centres, radii, strict=True) if m != c):
                moment = r * (c.real * (math.sin(b) - math.sin(a)) - c.imag * (math.cos(b) - math.cos(a)))
                total += 0.5 * sign * (r * r * (b - a) + moment)
    return total


STROKES = [
    [(14.98, 16.0), (13.0, 15.38), (12.0, 20.0)],
    [(8.0, 20.0), (9.0, 19.0), (7.0, 21.0)],
    [(2.0, 15.0), (6.0, 30.0), (3.0, 17.0)],
    [(0.5, 25.0), (1.0, 26.0), (0.7, 24.0)],
]


@pytest.mark.few(2)
@pytest.mark.parametrize("strokes", STROKES)
@pytest.mark.parametrize("degrees", [0.0, 17.0, -140.0])
def test_a_platform_of_given_orientation_reaches_the_intersection_of_three_rings(
    tmp_path: Path, strokes: list[tuple[float, float]], degrees: float
) -> None:
    """Each ram's ring about its pivot, shifted by the platform's joint."""
    data = platform(strokes)
    mechanism, turn = made(tmp_path, data), cmath.exp(1j * math.radians(degrees))
    joints = [complex(*xy) for xy in data["elements"]["platform"]["shape"].values()]
    centres = [complex(*data["nodes"][f"A{k}"]) + (10.0 + 5.0j - j) * turn for k, j in enumerate(joints, start=1)]
    exact = rings_area(centres, strokes)
    if exact == 0.0:
        with pytest.raises(StructureError):
            survey(mechanism, "M", {"platform": math.radians(degrees)})
        return
    found = survey(mechanism, "M", {"platform": math.radians(degrees)})
    assert found.complete
    assert area(found) == pytest.approx(exact, rel=1e-7)
    assert all(edge.arc.held for edge in found.edges), "only rams at their ends bound it"


def test_a_point_that_moves_along_curves_has_no_workspace() -> None:
    mechanism = load(MODELS / "crank_rocker.yaml")
    with pytest.raises(UsageError):
        survey(mechanism, mechanism.traced[0])


def enclosed(found: Workspace, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return for points (file units) whether the loops enclose them, and their distances from the loops."""
    winding, gap = np.zeros(len(z)), np.full(len(z), np.inf)
    for loop in found.loops:
        outline = found.task.mechanism.to_file(loop.points(8) @ np.array([1.0, 1.0j]))
        apart = np.append(outline, outline[0]) - z[:, None]
        gap = np.minimum(gap, np.abs(apart).min(axis=1))
        winding += np.angle(apart[:, 1:] / apart[:, :-1]).sum(axis=1) / (2.0 * np.pi)
    return np.round(winding) > 0.5, gap


def arm_reaches(z: np.ndarray, pivot: float, arm: tuple[float, float], law: dict[str, float] | None) -> np.ndarray:
    """Return whether a two-link arm with a stop at its pivot reaches points: its triangle for both elbows."""
    way, fits = z - pivot, np.zeros(len(z), dtype=bool)
    cosine = (arm[0] ** 2 + np.abs(way) ** 2 - arm[1] ** 2) / (2.0 * arm[0] * np.abs(way))
    for elbow in (1.0, -1.0):
        angle = np.degrees(np.angle(way) + elbow * np.arccos(np.clip(cosine, -1.0, 1.0)))
        stops = True if law is None else (angle - law["from"]) % 360.0 <= law["to"] - law["from"]
        fits |= (np.abs(cosine) <= 1.0) & stops
    return fits


STOPS = [
    (4.0, [(5.0, 6.0), (5.0, 6.0)], [{"from": 60, "to": 200}, None]),
    (3.0, [(5.0, 3.5), (4.0, 6.0)], [{"from": -20, "to": 170}, {"from": 10, "to": 250}]),
    (6.0, [(3.0, 5.0), (3.0, 5.0)], [{"from": 45, "to": 135}, {"from": 45, "to": 135}]),
]


@cache
def stopped(k: int) -> Workspace:
    """Return the workspace of the five-bar of `STOPS[k]`."""
    with TemporaryDirectory() as folder:
        return survey(made(Path(folder), five_bar(*STOPS[k])), "P")


@pytest.mark.few(1)
@pytest.mark.parametrize("number", range(len(STOPS)))
def test_a_five_bar_with_stops_reaches_the_points_that_both_arms_reach(number: int) -> None:
    """Random points: inside the loops if and only if the triangles of both arms close."""
    found, (base, arms, laws) = stopped(number), STOPS[number]
    size = sum(arms[0])
    parts = np.random.default_rng(3).uniform(-size, size, (2, 5000))
    z = parts[0] + 1j * parts[1]
    reached = np.logical_and(*(arm_reaches(z, k * base, arms[k], laws[k]) for k in (0, 1)))
    inside, gap = enclosed(found, z)
    assert found.complete
    assert 200 < reached.sum() < 4800
    assert np.array_equal(inside[gap > 2e-3 * size], reached[gap > 2e-3 * size])
    stops = {
        (k, law[end]): k * base + arms[k][0] * cmath.exp(1j * math.radians(law[end]))
        for k, law in enumerate(laws) if law for end in ("from", "to")
    }  # fmt: skip
    for edge in found.edges:  # a motor at its stop: P on the circle of its distal link about the proximal link's end
        points = found.task.mechanism.to_file(edge.arc.y @ np.array([1.0, 1.0j]))
        for k, inward in edge.arc.held:
            knee = stops[k, laws[k]["from" if inward > 0.0 else "to"]]
            assert np.abs(np.abs(points - knee) - arms[k][1]).max() < 1e-10


SHAPE = np.array([0.0, 17.04, 13.236373239436618 + 16.096708466836507j])
PIVOTS = np.array([0.0, 15.91, 10.0j])
RAMS = ((14.98, 16.0), (13.0, 15.38), (12.0, 20.0))
"""Corners of the platform, pivots of its rams and their laws in models/platform_3rpr.yaml."""


def room(k: int, place: np.ndarray) -> np.ndarray:
    """Return the greatest margin of the other rams within their ranges with corner k at points (rows,)."""
    others = [j for j in range(3) if j != k]
    angle, step = np.zeros((len(place), 1)), 2.0 * math.pi / 4000
    look = step * np.arange(4000)
    for _ in range(9):  # refinement about the best angle
        way = np.exp(1j * (angle + look))
        lengths = [(np.abs(place[:, None] + (SHAPE[j] - SHAPE[k]) * way - PIVOTS[j]), *RAMS[j]) for j in others]
        least = np.min([np.minimum(length - low, high - length) for length, low, high in lengths], axis=0)
        best = np.argmax(least, axis=1)
        angle, step = angle + look[best, None], step / 8.0
        look = step * np.linspace(-10.0, 10.0, 21)
    return np.asarray(least.max(axis=1))


def reached_angles(k: int, radius: float) -> list[float]:
    """Return the ends of the reached arcs of a circle about the pivot of corner k, by bisection."""

    def inside(angle: np.ndarray) -> np.ndarray:
        return np.asarray(room(k, PIVOTS[k] + radius * np.exp(1j * angle)) >= 0.0)

    grid = np.linspace(0.0, 2.0 * math.pi, 721)
    (at,) = np.nonzero(np.diff(inside(grid)))
    low, high, first = grid[at], grid[at + 1], inside(grid[at])
    for _ in range(36):
        middle = 0.5 * (low + high)
        same = inside(middle) == first
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return sorted(low.tolist())


@pytest.mark.soak
@pytest.mark.parametrize("k", range(3))
def test_a_corner_on_a_ram_is_bounded_by_arcs_within_the_ranges_of_the_other_rams(k: int) -> None:
    """With its ram at an end the corner is on a circle, with two degrees of freedom: all positions are critical."""
    mechanism = load(MODELS / "platform_3rpr.yaml")
    found = survey(mechanism, f"B{k + 1}")
    assert found.complete
    assert all(loop.area**2 > 1e-12 for loop in found.loops)
    pivot = mechanism.drawn[mechanism.nodes.index(f"A{k + 1}")]
    for inward, radius in zip((1.0, -1.0), RAMS[k], strict=True):
        arcs = [e.arc.y - [pivot.real, pivot.imag] for e in found.edges if (k, inward) in e.arc.held]
        ends = np.array([np.unwrap(np.arctan2(y[:, 1], y[:, 0]))[[0, -1]] for y in arcs])
        turns = ends[:, None, :] + 2.0 * math.pi * np.arange(-1, 2)[:, None]
        expected = reached_angles(k, radius)
        assert expected
        for angle in expected:  # corners closer than 1e-5 are joined
            assert np.min(np.abs(turns - angle)) < 3e-5
        for middle in 0.5 * np.array([*pairwise([*expected, expected[0] + 2.0 * math.pi])]).sum(axis=1):
            along = np.any((turns.min(axis=2) <= middle) & (middle <= turns.max(axis=2)))
            assert along == (room(k, PIVOTS[k] + radius * np.exp(1j * np.array([middle])))[0] >= 0.0)


@pytest.mark.soak
def test_stops_with_the_same_circle_bound_a_region_and_isolated_curves(tmp_path: Path) -> None:
    """All lengths 4: at 60 and 120 degrees the proximal links end at the same point, about which P turns freely.

    The expected boundary: circles of 4 about the knees at the stops and of 8 about the pivots, by Green's theorem.
    """
    laws = [{"from": 60, "to": 200}, {"from": -20, "to": 120}]
    found = survey(made(tmp_path, five_bar(4.0, [(4.0, 4.0), (4.0, 4.0)], laws)), "P")
    knee, top = complex(2.0, 2.0 * math.sqrt(3.0)), math.degrees(math.acos(0.25))
    arcs = [
        (knee, 4.0, -120.0, -60.0), (4.0 + 4.0 * cmath.exp(-1j * math.pi / 9.0), 4.0, 160.0, 120.0),
        (knee, 4.0, -20.0, 60.0), (0j, 8.0, 60.0, top), (4.0 + 0j, 8.0, 180.0 - top, 120.0),
        (knee, 4.0, 120.0, 200.0), (4.0 * cmath.exp(1j * math.pi / 0.9), 4.0, 60.0, 20.0),
    ]  # fmt: skip
    assert found.complete
    assert (len(found.loops), holes(found)) == (1, 0)
    assert area(found) == pytest.approx(sum(under_arc(*arc) for arc in arcs), rel=1e-7)
    assert {edge.kind for edge in found.open} == {"alone"}
    for edge in found.open:
        points = found.task.mechanism.to_file(edge.arc.y @ np.array([1.0, 1.0j]))
        assert np.allclose(np.abs(points - knee), 4.0, atol=1e-9)


def under_arc(centre: complex, r: float, start: float, end: float) -> float:
    """Return the contribution of an arc between two angles [deg] to an area, by Green's theorem."""
    a, b = math.radians(start), math.radians(end)
    turn = centre.real * (math.sin(b) - math.sin(a)) - centre.imag * (math.cos(b) - math.cos(a))
    return 0.5 * r * (r * (b - a) + turn)


def test_inner_curves_have_reached_points_on_both_sides() -> None:
    """Where a stop limits one configuration of the elbow, the other configuration passes."""
    found, (base, arms, laws) = stopped(0), STOPS[0]
    assert len(found.inner) >= 2
    for edge in found.inner:
        cut = edge.arc.halfway()
        z, way = (v @ np.array([1.0, 1.0j]) for v in (edge.arc.at(*cut), edge.arc.slope(*cut)))
        beside = found.task.mechanism.to_file(z + np.array([1e-4j, -1e-4j]) * way / abs(way))
        assert all(np.all(arm_reaches(beside, k * base, arms[k], laws[k])) for k in (0, 1))


def test_two_sliders_reach_the_region_of_their_strokes(tmp_path: Path) -> None:
    """2-PRR: at height y each slider is sqrt(L^2 - y^2) beside P."""
    from scipy.integrate import quad

    data = {
        "nodes": {"G1": [0, 0], "G2": [10, 0], "S1": [2, 0], "S2": [7, 0], "P": [4.5, 3.1]},
        "ground": ["G1", "G2"],
        "links": {"l1": {"nodes": ["S1", "P"], "length": 4}, "l2": {"nodes": ["S2", "P"], "length": 4}},
        "prismatic": {k: {"node": k.upper(), "guide": ["G1", "G2"]} for k in ("s1", "s2")},
        "actuators": {
            "a1": {"type": "linear", "node": "S1", "guide": ["G1", "G2"], "law": {"from": 0, "to": 4}},
            "a2": {"type": "linear", "node": "S2", "guide": ["G1", "G2"], "law": {"from": 5, "to": 9}},
        },
    }

    def width(y: float) -> float:
        """Return the length of the x at a height that both strokes allow: an intersection of unions of intervals."""
        h = math.sqrt(max(16.0 - y * y, 0.0))
        marks = sorted({e + s * h for e in (0.0, 4.0, 5.0, 9.0) for s in (1.0, -1.0)})
        middles = [(0.5 * (a + b), b - a) for a, b in pairwise(marks)]
        return sum(
            length for x, length in middles
            if any(0.0 <= x + s * h <= 4.0 for s in (1.0, -1.0)) and any(5.0 <= x + s * h <= 9.0 for s in (1.0, -1.0))
        )  # fmt: skip

    found = survey(made(tmp_path, data), "P")
    kinks = [math.sqrt(16.0 - h * h) for h in (0.5, 2.0, 2.5, 4.0 - 1e-12)]
    exact = 2.0 * sum(
        quad(width, a, b, epsabs=1e-12)[0] for a, b in zip([0.0, *sorted(kinks)], [*sorted(kinks), 4.0], strict=True)
    )
    assert found.complete
    assert area(found) == pytest.approx(exact, rel=1e-7)


@pytest.mark.soak
def test_a_redundant_platform_reaches_the_points_of_all_its_orientations() -> None:
    """3-RRR with a free angle: random points compared with a scan of the angle with all legs' triangles."""
    mechanism = load(MODELS / "platform_3rrr.yaml")
    data = read_source(MODELS / "platform_3rrr.yaml").data
    found = survey(mechanism, "M")
    low, high = (mechanism.to_file(c @ np.array([1.0, 1.0j])) for c in found.bounds)
    rng = np.random.default_rng(8)
    z = rng.uniform(low.real, high.real, 400) + 1j * rng.uniform(low.imag, high.imag, 400)
    reached = np.zeros(len(z), dtype=bool)
    for angle in np.radians(np.arange(0.0, 360.0, 0.05)):
        reached |= legs_reach(data, mechanism, z, angle)
    inside, gap = enclosed(found, z)
    clear = gap > 0.02
    assert found.complete
    assert 50 < reached.sum() < 390
    assert np.array_equal(inside[clear], reached[clear])
    assert all(len(edge.arc.held) in (0, 1, 2) for edge in found.edges)


@pytest.mark.soak
def test_the_regions_of_both_configurations_of_the_boom_have_the_same_size() -> None:
    """The boom of the excavator turns by the same angle in both configurations of its ram."""
    found = survey(load(MODELS / "excavator.yaml"), "tip")
    assert found.complete
    assert [loop.area > 0.0 for loop in found.loops] == [True, True]
    assert found.loops[0].area == pytest.approx(found.loops[1].area, rel=1e-9)


def legs_reach(data: dict[str, Any], mechanism: Mechanism, z: np.ndarray, angle: float) -> np.ndarray:
    """Return whether every leg of the 3-RRR reaches its joint of the platform within the law of its motor."""
    member = next(m for m in mechanism.members if m.name in data["elements"])
    point = next(p for p in mechanism.points if p.name == "M")
    fits = np.ones(len(z), dtype=bool)
    for motor in data["actuators"].values():
        pivot, knee = mechanism.nodes.index(motor["pivot"]), mechanism.nodes.index(motor["arm"])
        near = next(m for m in mechanism.members[1:] if set(m.nodes) == {pivot, knee})
        far = next(m for m in mechanism.members[1:] if knee in m.nodes and pivot not in m.nodes)
        joint = next(n for n in far.nodes if n != knee)
        place = z + (member.local(joint) - point.local) * mechanism.scale * cmath.exp(1j * angle)
        lengths = tuple(abs(m.shape[1] - m.shape[0]) * mechanism.scale for m in (near, far))
        law = motor["law"]
        law = {"from": min(law.values()), "to": max(law.values())}
        base = complex(mechanism.to_file(mechanism.drawn[[pivot]])[0])
        fits &= arm_reaches(place - base, 0.0, lengths, law)
    return fits


@pytest.mark.soak
@pytest.mark.parametrize(
    ("scale", "turn", "shift"),
    [(2.5e5, 73.0, 3e6 - 1e6j), (1e-6, 0.0, 0.0j), (2.5e5, 0.0, 3e6 - 1e6j), (1.0, 73.0, 12.0 + 5.0j)],
)
def test_scale_position_and_direction_change_only_the_coordinates(
    tmp_path: Path, scale: float, turn: float, shift: complex
) -> None:
    first, (base, arms, laws) = stopped(1), STOPS[1]
    moved = [(law | {k: v + turn for k, v in law.items()}) for law in laws]
    data = five_bar(base, arms, moved)
    for name, xy in data["nodes"].items():
        z = (complex(*xy) * cmath.exp(1j * math.radians(turn))) * scale + shift
        data["nodes"][name] = [z.real, z.imag]
    for link in data["links"].values():
        link["length"] *= scale
    second = survey(made(tmp_path, data), "P")
    assert second.complete
    assert area(second) == pytest.approx(area(first) * scale**2, rel=1e-8)
    assert len(second.loops) == len(first.loops)


def test_an_input_with_a_stop_limits_the_path_of_a_four_bar() -> None:
    """The trammel's ellipse, semi-axes 3.5 and 1: its extent, its perimeter by the elliptic integral."""
    from scipy.special import ellipe

    found = reach(load(MODELS / "elliptic_trammel.yaml"), "P")
    (run,) = found.runs
    scale = found.task.mechanism.scale
    low, high = (
        corner * scale + [found.task.mechanism.origin.real, found.task.mechanism.origin.imag] for corner in run.bounds
    )
    assert np.allclose(high, [3.5, 1.0], rtol=1e-9)
    assert np.allclose(low, [-3.5, -1.0], rtol=1e-9)
    assert run.length * scale == pytest.approx(4.0 * 3.5 * ellipe(1.0 - (1.0 / 3.5) ** 2), rel=1e-8)
    assert run.closed
    assert run.drawn
    assert run.intervals[0].full


def rocker(tmp_path: Path, ground: float, crank: float, coupler: float, follower: float) -> Mechanism:
    """Return a four-bar driven at its first link, with an initial angle of 30 degrees to the ground."""
    a = crank * cmath.exp(1j * math.pi / 6.0)
    way = ground - a
    cosine = (coupler**2 + abs(way) ** 2 - follower**2) / (2.0 * coupler * abs(way))
    b = a + coupler * way / abs(way) * cmath.exp(1j * math.acos(cosine))
    return made(
        tmp_path,
        {
            "nodes": {"O": [0, 0], "G": [ground, 0], "A": [a.real, a.imag], "B": [b.real, b.imag]},
            "ground": ["O", "G"],
            "links": {
                "crank": {"nodes": ["O", "A"], "length": crank},
                "coupler": {"nodes": ["A", "B"], "length": coupler},
                "follower": {"nodes": ["G", "B"], "length": follower},
            },
            "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
            "trace": ["B"],
        },
    )


def test_the_input_of_a_non_grashof_four_bar_reverses_where_coupler_and_follower_are_in_line(tmp_path: Path) -> None:
    """Law of cosines with coupler + follower against crank and ground (Norton, Design of Machinery, 4.10)."""
    ground, crank, coupler, follower = 7.0, 5.0, 4.0, 3.5  # 7 + 3.5 > 5 + 4: a triple rocker
    mechanism = rocker(tmp_path, ground, crank, coupler, follower)
    found = reach(mechanism, "B")
    limit = math.acos((ground**2 + crank**2 - (coupler + follower) ** 2) / (2.0 * ground * crank))
    (run,) = found.runs  # both configurations belong to one circuit
    assert run.closed
    (interval,) = run.intervals
    assert not interval.full
    assert (interval.low, interval.high) == pytest.approx((-limit, limit), abs=1e-9)
    assert interval.folds == pytest.approx((-limit, limit), abs=1e-9)
    angle = math.acos((ground**2 + follower**2 - (crank + coupler) ** 2) / (2.0 * ground * follower))
    low, high = run.bounds  # B is farthest right with crank and coupler in line; it also passes its leftmost position
    assert high[0] * mechanism.scale == pytest.approx(ground - follower * math.cos(angle), rel=1e-9)
    assert low[0] * mechanism.scale == pytest.approx(ground - follower, rel=1e-9)


def test_reach_of_a_limited_input_ends_at_its_law(tmp_path: Path) -> None:
    data = two_link_arm(3.0, 2.0, ({"from": 10, "to": 70}, None))
    data["actuators"]["elbow"] = {"type": "rotary", "pivot": "A", "arm": "P", "reference": "O",
                                  "law": {"from": 90, "to": 90}}  # fmt: skip
    found = reach(made(tmp_path, data), "P")
    run = found.runs[0]
    assert not run.closed
    assert run.length * found.task.mechanism.scale == pytest.approx(math.radians(60.0) * math.hypot(3.0, 2.0), rel=1e-9)
    assert np.degrees([run.intervals[0].low, run.intervals[0].high]) == pytest.approx([10.0, 70.0], abs=1e-9)
