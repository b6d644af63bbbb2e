"""`gimcli.fit` and `gim fit`: known least errors through the whole command; the written file passes the targets."""

import csv
import json
import math

import numpy as np
import pytest
from bundled import ROOT
from four_bar_positions import NAMES, FourBarPoint
from in_process import gim, refused
from path_problems import NINE_POINT_LENGTHS, PROBLEMS

from gimcli import UsageError, assembled, fit, load, loads, trace
from gimcli.families.design_state import position_items
from gimcli.families.family import Family
from gimcli.fitting.conditions import DesignQuantities
from gimcli.fitting.least_squares import FitProblem, Trials
from gimcli.fitting.motion_quantity import MotionQuantity
from gimcli.library.fit_targets import columns_of, task_of
from gimcli.library.fitted_design import TargetChecker

FOUR_BAR = ROOT / "examples" / "four_bar.yaml"


def vary(name):
    """Return the bounds of a path problem by the names of the dimensions, angles in deg."""
    lower, upper = PROBLEMS[name].bounds
    turn = np.where(np.array(NAMES) == "theta0", 180.0 / math.pi, 1.0)
    return {n: (low, high) for n, low, high in zip(NAMES, lower * turn, upper * turn, strict=True) if low < high}


def columns(name):
    one = PROBLEMS[name]
    z = np.array(one.targets)
    found = {"x": z.real, "y": z.imag}
    if one.second:
        found |= {"x2": np.array(one.second).real, "y2": np.array(one.second).imag}
    return found | ({"input": np.array(one.inputs)} if one.inputs else {})


def fitted(name, **options):
    return fit(load(FOUR_BAR), vary(name), columns(name), timing=PROBLEMS[name].timing, **options)


@pytest.fixture(scope="module")
def family():
    return Family(load(FOUR_BAR), NAMES)


def test_derivatives_are_those_of_the_closed_form(family):
    generator = np.random.default_rng(1)
    lower, upper = [3, 1, 3, 2.5, -3, -3, 0, -3, -3], [4.5, 1.5, 4, 4, 3, 3, 360, 3, 3]
    designs = generator.uniform(lower, upper, (40, 9))
    inputs = np.tile(np.linspace(0.0, 6.0, 7), (40, 1))
    found = MotionQuantity(family, position_items(family.mechanism, "P")).rates(designs, inputs)
    turned = designs * np.where(np.arange(9) == 6, math.pi / 180.0, 1.0)
    known = FourBarPoint().rates(turned, inputs)
    good = np.isfinite(found.values).all(axis=(1, 2))
    assert good.sum() > 30
    assert found.values[good] == pytest.approx(known.values[good], abs=1e-9)
    assert found.by_input[good] == pytest.approx(known.by_input[good], abs=1e-8)
    slopes = known.by_dimension * np.where(np.arange(9) == 6, math.pi / 180.0, 1.0)
    assert found.by_dimension[good] == pytest.approx(slopes[good], abs=1e-8)


def test_derivatives_of_directions_are_differences(family):
    quantity = MotionQuantity(
        family, [*position_items(family.mechanism, "follower"), *position_items(family.mechanism, "B.x")]
    )
    design, inputs, h = family.nominal[None], np.array([[0.3, 1.2, 2.0]]), 1e-6
    rates = quantity.rates(design, inputs)
    for k in range(4):
        step = np.eye(9)[k] * h
        change = (quantity.values(design + step, inputs) - quantity.values(design - step, inputs)) / (2 * h)
        assert rates.by_dimension[..., k] == pytest.approx(change, abs=1e-7)
    change = (quantity.values(design, inputs + h) - quantity.values(design, inputs - h)) / (2 * h)
    assert rates.by_input == pytest.approx(change, abs=1e-7)


