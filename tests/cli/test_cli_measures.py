"""Columns, reports and pictures of `gim trace --measure --plot` and `gim solve --velocities`."""

from __future__ import annotations

import csv
import json
import math
import struct
from itertools import pairwise

import numpy as np
import pytest
from bundled import MODELS, run_model
from drawn_styles import strokes
from in_process import printed as gim, refused
from table_graphs import graph_of

from gimcli import load
from gimcli.motion.solve import solve
from gimcli.output.curves import drawn_runs
from gimcli.output.drawing import position_picture
from gimcli.output.panels import panel
from gimcli.output.vectors import PENS, Arrows, Field
from gimcli.positions.options import Options
from gimcli.quantities.kinds import KINDS
from gimcli.quantities.motion_table import abscissa
from gimcli.rates.derivatives import instant, law_time
from gimcli.table import Column, Table

FOUR_BAR = MODELS / "crank_rocker.yaml"


def rows_of(path):
    with path.open(newline="") as handle:
        return list(csv.DictReader(handle))


def size_of(path):
    return struct.unpack(">II", path.read_bytes()[16:24])


# --- trace -----------------------------------------------------------------------------------------------


def test_measures_are_columns_and_ranges(tmp_path):
    report = json.loads(
        gim("trace", FOUR_BAR, "-n", 90, "-m", "transmission", "-m", "area:crank", "--json", "-o", tmp_path)
    )
    rows = rows_of(tmp_path / "crank_rocker.csv")
    mu = [float(row["transmission:coupler/rocker"]) for row in rows]
    found = report["measures"]["transmission:coupler/rocker"]
    column = found["columns"]["transmission:coupler/rocker"]
    # minimum and maximum are where crank and frame are in line (law of cosines)
    ends = [math.degrees(math.acos((120**2 + 80**2 - far**2) / (2 * 120 * 80))) for far in (60, 140)]
    assert [column["least"], column["greatest"]] == pytest.approx(ends, abs=1e-9)
    assert [min(mu), max(mu)] == pytest.approx(ends, abs=1e-9)
    assert (column["unit"], column["empty"], column["infinite"]) == ("deg", 0, False)
    area = report["measures"]["area:crank"]
    assert area["area"] == pytest.approx(math.pi * 1600, rel=1e-5)
    assert abs(area["area"] - math.pi * 1600) <= area["error"]
    assert area["unit"] == "mm^2"
    assert list(rows[0])[-3:] == ["residual", "sweeps", "status"]


def test_plotted_quantities_are_columns_and_graphs(tmp_path):
    gim("trace", FOUR_BAR, "-n", 24, "-o", tmp_path / "plain")
    gim("trace", FOUR_BAR, "-n", 24, "-o", tmp_path / "more", "--plot", "velocity,alpha,transmission")
    plain, more = (tmp_path / name / "crank_rocker" for name in ("plain", "more"))
    heads = [list(rows_of(p.with_suffix(".csv"))[0]) for p in (plain, more)]
    assert not any("v" in h.partition(".")[2] for h in heads[0][2:])
    assert {"P.vx", "P.ay", "crank.alpha", "transmission:coupler/rocker"} <= set(heads[1])
    assert "P.jx" not in heads[1]
    gim("trace", FOUR_BAR, "-n", 2, "-o", tmp_path / "most", "--plot", "velocity", "-d", 3)
    assert "P.jx" in rows_of(tmp_path / "most" / "crank_rocker.csv")[0], (
        "the requested derivatives, although the graph needs fewer"
    )
    assert size_of(more.with_suffix(".png"))[1] > size_of(plain.with_suffix(".png"))[1] + 3 * 150


def test_a_centrode_far_away_does_not_shrink_the_mechanism(tmp_path):
    """The centre of the coupler moves to infinity; the picture is at most twice as large as the mechanism."""
    from gimcli.output.drawing import motion_picture

    run = run_model("crank_rocker", 36)
    poses = run.mechanism.to_file(run.motion.z[:, ::6].T)
    far = np.array([0, 50, 1e6 + 1e6j, 60, np.nan, 1e9])
    plain = motion_picture(run.mechanism, poses, {}, "t")
    picture = motion_picture(run.mechanism, poses, {}, "t", {"centrode": far.astype(complex)})
    assert picture.frame.high.real - picture.frame.low.real < 2.0 * (plain.frame.high.real - plain.frame.low.real)
    assert picture.legend[0][0] == "centrode"


