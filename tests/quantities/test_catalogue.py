"""Every quantity in every place: the same numbers in traces, forces, graphs, sweeps and sensitivities, by one name."""

import numpy as np
import pytest
from bundled import MODELS

import gimcli
from gimcli import UsageError
from gimcli.quantities.catalogue import catalogue

STEPS = 12
MORE = (
    "transmission", "distance:{a}/{b}", "angle:{m}", "curvature:{p}", "centre:frame/{m}", "area:{m}.signed",
    "hypot({p}.x - 1, {p}.y)", "|{p}.v|", "|{p}|", "(({p}.x + {a}.x) / 2)", "max({p}.x, {a}.x)",
)  # fmt: skip
FORCES = ("crank_press", "toggle_clamp", "slider_crank")
SWEPT = {"crank_press": "crank.length", "crank_rocker": "crank.length", "slider_crank": "rod.length"}


def asked(m):
    """Return the names of all columns, and some quantities with arguments."""
    at = {"p": m.traced[0], "a": m.nodes[1], "b": m.nodes[2], "m": m.members[2].name}
    return [*catalogue(m).columns, *(text.format(**at) for text in MORE)]


def named(m, text):
    """Return the columns that a quantity adds to a trace."""
    items = catalogue(m).find(text)
    return [item.head.name for item in items] if items and not text.startswith("|") else [text]


@pytest.fixture(scope="module", params=["crank_press", "crank_rocker", "slider_crank"])
def traced(request):
    """A model, its quantities, and a trace with all of them as measures."""
    m = gimcli.load(MODELS / f"{request.param}.yaml")
    texts = asked(m)
    return m, texts, gimcli.trace(m, STEPS, measure=texts)


def alike(found, expected, size=1.0):
    found, expected = (np.asarray(values, dtype=float) for values in (found, expected))
    finite = np.isfinite(expected)
    np.testing.assert_array_equal(np.isfinite(found), finite)
    room = 1e-9 * (size + np.max(np.abs(expected[finite]), initial=0.0))
    assert np.max(np.abs(found - expected)[finite], initial=0.0) <= room


def test_columns_of_a_trace_are_those_of_its_derivatives(traced):
    m, _, t = traced
    whole = gimcli.trace(m, STEPS, derivatives=3).table()
    for column in whole.columns:
        if column.values.dtype.kind == "f" and column.name in catalogue(m).columns:
            alike(t[column.name], column.values)


def test_forces_are_those_of_the_forces_command(traced):
    m, _, t = traced
    if m.dynamics.empty:
        pytest.skip("no masses, loads or springs")
    found = gimcli.forces(m, STEPS)
    names = [name for name in found if name in set(catalogue(m).columns)]
    assert len(names) > 10
    for name in names:
        alike(t[name], found[name])


def test_graphs_show_the_same_numbers(traced):
    m, texts, t = traced
    for text in texts:
        names = named(m, text)
        if text.startswith("transmission") or len(names) > 2:
            continue
        (graph, *_) = gimcli.trace(m, STEPS, plot=text).graphs()
        shown = {curve.name: curve.y for curve in graph.curves}
        for name in names:
            alike(shown[name], t[name])


def test_sweeps_keep_the_same_numbers_in_each_row(traced):
    m, texts, t = traced
    motor = m.actuators[0].name
    dimension = SWEPT[m.path.stem]
    row = 4
    columns = [name for text in texts for name in named(m, text)]
    keep = [f"at({name}, {motor}={float(t[motor][row])!r})" for name in columns]
    own = m.written.dimension(dimension).value
    found = gimcli.sweep(m, {dimension: [own]}, steps=STEPS, keep=keep)
    for name, text in zip(columns, keep, strict=True):
        if name not in ("step", "residual"):
            alike(found[" ".join(text.split())][0], t[name][row], 1e-3)


def test_derivatives_are_differences(traced):
    """Of what has derivatives by dimensions: positions, directions, distances, transmission angles."""
    m, texts, _ = traced
    dimension, motor = SWEPT[m.path.stem], m.actuators[0]
    own = m.written.dimension(dimension).value
    start = float(m.inputs_to_file(m.start_inputs)[motor.name]) + 20.0
    known, step = 0, 1e-4 * own
    changed = [m.with_({dimension: own + sign * step}) for sign in (1.0, -1.0)]
    for text in texts:
        try:
            found, *ends = (
                gimcli.sensitivity(one, of=text, by=dimension, samples=0, at={motor.name: start})
                for one in (m, *changed)
            )
        except UsageError:
            continue
        for name in found.names:
            change = ends[0].value[name] - ends[1].value[name]
            assert found.derivatives[name][dimension] == pytest.approx(change / (2.0 * step), rel=1e-6, abs=1e-5)
            known += 1
    assert known > 8


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("max(P.x)", "expected a column, with a value for each row"), ("P.z", "did you mean 'P."),
        ("hypot(P.x, rocker.angle)", "needs equal units, got mm and deg"), ("P.x + time", "needs equal units"),
        ("distance:P/P", "two different points"), ("distance:P/Q", "no point or node 'Q'"), ("P.x > 3", "write for"),
        ("rocker.effort", "no column or measure 'rocker.effort'"), ("at(P.x, motor=3)", "is one row"),
    ],
)  # fmt: skip
def test_what_is_no_column_is_refused_in_one_sentence(text, part):
    with pytest.raises(UsageError) as found:
        gimcli.trace(gimcli.load(MODELS / "crank_rocker.yaml"), 4, measure=text)
    assert part in str(found.value)
    assert "\n" not in str(found.value)


