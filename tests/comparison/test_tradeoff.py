"""`gim tradeoff`: solved positions, operations, times and recommendations."""

import csv
import json
import math
import subprocess
import sys
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from bundled import MANUAL, MODELS
from canvases import canvas_of
from drawn_styles import marks
from in_process import printed as gim
from matplotlib.backends.backend_agg import FigureCanvasAgg
from table1_operations import CASES, from_far, measure

from gimcli import StructureError, load
from gimcli.comparison import timing as clocks
from gimcli.comparison.methods import METHODS, MotionMethod, Outcome
from gimcli.comparison.timing import Measured, Timing
from gimcli.comparison.tradeoff import Entry, Tradeoff, advise, mark_efficient, tradeoff
from gimcli.motion.motion import trace
from gimcli.output.tradeoff import tradeoff_picture
from gimcli.positions.options import Options

QUICK = Timing(rounds=1, fewest=1, least=0.0)


def compare(name, tolerances=(1e-3, 1e-6, 1e-11), steps=24, **more):
    return tradeoff(load(MODELS / f"{name}.yaml"), steps, tolerances, "off", timing=QUICK, **more)


def of(found, method):
    return [e for e in found.entries if e.method.name == method]


def test_every_method_solves_a_four_bar_and_errors_follow_tolerances():
    found = compare("crank_rocker")
    assert len(found.entries) == 3 * len(METHODS)
    assert all(e.complete and e.rows == 24 and e.time.seconds > 0.0 and e.fixed.seconds > 0.0 for e in found.entries)
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
        return Outcome(z, good, np.ones(len(good)), cost, lambda count: count, lambda: None)


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
    """Klann's leg at tolerance 0.1: most rows converge to another configuration (measured) and count as failures."""
    (entry,) = of(compare("klann", (1e-1,), 72), "gim-classic")
    assert 0 < entry.solved < entry.rows
    assert "other-configuration" in entry.reason


@pytest.mark.soak
def test_a_method_that_does_not_converge_or_has_no_sequence_has_an_entry_with_the_reason():
    (entry,) = of(compare("gim_fig13c", (1e-4,)), "gim-spectral")
    assert 0 < entry.solved < entry.rows
    assert entry.reason in ("stalled", "not-converged", "other-configuration")

    def refuse(task):
        raise StructureError("no sequence moves nodes A, B twice each")

    refused = MotionMethod("refused", "refused", "--refused", refuse)
    found = compare("gim_fig13a", (1e-4, 1e-6), methods=(refused, METHODS[3]))
    (entry,) = of(found, "refused")
    assert entry.reason == "no sequence moves nodes A, B twice each"
    assert len(of(found, "auto")) == 2
    assert len(found.entries) == 3


def entry(number, seconds, error, solved=10, tolerance=1e-6, spread=0.0, work=1.0):
    time, fixed = Measured(seconds, spread), Measured(1e-3, 0.0)
    return Entry(
        METHODS[number], tolerance, (2,), (100.0,), 1.0, 1.0, 1.0, work, time, fixed, 10, error, solved, 10, ""
    )


def test_no_entry_is_better_than_one_of_the_efficient_front():
    generator = np.random.default_rng(0)
    entries = [entry(k % 7, *10.0 ** generator.uniform(-12, -1, 2), solved=10 - (k % 5 == 0)) for k in range(60)]
    entries = [replace(e, time=Measured(10.0 ** generator.uniform(-6, -3), 0.0)) for e in entries]
    front = {id(e) for e, m in zip(entries, mark_efficient(entries), strict=True) if m.efficient}
    whole = sorted((e for e in entries if e.solved == 10), key=lambda e: e.time.seconds)
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