def test_a_curve_of_two_laps_is_drawn_once():
    """Dashes drawn over dashes would look like a full line. A curve of one and a half laps is not changed."""
    circle = np.exp(1j * np.linspace(0.0, 4.0 * np.pi, 361))
    (twice,) = drawn_runs(circle, 0.01)
    assert np.sum(np.abs(np.diff(twice))) == pytest.approx(2.0 * np.pi, rel=1e-3)
    (half,) = drawn_runs(circle[:271], 0.01)
    assert np.sum(np.abs(np.diff(half))) == pytest.approx(3.0 * np.pi, rel=1e-3)


def test_wrong_measures_and_graphs_are_refused_before_the_computation(tmp_path):
    for arguments, part in (
        (("--plot", "velocty"), "did you mean 'velocity'?"),
        (("--plot", "velocity", "--no-png"), "--no-png"),
        (("-m", "centre:crank/rod"), "no member 'rod'"),
        (("-m", "speed"), "known: centre, curvature, transmission, advantage, area, angle"),
    ):
        assert part in refused("trace", FOUR_BAR, *arguments, "-o", tmp_path)
    assert not list(tmp_path.iterdir())


def test_measure_help_lists_every_kind():
    listed = gim("trace", "--measure", "help")
    assert all(kind in listed for kind in KINDS)


@pytest.mark.usefixtures("unrendered")
def test_rows_that_are_not_solved_leave_the_measures_empty(tmp_path):
    (tmp_path / "model.yaml").write_text(
        "nodes: {A: [0,0], B: [4,0.5], C: [5.2,2.4], D: [4,0]}\nground: [A,D]\n"
        "links: {a: {nodes: [A,B], length: 4}, b: {nodes: [B,C], length: 1.5}, c: {nodes: [D,C], length: 2}}\n"
        "actuators: {m: {type: rotary, pivot: A, arm: B, law: {from: 20, to: 200}}}\ntrace: [C]\n"
    )
    specs = ("centre:frame/b", "curvature:C", "transmission", "advantage:m/c", "area:b")
    measures = [word for spec in specs for word in ("-m", spec)]
    plots = ["--plot", "velocity,centre,curvature,transmission,advantage,area"]
    report = json.loads(gim("trace", "-n", 90, *measures, *plots, "--json", cwd=tmp_path, code=5))
    rows = rows_of(tmp_path / "model.csv")
    own = [name for name in rows[0] if name.startswith(tuple(KINDS))]
    assert len(own) == 12
    for row in rows:
        assert all((row[name] == "") == (row["status"] != "ok") for name in own)
    assert all(column["empty"] == 0 for found in report["measures"].values() for column in found["columns"].values())


# --- panels ----------------------------------------------------------------------------------------------


def test_a_panel_names_quantity_and_units():
    x = np.linspace(0.0, 360.0, 50)
    table = Table((Column("motor", x, "deg"), Column("P", np.sin(x), "mm/s"), Column("Q", np.cos(x), "mm/s")))
    found = panel(graph_of("velocity", table), 5.0)
    assert found.labels == ("motor [deg]", "velocity [mm/s]")
    assert [name for name, _ in found.legend] == ["P", "Q"]
    dashes = [key.dash for _, key in found.legend]
    assert len(set(dashes)) == 2, "different in a grey print"
    assert found.frame.low.imag < -1.0
    assert found.frame.high.imag > 1.0


def test_a_panel_shows_most_values_of_a_curve_with_a_pole():
    """1/x: the window shows most of the values, and the curve is cut where it jumps between the infinities."""
    x = np.linspace(-1.0, 1.0, 400)
    found = panel(graph_of("advantage", Table((Column("t", x), Column("c", 1.0 / x)))), 5.0)
    assert 2.0 < found.frame.high.imag < 100.0
    (runs,) = [paths for pen, paths in strokes(found).items() if pen.width > 1.0]
    assert len(runs) == 2
    constant = panel(graph_of("omega", Table((Column("t", x), Column("c", 0.0 * x + 360.0 + 1e-13 * x)))), 5.0)
    assert constant.frame.high.imag - constant.frame.low.imag > 10.0