def test_units_of_expressions():
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    units = {
        "P.x + 3": "mm", "hypot(P.x, P.y - 2)": "mm", "sqrt(P.x*P.x)": "", "P.x * 2": "", "|P.v|": "mm/s",
        "min(P.x, 4)": "mm", "-P.x": "mm", "rocker.angle - crank.angle": "deg", "abs(rocker.omega)": "deg/s",
    }  # fmt: skip
    table = gimcli.trace(m, 2, measure=list(units)).table()
    assert {c.name: c.unit for c in table.columns if c.name in units} == units


def test_first_last_and_integral_of_a_sweep():
    """One turn of the crank: the integral of x over the input is that of the trapezoidal rule."""
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    keep = ["first(P.x)", "last(P.x)", "integral(P.x)", "argmax(P.x)", "argmin(P.x)"]
    s, t = gimcli.sweep(m, {"crank.length": [40.0]}, steps=72, keep=keep), gimcli.trace(m, 72)
    x, u = t["P.x"], t["motor"]
    area = float(np.sum((x[1:] + x[:-1]) / 2.0 * np.diff(u)))
    expected = [x[0], x[-1], area, u[np.argmax(x)], u[np.argmin(x)]]
    assert [s[text][0] for text in keep] == pytest.approx(expected, rel=1e-9)


FILE = {
    "units": {"length": "mm"},
    "nodes": {"A": [0, 0], "D": [90, 0], "B": [40, 0], "C": [60, 70]},
    "ground": ["A", "D"],
    "links": {"crank": ["A", "B"], "coupler": ["B", "C"], "rocker": ["D", "C"]},
    "actuators": {"motor": {"type": "rotary", "pivot": "A", "arm": "B"}},
}


def with_quantities(**named):
    return gimcli.load({**FILE, "quantities": named})


def test_quantities_of_the_file_are_names_like_any_other():
    m = with_quantities(swing="range(rocker.angle)", twice="2 * strut", strut="hypot(C.x - 50, C.y + 550)")
    t = gimcli.trace(m, 72, measure=["strut", "twice"], plot="strut+twice")
    strut = np.hypot(t.xy["C"][:, 0] - 50.0, t.xy["C"][:, 1] + 550.0)
    assert t["strut"] == pytest.approx(strut)
    assert t["twice"] == pytest.approx(2.0 * strut)
    assert [c.name for c in t.graphs()[0].curves] == ["strut [mm]", "twice"]
    s = gimcli.sweep(m, {"crank.length": [40.0]}, keep=["swing", "max(strut)", "max(twice) - swing"])
    angle = t.angle["rocker"]
    assert s["swing"][0] == pytest.approx(np.ptp(angle))
    assert s["max(strut)"][0] == pytest.approx(strut.max())
    found = gimcli.sensitivity(m, of="strut", by="C.x", motor=30)
    plain = gimcli.sensitivity(m, of="hypot(C.x - 50, C.y + 550)", by="C.x", motor=30)
    assert found.derivatives["strut"]["C.x"] == plain.derivatives["hypot(C.x - 50, C.y + 550)"]["C.x"]
    assert gimcli.sensitivity(m, of="swing", by="crank").names == ["swing"]


@pytest.mark.parametrize(
    ("named", "part"),
    [
        ({"A": "C.x"}, "quantities.A: 'A' is already the name of a part or a column"),
        ({"rocker": "C.x"}, "is already the name"), ({"time": "C.x"}, "is already the name"),
        ({"a": "C.z"}, "no column or measure 'C.z'; did you mean 'C."), ({"a": "b", "b": "a + 1"}, "depends on itself"),
        ({"a": "a"}, "'a' depends on itself"), ({"a": "C.x +"}, "expected a name or number, got the end"),
        ({"a": "C.x + rocker.angle"}, "needs equal units"),
    ],
)  # fmt: skip
def test_faulty_quantities_of_the_file_are_refused_with_their_place(named, part):
    with pytest.raises(gimcli.ModelError) as found:
        with_quantities(**named)
    assert part in str(found.value)


