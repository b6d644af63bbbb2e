"""The region that a point reaches, against areas and arcs in closed form and against strewn positions."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from gimcli.analysis.workspace.region import HOLE, INNER, OUTER
from gimcli.analysis.workspace.survey import Workspace, survey
from gimcli.errors import StructureError, UsageError
from gimcli.mechanism import Mechanism
from gimcli.model import load
from gimcli.model.source import read_source

MODELS = Path(__file__).parents[1] / "models"


def made(tmp_path: Path, data: dict[str, Any]) -> Mechanism:
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False))
    return load(path)


def five_bar(base: float, arms: Sequence[tuple[float, float]], laws: Sequence[Any] = (None, None)) -> dict[str, Any]:
    """Two arms (proximal, distal) whose pivots are `base` apart and whose ends meet in P."""
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
    """A serial arm: the second motor turns the second link against the first."""
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
    """Area that two circles of radii r and s, d apart, have in common (Weisstein, Circle-Circle Intersection)."""
    if d >= r + s:
        return 0.0
    if d <= abs(r - s):
        return math.pi * min(r, s) ** 2
    a = math.acos((d * d + r * r - s * s) / (2.0 * d * r))
    b = math.acos((d * d + s * s - r * r) / (2.0 * d * s))
    root = math.sqrt((-d + r + s) * (d + r - s) * (d - r + s) * (d + r + s))
    return r * r * a + s * s * b - 0.5 * root


def two_rings(base: float, arms: Sequence[tuple[float, float]]) -> float:
    """Area that the rings |r - s| .. r + s about two pivots have in common."""
    (out_1, in_1), (out_2, in_2) = ((r + s, abs(r - s)) for r, s in arms)
    return lens(out_1, out_2, base) - lens(in_1, out_2, base) - lens(out_1, in_2, base) + lens(in_1, in_2, base)


def area(found: Workspace) -> float:
    return found.area * found.task.mechanism.scale**2


def holes(found: Workspace) -> int:
    return sum(loop.area < 0.0 for loop in found.loops)


FIVE_BARS: list[tuple[float, list[tuple[float, float]], int, int]] = [
    (4.0, [(5.0, 6.0), (5.0, 6.0)], 1, 2),  # outer loops, holes
    (4.0, [(5.0, 6.0), (3.0, 5.5)], 1, 2),
    (7.0, [(4.0, 6.5), (3.0, 2.0)], 1, 1),  # one hole inside, the other cuts into the edge
    (9.0, [(2.0, 5.0), (5.0, 3.0)], 1, 0),
    (1.0, [(6.0, 2.5), (2.0, 6.5)], 1, 1),  # holes about both pivots overlap
    (2.0, [(6.0, 2.0), (4.0, 3.2)], 1, 1),
]


@pytest.mark.parametrize(("base", "arms", "outer", "hole"), FIVE_BARS)
def test_five_bar_reaches_what_two_rings_have_in_common(
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


def test_two_link_arm_reaches_a_ring(tmp_path: Path) -> None:
    found = survey(made(tmp_path, two_link_arm(3.0, 2.0)), "P")
    assert found.complete
    assert area(found) == pytest.approx(math.pi * (25.0 - 1.0), rel=1e-7)
    assert [loop.area < 0.0 for loop in found.loops] == [False, True]


def test_two_link_arm_with_stops_reaches_a_sector_of_a_ring(tmp_path: Path) -> None:
    """The elbow's angle gives the radius by the law of cosines, the shoulder turns the arc: an area by Pappus."""
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
    """The bundled 3-RPR with other strokes."""
    data: dict[str, Any] = read_source(MODELS / "platform_3rpr.yaml").data
    for k, (low, high) in enumerate(rams, start=1):
        data["actuators"][f"ram_{k}"]["law"] = {"from": low, "to": high}
    return data


def rings_area(centres: Sequence[complex], radii: Sequence[tuple[float, float]]) -> float:
    """Area that rings have in common: the arcs of every circle that the other rings cover, by Green's theorem."""
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


@pytest.mark.parametrize("strokes", STROKES)
@pytest.mark.parametrize("degrees", [0.0, 17.0, -140.0])
def test_platform_at_a_given_orientation_reaches_what_three_rings_have_in_common(
    tmp_path: Path, strokes: list[tuple[float, float]], degrees: float
) -> None:
    """Each ram's ring about its pivot, shifted by the platform's joint."""
    data = platform(strokes)
    mechanism, turn = made(tmp_path, data), cmath.exp(1j * math.radians(degrees))
    joints = [complex(*xy) for xy in data["elements"]["platform"]["shape"].values()]
    centres = [complex(*data["nodes"][f"A{k}"]) + (10.0 + 5.0j - j) * turn for k, j in enumerate(joints, start=1)]
    exact = rings_area(centres, strokes)
    if exact == 0.0:
        with pytest.raises(StructureError, match="no position within the ranges"):
            survey(mechanism, "M", {"platform": math.radians(degrees)})
        return
    found = survey(mechanism, "M", {"platform": math.radians(degrees)})
    assert found.complete
    assert area(found) == pytest.approx(exact, rel=1e-7)
    assert all(edge.arc.held for edge in found.edges), "only rams at their ends bound it"


def test_what_does_not_fit_is_refused() -> None:
    mechanism = load(MODELS / "five_bar.yaml")
    with pytest.raises(UsageError, match="stands still"):
        survey(mechanism, "A1")
    with pytest.raises(UsageError, match="no such moving member"):
        survey(mechanism, "P", {"lever": 0.0})
    with pytest.raises(UsageError, match="runs along curves"):
        survey(load(MODELS / "crank_rocker.yaml"), load(MODELS / "crank_rocker.yaml").traced[0])


KINDS = (OUTER, HOLE, INNER)
Change = Callable[[complex], complex]