def test_a_panel_accepts_empty_and_infinite_values():
    x = np.linspace(0.0, 1.0, 5)
    for values in (np.full(5, np.nan), np.full(5, np.inf), np.array([np.nan, 1.0, np.inf, 2.0, np.nan])):
        found = panel(graph_of("q", Table((Column("t", x), Column("c", values)))), 5.0)
        assert np.isfinite([found.frame.low.imag, found.frame.high.imag]).all()
        assert found.frame.high.imag > found.frame.low.imag


def test_graphs_run_over_the_input_or_the_time():
    assert abscissa(run_model("crank_rocker", 8).motion).name == "motor"
    assert abscissa(run_model("five_bar", 8).motion).name == "time"
    back = {"profile": {"polynomial": [0, 90, -90]}}
    assert abscissa(run_model("crank_rocker", 8, laws={"motor": back}).motion).name == "time"


# --- solve -----------------------------------------------------------------------------------------------


def velocities(*arguments, code=0):
    return json.loads(gim("solve", *arguments, "--velocities", "--json", code=code))


def test_velocities_of_a_four_bar():
    """Norton, Design of Machinery, eqs 6.18 and 7.12: crank 2 pi rad/s at 40 deg; theta3 = 20.298, theta4 = 57.325."""
    report = velocities(FOUR_BAR, "--at", "motor=40")
    a, b, o4 = (complex(*report["nodes"][n]) for n in ("A", "B", "O4"))
    t2, t3, t4, w2 = np.angle(a), np.angle(b - a), np.angle(b - o4), 2.0 * math.pi
    assert [math.degrees(t3), math.degrees(t4)] == pytest.approx([20.298, 57.325], abs=5e-4)
    w3 = w2 * 40 * math.sin(t4 - t2) / (120 * math.sin(t3 - t4))
    w4 = w2 * 40 * math.sin(t2 - t3) / (80 * math.sin(t4 - t3))
    assert report["omega"] == pytest.approx({"crank": 360.0, "coupler": math.degrees(w3), "rocker": math.degrees(w4)})
    # alpha from the loop's second derivative: two equations in alpha3, alpha4
    e = [np.exp(1j * t) for t in (t2, t3, t4)]
    known = 40 * w2**2 * e[0] + 120 * w3**2 * e[1] - 80 * w4**2 * e[2]
    table = np.array([[(120j * e[1]).real, (-80j * e[2]).real], [(120j * e[1]).imag, (-80j * e[2]).imag]])
    alpha3, alpha4 = np.linalg.solve(table, [known.real, known.imag])
    assert report["alpha"]["coupler"] == pytest.approx(math.degrees(alpha3), rel=1e-9)
    assert report["alpha"]["rocker"] == pytest.approx(math.degrees(alpha4), rel=1e-9)
    assert complex(*report["velocities"]["B"]) == pytest.approx(80j * w4 * e[2])
    assert complex(*report["accelerations"]["B"]) == pytest.approx((80j * alpha4 - 80 * w4**2) * e[2])
    p = (b - a) / 120 * (60 + 40j)
    assert complex(*report["velocities"]["P"]) == pytest.approx(40j * w2 * e[0] + 1j * w3 * p)
    assert set(report["velocities"]) == set(report["nodes"]) | set(report["points"])
    assert report["input_rates"]["motor"] == pytest.approx({"rate": 360.0, "acceleration": 0.0, "time": 1 / 9})


def test_the_input_rate_is_that_of_the_law_at_this_value(tmp_path):
    """Quintic, 0 to 90 deg in 2 s: in the middle 15/8 of the mean speed and no acceleration; at rest at the start."""
    text = FOUR_BAR.read_text().replace("{from: 0, to: 360}", "{from: 0, to: 90, profile: quintic}")
    (tmp_path / "m.yaml").write_text(text + "\nduration: 2\n")
    half = velocities(tmp_path / "m.yaml", "--at", "motor=45")
    assert half["input_rates"]["motor"] == pytest.approx(
        {"rate": 45 * 15 / 8, "acceleration": 0.0, "time": 1.0}, abs=1e-9
    )
    start = velocities(tmp_path / "m.yaml")
    assert all(v == [0.0, 0.0] for v in start["velocities"].values())
    quarter = velocities(tmp_path / "m.yaml", "--at", "motor=10")["input_rates"]["motor"]
    s = quarter["time"] / 2
    assert 90 * (10 * s**3 - 15 * s**4 + 6 * s**5) == pytest.approx(10.0, rel=1e-12)
    assert quarter["rate"] == pytest.approx(45 * (30 * s**2 - 60 * s**3 + 30 * s**4), rel=1e-9)
    assert quarter["acceleration"] == pytest.approx(22.5 * (60 * s - 180 * s**2 + 120 * s**3), rel=1e-9)