@pytest.mark.parametrize("name", ["L5", "S6"])
def test_given_inputs(name):
    found = fitted(name, starts=300)
    assert found.error == pytest.approx(PROBLEMS[name].error, rel=2e-8)
    assert found.report()["starts"]["hits"] > 5
    assert found["distance"] @ found["distance"] == pytest.approx(found.error, rel=1e-9)


def test_pairs():
    """The error of pairs is that of their middles, twice, and half of the squared distances of the pairs."""
    one = PROBLEMS["P10"]
    pairs = np.array([one.targets, one.second])[:, ::2]
    middles = pairs.mean(axis=0)
    bounds = {"r2": (0.5, 1.5), "rcx": (-3.0, 3.0), "rcy": (-3.0, 3.0), "x0": (-3.0, 3.0), "y0": (-3.0, 3.0)}
    columns = {"x": pairs[0].real, "y": pairs[0].imag, "x2": pairs[1].real, "y2": pairs[1].imag}
    found = fit(load(FOUR_BAR), bounds, columns, starts=200)
    place = found["P.x"] + 1j * found["P.y"]
    assert found.error == pytest.approx(np.sum(np.abs(pairs - place) ** 2), rel=1e-9)
    known = 2.0 * np.sum(np.abs(middles - place) ** 2) + 0.5 * np.sum(np.abs(pairs[0] - pairs[1]) ** 2)
    assert found.error == pytest.approx(known, rel=1e-9)
    assert found["distance"] @ found["distance"] == pytest.approx(found.error, rel=1e-9)
    assert found.rms == pytest.approx(math.sqrt(found.error / pairs.size), rel=1e-12)


def test_nine_points():
    found = fitted("N9", starts=2500)
    assert found.error < 1e-25
    lengths = [found.dimensions[name] for name in NAMES[:4]]
    assert np.abs(np.array(NINE_POINT_LENGTHS) - lengths).max(axis=1).min() < 1e-9


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", PROBLEMS)
def test_least_errors(name, seed):
    known = {"V6": 1e-16, "L5": 7.49e-7, "C18": 9.12e-3, "E10": 4.06e-4, "S6": 2.607, "P10": 0.2749584, "N9": 1e-16}
    assert fitted(name, seed=seed).error <= known[name]


def test_written_model_passes_the_targets(tmp_path):
    """The file has the fitted numbers in place; its own trace meets the targets of the table."""
    targets, model = tmp_path / "v6.csv", tmp_path / "fitted.yaml"
    with targets.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerows([["x", "y"], *([z.real, z.imag] for z in PROBLEMS["V6"].targets)])
    bounds = [f"--vary={name}={low}:{high}" for name, (low, high) in vary("V6").items()]
    done = gim("fit", FOUR_BAR, *bounds, "--through", targets, "--starts", 300, "--json", "-o", model)
    assert done.code == 0, done.error
    old, new = FOUR_BAR.read_text().splitlines(), model.read_text().splitlines()
    changed = [line.split(":")[0].strip() for line, other in zip(old, new, strict=True) if line != other]
    assert set(changed) <= {"parameters", "A", "B"}
    motion = trace(load(model), 3600)
    path = motion.xy["P"] @ [1, 1j]
    assert max(np.min(np.abs(path - z)) for z in PROBLEMS["V6"].targets) < 0.2
    assert done.json["error"] < 1e-16
    at = [round(u * 10) for u in done.json["inputs"]]
    assert np.max(np.abs(path[at] - np.array(PROBLEMS["V6"].targets))) < 0.1


def test_function():
    """Three precision points of a function have one solution (Freudenstein): y = log10 x of the references."""
    mechanism = load(FOUR_BAR).with_({"r1": 1, "r2": 0.6, "r3": 1.2, "r4": 0.6})
    phi = [49.01923788646684, 75.0, 100.9807621135332]
    psi = [8.418870160197133, 52.64662506490406, 85.57660058206368]
    bounds = {"r2": (0.05, 20.0), "r3": (0.05, 20.0), "r4": (0.05, 20.0)}
    law = mechanism.with_({"motor.from": 45, "motor.to": 105})
    found = fit(law, bounds, {"input": phi, "output": psi}, output="follower.angle", starts=600)
    assert found.error < 1e-18
    lengths = [found.dimensions[name] for name in bounds]
    assert lengths == pytest.approx([0.6525857408811186, 1.170609285983374, 0.5281106634575285], abs=1e-9)


