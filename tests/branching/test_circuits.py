"""Circuits: they close in the initial configuration and stay on their branch; limits agree with the law of cosines."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from bundled import FEWEST, MODELS
from four_bars import cosines, four_bar, four_bar_text

from gimcli import load
from gimcli.branching.resampling import along, circuit_motion
from gimcli.branching.singular_positions import drawn_circuit, survey
from gimcli.branching.singularities import LIMIT, singularities
from gimcli.comparison.true_error import Constraints
from gimcli.continuation.circuit import Circuit, Ended
from gimcli.motion.motion import trace
from gimcli.status import CHANGE
from gimcli.structure.residual import residual


def limits(circuit: Circuit) -> dict[str, list[float]]:
    found = [s for s in singularities(circuit) if s.kind == LIMIT]
    return {end: [float(s.p[-1]) for s in found if s.end == end] for end in ("lower", "upper")}


def check_against_cosines(lengths: tuple[float, ...], circuit: Circuit) -> None:
    """Compare the limits and full turns of a circuit with the law of cosines."""
    stretched, folded_ = cosines(*lengths)
    found = limits(circuit)
    assert circuit.closed
    free_above, free_below = not abs(stretched) < 1.0, not abs(folded_) < 1.0
    if free_above and free_below:
        assert found == {"lower": [], "upper": []}
        assert abs(circuit.turns) == 1.0
        return
    assert circuit.turns == 0.0
    assert len(found["lower"]) == len(found["upper"]) == 1
    least, most = found["lower"][0], found["upper"][0]
    ends = [math.cos(least), math.cos(most)]
    if free_below:  # swings about the frame's line, from stretched to stretched
        assert ends == pytest.approx([stretched, stretched], abs=1e-12)
        assert round((least + most) / 2.0 / math.pi, 9) % 2 == 0.0
    elif free_above:  # swings about its back, from folded to folded
        assert ends == pytest.approx([folded_, folded_], abs=1e-12)
        assert round((least + most) / 2.0 / math.pi, 9) % 2 == 1.0
    else:
        assert sorted(ends) == pytest.approx(sorted([stretched, folded_]), abs=1e-12)


def random_four_bar(rng: np.random.Generator) -> tuple[tuple[float, ...], float]:
    """Return lengths and a crank angle at which they can be assembled."""
    while True:
        lengths = tuple(float(v) for v in rng.uniform(0.3, 3.0, 4))
        angle = float(rng.uniform(-math.pi, math.pi))
        crank, coupler, follower, ground = lengths
        reach = abs(ground - crank * complex(math.cos(angle), math.sin(angle)))
        if 1.01 * abs(coupler - follower) < reach < 0.99 * (coupler + follower):
            return lengths, angle


def run_random(tmp_path: Path, seed: int, count: int, least: int) -> None:
    rng, kinds = np.random.default_rng(seed), set()
    for _ in range(count):
        lengths, angle = random_four_bar(rng)
        circuit = drawn_circuit(four_bar(tmp_path, *lengths, angle, side=float(rng.choice([-1.0, 1.0]))), 1e-10)
        check_against_cosines(lengths, circuit)
        short, *middle, long = sorted(lengths)
        kinds.add((short + long < sum(middle), lengths.index(short)))
    assert len(kinds) >= least  # Grashof and not, each link the shortest


def test_limits_of_random_four_bars_agree_with_the_law_of_cosines(tmp_path: Path) -> None:
    run_random(tmp_path, 1, 14, 4)


@pytest.mark.soak
def test_limits_of_a_thousand_four_bars_agree_with_the_law_of_cosines(tmp_path: Path) -> None:
    run_random(tmp_path, 2, 1000, 6)


def run_whole_lengths(tmp_path: Path, count: int) -> None:
    """Compare four-bars with lengths 1 to 4, most of them change-point linkages, with the law of cosines.

    Where a cosine is 1 or -1 exactly, coupler and follower are in line with the frame: a change point, no limit.
    """
    rng, edges = np.random.default_rng(3), 0
    for lengths in rng.permutation(list(product((1.0, 2.0, 3.0, 4.0), repeat=4)))[:count].tolist():
        crank, coupler, follower, ground = lengths
        angles = rng.uniform(-math.pi, math.pi, 50)
        reach = np.abs(ground - crank * np.exp(1j * angles))
        fits = angles[(reach > 1.02 * abs(coupler - follower) + 0.02) & (reach < 0.98 * (coupler + follower))]
        if not len(fits):
            continue
        found = survey(four_bar(tmp_path, *lengths, float(fits[0])))
        both = cosines(*lengths)
        of_kind = {k: {math.cos(f.what.p[-1]) for f in found.found if f.what.kind == k} for k in (CHANGE, LIMIT)}
        assert {round(c, 12) for c in of_kind[CHANGE]} == {c for c in both if abs(c) == 1.0}
        assert all(min(abs(c - own) for own in both if abs(own) < 1.0) < 1e-13 for c in of_kind[LIMIT])
        assert bool(of_kind[LIMIT]) == any(abs(c) < 1.0 for c in both)
        assert found.branches.complete
        assert all(c.closed for c in found.branches.circuits)
        edges += bool(of_kind[CHANGE])
    assert edges > count // 4


def test_grashof_change_point_linkages_have_change_points(tmp_path: Path) -> None:
    run_whole_lengths(tmp_path, 10)


@pytest.mark.soak
def test_all_grashof_change_point_linkages_have_change_points(tmp_path: Path) -> None:
    run_whole_lengths(tmp_path, 256)


@pytest.mark.few(2)
@pytest.mark.parametrize("excess", [1e-3, 1e-6, 1e-9, 1e-11, 1e-12, 3e-13])
def test_the_branch_is_kept_near_a_change_point(tmp_path: Path, excess: float) -> None:
    """1-3-2-(4 - e): stretched coupler and follower are e longer than needed, so B always stays on one side.

    Its least distance from the line A-O4 is sqrt(2 b c e / (b + c)) to leading order: 1e-6 for the least of them.
    """
    circuit = drawn_circuit(four_bar(tmp_path, 1.0, 3.0, 2.0, 4.0 - excess, 1.0), 1e-10)
    assert circuit.closed
    assert circuit.turns == 1.0
    assert circuit.crossings == {}
    z = circuit.curve.nodes(circuit.p)
    o4, a, b = (z[circuit.mechanism.nodes.index(n)] for n in ("O4", "A", "B"))
    side = ((b - a) * (o4 - a).conjugate()).imag
    assert np.all(side > 0.0) or np.all(side < 0.0)
    short = drawn_circuit(four_bar(tmp_path, 1.0, 3.0, 2.0, 4.0 + excess, 1.0), 1e-10)
    assert short.closed
    assert short.turns == 0.0  # stretched, they are too short: the crank reverses on either side of 180 deg
    assert len(limits(short)["upper"]) == len(limits(short)["lower"]) == 1


@pytest.mark.few(3)
@pytest.mark.parametrize("excess", [1e-3, 1e-6, 1e-9, 1e-12, 0.0])
def test_the_branch_is_kept_near_two_change_points_together(tmp_path: Path, excess: float) -> None:
    """Two equal dyads on one crank: if both change, no determinant shows it. At e = 0 there are four branches."""
    text = four_bar_text(1.0, 3.0, 2.0, 4.0 - excess, 1.0)
    place = text.split("B: [")[1].split("]")[0]
    text = text.replace(f"B: [{place}]", f"B: [{place}], C: [{place}]")
    text = text.replace(
        "actuators", "  more: {nodes: [A, C], length: 3}\n  last: {nodes: [O4, C], length: 2}\nactuators"
    )
    (tmp_path / "m.yaml").write_text(text)
    circuit = drawn_circuit(load(tmp_path / "m.yaml"), 1e-10)
    assert circuit.closed
    assert circuit.turns == (1.0 if excess else 2.0)
    assert [len(crossing.tangents) for crossing in circuit.crossings.values()] == ([] if excess else [4, 4])
    z = circuit.curve.nodes(circuit.p)
    o4, a, b, c = (z[circuit.mechanism.nodes.index(n)] for n in ("O4", "A", "B", "C"))
    assert np.abs(b - c).max() < 1e-8  # they are never on different sides
    sides = ((b - a) * (o4 - a).conjugate()).imag
    assert (sides > 0.0).all() or (sides < 0.0).all() or not excess


@pytest.mark.few(2)
@pytest.mark.parametrize("excess", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_near_parallelogram_stays_on_its_circuit(tmp_path: Path, excess: float, sign: float) -> None:
    """1-3-1-(3 -+ e) is a rocker; its limits agree with the law of cosines."""
    lengths = (1.0, 3.0, 1.0, 3.0 - sign * excess)
    circuit = drawn_circuit(four_bar(tmp_path, *lengths, 1.0), 1e-10)
    assert circuit.closed
    assert circuit.crossings == {}
    stretched, folded_ = cosines(*lengths)
    found = limits(circuit)
    wanted = stretched if abs(stretched) < 1.0 else folded_
    for q in found["lower"] + found["upper"]:  # rounding of the cosine divided by the sine of the angle
        assert math.cos(q) == pytest.approx(wanted, abs=1e-13)
        assert abs(math.sin(q)) == pytest.approx(math.sqrt((1.0 - wanted) * (1.0 + wanted)), rel=1e-2)


def test_a_circuit_can_close_after_two_turns_of_the_input(tmp_path: Path) -> None:
    """1-3-2-4 passes its change point at 180 deg: B is on the other side for the next turn."""
    circuit = drawn_circuit(four_bar(tmp_path, 1.0, 3.0, 2.0, 4.0, 1.0), 1e-10)
    assert circuit.closed
    assert circuit.turns == 2.0
    assert sorted(math.degrees(m.p[-1]) % 360.0 for m in circuit.crossings.values()) == pytest.approx([180.0, 180.0])
    p = circuit.p
    start, twice = p[:, 0], p[:, -1]
    once = p[:, np.argmin(np.abs(p[-1] - start[-1] - math.copysign(2.0 * math.pi, twice[-1] - start[-1])))]
    assert np.abs(twice[:-1] - start[:-1]).max() < 1e-12
    assert np.abs(once[:-1] - start[:-1]).max() > 0.05


@pytest.mark.parametrize("windows", [4, 7, 8])
def test_many_windows_pass_their_common_flat_position(tmp_path: Path, windows: int) -> None:
    """With an even number of parallelograms in a row no determinant changes its sign at the change point."""
    count = range(windows + 1)
    nodes = ", ".join(f"O{k}: [{3 * k}, 0], A{k}: [{3 * k + 0.6}, 0.8]" for k in count)
    links = [f"c{k}: [O{k}, A{k}]" for k in count] + [f"b{k}: [A{k}, A{k + 1}]" for k in range(windows)]
    (tmp_path / "m.yaml").write_text(
        f"units: {{length: unit}}\nnodes: {{{nodes}}}\nground: [{', '.join(f'O{k}' for k in count)}]\n"
        f"links: {{{', '.join(links)}}}\nactuators: {{m: {{type: rotary, pivot: O0, arm: A0}}}}\n"
    )
    circuit = drawn_circuit(load(tmp_path / "m.yaml"), 1e-10)
    assert circuit.closed
    assert circuit.turns == 1.0
    assert [crossing.lost for crossing in circuit.crossings.values()] == [windows] * 2
    z = circuit.mechanism.to_file(circuit.curve.nodes(along(circuit, 100)))
    first, last = (z[circuit.mechanism.nodes.index(f"A{k}")] for k in (0, windows))
    assert np.abs(last - first - 3.0 * windows).max() < 1e-10


def test_a_double_rocker_has_its_full_closed_curve() -> None:
    """Chebyshev 4-5-5-2: both branches of the motion, its ends at acos(4/5) and acos(-1/5)."""
    circuit = drawn_circuit(load(MODELS / "chebyshev.yaml"), 1e-10)
    found = limits(circuit)
    assert found["lower"] == pytest.approx([math.acos(0.8)], abs=1e-14)
    assert found["upper"] == pytest.approx([math.acos(-0.2)], abs=1e-14)
    motion = circuit_motion(circuit, 721, 1e-10)
    assert motion.solved == 721
    z = motion.mechanism.to_file(motion.z)
    a, b = (z[motion.mechanism.nodes.index(n)] for n in ("A", "B"))
    assert np.abs(np.abs(a - b) - 2.0).max() < 1e-13
    p = 0.5 * (a + b)
    assert abs(p[0] - p[-1]) < 1e-12
    assert np.ptp(p.imag) > 0.8  # from the straight part at the height 4 to the arc above it
    mirrored = 4.0 - p.real + 1j * p.imag  # the linkage is symmetric, so its curve is too
    nearest = np.abs(mirrored[:, None] - p).min(axis=1)
    assert nearest.max() < 1.1 * np.abs(np.diff(p)).max()
    step = np.linalg.norm(np.diff(along(circuit, 721), axis=1), axis=0)
    assert step.max() < 1.01 * step.min()


@pytest.mark.few(*FEWEST)
@pytest.mark.parametrize("path", sorted(MODELS.glob("*.yaml")), ids=lambda p: p.stem)
def test_the_rows_of_a_circuit_fulfil_all_constraints_of_every_model(path: Path) -> None:
    """Residuals of the members as written along the circuit; limits are accurate to rounding."""
    circuit = drawn_circuit(load(path), 1e-10)
    assert circuit.closed or circuit.ended == "end of a law" or path.stem == "rack_lift"  # a rack of any length
    assert len(circuit.places) < 1000  # redundant constraints do not shorten the steps
    motion = circuit_motion(circuit, 200, 1e-10)
    assert motion.solved == 200
    assert np.nanmax(motion.residual) < 1e-12
    for k in range(1, len(circuit.places)):
        assert circuit.places[k].tangent @ circuit.places[k - 1].tangent > 0.9
    for one in singularities(circuit):
        z, u = circuit.curve.nodes(one.p)[:, None], circuit.curve.inputs(one.p)[:, None]
        assert residual(circuit.mechanism, z, u).total[0] < 1e-13
        if one.kind == LIMIT:  # an independent Jacobian, by central differences of the constraints as written
            system = circuit.curve.system
            values = np.linalg.svd(Constraints(system.mechanism).jacobian(z, u)[0], compute_uv=False)[: system.n]
            assert values[-1] < 1e-11 * values[0]


@pytest.mark.parametrize("offset", [0.0, 0.4, -1.1])
def test_the_stroke_of_a_slider(tmp_path: Path, offset: float) -> None:
    """Driven by its slider, a slider-crank r = 1, l = 3, offset e ends at sqrt((l +- r)^2 - e^2)."""
    b = math.sqrt(9.0 - (0.8 - offset) ** 2) + 0.6
    (tmp_path / "m.yaml").write_text(
        f"units: {{length: unit}}\nnodes: {{O: [0, 0], G: [0, {offset}], H: [5, {offset}], A: [0.6, 0.8], "
        f"B: [{b!r}, {offset}]}}\nground: [O, G, H]\nlinks: {{c: {{nodes: [O, A], length: 1}}, "
        "r: {nodes: [A, B], length: 3}}\nprismatic: {s: {node: B, guide: [G, H]}}\n"
        f"actuators: {{j: {{type: linear, node: B, guide: [G, H], law: {{from: {b!r}, to: 3}}}}}}\n"
    )
    mechanism = load(tmp_path / "m.yaml")
    found = limits(drawn_circuit(mechanism, 1e-10))
    low, high = (math.sqrt((3.0 + s) ** 2 - offset**2) for s in (-1.0, 1.0))
    assert mechanism.value_to_file(0, np.array(found["lower"])) == pytest.approx([low], abs=1e-13)
    assert mechanism.value_to_file(0, np.array(found["upper"])) == pytest.approx([high], abs=1e-13)


def test_two_inputs_follow_their_laws_together_through_a_limit() -> None:
    """A 3-RRR's inputs keep the ratio of their laws on the whole circuit, which is closed."""
    mechanism = load(MODELS / "platform_3rrr.yaml")
    found = survey(mechanism)
    circuit = found.branches.circuits[0]
    assert circuit.closed
    u = circuit.curve.inputs(circuit.p).T
    begin, end = (np.array([float(a.law(np.array([t]))[0]) for a in mechanism.actuators]) for t in (0.0, 1.0))
    part = (u - begin) / (end - begin)
    assert np.ptp(part, axis=1).max() < 1e-12
    assert len(limits(circuit)["upper"]) == len(limits(circuit)["lower"]) == 1