def test_at_a_value_outside_the_law_the_input_rate_is_one():
    report = velocities(FOUR_BAR, "--at", "motor=50", "--set", "motor.to=40")
    assert report["input_rates"]["motor"] == {"rate": 1.0, "acceleration": 0.0, "time": None}
    assert report["omega"]["crank"] == pytest.approx(1.0)
    ram = velocities(MODELS / "platform_3rpr.yaml", "--at", "ram_2=20")
    assert ram["input_rates"]["ram_2"]["rate"] == 1.0
    assert ram["input_rates"]["ram_1"]["time"] == 0.0


def test_the_first_time_is_used_if_a_law_has_a_value_twice():
    run = run_model("crank_rocker", 4, laws={"motor": {"profile": {"polynomial": [0, 360, -360]}}})
    (motor,) = run.mechanism.actuators
    assert law_time(motor, math.radians(67.5)) == pytest.approx(0.25, abs=1e-12)
    assert math.isnan(law_time(motor, math.radians(95.0)))


def test_a_singular_position_has_a_status_and_no_velocities():
    report = velocities(MODELS / "parallelogram.yaml", "--at", "motor=0", code=5)
    assert report["status"] == "ok"
    assert report["velocity_status"] == "singular"
    assert report["velocities"] == report["accelerations"] == report["omega"] == report["alpha"] == {}
    text = gim("solve", MODELS / "parallelogram.yaml", "--at", "motor=0", "--velocities", code=5)
    assert "singular" in text
    assert "omega" not in text


@pytest.mark.few
def test_velocities_are_differences_of_positions(model):
    """The differences are of two close positions that are solved separately, without derivatives."""
    mechanism = load(model)
    middle = np.array([float(a.law(np.array([0.4]))[0]) for a in mechanism.actuators])
    z = solve(mechanism, middle, Options()).z
    found = instant(mechanism, middle, z)
    h = 1e-5
    sides = []
    for sign in (-1.0, 1.0):
        shifted = middle + sign * h * found.given[1] + 0.5 * h**2 * found.given[2]
        there = solve(mechanism, shifted, Options(tolerance=1e-13))
        sides.append(there.z)
    assert not found.singular
    assert np.isfinite(sides).all()
    speed = (sides[1] - sides[0]) / (2.0 * h)
    velocity = found.rates.nodes[1, :, 0]
    assert np.max(np.abs(speed - velocity)) < 1e-5 * max(1.0, np.max(np.abs(found.rates.nodes[1:])))


def test_the_vector_picture(tmp_path):
    """Arrows start at their points; each kind has one scale, and a scale bar with a round value."""
    text = gim("solve", FOUR_BAR, "--at", "motor=40", "--velocities", "--png", tmp_path / "v.png")
    assert "its law at 0.111111 s" in text
    assert (tmp_path / "v.png").read_bytes().startswith(b"\x89PNG")
    mechanism = load(FOUR_BAR)
    inputs = np.array([math.radians(40.0)])
    z = solve(mechanism, inputs, Options()).z
    found = instant(mechanism, inputs, z)
    places = dict(zip(mechanism.nodes, mechanism.to_file(z).tolist(), strict=True))
    kinds = [
        Arrows(name, "u", {n: (p, found.of_points(k)[n]) for n, p in places.items()})
        for k, name in ((1, "velocity"), (2, "acceleration"))
    ]
    picture = position_picture(mechanism, mechanism.to_file(z), "t", {}, kinds)
    for k, kind in enumerate(kinds):
        paths = [path for path in strokes(picture)[PENS[k]] if len(path) == 2]
        starts = {complex(np.round(path[0], 9)) for path in paths}
        moving = [n for n, (_, v) in kind.vectors.items() if abs(v) > 1e-6]
        assert {complex(np.round(places[n], 9)) for n in moving} <= starts
        assert len(paths) == len(moving) + 1
        bar = next(t.text for t in picture.texts if t.text.startswith(kind.name))
        value = float(bar.split()[1])
        assert kind.greatest / 2.5 <= value <= kind.greatest
        for n in moving:  # the line of an arrow ends 0.6 of a head before the tip
            line = next(path for path in paths if abs(path[0] - places[n]) < 1e-9)
            along = np.diff(line)[0] / kind.vectors[n][1]
            assert abs(along.imag) < 1e-9 * abs(along), "parallel to the vector"
            low, high = picture.frame.low, picture.frame.high
            tip = places[n] + Field(kinds, np.array(list(places.values()))).scale(kind) * kind.vectors[n][1]
            assert low.real < tip.real < high.real
            assert low.imag < tip.imag < high.imag