def test_of_methods_within_the_spread_the_default_is_recommended_and_no_reference_is_named():
    newton, auto, reference = (
        entry(2, 1e-5, 1e-12, spread=1e-6),
        entry(3, 1.2e-5, 1e-12, spread=1.1e-6),
        entry(5, 9e-6, 1e-13, spread=2e-6),
    )
    advice = advice_on(newton, auto, reference)[6]
    assert (advice.best, advice.reference) == (auto, None)
    clearly = replace(auto, time=Measured(1.3e-5, 1.1e-6))
    assert advice_on(newton, clearly)[6].best is newton
    assert {e.method.name for e in mark_efficient([newton, auto]) if e.efficient} == {"newton", "auto"}
    assert {e.method.name for e in mark_efficient([newton, clearly]) if e.efficient} == {"newton"}


def test_between_tolerances_the_counted_operations_decide_whatever_the_times():
    """Times of one method vary; its operations do not. Equal ones: the tolerance that has the digits."""
    closed = [
        entry(3, 1e-7 * (1 + k % 3), 3e-16, tolerance=t) for k, t in enumerate((1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12))
    ]
    assert [advice_on(*closed)[d].best.tolerance for d in (3, 6, 9, 12)] == [1e-4, 1e-6, 1e-10, 1e-12]
    rough, fine, exact = (
        entry(2, t, e, tolerance=e, work=w) for t, e, w in ((3e-6, 1e-7, 100), (1e-6, 1e-10, 110), (2e-6, 1e-13, 200))
    )
    assert [advice_on(rough, fine, exact)[d].best for d in (6, 12)] == [fine, exact]


def test_the_advice_has_the_price_of_each_further_digit_and_the_time_of_the_whole_call():
    """Of 10 steps with a fixed part of 1 ms."""
    advice = advice_on(
        entry(2, 4e-5, 1e-4, spread=1e-7),
        entry(2, 7e-5, 1e-8, spread=1e-7, work=2.0),
        entry(2, 7.01e-5, 1e-11, spread=1e-7, work=3.0),
    )
    assert [advice[d].price for d in (3, 6, 9)] == [None, pytest.approx(1e-5), 0.0]
    assert advice[3].best.call == pytest.approx(1.4e-3)
    assert "40 µs a position, 1.4 ms a call of 10 steps" in advice[3].text
    assert advice[6].text.endswith("Each digit beyond 3: 10 µs a position, 100 µs a call.")
    assert advice[9].text.endswith("The same time as for 6 digits, within the spread.")


def test_the_recommendation_states_that_no_method_reaches_the_digits():
    advice = advice_on(entry(1, 1e-5, 1e-4), entry(3, 1e-5, 1e-7))
    assert advice[9].best is None
    assert advice[9].text.startswith("9 digits: no method reaches this accuracy")
    assert "--method auto" in advice[9].text
    assert advice_on(entry(1, 1e-5, 1e-9, solved=3))[3].text == "3 digits: no method solves all positions."


# -- clocks that lie ------------------------------------------------------------------------------------


class FakeClock:
    """Virtual time that runs add to, as a clock shows it that lies; another program takes no virtual time."""

    def __init__(self, lie):
        self.now, self.calls, self.lie, self.random = 0.0, 0, lie, np.random.default_rng(1)

    def __call__(self):
        self.calls += 1
        return self.lie(self)

    def run(self, seconds):
        """Return a run of units that take some time each, with the noise of the machine."""

        def run(count):
            factor = 1.0 + (0.3 * self.random.uniform(-1.0, 1.0) if self.lie is noisy else 0.0)
            self.now += count * seconds * factor
            return count

        return run


def exact(clock):
    return clock.now


def noisy(clock):
    return clock.now


def standing(clock):
    return 0.0