@pytest.mark.few(2)
@pytest.mark.parametrize("windows", [2, 7, 12])
def test_many_windows_start_from_their_flat_position(tmp_path: Path, windows: int) -> None:
    """Too many branches to list; on the first one all cranks are parallel: A_k = O_k + e^(i q)."""
    count = range(windows + 1)
    nodes = ", ".join(f"O{k}: [{3 * k}, 0], A{k}: [{3 * k + 1}, 0]" for k in count)
    links = [f"c{k}: [O{k}, A{k}]" for k in count] + [f"b{k}: [A{k}, A{k + 1}]" for k in range(windows)]
    (tmp_path / "m.yaml").write_text(
        f"units: {{length: unit}}\nnodes: {{{nodes}}}\nground: [{', '.join(f'O{k}' for k in count)}]\n"
        f"links: {{{', '.join(links)}}}\nactuators: {{m: {{type: rotary, pivot: O0, arm: A0}}}}\n"
    )
    mechanism = load(tmp_path / "m.yaml")
    motion = trace(mechanism, 36)
    assert motion.solved == 37
    z = mechanism.to_file(motion.z)
    for k in count:
        expected = 3.0 * k + np.exp(1j * motion.inputs[0])
        assert np.abs(z[mechanism.nodes.index(f"A{k}")] - expected).max() < 1e-10
    assert drawn_circuit(mechanism, 1e-10).closed