FUNCTION = """
units: {length: unit, angle: deg}
parameters: {a: 2, b: 2.2, c: 2, phi0: 60, psi0: 90}
nodes: {O: [0, 0], O4: [cos(phi0*deg), -sin(phi0*deg)], A: [a, 0], B: [0.3, -2], Q: [1.5, -0.8]}
ground: [O, O4]
links: {crank: {nodes: [O, A], length: a}, coupler: {nodes: [A, B], length: b}}
elements:
  rocker: {nodes: [O4, Q, B], shape: {O4: [0, 0], Q: [1, 0], B: [c*cos(psi0*deg), c*sin(psi0*deg)]}}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {from: 0, to: 90}}}
"""
"""A four-bar with frame 1, whose input and output are measured from directions phi0 and psi0."""


def test_function_with_least_squares():
    """y = x^1.5 from 1 to 4, both turned by 90 deg: the least error of the references (61 equidistant points)."""
    s = np.linspace(0.0, 1.0, 61)
    y = ((1.0 + 3.0 * s) ** 1.5 - 1.0) / 7.0
    bounds = dict.fromkeys("abc", (0.05, 20.0)) | dict.fromkeys(("phi0", "psi0"), (0.0, 360.0))
    targets = {"input": 90.0 * s, "output": 90.0 * y}
    found = fit(loads(FUNCTION), bounds, targets, output="rocker.angle", starts=1000)
    assert found.rms == pytest.approx(0.0028867119541, rel=1e-9)
    assert found.report()["largest"] == pytest.approx(0.0103679669, rel=2e-6)
    assert [found.dimensions[n] for n in "abc"] == pytest.approx([10.998865957, 7.152306449, 3.786525231], rel=1e-6)
    assert found.dimensions["phi0"] == pytest.approx(302.206320808, abs=1e-5)


POSES = """
units: {length: unit, angle: deg}
parameters: {ox: 0, oy: 0, qx: 4, qy: 0, r2: 1.5, r4: 3, bx: 3.5, by: 0, px: 1, py: 1}
nodes: {O: [ox, oy], O4: [qx, qy], A: [0.75, 1.3], B: [3.8, 2.99], Q: [1.6, 1.8]}
ground: [O, O4]
links: {crank: {nodes: [O, A], length: r2}, follower: {nodes: [O4, B], length: r4}}
elements: {coupler: {nodes: [A, Q, B], shape: {A: [0, 0], Q: [1, 0], B: [bx, by]}}}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {from: 0, to: 360}}}
points: {P: {on: coupler, local: [px, py]}}
"""


def test_five_poses():
    """Only two four-bars take the five poses in order on one branch; their dyads are known (Burmester)."""
    poses = np.array([
        (2.143882187, 3.595497372, 41.462636109), (-0.673257429, 3.070514712, 26.017335392),
        (-0.809155527, 0.617482031, 55.998730772), (0.873924703, 1.233125295, 70.933499297),
        (1.64194314, 2.301004135, 61.18827789),
    ])  # fmt: skip
    bounds = {n: (-15.0, 15.0) for n in ("ox", "oy", "qx", "qy", "bx", "by", "px", "py")}
    bounds |= {"r2": (0.1, 15.0), "r4": (0.1, 15.0)}
    found = fit(loads(POSES), bounds, dict(zip(("x", "y", "angle"), poses.T, strict=True)), starts=1000)
    assert found.error < 1e-24
    assert found["motor"] == pytest.approx([35.0, 155.0, 250.0, 325.0, 355.0], abs=1e-6)
    own = [found.dimensions[n] for n in ("ox", "oy", "r2")]
    assert own == pytest.approx([0.0, 0.0, 1.99999999993107], abs=2e-8)
    followers = [(6.0, 0.0, 4.49999998596008), (9.12005763796576, -4.83070224072545, 13.3072016524808)]
    second = [found.dimensions[n] for n in ("qx", "qy", "r4")]
    assert min(np.max(np.abs(np.array(second) - known)) for known in followers) < 2e-8