def jumping(clock):
    """Jump by an hour, forward and back, at every 17th call."""
    return clock.now + 3600.0 * (clock.calls % 34 // 17)


def stalling(clock):
    """Stand still in some calls in a row: short runs take no time, and then a long one."""
    clock.held = clock.now if clock.calls % 23 > 3 else getattr(clock, "held", 0.0)
    return clock.held


UNITS = (36e-9, 36e-9, 150e-9, 4e-6)


def measured(lie):
    clock = FakeClock(lie)
    return clocks.measure([clock.run(unit) for unit in UNITS], Timing(clock, patience=30.0))


@pytest.mark.parametrize("lie", [exact, noisy, jumping, stalling])
def test_a_clock_that_lies_leaves_times_ties_and_order(lie):
    found = measured(lie)
    for one, unit in zip(found, UNITS, strict=True):
        assert one.seconds == pytest.approx(unit, rel=0.25 if lie is noisy else 1e-3)
        assert 0.05 * one.seconds <= one.spread <= 0.45 * one.seconds
    assert found[0].ties(found[1])
    assert found[0].is_less(found[2])
    assert found[2].is_less(found[3])


def test_a_clock_that_stands_still_shows_no_time_and_everything_is_a_tie():
    clock = FakeClock(standing)
    found = clocks.measure([clock.run(1e-6)] * 2, Timing(clock, patience=0.01))
    assert all(math.isnan(one.seconds) and math.isnan(one.spread) for one in found)
    assert found[0].ties(found[1])
    assert not found[0].is_less(found[1])


def test_a_long_run_is_made_once_and_its_spread_is_wide():
    clock, made = FakeClock(exact), []
    run = clock.run(0.3)
    (found,) = clocks.measure([lambda count: made.append(count) or run(count)], Timing(clock))
    assert made == [1]
    assert (found.seconds, found.spread) == (pytest.approx(0.3), pytest.approx(0.15))


COSTS = {
    "gim-classic": 9e-7, "gim-spectral": 1e-6, "newton": 1.5e-7, "auto": 4e-8,
    "joint": 5e-7, "absolute": 2e-6, "natural": 4e-7,
}  # fmt: skip


class Priced:
    """A method whose positions and calls take a given virtual time."""

    def __init__(self, method, clock):
        self.method, self.clock = method, clock

    def __call__(self, task):
        self.solver = self.method.prepare(task)
        return self

    def solve(self, tolerance):
        call = self.clock.run(1e-3)
        return replace(
            self.solver.solve(tolerance), run=self.clock.run(COSTS[self.method.name]), call=lambda: call(1)
        )  # fmt: skip


@pytest.mark.few(3)
@pytest.mark.parametrize("lie", [exact, noisy, jumping, stalling, standing])
def test_the_advice_is_the_same_whatever_the_clock_shows(lie):
    """`auto` needs the least time of a dyadic mechanism; without a time it is recommended too, and the text says so."""
    clock = FakeClock(lie)
    methods = [replace(method, prepare=Priced(method, clock)) for method in METHODS]
    timing = Timing(clock, patience=0.01 if lie is standing else 30.0)
    found = tradeoff(
        load(MODELS / "crank_rocker.yaml"), 24, (1e-3, 1e-6, 1e-12), "off", timing=timing, methods=methods
    )  # fmt: skip
    advice = advise(found)
    assert [(a.best.method.name, a.reference) for a in advice] == [("auto", None)] * 4
    assert [a.best.tolerance for a in advice] == [1e-3, 1e-6, 1e-12, 1e-12]
    assert all(("not measured" in a.text) == (lie is standing) for a in advice)
    assert all(a.price in (None, 0.0) for a in advice)
    assert all(e.time.seconds != 0.0 and e.fixed.seconds != 0.0 for e in found.entries)
    if lie is not standing:
        for e in found.entries:
            assert e.time.seconds == pytest.approx(COSTS[e.method.name], rel=0.25)
            assert e.fixed.seconds == pytest.approx(1e-3, rel=0.25)
        assert {e.method.name for e in found.entries if e.efficient} == {"auto"}


def test_no_part_of_the_picture_is_clipped():
    generator = np.random.default_rng(0)
    curves = {
        m.label: np.stack([*10.0 ** generator.uniform([[-6], [-16]], [[-1], [-1]], (2, 7)), np.ones(7)], axis=1)
        for m in METHODS
    }
    curves["auto"][:, 2] = 0.0
    picture = tradeoff_picture(curves, curves["newton"][:2, :2], "time of a position [µs]")
    low, high = picture.frame.low, picture.frame.high
    for z in (place for places in marks(picture).values() for place in places):
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
    arguments = ("--steps", 4, "--tolerances", "1e-3,1e-8", "--jit", jit, "--out", tmp_path, "--seconds", 600)
    report = json.loads(gim("tradeoff", MODELS / "gim_fig13a.yaml", *arguments, "--json"))
    assert report["steps"] == 4
    assert report["solved"] == 5
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
        "sweeps, as": "sweeps", "sweeps by the": "rules", "iterations in absolute": "absolute iterations",
        "paper's count: 12": "paper",
        "paper's count: 9": "paper absolute", "operations counted": "real", "`auto`": "real auto",
        "sweeps to 1e-12": "tight sweeps", "iterations to 1e-12": "tight absolute",
        **{f"Newton-Raphson, {name}": f"real {name}" for name in ("absolute", "joint", "natural")},
    }  # fmt: skip
    for label, name in names.items():
        assert number(label) == np.round(found[name]), label
    assert number("of 50 random starts") == from_far(case)[0]