CRANK_AND_SLIDER = """\
nodes: {A: [0, 0], B: [1, 0], C: [0, 2], D: [1, 2], E: [0.5, 2]}
ground: [A, C, D]
links: {crank: [A, B]}
prismatic: {slide: {node: E, guide: [C, D]}}
actuators:
  turn: {type: rotary, pivot: A, arm: B, law: {from: 0, to: 90}}
  push: {type: linear, node: E, guide: [C, D], law: {from: 0.5, to: 0.6}}
"""
"""A crank and a slider that are not connected: no position occurs twice."""


def test_inputs_without_a_common_period_are_followed_for_some_turns(tmp_path: Path) -> None:
    file = tmp_path / "model.yaml"
    file.write_text(CRANK_AND_SLIDER)
    found = survey(load(file))
    (circuit,), (reach,) = found.branches.circuits, found.reach
    assert circuit.ended == Ended.LONG
    assert len(circuit.places) < 2000
    turn, push = np.array([circuit.curve.given(q) for q in reach]).T
    assert np.sort(turn) == pytest.approx([-8.0 * math.pi, 8.5 * math.pi], abs=1e-9)  # four turns beyond the law
    slope = 0.1 / (0.5 * math.pi)
    assert np.sort(push) * found.curve.mechanism.scale == pytest.approx(
        [0.5 - slope * 8.0 * math.pi, 0.5 + slope * 8.5 * math.pi], abs=1e-9
    )