def test_active_condition():
    """Of two lengths the fit with a condition is not worse than the best of a fine grid, and it is on the condition."""
    mechanism, bounds = load(FOUR_BAR), {"r3": (3.0, 4.5), "r4": (2.5, 4.0)}
    targets = {"input": np.array([10.0, 80.0, 200.0]), "x": np.array([1.9, 0.8, -0.4]), "y": np.array([2.8, 3.2, 1.6])}
    free = fit(mechanism, bounds, targets, starts=500)
    held = fit(mechanism, bounds, targets, where="min(transmission) > 50", starts=500)
    least = [
        trace(m.mechanism, 360, measure="transmission")["transmission:coupler/follower"].min() for m in (free, held)
    ]
    assert least[0] < 49.0
    assert least[1] == pytest.approx(50.0, abs=1e-3)
    r3, r4 = (a.ravel() for a in np.meshgrid(np.linspace(3.0, 4.5, 121), np.linspace(2.5, 4.0, 121)))
    designs = np.column_stack([np.full_like(r3, v) for v in (4.0, 1.5)] + [r3, r4])
    designs = np.column_stack((designs, np.tile([2.0, 1.0, 0.0, 0.0, 0.0], (len(r3), 1))))
    found = FourBarPoint().values(designs, np.tile(np.radians(targets["input"]), (len(r3), 1)))
    errors = np.sum((found - np.stack((targets["x"], targets["y"]), -1)) ** 2, axis=(1, 2))
    diagonal = 4.0**2 + 1.5**2 - 2.0 * 4.0 * 1.5 * np.cos(np.linspace(0.0, math.pi, 181))[:, None]
    angle = np.degrees(np.arccos(np.clip((r3**2 + r4**2 - diagonal) / (2.0 * r3 * r4), -1.0, 1.0)))
    least = np.min(errors[angle.min(axis=0) > 50.0])
    assert free.error < held.error <= least
    assert held.error == pytest.approx(least, rel=0.02)


def test_condition_without_margin():
    """A condition that is no inequality selects among the fits."""
    made = load(FOUR_BAR).with_({"r1": 1, "r2": 3})
    known = trace(made, 6)
    targets = {"input": known["motor"][:6], "x": known.xy["P"][:6, 0], "y": known.xy["P"][:6, 1]}
    begin, bounds = made.with_({"r1": 1.1, "r2": 2.9}), {"r1": (0.5, 2.0), "r2": (2.0, 4.0)}
    found = fit(begin, bounds, targets, where="type == 'double-crank'", starts=200)
    assert [found.dimensions["r1"], found.dimensions["r2"]] == pytest.approx([1.0, 3.0], abs=1e-8)
    assert not fit(begin, bounds, targets, where="type == 'crank-rocker'", starts=200).feasible


SLIDER_CRANK = """
units: {length: mm, angle: deg}
nodes: {O: [0, 0], A: [20, 0], B: [120, 0], G: [200, 0]}
ground: [O, G]
links: {crank: {nodes: [O, A], length: 20}, rod: {nodes: [A, B], length: 100}}
prismatic: {slide: {node: B, guide: [O, G]}}
actuators: {motor: {type: rotary, pivot: O, arm: A}}
"""