def test_an_arrow_that_leaves_the_mechanism_is_not_clipped():
    """Only the pin of the rocker has a vector, which points away from the mechanism."""
    mechanism = load(FOUR_BAR)
    z = mechanism.to_file(mechanism.drawn)
    arrows = Arrows("velocity", "mm/s", {"B": (complex(z[3]), 7.0 + 0.0j)})
    picture = position_picture(mechanism, z, "t", {}, [arrows])
    assert picture.frame.high.real > z[3].real + 0.29 * np.ptp(z.real)


def test_a_mechanism_at_rest_has_no_arrows(tmp_path):
    text = FOUR_BAR.read_text().replace("{from: 0, to: 360}", "{from: 0, to: 90, profile: quintic}")
    (tmp_path / "m.yaml").write_text(text)
    gim("solve", tmp_path / "m.yaml", "--velocities", "--png", tmp_path / "v.png")
    assert (tmp_path / "v.png").is_file()


# --- layout ----------------------------------------------------------------------------------------------


def test_nothing_of_a_stacked_picture_is_clipped_or_overlaps():
    """All texts are inside the figure; axes with their labels do not overlap."""
    from canvases import canvas_of
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from gimcli.output.drawing import motion_picture
    from gimcli.output.panels import with_panels

    run = run_model("crank_rocker", 36)
    picture = motion_picture(run.mechanism, run.mechanism.to_file(run.motion.z[:, ::6].T), {"P": run.xy("P")}, "title")
    x = Column("motor", run.value["motor"], "deg")
    curves = [Column(f"point number {k}", 9.7e5 * np.sin(k + 0.1 * x.values), "mm/s^3") for k in range(9)]
    small = [Column("c", -1e-7 * np.cos(x.values), "1/mm")]
    tables = {"jerk": (x, *curves), "curvature": (x, *small), "alpha": (x, *curves[:2])}
    sheet = with_panels(picture, [graph_of(name, Table(columns)) for name, columns in tables.items()])
    canvas = canvas_of(FigureCanvasAgg, sheet)
    canvas.draw()
    figure = canvas.figure
    whole, renderer = figure.bbox, canvas.get_renderer()
    boxes = [axes.get_tightbbox(renderer) for axes in figure.axes]
    legends = [legend.get_window_extent(renderer) for legend in figure.legends]
    assert (len(boxes), len(legends)) == (4, 3), "no legend under a single curve"
    for box in boxes + legends + [text.get_window_extent(renderer) for text in figure.texts]:
        assert whole.x0 <= box.x0
        assert box.x1 <= whole.x1
        assert whole.y0 <= box.y0
        assert box.y1 <= whole.y1
    everything = sorted(boxes + legends, key=lambda box: -box.y1)
    for upper, lower in pairwise(everything):
        assert lower.y1 <= upper.y0 + 1.0, "one above the other"


def test_a_structure_without_inputs_has_zero_velocities(tmp_path):
    (tmp_path / "model.yaml").write_text(
        "nodes: {A: [0,0], B: [4,0], C: [2,3]}\nground: [A,B]\nlinks: {a: [A,C], b: [B,C]}\n"
    )
    report = velocities(tmp_path / "model.yaml")
    assert report["velocity_status"] == "ok"
    assert report["velocities"] == {"A": [0.0, 0.0], "B": [0.0, 0.0], "C": [0.0, 0.0]}
    assert report["input_rates"] == {}


def test_plot_may_be_repeated(tmp_path):
    """Two options draw what one list draws."""
    for path, options in (
        ("a.svg", ["--plot", "omega", "--plot", "velocity"]),
        ("b.svg", ["--plot", "omega,velocity"]),
    ):
        gim("trace", MODELS / "crank_rocker.yaml", "-n", 12, *options, "-o", tmp_path / path)
    one, other = ((tmp_path / path).read_text() for path in ("a.svg", "b.svg"))
    assert one == other
    assert "omega" in one
