"""`gim tradeoff`: solved positions, operations, times and recommendations."""

import csv
import json
import math
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from bundled import MANUAL, MODELS
from in_process import printed as gim
from matplotlib.backends.backend_agg import FigureCanvasAgg
from table1_operations import CASES, from_far, measure

from gimcli import load
from gimcli.comparison.methods import METHODS, Clock, MotionMethod, Outcome, Timing
from gimcli.comparison.tradeoff import EQUAL_TIMES, Entry, Tradeoff, advise, mark_efficient, tradeoff, tradeoff_table
from gimcli.errors import StructureError
from gimcli.motion.motion import trace
from gimcli.output.figure import canvas_of
from gimcli.output.tradeoff import tradeoff_picture

QUICK = Timing(1, 1, 0.0)


def compare(name, tolerances=(1e-3, 1e-6, 1e-11), steps=24, **more):
    return tradeoff(load(MODELS / f"{name}.yaml"), steps, tolerances, "off", timing=QUICK, **more)


def of(found, method):
    return [e for e in found.entries if e.method.name == method]


def test_every_method_solves_a_four_bar_and_errors_follow_tolerances():
    found = compare("crank_rocker")
    assert len(found.entries) == 3 * len(METHODS)
    assert all(e.complete and e.rows == 24 and e.seconds >= 0.0 for e in found.entries)
    assert all(e.error < 10.0 * e.tolerance for e in found.entries)
    for method in METHODS:
        entries = of(found, method.name)
        assert [e.tolerance for e in entries] == [1e-3, 1e-6, 1e-11]
        assert all(a.work <= b.work for a, b in pairwise(entries))


def test_closed_forms_take_no_iteration_and_have_only_rounding_errors():
    for entry in of(compare("crank_rocker"), "auto"):
        assert (entry.work, entry.paper, entry.unknowns) == (0.0, 0.0, ())
        assert entry.operations > 0.0
        assert entry.error < 1e-15


def test_sweeps_grow_with_the_digits_but_iterations_hardly_do():
    """For one dyad the convergence factor is exactly the squared cosine of the angle between its bars."""
    found = compare("gim_fig13a", (1e-5, 1e-12), 72)
    coarse, tight = of(found, "gim-classic")
    motion = trace(found.mechanism, 72)
    b, c, d = (motion.z[motion.mechanism.nodes.index(n), 1:] for n in "BCD")
    cosine = ((b - c).conjugate() * (d - c)).real / np.abs(b - c) / np.abs(d - c)
    assert tight.work - coarse.work == pytest.approx(np.mean(np.log(1e-7) / np.log(cosine**2)), rel=0.1)
    for name in ("joint", "absolute", "natural"):
        coarse, tight = of(found, name)
        assert tight.work - coarse.work < 2.1
    assert of(found, "gim-classic")[1].paper == pytest.approx(12.0 * of(found, "gim-classic")[1].work)
    assert of(found, "absolute")[1].paper == pytest.approx(9.0 * 27.0 * of(found, "absolute")[1].work)


class Altered:
    """Path following with altered positions."""

    def __init__(self, task, alter):
        self.task, self.alter = task, alter

    def solve(self, tolerance):
        z, good = self.task.z.copy(), np.ones(self.task.z.shape[1], dtype=bool)
        self.alter(self.task.mechanism, z, good)
        cost = METHODS[3].prepare(self.task).solve(tolerance).cost
        return Outcome(z, good, np.ones(len(good)), cost, lambda: None)


def mirrored(mechanism, z, good):
    """Move the last ten rows to the other branch of the dyad BCD; all constraints remain satisfied."""
    b, c, d = (mechanism.nodes.index(n) for n in "BCD")
    rows = slice(-10, None)
    line = z[d, rows] - z[b, rows]
    z[c, rows] = z[b, rows] + ((z[c, rows] - z[b, rows]) / line).conjugate() * line


def test_a_position_on_another_branch_is_not_solved():
    altered = MotionMethod("altered", "altered", "--altered", lambda task: Altered(task, mirrored))
    found = compare("gim_fig13a", (1e-6,), methods=(altered, METHODS[3]))
    (entry,) = of(found, "altered")
    assert (entry.solved, entry.rows, entry.complete) == (14, 24, False)
    assert entry.reason == "10 on another branch"
    assert entry.error < 1e-14
    assert not entry.efficient
    assert all(a.best is None or a.best.method.name == "auto" for a in advise(found))


def test_sweeps_that_leave_the_branch_give_a_status():
    """Klann's leg at tolerance 0.01: some rows converge to another configuration (measured) and count as failures."""
    (entry,) = of(compare("klann", (1e-2,), 72), "gim-classic")
    assert 0 < entry.solved < entry.rows
    assert "other-configuration" in entry.reason