def test_goal_under_a_condition():
    """The longest stroke of a slider-crank whose rod turns at most 30 deg from the guide: crank = rod sin 30 deg."""
    found = fit(
        loads(SLIDER_CRANK), {"crank.length": (10, 90)}, goal="-range(B.x)", where="max(rod.angle) < 30", starts=300
    )
    assert found.dimensions["crank.length"] == pytest.approx(50.0, rel=1e-5)
    assert found.error == pytest.approx(-100.0, rel=1e-5)
    assert found.report()["kind"] == "goal"


def test_goal_without_conditions():
    """An eccentric slider-crank has a given stroke: sqrt((l + r)^2 - e^2) - sqrt((l - r)^2 - e^2) = 60."""
    mechanism = loads(SLIDER_CRANK.replace("guide: [O, G]", "guide: [O, G], offset: 30"))
    found = fit(mechanism, {"crank.length": (5, 60)}, goal="(range(B.x) - 60)**2", starts=100)
    r = found.dimensions["crank.length"]
    stroke = math.sqrt((100 + r) ** 2 - 900) - math.sqrt((100 - r) ** 2 - 900)
    assert stroke == pytest.approx(60.0, abs=0.01)


def test_a_linear_input():
    """A slider that drives a four-bar: the fit of its crank is that of the dimension that made the targets."""
    text = SLIDER_CRANK.replace(
        "{type: rotary, pivot: O, arm: A}", "{type: linear, node: B, guide: [O, G], law: {from: 90, to: 115}}"
    )
    mechanism = loads(text)
    known = trace(mechanism.with_({"crank.length": 22.5}), 5)
    targets = {"input": known["motor"], "x": known.xy["A"][:, 0], "y": known.xy["A"][:, 1]}
    found = fit(mechanism, {"crank.length": (21, 28)}, targets, point="A", starts=200)
    assert found.dimensions["crank.length"] == pytest.approx(22.5, abs=1e-9)


@pytest.mark.parametrize(
    ("model", "point", "names"),
    [("stephenson_3_far", "E", ["D.x", "CD.length"]), ("jansen", "foot", ["m.length", "c.length"])],
)
def test_dimensions_that_made_the_targets(model, point, names):
    """Of a coupled and of a dyadic linkage, with unknown inputs."""
    mechanism = load(ROOT / "models" / f"{model}.yaml")
    values = [mechanism.written.dimension(name).value for name in names]
    known = trace(mechanism, 12)
    targets = known.xy[point][[1, 4, 6, 9, 11]]
    bounds = {name: (0.9 * value, 1.1 * value) for name, value in zip(names, values, strict=True)}
    begin = mechanism.with_({names[0]: 1.01 * values[0]})
    found = fit(begin, bounds, targets, point=point, starts=100)
    assert found.error < 1e-12 * np.sum((targets - targets.mean(axis=0)) ** 2)
    assert [found.dimensions[name] for name in names] == pytest.approx(values, rel=1e-5)


@pytest.mark.few(6)
@pytest.mark.parametrize("law", [(360, 0), (150, 20), (20, 150), (-90, 270)])
@pytest.mark.parametrize("timing", ["free", "given", "step"])
def test_laws(law, timing):
    """Increasing and decreasing laws, of a full turn and less."""
    mechanism = load(FOUR_BAR).with_({"motor.from": law[0], "motor.to": law[1]})
    known = trace(mechanism.with_({"r2": 1.3, "rcx": 2.4}), 12)
    rows = [1, 3, 6, 8, 11]
    targets = {"x": known.xy["P"][rows, 0], "y": known.xy["P"][rows, 1]}
    if timing != "free":
        targets["motor"] = known["motor"][rows]
    found = fit(mechanism, {"r2": (1, 2), "rcx": (1, 4)}, targets, timing=timing, starts=60)
    assert found.dimensions == pytest.approx({"r2": 1.3, "rcx": 2.4}, abs=1e-8)
    assert found["motor"] == pytest.approx(known["motor"][rows], abs=1e-5)