def test_short_names_are_those_of_the_closed_form():
    """A slider-crank with offset e: stroke and time ratio by its dead points. Source: Norton, section 3.4."""
    r, rod, e = 1.0, 3.0, 0.5
    model = {
        "nodes": {"O": [0, 0], "A": [r, 0], "S": [3.9, e], "G": [0, e], "H": [9, e]}, "ground": ["O", "G", "H"],
        "links": {"crank": ["O", "A"], "rod": {"nodes": ["A", "S"], "length": rod}},
        "prismatic": {"piston": {"node": "S", "guide": ["G", "H"]}},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}}, "trace": ["S"],
    }  # fmt: skip
    m = gimcli.load(model)
    keep = ["stroke:S", "stroke:S.x", "time_ratio:S.x", "worst_transmission"]
    s = gimcli.sweep(m, {"crank.length": [r]}, steps=3600, keep=keep)
    far, near = np.sqrt((rod + r) ** 2 - e**2), np.sqrt((rod - r) ** 2 - e**2)
    back = np.degrees(np.arcsin(e / (rod - r)) - np.arcsin(e / (rod + r)))
    assert s["stroke:S"][0] == pytest.approx(far - near, abs=1e-5)
    assert s["stroke:S.x"][0] == s["stroke:S"][0]
    assert s["time_ratio:S.x"][0] == pytest.approx((180.0 + back) / (180.0 - back), abs=3e-3)
    worst = np.degrees(np.arccos((r + e) / rod))
    assert s["worst_transmission"][0] == pytest.approx(worst, abs=1e-3)


def test_results_know_any_quantity_by_its_name():
    m = gimcli.load(MODELS / "crank_press.yaml")
    t = gimcli.trace(m, STEPS, derivatives=2, measure=["transmission", "crank_angle.effort"])
    plain = gimcli.trace(m, STEPS)
    names = [name for name in t if name not in plain and t[name].dtype.kind == "f"]
    assert len(names) > 10
    for name in names:
        alike(plain[name], t[name])
    assert plain["C.v"].shape == (STEPS + 1, 2)
    row = 4
    p = gimcli.solve(m, {"crank_angle": float(t["crank_angle"][row])})
    for name in names:
        if "effort" not in name and not name.endswith(".angle"):
            assert p[name] == pytest.approx(t[name][row], rel=1e-9, abs=1e-9), name
    assert p["C.x"] == pytest.approx(p.xy["C"][0])
    assert p["hypot(C.x - 1, C.y)"] == pytest.approx(np.hypot(*(p.xy["C"] - [1.0, 0.0])))
    assert p["crank_angle"] == pytest.approx(p.inputs["crank_angle"])
    for name in ("Q.x", "max(C.x)", "step", "crank_angle.efforts"):
        with pytest.raises(KeyError):
            p[name]


def test_forces_and_simulations_draw_and_know_any_quantity_of_their_motion():
    m = gimcli.load(MODELS / "crank_press.yaml")
    found = gimcli.forces(m, STEPS, plot="C.vx, hypot(C.x, C.y), effort, A")
    t = gimcli.trace(m, STEPS, derivatives=1)
    speed, far, effort, reaction = found.graphs()
    alike(speed.curves[0].y, t["C.vx"])
    alike(far.curves[0].y, np.hypot(t["C.x"], t["C.y"]))
    assert [curve.name for curve in effort.curves] == ["crank_angle"]
    assert reaction.curves[0].name == "A.fx", "in this command A is its reaction"
    pendulum = gimcli.load(MODELS / "double_pendulum.yaml")
    s = gimcli.simulate(pendulum, 0.5, plot="B.v")
    z, time = s.xy["B"], s["time"]
    rate = np.gradient(z, time, axis=0, edge_order=2)
    assert s["B.v"] == pytest.approx(rate, abs=2e-4 * np.abs(rate).max() + 1e-6)
    assert s.graphs()[0].curves[0].y == pytest.approx(s["B.vx"])
    assert "B.vx" not in s
    assert np.hypot(*s["B.v"].T) == pytest.approx(s["|B.v|"])


def test_positions_at_arrays_of_inputs_are_those_of_each_input():
    m = gimcli.load(MODELS / "slider_crank.yaml")
    u = [10.0, 200.0, 75.0]
    p = gimcli.solve(m, motor=u)
    each = [gimcli.solve(m, motor=value) for value in u]
    assert p.status.tolist() == ["ok"] * 3
    name = m.traced[0]
    assert p.xy[name] == pytest.approx(np.array([one.xy[name] for one in each]))
    for quantity in (f"{name}.x", "rod.angle", f"distance:{name}/{m.nodes[0]}", "motor"):
        assert p[quantity] == pytest.approx(np.array([one[quantity] for one in each])), quantity
    pair = gimcli.solve(gimcli.load(MODELS / "five_bar.yaml"), {"motor_1": [100, 110], "motor_2": 60})
    assert pair["motor_2"].tolist() == pytest.approx([60.0, 60.0])
    bad = gimcli.solve(m.with_({"rod": 0.9}), motor=[0.0, 270.0])
    assert bad.status[1] != "ok"
    assert np.isnan(bad[f"{name}.x"][1])
    with pytest.raises(UsageError):
        gimcli.solve(gimcli.load(MODELS / "five_bar.yaml"), {"motor_1": [100, 110], "motor_2": [1, 2, 3]})
    with pytest.raises(UsageError):
        gimcli.solve(m, motor=u, method="gim")
