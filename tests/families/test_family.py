"""Many designs at once: positions and statuses against closed forms and against the trace of each design."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gimcli
from gimcli.families import family as families
from gimcli.families.family import Family
from gimcli.families.float_tables import listed
from gimcli.kernels import jit
from gimcli.kernels.family import LONGEST
from gimcli.mechanism import FloatArray
from gimcli.motion.motion import trace
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options
from gimcli.positions.program import plan_program
from gimcli.status import Status
from gimcli.structure.plan import make_plan

MODELS = Path(__file__).parents[2] / "models"

FOUR_BAR = """
nodes: {A: [0, 0], B: [2, 3], C: [8, 5], D: [6, 0]}
ground: [A, D]
links: {crank: {nodes: [A, B], length: 2}, rod: {nodes: [B, C], length: 7}, rocker: {nodes: [C, D], length: 9}}
actuators: {motor: {type: rotary, pivot: A, arm: B, law: {from: 20, to: 380}}}
"""
LENGTHS = ("D.x", "crank.length", "rod.length", "rocker.length")


@pytest.fixture(autouse=True)
def compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Solve all designs in compiled code, however few they are."""
    monkeypatch.setattr(families, "choose", lambda *_: jit.compiled)


def four_bars(designs: FloatArray, angles: FloatArray) -> tuple[Any, Any]:
    """Return C (designs, rows) of four-bars by the closed form, left of B -> D, and the number of rows reached."""
    ground, crank, rod, rocker = (designs[:, k : k + 1] for k in range(4))
    b = crank * np.exp(1j * angles)
    to = ground - b
    d = np.abs(to)
    cosine = (rod**2 + d**2 - rocker**2) / (2 * rod * d)
    with np.errstate(invalid="ignore"):
        c = b + rod * to / d * (cosine + 1j * np.sqrt(1 - cosine**2))
    fine = np.linspace(angles[0], angles[-1], 50 * (len(angles) - 1) + 1)
    d = np.abs(ground - crank * np.exp(1j * fine))
    out = (d > rod + rocker) | (d < np.abs(rod - rocker))
    first = np.where(out.any(axis=1), np.argmax(out, axis=1), len(fine))
    return c, -(-first // 50)  # rows before the first angle that is out of reach


def random_designs(nominal: FloatArray, count: int, spread: float, seed: int = 1) -> FloatArray:
    return nominal * (1 + spread * np.random.default_rng(seed).uniform(-1, 1, (count, len(nominal))))


def test_designs_that_are_solved_one_by_one_keep_the_branch_of_the_nominal_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """C below the line from B to D is the other branch; as an initial coordinate it does not change the design."""
    m = gimcli.loads(FOUR_BAR)
    family = Family(m, (*LENGTHS, "C.y"))
    designs = family.nominal * np.array([[1.0, 1.0, 1.0, 1.0, -1.0], [1.1, 1.0, 0.9, 1.0, -1.0]])
    c, reached = four_bars(designs, np.radians(np.linspace(20, 380, 25)))
    assert (reached >= 25).all()
    monkeypatch.setattr(families, "choose", lambda *_: plain)
    found = family.solve(designs, 24)
    assert (found.careful, found.good.all()) == (2, True)
    assert np.abs(m.to_file(found.z[:, m.nodes.index("C")]) - c).max() < 1e-9


def test_few_designs_of_a_coupled_group_are_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise the number of designs would decide on their assembly."""
    modes = []
    monkeypatch.setattr(families, "choose", lambda mode, *_: modes.append(mode) or jit.compiled)
    for name in ("stephenson_2", "jansen"):
        family = Family(gimcli.load(MODELS / f"{name}.yaml"), ("duration",))
        family.solve(family.nominal[None], 4)
    assert modes == ["on", "auto"]


@pytest.mark.parametrize("count", [1000, pytest.param(4000, marks=pytest.mark.soak)])
def test_four_bars_by_the_closed_form(count: int) -> None:
    m = gimcli.loads(FOUR_BAR)
    family = Family(m, LENGTHS)
    designs = random_designs(family.nominal, count, 0.7)
    found = family.solve(designs, 72)
    c, reached = four_bars(designs, np.radians(np.linspace(20, 380, 73)))
    assert found.careful <= count // 100
    place = m.to_file(found.z[:, m.nodes.index("C")])
    sure = np.ones(len(designs), dtype=bool)
    for k in range(4):  # a limit within a thousandth of a step of a row is not decided by the samples of the oracle
        for h in (-1e-3, 1e-3):
            other = designs.copy()
            other[:, k] *= 1 + h
            sure &= four_bars(other, np.radians(np.linspace(20, 380, 73)))[1] == reached
    assert sure.mean() > 0.9
    assert np.array_equal(found.solved[sure], reached[sure])
    begun = found.solved > 0
    assert set(np.unique(found.codes[~begun])) == {Status.NOT_ASSEMBLED}
    assert set(np.unique(found.codes[begun])) == {Status.OK, Status.LIMIT}
    assert np.nanmax(np.abs(place - c)[found.good]) < 1e-10 * 20
    assert np.isnan(found.z.transpose(0, 2, 1)[~found.good]).all()


@pytest.mark.parametrize("length", [1.0, 11.0], ids=["not assembled", "flat"])
def test_a_nominal_design_without_a_regular_start(length: float) -> None:
    """The rod of the nominal design is too short, or just reaches the rocker: |D - B| = 8 - 2, rocker 9 or 5."""
    text = FOUR_BAR.replace("length: 7", f"length: {length}").replace("from: 20, to: 380", "from: 0, to: 360")
    m = gimcli.loads(text.replace("D: [6, 0]", "D: [8, 0]").replace("length: 9", f"length: {9 if length < 5 else 5}"))
    family = Family(m, LENGTHS)
    designs = random_designs(np.array([6.0, 2.0, 7.0, 9.0]), 500, 0.1)
    found = family.solve(designs, 72)
    c, reached = four_bars(designs, np.radians(np.linspace(0, 360, 73)))
    assert found.careful == 0
    assert np.array_equal(found.solved, reached)
    assert np.nanmax(np.abs(m.to_file(found.z[:, m.nodes.index("C")]) - c)[found.good]) < 1e-9


def test_the_arc_of_a_design_that_cannot_be_assembled_at_the_first_row() -> None:
    m = gimcli.loads(FOUR_BAR.replace("from: 20, to: 380", "from: 0, to: 180"))
    family = Family(m, LENGTHS)
    design = np.array([[6.0, 5.0, 4.0, 3.0]])  # |rod - rocker| = 1 <= d <= 7: not for d = 1 (crank at 0, a limit)
    design[0, 1] = 5.1  # d = 0.9 at 0 deg, 7 at acos((36 + 26.01 - 49) / 61.2) = 77.7 deg
    low = math.degrees(math.acos((36 + 5.1**2 - 1) / (2 * 6 * 5.1)))
    high = math.degrees(math.acos((36 + 5.1**2 - 49) / (2 * 6 * 5.1)))
    rows = np.flatnonzero((np.linspace(0, 180, 181) > low) & (np.linspace(0, 180, 181) < high))
    assert family.solve(design, 180).solved[0] == 0
    found = family.solve(design, 180, reachable=True)
    assert np.array_equal(np.flatnonzero(found.good[0]), rows)
    assert found.codes[0, 0] == Status.NOT_ASSEMBLED
    assert found.codes[0, -1] == Status.LIMIT


@cache
def _model(name: str) -> Any:
    return gimcli.load(MODELS / f"{name}.yaml")


def some_names(m: Any) -> list[str]:
    names = [f"{name}.length" for name in m.written.model.links][:5]
    return names + [f"{m.nodes[k]}.{'xy'[k % 2]}" for k in m.members[0].nodes][: 6 - len(names)]


CASES = [
    "jansen",
    "slider_crank",
    "whitworth",
    "five_bar",
    "stephenson_3_far",
    "platform_3rrr",
    "excavator",
    "scotch_yoke",
]


@pytest.mark.few(8)
@pytest.mark.parametrize("steps", [1, 5, 18, 43, 71, 72])
@pytest.mark.parametrize("name", CASES)
def test_each_design_as_its_own_trace(name: str, steps: int) -> None:
    m = _model(name)
    family = Family(m, some_names(m))
    designs = random_designs(family.nominal, 12, 0.05)
    found = family.solve(designs, steps, jit="on")
    assert found.careful == 0
    for d, design in enumerate(designs):
        own = m.with_(dict(zip(family.names, design.tolist(), strict=True)))
        motion = trace(own, steps, Options(jit="off"))
        assert np.array_equal(motion.codes, found.codes[d])
        z = (own.to_file(motion.z) - m.origin) / m.scale
        assert np.nanmax(np.abs(z - found.z[d]), initial=0.0) < 1e-10
        assert np.nanmax(found.residual[d], initial=0.0) < 1e-9


def test_a_gap_between_two_rows_is_not_passed() -> None:
    """The last dyad of this leg (radii g, f) cannot be assembled between 179.49 and 179.86 deg of the crank."""
    m = _model("jansen")
    family = Family(m, [f"{name}.length" for name in "mjkcfg"])
    design = np.array([[15.20373807, 51.32417517, 62.64036725, 38.58622951, 39.77050777, 38.23356659]])
    for steps in (1, 3, 24, 43, 47, 50, 60, 71, 72, 720):  # rows at both sides of the gap
        assert family.solve(design, steps).solved[0] == math.floor(179.488 / 360 * steps) + 1


@pytest.mark.soak
def test_ten_thousand_jansen_designs_as_their_own_traces() -> None:
    m = _model("jansen")
    family = Family(m, [f"{name}.length" for name in "mjkcfg"])
    designs = random_designs(family.nominal, 10000, 0.05)
    found = family.solve(designs, 72)
    assert found.careful <= 100
    for d, design in enumerate(designs):
        own = m.with_(dict(zip(family.names, design.tolist(), strict=True)))
        motion = trace(own, 72, Options(jit="on"))
        assert np.array_equal(motion.codes, found.codes[d]), design
        assert np.nanmax(np.abs(motion.z - found.z[d]), initial=0.0) < 1e-10, design


@pytest.mark.few
@pytest.mark.parametrize("name", sorted(path.stem for path in MODELS.glob("*.yaml")))
def test_the_numbers_of_the_plan_are_those_of_the_changed_model(name: str) -> None:
    m = _model(name)
    names = [n for n in some_names(m) if n.partition(".")[0] != m.nodes[m.members[0].nodes[0]]]  # keeps the origin
    family = Family(m, names)
    design = random_designs(family.nominal, 1, 0.01)
    own = m.with_(dict(zip(names, design[0].tolist(), strict=True)))
    program = plan_program(own, make_plan(own))
    assert (program.tables.steps, program.tables.vi) == (family.program.tables.steps, family.program.tables.vi)
    assert own.scale == m.scale
    for table, expected in zip(family.tables(design), listed(own, program), strict=True):
        assert np.allclose(table.ravel(), np.array(expected, dtype=float), rtol=0, atol=1e-13, equal_nan=True)


def test_the_number_of_threads_changes_no_bit() -> None:
    m = _model("jansen")
    family = Family(m, some_names(m))
    designs = random_designs(family.nominal, 1000, 0.1)
    one, two = family.solve(designs, 36, threads=1), family.solve(designs, 36, threads=2)
    assert one.z.tobytes() == two.z.tobytes()
    assert one.codes.tobytes() == two.codes.tobytes()


def test_a_redundant_constraint_that_contradicts() -> None:
    m = _model("parallelogram_third_crank")
    name = next(iter(m.written.model.links))
    family = Family(m, [f"{name}.length"])
    found = family.solve(np.array([family.nominal, family.nominal * 1.1]), 12)
    assert found.status[0] in (Status.OK, Status.SINGULAR)
    assert found.status[1] != Status.OK


@pytest.mark.parametrize("steps", range(1, 72))
def test_rows_in_between_are_few_and_lead_from_row_to_row(steps: int) -> None:
    """All rows are solved in one run: no step is longer than of 72, and there are at most twice as many rows."""
    family = Family(_model("crank_rocker"), ["coupler.length"])
    time = np.arange(steps + 1) / steps
    inputs = family.law_inputs(time, family.tables(family.nominal[None]))
    grid, between, own = family._refined(time, inputs)
    assert len(grid) - 1 <= steps * math.ceil(72 / steps) <= 142
    assert np.array_equal(grid[own], time)
    assert np.array_equal(between[..., own], inputs)
    assert np.abs(np.diff(between)).max() <= LONGEST
    assert np.abs(between[0, 0] - 2.0 * np.pi * grid).max() < 1e-12