def test_any_order():
    """Points of a curve in another order: no fit passes them in order, one passes them."""
    mechanism = load(FOUR_BAR)
    targets = trace(mechanism.with_({"r2": 1.3, "rcx": 2.4}), 12).xy["P"][[1, 7, 3, 10, 5]]
    in_order, free = (
        fit(mechanism, {"r2": (1, 2), "rcx": (1, 4)}, targets, any_order=any_order, starts=200)
        for any_order in (False, True)
    )
    assert not in_order.error < 1.0
    assert free.dimensions == pytest.approx({"r2": 1.3, "rcx": 2.4}, abs=1e-9)
    assert free["motor"] == pytest.approx([30.0, 210.0, 90.0, 300.0, 150.0], abs=1e-6)


def test_the_real_motion_decides():
    """Designs that meet all targets exactly, but not in order, not over the whole law, or on the other branch."""
    mechanism = load(FOUR_BAR)
    path = {r2: trace(mechanism.with_({"r2": r2, "motor.from": 60, "motor.to": 120}), 2).xy["P"] for r2 in (1.5, 2.7)}
    family, inputs = Family(mechanism, ["r2"]), np.radians([[60.0, 90.0, 120.0]])
    checked = {}
    for r2, sense, moved in ((1.5, 1.0, 0.0), (1.5, -1.0, 0.0), (2.7, 1.0, 0.0), (1.5, 1.0, 1.0)):
        task = task_of(mechanism, columns_of(path[r2]), "free", "P", "")
        quantity = MotionQuantity(family, task.components)
        problem = FitProblem(quantity, task.targets, np.array([1.0]), np.array([3.0]), np.array([False]))
        checker = TargetChecker(problem, task, DesignQuantities(family))
        if moved:  # the fit has solved another position than that of the model
            problem.quantity.values = lambda designs, at, own=quantity.values: own(designs, at) + 1.0
        trial = Trials(np.array([[r2]]), inputs, np.array([sense]), np.zeros(1), np.ones(1))
        checked[r2, sense, moved] = checker.checked(trial), next(iter(checker.refused), "")
    assert checked[1.5, 1.0, 0.0][0].error < 1e-20
    assert "order" in checked[1.5, -1.0, 0.0][1]
    assert "whole law" in checked[2.7, 1.0, 0.0][1]
    assert "another branch" in checked[1.5, 1.0, 1.0][1]
    assert all(found is None for key, (found, _) in checked.items() if key != (1.5, 1.0, 0.0))


def test_nothing_feasible(tmp_path):
    """A coupler point that stays within 2 of a fixed place cannot reach targets that are 50 apart in order."""
    targets = tmp_path / "far.csv"
    targets.write_text("x,y\n100,0\n100,50\n")
    files = [tmp_path / f"f.{suffix}" for suffix in ("yaml", "csv", "npz", "png", "html", "json")]
    written = [word for file in files for word in ("-o", file)]
    done = gim("fit", FOUR_BAR, "--vary", "r2=30:40", "--through", targets, "--starts", 200, "--json", *written)
    assert done.code == 5
    assert not done.json["feasible"]
    assert done.json["reason"]
    assert [file.name for file in files if file.exists()] == ["f.json"]