@pytest.mark.soak
def test_a_method_that_does_not_converge_or_has_no_sequence_has_an_entry_with_the_reason():
    found = compare("double_butterfly", (1e-4,))
    (entry,) = of(found, "gim-classic")
    assert 0 < entry.solved < entry.rows
    assert entry.reason in ("stalled", "not-converged", "other-configuration")

    def refuse(task):
        raise StructureError("no sequence moves nodes A, B twice each")

    refused = MotionMethod("refused", "refused", "--refused", refuse)
    found = compare("gim_fig13a", (1e-4, 1e-6), methods=(refused, METHODS[3]))
    (entry,) = of(found, "refused")
    assert entry.reason == "no sequence moves nodes A, B twice each"
    assert len(of(found, "auto")) == 2
    assert len(tradeoff_table(found)) == 3


def entry(number, seconds, error, solved=10):
    return Entry(METHODS[number], 1e-6, (2,), (100.0,), 1.0, 1.0, 1.0, 1.0, seconds, error, solved, 10, "")


def test_no_entry_is_better_than_one_of_the_efficient_front():
    generator = np.random.default_rng(0)
    entries = [entry(k % 7, *10.0 ** generator.uniform(-12, -1, 2), solved=10 - (k % 5 == 0)) for k in range(60)]
    entries = [replace(e, seconds=10.0 ** generator.uniform(-6, -3)) for e in entries]
    front = {id(e) for e, m in zip(entries, mark_efficient(entries), strict=True) if m.efficient}
    whole = sorted((e for e in entries if e.solved == 10), key=lambda e: e.seconds)
    least = np.minimum.accumulate([e.error for e in whole])
    expected = {id(e) for e, before in zip(whole, [math.inf, *least], strict=False) if e.error < before}
    assert front == expected
    assert len(front) > 1


def advice_on(*entries):
    return {a.digits: a for a in advise(Tradeoff(None, entries, None, False, 0))}


def test_the_fastest_method_of_gim_with_enough_digits_is_recommended():
    slow, quick, rough = entry(3, 5e-5, 1e-14), entry(2, 2e-5, 3e-9), entry(1, 1e-5, 3e-4)
    partial, reference = entry(0, 1e-6, 1e-14, solved=9), entry(5, 3e-5, 1e-15)
    advice = advice_on(slow, quick, rough, partial, reference)
    assert [advice[d].best for d in (3, 6, 9, 12)] == [rough, quick, slow, slow]
    assert [advice[d].reference for d in (3, 6, 9, 12)] == [None, None, reference, reference]
    assert "--method gim --strategy spectral --tolerance 1e-06" in advice[3].text
    assert "absolute coordinates" in advice[9].text


def test_the_more_accurate_of_two_equally_fast_methods_is_recommended():
    first, second = entry(2, 1e-5, 1e-7), entry(3, 1e-5 * (EQUAL_TIMES - 0.01), 1e-12)
    assert advice_on(first, second)[6].best is second


def test_the_recommendation_states_that_no_method_reaches_the_digits():
    advice = advice_on(entry(1, 1e-5, 1e-4), entry(3, 1e-5, 1e-7))
    assert advice[9].best is None
    assert advice[9].text.startswith("9 digits: no method reaches this accuracy")
    assert "--method auto" in advice[9].text
    assert advice_on(entry(1, 1e-5, 1e-9, solved=3))[3].text == "3 digits: no method solves all positions."


def test_a_clock_subtracts_the_preparation():
    def wait(seconds):
        import time

        end = time.process_time() + seconds
        while time.process_time() < end:
            pass

    clock = Clock(Outcome(None, None, None, None, lambda: wait(0.03), lambda: wait(0.02)), Timing(2, 2, 1.0))
    clock.round()
    assert clock.seconds == pytest.approx(0.01, abs=0.005)


def test_no_part_of_the_picture_is_clipped():
    generator = np.random.default_rng(0)
    curves = {
        m.label: np.stack([*10.0 ** generator.uniform([[-6], [-16]], [[-1], [-1]], (2, 7)), np.ones(7)], axis=1)
        for m in METHODS
    }
    curves["auto"][:, 2] = 0.0
    picture = tradeoff_picture(curves, curves["newton"][:2, :2], "A mechanism: error and time, compiled")
    low, high = picture.frame.low, picture.frame.high
    for z in (place for places in picture.marks.values() for place in places):
        assert low.real < z.real < high.real
        assert low.imag < z.imag < high.imag
    assert [name for name, _ in picture.legend] == [*curves, "efficient front", "hollow: positions missing"]
    shapes = [style[1].shape for _, style in picture.legend[: len(curves)]]
    assert len(set(shapes)) == len(curves)
    canvas = canvas_of(FigureCanvasAgg, picture)
    canvas.draw()
    figure = canvas.figure
    for text in [*figure.legends[0].get_texts(), *figure.texts, figure.axes[0].xaxis.label, figure.axes[0].yaxis.label]:
        box = text.get_window_extent()
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= figure.bbox.x1
        assert box.y1 <= figure.bbox.y1


