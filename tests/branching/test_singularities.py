"""Change points with the tangents of all branches, dead points and stationary positions, compared with closed forms."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from bundled import MODELS
from four_bars import four_bar
from typer.testing import CliRunner

import gimcli
from gimcli import load
from gimcli.branching.resampling import circuit_motion
from gimcli.branching.singular_positions import Found, Survey, survey
from gimcli.branching.singularities import (
    DEAD,
    LIMIT,
    STATIONARY,
    _null_left,
    dead_points,
    limits,
    rates,
)
from gimcli.cli import app
from gimcli.continuation.arclength import ArclengthConstants, place, walk
from gimcli.continuation.bifurcation import crossing
from gimcli.continuation.circuit import Circuit
from gimcli.mechanism import FloatArray
from gimcli.model.source import read_source
from gimcli.status import CHANGE, TANGENCY


def of(found: Survey, kind: str) -> list[Found]:
    return [one for one in found.found if one.what.kind == kind]


def degrees(found: Survey, one: Found) -> float:
    return math.degrees(float(one.what.p[-1])) % 360.0


def member_rates(found: Survey, one: Found, name: str) -> list[float]:
    return sorted(rates(found.curve, one.what.p, v).members[name] for v in one.what.branches)


def check_branches(found: Survey) -> None:
    """Assert that every branch is a circuit that fulfils the constraints, and circuits share only intersections."""
    names = []
    for circuit in found.branches.circuits:
        motion = circuit_motion(circuit, 97, 1e-10)
        assert motion.solved == 97
        names.append(motion.z)
    for k, one in enumerate(names):
        for other in names[:k]:
            gaps = np.abs(one[:, :, None] - other[:, None, :]).max(axis=0).min(axis=1)
            assert np.median(gaps) > 1e-3


PARALLELOGRAM = {0.0: [-2.0, 1.0], 180.0: [-0.5, 1.0]}
"""omega of the follower over that of the crank, of 1-3-1-3, on the crossed and on the parallel branch."""


@pytest.mark.parametrize("name", ["parallelogram", "antiparallelogram"])
def test_both_branches_of_a_parallelogram(name: str) -> None:
    found = survey(load(MODELS / f"{name}.yaml"))
    assert [(c.closed, abs(c.turns)) for c in found.branches.circuits] == [(True, 1.0)] * 2
    points = of(found, CHANGE)
    assert len(points) == 2
    for one in points:
        at = degrees(found, one)
        nearest = min(PARALLELOGRAM, key=lambda angle: abs(angle - at))
        assert at == pytest.approx(nearest, abs=1e-11)
        assert sorted(one.circuits) == [0, 1]
        assert member_rates(found, one, "follower") == pytest.approx(PARALLELOGRAM[nearest], abs=1e-12)
        assert set(one.what.about) == {"crank", "coupler", "follower"}
    check_branches(found)


def test_both_branches_of_a_kite() -> None:
    """1-1-3-3: the follower is at twice the angle of A seen from O4, or is at rest with B on O2.

    So its rate is 2 Re(1 / (1 - 3 exp(-i angle))): -1 at 0 and 1/2 at 180 deg; it is at rest where cos(angle) is 1/3.
    """
    found = survey(load(MODELS / "galloway_kite.yaml"))
    for one in of(found, CHANGE):
        at = degrees(found, one)
        own = -1.0 if abs(math.remainder(at, 360.0)) < 90.0 else 0.5
        assert math.remainder(at, 180.0) == pytest.approx(0.0, abs=1e-11)
        assert member_rates(found, one, "follower") == pytest.approx(sorted([own, 0.0]), abs=1e-12)
    rests = [math.cos(math.radians(degrees(found, one))) for one in of(found, STATIONARY) if 0 in one.circuits]
    assert rests == pytest.approx([1.0 / 3.0] * 2, abs=1e-13)
    assert len(of(found, CHANGE)) == 2
    check_branches(found)


def test_the_symmetric_double_butterfly_bifurcates() -> None:
    """PST is at -65.63987904 deg; one tangent keeps the mirror symmetry, on the other the input rate is zero.

    Mirrored are QU and TX, SV and RY, and the bodies WUV and WXY, about a line that turns by half the angle of PST.
    """
    found = survey(load(MODELS / "double_butterfly_symmetric.yaml"))
    drawn = math.degrees(math.atan2(-3.0, 4.0))  # of the arm P-T in PST
    turned = [math.degrees(float(one.what.p[-1])) - drawn for one in of(found, CHANGE)]
    assert min(abs(t + 65.63987904) for t in turned) < 5e-9
    one = of(found, CHANGE)[int(np.argmin([abs(t + 65.63987904) for t in turned]))]
    actual = [rates(found.curve, one.what.p, v) for v in one.what.branches]
    (symmetric,) = [t.members for t in actual if not t.rests]
    (other,) = [t.members for t in actual if t.rests]
    for a, b in (("QU", "TX"), ("SV", "RY"), ("WUV", "WXY")):
        assert symmetric[a] + symmetric[b] == pytest.approx(symmetric["PST"], abs=1e-9)
        assert other[a] == pytest.approx(other[b], abs=1e-9)
    assert found.branches.complete
    assert len(found.branches.circuits) == 3
    check_branches(found)


def test_four_branches_where_two_parallelograms_are_flat_together(tmp_path: Path) -> None:
    """Each of two windows continues as a parallelogram or crossed: the third crank has the product of two rates."""
    (tmp_path / "m.yaml").write_text(
        "units: {length: unit}\nnodes: {O1: [0, 0], O2: [3, 0], O3: [6, 0], A1: [0.6, 0.8], A2: [3.6, 0.8],"
        " A3: [6.6, 0.8]}\nground: [O1, O2, O3]\nlinks: {c1: [O1, A1], c2: [O2, A2], c3: [O3, A3], b1: [A1, A2],"
        " b2: [A2, A3]}\nactuators: {m: {type: rotary, pivot: O1, arm: A1}}\n"
    )
    found = survey(load(tmp_path / "m.yaml"))
    points = of(found, CHANGE)
    assert len(points) == 2
    for one in points:
        own = (1.0, -2.0) if abs(math.remainder(degrees(found, one), 360.0)) < 90.0 else (1.0, -0.5)
        pairs = [(rates(found.curve, one.what.p, v).members) for v in one.what.branches]
        actual = sorted((round(t["c2"], 9), round(t["c3"], 9)) for t in pairs)
        assert actual == sorted((a, a * b) for a in own for b in own)
    assert len(found.branches.circuits) == 4
    check_branches(found)


def test_a_third_crank_leaves_one_branch() -> None:
    """The constraints lose rank, but only the parallel motion satisfies them to second order: a tangency."""
    found = survey(load(MODELS / "parallelogram_third_crank.yaml"))
    assert of(found, CHANGE) == []
    assert sorted(degrees(found, one) % 180.0 for one in of(found, TANGENCY)) == pytest.approx([0.0, 0.0], abs=1e-10)
    for one in of(found, TANGENCY):
        assert member_rates(found, one, "right") == pytest.approx([1.0], abs=1e-9)
    assert len(found.branches.circuits) == 1


def test_a_kite_driven_by_its_follower_has_a_branch_with_zero_input_rate(tmp_path: Path) -> None:
    """Folded, the crank turns freely while the input is constant at 180 deg; its limits are 2 asin(1/3) from there."""
    found = survey(four_bar(tmp_path, 1.0, 1.0, 3.0, 3.0, 1.0, driven="follower"))
    (dead,) = of(found, DEAD)
    assert degrees(found, dead) == pytest.approx(180.0, abs=1e-10)
    free = found.branches.circuits[dead.circuits[0]]
    assert free.closed
    z = free.curve.nodes(free.p)
    a = z[free.mechanism.nodes.index("A")] * free.mechanism.scale
    assert np.ptp(np.unwrap(np.angle(a))) == pytest.approx(2.0 * math.pi, abs=1e-9)
    assert {one.what.end for one in of(found, LIMIT)} == {"upper", "lower"}
    for one in of(found, LIMIT):  # the tangent from O4 to the circle of A, doubled
        assert abs(degrees(found, one) - 180.0) == pytest.approx(2.0 * math.degrees(math.asin(1.0 / 3.0)), abs=1e-10)


def test_a_rocker_is_stationary_in_its_dead_centres() -> None:
    """Crank 40, coupler 120, rocker 80, frame 100: crank and coupler in line, 160 and 80 long (law of cosines)."""
    found = survey(load(MODELS / "crank_rocker.yaml"))
    wanted = [math.acos((100.0**2 + s**2 - 80.0**2) / (200.0 * s)) for s in (160.0, 80.0)]
    actual = sorted(degrees(found, one) for one in of(found, STATIONARY))
    assert actual == pytest.approx(sorted([math.degrees(wanted[0]), math.degrees(wanted[1]) + 180.0]), abs=1e-10)
    assert all(one.what.about == ("rocker",) for one in of(found, STATIONARY))


def test_a_slider_is_stationary_at_the_ends_of_its_stroke() -> None:
    found = survey(load(MODELS / "slider_crank.yaml"))
    actual = of(found, STATIONARY)
    assert [one.what.about for one in actual] == [("slide",)] * 2
    curve = found.curve
    for one in actual:  # crank and rod in line
        z = dict(zip(curve.mechanism.nodes, curve.nodes(one.what.p), strict=True))
        o, a, b = (z[n] for n in ("O2", "A", "B")) if "O2" in z else (z[n] for n in ("O", "A", "B"))
        assert ((b - a) * (a - o).conjugate()).imag == pytest.approx(0.0, abs=1e-13)


class Plane:
    """A plane curve g(x, y) = 0 with its gradient and second derivatives, and z = x."""

    def __init__(
        self, value: Callable[..., float], slope: Callable[..., list[float]], bend: Callable[..., Any]
    ) -> None:
        self.value, self.slope, self.bend = value, slope, bend

    def linearised(self, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.array([self.value(*p[:2]), p[2] - p[0]]), self.jacobian(p)

    def jacobian(self, p: FloatArray) -> FloatArray:
        return np.array([[*self.slope(*p[:2]), 0.0], [-1.0, 0.0, 1.0]])

    def jacobian_along(self, p: FloatArray, v: FloatArray) -> FloatArray:
        return np.array([[*(np.array(self.bend(*p[:2])) @ v[:2]), 0.0], [0.0, 0.0, 0.0]])


def plane(a: float, b: float, c: float, excess: float = 0.0) -> Plane:
    """Return the curve a x^2 + 2 b x y + c y^2 + x^3 = excess."""
    return Plane(
        lambda x, y: a * x * x + 2 * b * x * y + c * y * y + x**3 - excess,
        lambda x, y: [2 * a * x + 2 * b * y + 3 * x * x, 2 * b * x + 2 * c * y],
        lambda x, y: [[2 * a + 6 * x, 2 * b], [2 * b, 2 * c]],
    )


def test_the_directions_at_a_crossing_are_the_roots_of_its_quadratic_form() -> None:
    found = crossing(plane(1.0, 0.5, -2.0), np.array([0.03, -0.02, 0.0]))
    assert found is not None
    assert np.abs(found.p).max() < 1e-14
    slopes = sorted(float(t[1] / t[0]) for t in found.tangents)
    assert slopes == pytest.approx(sorted(np.roots([-2.0, 1.0, 1.0])), abs=1e-13)
    assert found.miss < 1e-16


def test_the_distance_of_a_near_crossing() -> None:
    found = crossing(plane(1.0, 0.0, -1.0, excess=1e-7), np.array([0.01, 0.02, 0.0]))
    assert found is not None
    assert found.miss == pytest.approx(1e-7, rel=1e-9)


def test_an_isolated_point_has_no_branches() -> None:
    found = crossing(plane(1.0, 0.2, 2.0), np.array([0.01, 0.02, 0.0]))
    assert found is not None
    assert found.tangents == ()
    assert not found.touching


def test_a_cusp_has_one_double_tangent() -> None:
    """Semicubical parabola y^2 = -x^3: its singular position is accurate to at least half the digits."""
    found = crossing(plane(0.0, 0.0, 1.0), np.array([-0.02, 0.01, 0.0]))
    assert found is not None
    assert np.abs(found.p).max() < 1e-6
    assert found.touching
    (tangent,) = found.tangents
    assert abs(float(tangent[1] / tangent[0])) < 1e-5


class Dwelling:
    """The input q = x^3 - c x of a made-up motion: its rate is 0 at 0 for c = 0, and it reverses twice for c > 0."""

    system = SimpleNamespace(names=("g",))

    def __init__(self, c: float) -> None:
        self.c = c

    def linearised(self, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.array([p[0] ** 3 - self.c * p[0] - p[1]]), self.jacobian(p)

    def jacobian(self, p: FloatArray) -> FloatArray:
        return np.array([[3.0 * p[0] ** 2 - self.c, -1.0]])

    def jacobian_along(self, p: FloatArray, v: FloatArray) -> FloatArray:
        return np.array([[6.0 * p[0] * v[0], 0.0]])


@pytest.mark.parametrize(("c", "dead", "ends"), [(0.0, 1, 0), (0.03, 0, 2), (-0.03, 0, 0)])
def test_at_a_dead_point_the_input_rate_is_zero_without_reversal(c: float, dead: int, ends: int) -> None:
    curve: Any = Dwelling(c)
    start = place(curve, np.array([-0.8, -0.512 + 0.8 * c]), np.array([1.0, 0.0]))
    places = (start, *walk(curve, start, ArclengthConstants(points=40)))
    circuit = Circuit(curve, places, {}, "end")
    found = dead_points(circuit)
    assert len(found) == dead
    assert len(limits(circuit)) == ends
    for one in found:
        assert np.abs(one.p).max() < 1e-12
    for one in limits(circuit):
        assert abs(one.p[0]) == pytest.approx(math.sqrt(c / 3.0), abs=1e-12)


def run(*arguments: object) -> Any:
    done = CliRunner().invoke(app, [str(a) for a in arguments])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_the_command_reports_in_the_files_units(tmp_path: Path) -> None:
    report = run("singularities", MODELS / "parallelogram.yaml", "--json", "--png", tmp_path / "p.png")
    assert (tmp_path / "p.png").read_bytes()[:4] == b"\x89PNG"
    assert [c["branch"] for c in report["circuits"]] == [1, 2]
    assert all(c["closed"] and c["turns"] == 1 for c in report["circuits"])
    assert [s["at"]["motor"] for s in report["singularities"]] == pytest.approx([180.0, 360.0], abs=1e-10)
    for s in report["singularities"]:
        assert s["kind"] == "change point"
        assert s["branches"] == [1, 2]
        actual = sorted(t["members"]["follower"] for t in s["tangents"])
        assert actual == pytest.approx(PARALLELOGRAM[s["at"]["motor"] % 360.0], abs=1e-12)
        assert abs(complex(*s["nodes"]["A"])) == pytest.approx(1.0, abs=1e-13)


def test_rates_over_a_linear_input_have_the_files_units(tmp_path: Path) -> None:
    """x = 2 r cos(angle), r = 50 mm, moved through 0: the crank turns by 1 / (2 r) rad per mm at x = 0."""
    (tmp_path / "m.yaml").write_text(
        "units: {length: mm, angle: deg}\nnodes: {O: [0, 0], G: [200, 0], A: [30, 40], B: [60, 0]}\n"
        "ground: [O, G]\nlinks: {crank: [O, A], rod: [A, B]}\nprismatic: {s: {node: B, guide: [O, G]}}\n"
        "actuators: {j: {type: linear, node: B, guide: [O, G], law: {from: 60, to: -60}}}\n"
    )
    report = run("singularities", tmp_path / "m.yaml", "--json")
    points = [s for s in report["singularities"] if s["kind"] == "change point"]
    assert [p["at"]["j"] for p in points] == pytest.approx([0.0, 0.0], abs=1e-10)
    for p in points:
        moving = [t["members"]["crank"] for t in p["tangents"] if t["inputs"]["j"]]
        assert [abs(m) for m in moving] == pytest.approx([math.degrees(0.01)], rel=1e-12)
        resting = [t["members"] for t in p["tangents"] if not t["inputs"]["j"]]
        assert [t["crank"] for t in resting] == pytest.approx([t["rod"] for t in resting])


def test_mechanisms_without_motion_are_rejected(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(
        "nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 1]}\nground: [O, G]\n"
        "links: {a: [O, A], b: [A, B], c: [B, G]}\n"
    )
    done = CliRunner().invoke(app, ["singularities", str(tmp_path / "m.yaml")])
    assert done.exit_code != 0
    assert "no actuator" in str(done.exception)


def test_contradictory_constraints_are_rejected(tmp_path: Path) -> None:
    """A third crank that is too long by 1e-6 allows no motion."""
    data = read_source(MODELS / "parallelogram_third_crank.yaml").data
    data["links"]["middle"]["length"] = float(data["links"]["middle"]["length"]) * (1.0 + 1e-6)
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    done = CliRunner().invoke(app, ["singularities", str(tmp_path / "m.yaml")])
    assert "contradicts" in str(done.exception)


def test_a_branch_is_followed_once() -> None:
    """A branch that starts at both flat positions of the parallelogram is followed once."""
    found = survey(load(MODELS / "antiparallelogram.yaml"))
    assert all(isinstance(c, Circuit) for c in found.branches.circuits)
    assert [knot.taken.count(None) for knot in found.branches.knots] == [0, 0]


def test_rows_of_the_table_name_the_members_and_branches():
    """The rods in line: the change point of a parallelogram at 180 deg belongs to both branches."""
    found = gimcli.singularities(gimcli.load(MODELS / "parallelogram.yaml"))
    row = found["motor"].tolist().index(pytest.approx(180.0, abs=1e-9))
    assert set(found["about"][row].split()) == {"crank", "coupler", "follower"}
    assert found["branches"][row] == "1 2"


@pytest.mark.parametrize("lost", [1, 2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_a_limit_names_what_all_self_stresses_involve(lost, seed):
    """The null space of a table is that of its construction, whatever rounding does to single vectors."""
    rng = np.random.default_rng(seed)
    q, p = (np.linalg.qr(rng.normal(size=(6, 6)))[0] for _ in range(2))
    values = np.append(rng.uniform(0.1, 1.0, 6 - lost), 1e-15 * rng.uniform(size=lost))
    left = _null_left(q * values @ p, 6)
    assert left @ left.T == pytest.approx(q[:, 6 - lost :] @ q[:, 6 - lost :].T, abs=1e-12)