@pytest.mark.parametrize(
    ("options", "part"),
    [
        (["--vary", "r2=1:3"], "--through"),
        (["--vary", "r2=1", "--through", "t.csv"], "NAME=LOW:HIGH"),
        (["--vary", "r2=3:1", "--through", "t.csv"], "a greater"),
        (["--vary", "r9=1:3", "--through", "t.csv"], "r9"),
        (["--through", "t.csv"], "at least one dimension"),
        (["--vary", "r2=1:3", "--through", "none.csv"], "none.csv"),
        (["--vary", "r2=1:3", "--through", "t.csv", "--timing", "given"], "no column `input`"),
        (["--vary", "r2=1:3", "--through", "t.csv", "--point", "Q"], "'Q'"),
        (["--vary", "r2=1:3", "--through", "f.csv"], "--output"),
        (["--vary", "r2=1:3", "--through", "f.csv", "--output", "follow.angle"], "follower.angle"),
        (["--vary", "r2=1:3", "--through", "w.csv"], "line 3"),
        (["--vary", "r2=1:3", "--vary", "B.y=1:3", "--through", "t.csv"], "vary B.y: it changes no length"),
        (["--vary", "r2=1:3", "--through", "s.csv"], "semicolons"),
        (["--vary", "r2=1:3", "--through", "two.csv"], "input and motor are the same"),
        (["--vary", "r2=-1e308:1e308", "--through", "t.csv"], "finite"),
        (["--vary", "r2=1:3", "--through", "t.csv", "-o", "t.csv"], "choose another name"),
    ],
)
def test_refusals(options, part, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.csv").write_text("x,y\n2,3\n1,3\n")
    (tmp_path / "f.csv").write_text("input,output\n20,30\n30,40\n")
    (tmp_path / "w.csv").write_text("x,y\n2,3\n1,a\n")
    (tmp_path / "s.csv").write_text("x;y\n2;3\n1;3\n")
    (tmp_path / "two.csv").write_text("input,motor,x,y\n1,1,2,3\n2,2,1,3\n")
    assert part in refused("fit", FOUR_BAR, *options)


def test_reasons():
    mechanism, bounds = load(FOUR_BAR), {"r2": (1.0, 1.9)}
    targets = {"input": [10, 80, 200], "x": [1.9, 0.8, -0.4], "y": [2.8, 3.2, 1.6]}
    found = fit(mechanism, bounds, targets, where="min(transmission) > 100", starts=100)
    assert "conditions" in found.headline()
    found = fit(mechanism, bounds, targets, where="r2 == 1.5", starts=100)
    assert not found.feasible
    assert "conditions" in found.report()["reason"]


def test_fitted_file_of_another_assembly(tmp_path):
    """The file gets the initial coordinates of the assembly that was fitted."""
    other = assembled(load(FOUR_BAR), assembly=1)
    targets = trace(other.with_({"r2": 1.2, "rcy": 1.4}), 12).xy["P"][[1, 3, 5, 8]]
    found = fit(other, {"r2": (1.0, 1.8), "rcy": (0.5, 2.0)}, targets, starts=100)
    assert found.dimensions == pytest.approx({"r2": 1.2, "rcy": 1.4}, abs=1e-9)
    found.save(tmp_path / "fitted.yaml")
    path = trace(load(tmp_path / "fitted.yaml"), 12).xy["P"]
    assert path[[1, 3, 5, 8]] == pytest.approx(targets, abs=1e-8)


@pytest.mark.parametrize(
    "through",
    [
        [[1, 2], [1]], [["a", "b"]], [[1, 2, 3]], [1, 2], {"x": ["a", 1], "y": [1, 2]}, {"x": 1, "y": 2},
        {"x": [[1], [2]], "y": [[1], [2]]}, {"x": [1, 2], "y": [1]}, {"x": [1, 10**400], "y": [1, 2]},
    ],
)  # fmt: skip
def test_targets_that_are_no_columns_are_refused(through):
    with pytest.raises(UsageError):
        fit(load(FOUR_BAR), {"r2": (1.0, 1.8)}, through)


@pytest.fixture(scope="module")
def six():
    return fitted("S6", starts=20, seed=3)


def test_same_seed_same_design():
    one, other = (fitted("S6", starts=10, seed=3) for _ in range(2))
    assert one.dimensions == other.dimensions


def test_report_is_complete_json(six):
    report = json.loads(json.dumps(six.report()))
    assert {"error", "rms", "dimensions", "transmission", "starts", "feasible", "inputs"} <= set(report)