# -- how long a comparison takes ---------------------------------------------------------------------------


def test_the_sequence_of_a_strategy_is_searched_once(monkeypatch):
    from gimcli.gim import sweeper

    searched, search = [], sweeper.find_sequence
    monkeypatch.setattr(sweeper, "find_sequence", lambda *given: searched.append(given[2]) or search(*given))
    tradeoff(load(MODELS / "gim_fig13a.yaml"), 4, (1e-2, 1e-4, 1e-6), jit="off", timing=QUICK)
    assert sorted(searched) == ["classic", "spectral"]


def test_a_method_that_has_used_its_share_is_left_out_at_finer_tolerances():
    found = tradeoff(load(MODELS / "crank_rocker.yaml"), 4, (1e-2, 1e-4, 1e-6), jit="off", timing=QUICK, seconds=0.0)
    for method in {e.method.name for e in found.entries}:
        first, *finer = (e for e in found.entries if e.method.name == method)
        assert first.solved > 0
        assert first.time.seconds > 0.0
        assert [(e.tolerance, e.solved) for e in finer] == [(1e-4, 0), (1e-6, 0)]
        assert all("more `seconds` allow it" in e.reason for e in finer)


LOAD = "import itertools\nfor k in itertools.count():\n    k * k"


@pytest.fixture
def loaded():
    """Two busy processes."""
    busy = [subprocess.Popen([sys.executable, "-c", LOAD]) for _ in range(2)]
    yield
    for one in busy:
        one.kill()
        one.wait()


@pytest.mark.soak
@pytest.mark.parametrize("name", ["crank_rocker", "jansen", "stephenson_3_far"])
def test_ten_runs_under_load_give_the_same_advice(name, loaded):
    """A dyadic mechanism is solved fastest by `auto`, about as fast as by a trace of 100 000 steps."""
    mechanism, advice = load(MODELS / f"{name}.yaml"), set()
    for _ in range(10):
        found = tradeoff(mechanism, jit="on", timing=Timing(), seconds=10.0)
        advice.add(
            tuple((a.digits, a.best and (a.best.method.options, a.best.tolerance), a.reference) for a in advise(found))
        )
    assert len(advice) == 1
    if name == "stephenson_3_far":
        return
    assert all(best[0] == "--method auto" and other is None for _, best, other in advice.pop())
    assert {e.method.name for e in found.entries if e.efficient} == {"auto"}

    def taken(steps):
        began = time.process_time()
        trace(mechanism, steps, Options(jit="on"))
        return time.process_time() - began

    whole, fixed = (np.median([taken(steps) for _ in range(9)]) for steps in (100_000, 1))
    position = (whole - fixed) / 100_000
    ratios = [e.time.seconds / position for e in of(found, "auto")]
    assert all(1.0 / 1.5 < ratio < 1.5 for ratio in ratios), ratios


@pytest.mark.soak
def test_a_comparison_takes_at_most_ten_seconds(model):
    mechanism = load(model)
    tradeoff(mechanism, timing=QUICK)  # compiles
    began = time.process_time()
    tradeoff(mechanism, timing=Timing(), seconds=10.0)
    assert time.process_time() - began < 10.0