@pytest.mark.few(1)
@pytest.mark.parametrize("jit", ["off", "on"])
def test_command_line(jit, tmp_path):
    arguments = ("--steps", 12, "--tolerances", "1e-3,1e-8", "--jit", jit, "--out", tmp_path, "--seconds", 600)
    report = json.loads(gim("tradeoff", MODELS / "gim_fig13a.yaml", *arguments, "--json"))
    assert report["steps"] == 12
    assert report["solved"] == 13
    assert len(report["entries"]) == 2 * len(METHODS)
    assert [a["digits"] for a in report["advice"]] == [3, 6, 9, 12]
    assert (tmp_path / "gim_fig13a.tradeoff.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "gim_fig13a.tradeoff.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [r["method"] for r in rows] == [e["method"] for e in report["entries"]]
    assert [float(r["error"]) for r in rows] == [e["error"] for e in report["entries"]]
    text = gim("tradeoff", MODELS / "gim_fig13a.yaml", *arguments, "--no-png")
    assert "12 digits: " in text
    assert "absolute coordinates" in text


@pytest.mark.parametrize("wrong", ["1e-3,x", "0", "2", "nan", "1e-16"])
def test_tolerances_out_of_range_are_refused(wrong, tmp_path):
    gim("tradeoff", MODELS / "gim_fig13a.yaml", "--tolerances", wrong, cwd=tmp_path, code=2)


@pytest.mark.soak
def test_a_limit_of_the_motion_leaves_the_rows_up_to_the_limit(tmp_path):
    (tmp_path / "model.yaml").write_text(
        "nodes: {A: [0,0], B: [4,0.5], C: [5.2,2.4], D: [4,0]}\nground: [A,D]\n"
        "links: {a: {nodes: [A,B], length: 4}, b: {nodes: [B,C], length: 1.5}, c: {nodes: [D,C], length: 2}}\n"
        "actuators: {m: {type: rotary, pivot: A, arm: B, law: {from: 20, to: 200}}}\ntrace: [C]\n"
    )
    arguments = ("--steps", 90, "--tolerances", "1e-8", "--no-png", "--json")  # one tolerance: no entry is left out
    report = json.loads(gim("tradeoff", *arguments, cwd=tmp_path, code=5))
    limit = math.degrees(math.acos((4**2 + 4**2 - 3.5**2) / (2 * 4 * 4)))
    assert {e["positions"] for e in report["entries"]} == {math.floor((limit - 20) / 2)}
    assert {e["solved"] for e in report["entries"] if e["method"] == "auto"} == {math.floor((limit - 20) / 2)}


@pytest.mark.parametrize("column", [0, *(pytest.param(k, marks=pytest.mark.soak) for k in range(1, len(CASES)))])
def test_the_manual_has_table_1(column):
    """Every number of the table agrees with a measurement."""
    table, case = {}, CASES[column]
    for line in (MANUAL / "speed.md").read_text(encoding="utf-8").split("### Table 1")[1].splitlines():
        if line.startswith("| "):
            label, *cells = (cell.strip() for cell in line.strip("|").split("|"))
            table[label] = cells
    found = measure(case)

    def number(start):
        (cells,) = [cells for label, cells in table.items() if label.startswith(start)]
        return float(cells[column])

    names = {
        "sweeps, as": "sweeps", "iterations in absolute": "absolute iterations", "paper's count: 12": "paper",
        "paper's count: 9": "paper absolute", "operations counted": "real", "`auto`": "real auto",
        "sweeps to 1e-12": "tight sweeps", "iterations to 1e-12": "tight absolute",
        **{f"Newton-Raphson, {name}": f"real {name}" for name in ("absolute", "joint", "natural")},
    }  # fmt: skip
    for label, name in names.items():
        assert number(label) == round(found[name]), label
    assert number("of 50 random starts") == from_far(case)[0]


# -- how long a comparison takes ---------------------------------------------------------------------------


def test_rounds_share_the_total_time():
    timing = Timing(rounds=3, repeats=40, budget=0.05, total=1.5)
    assert timing.shared(100).budget == pytest.approx(1.5 / 300)
    assert timing.shared(1).budget == 0.05


def test_the_sequence_of_a_strategy_is_searched_once(monkeypatch):
    from gimcli.gim import sweeper

    searched, search = [], sweeper.find_sequence
    monkeypatch.setattr(sweeper, "find_sequence", lambda *given: searched.append(given[3]) or search(*given))
    tradeoff(load(MODELS / "gim_fig13a.yaml"), 4, (1e-2, 1e-4, 1e-6), jit="off", timing=QUICK)
    assert sorted(searched) == ["classic", "spectral"]


def test_a_method_that_has_used_its_share_is_left_out_at_finer_tolerances():
    found = tradeoff(load(MODELS / "crank_rocker.yaml"), 4, (1e-2, 1e-4, 1e-6), jit="off", timing=QUICK, seconds=0.0)
    for method in {e.method.name for e in found.entries}:
        first, *finer = (e for e in found.entries if e.method.name == method)
        assert first.solved > 0
        assert first.seconds > 0.0
        assert [(e.tolerance, e.solved) for e in finer] == [(1e-4, 0), (1e-6, 0)]
        assert all("--seconds allows more" in e.reason for e in finer)


@pytest.mark.soak
def test_a_comparison_takes_at_most_ten_seconds(model):
    mechanism = load(model)
    tradeoff(mechanism, timing=QUICK)  # compiles
    began = time.process_time()
    tradeoff(mechanism, seconds=10.0)
    assert time.process_time() - began < 10.0
