"""Kept quantities of designs equal those of a trace of each design, computed from its columns by numpy."""

import numpy as np
import pytest
from bundled import MODELS

import gimcli
from gimcli import UsageError
from gimcli.families.family import Family
from gimcli.status import Status

STEPS = 24

REDUCED = {
    "min": np.min, "max": np.max, "range": np.ptp, "mean": np.mean, "rms": lambda x: np.sqrt(np.mean(x**2)),
}  # fmt: skip

CASES = {
    "crank_rocker": {"crank.length": [35.0, 40.0, 70.0], "P.y": [40.0, -20.0]},
    "slider_crank": {"rod.length": [2.5, 3.0, 3.5]},
    "jansen": {"m.length": [14.0, 15.0, 30.0], "G.x": [-38.0, -37.0]},
    "stephenson_3": {},
    "platform_3rrr": {},
    "whitworth": {},
    "crank_shaper": {},
}
"""Models and values of dimensions; by default three values of the length of the first link."""


def case(name):
    m = gimcli.load(MODELS / f"{name}.yaml")
    own = {d.name: d.value for d in m.written.dimensions.values()}
    length = next(name for name in own if name.endswith(".length"))
    return m, CASES[name] or {length: [0.97 * own[length], own[length], 1.03 * own[length]]}


def traced(m, design, measure, derivatives=0):
    """Return the columns of a trace of one design in its solved rows, and its status words."""
    t = gimcli.trace(m.with_(design), STEPS, measure=measure, derivatives=derivatives, jit="off")
    good = t.status == "ok"
    return {c.name: np.asarray(c.values[good], dtype=float) for c in t.table().columns if c.values.dtype.kind != "U"}, t


@pytest.mark.parametrize("name", CASES)
def test_positions_and_angles(name):
    m, vary = case(name)
    point = m.traced[0]
    columns = [f"{point}.x", f"{point}.y", *(f"{member.name}.angle" for member in m.members[1:3])]
    measures = [h.name for h in gimcli_heads(m)]
    keep = [f"{word}({column})" for word in ("min", "max", "range", "mean", "rms") for column in columns]
    keep += [f"min({name})" for name in measures]
    got = gimcli.sweep(m, vary, steps=STEPS, keep=[*keep, "solved"])
    table = got.table()
    for k in range(got.designs):
        design = {name: float(table[name][k]) for name in vary}
        own, t = traced(m, design, measures, 1)
        size = 1.0 + max(np.abs(own[columns[0]]).max(initial=0.0), 360.0)
        assert table["solved"][k] == t.solved
        bad = t.status[t.status != "ok"]
        assert table["status"][k] == (bad[0] if len(bad) else "ok")
        for text in keep:
            word, column = text[:-1].split("(", 1)
            values = own[column]
            expected = REDUCED[word](values) if len(values) else np.nan
            assert table[text][k] == pytest.approx(expected, abs=1e-9 * size, nan_ok=True), (text, design)


def gimcli_heads(m):
    """Return the columns of the transmission angles, if there are any."""
    from gimcli.quantities.kinds import quantities_of

    try:
        return [head for measure in quantities_of(m, "transmission") for head in measure.heads]
    except UsageError:
        return []


def test_velocities_and_measures_that_need_them():
    m, spec, ratio = gimcli.load(MODELS / "crank_rocker.yaml"), "centre:coupler/frame", "advantage:motor/rocker.ratio"
    keep = ["max(P.vx)", "rms(rocker.omega)", f"min({spec}.y)", f"max({ratio})", "max(angle:rocker/crank)"]
    got = gimcli.sweep(m, {"rocker.length": [75.0, 80.0]}, steps=STEPS, keep=keep).table()
    for k, value in enumerate((75.0, 80.0)):
        specs = [spec, "advantage:motor/rocker", "angle:rocker/crank"]
        own, _ = traced(m, {"rocker.length": value}, specs, 1)
        assert got[keep[0]][k] == pytest.approx(own["P.vx"].max())
        assert got[keep[1]][k] == pytest.approx(np.sqrt(np.mean(own["rocker.omega"] ** 2)))
        assert got[keep[2]][k] == pytest.approx(np.nanmin(own[f"{spec}.y"]))
        assert got[keep[3]][k] == pytest.approx(own[ratio].max())
        assert got[keep[4]][k] == pytest.approx(own["angle:rocker/crank"].max())


@pytest.mark.parametrize("angle", [0, 30, 52.5, 359.9])
def test_value_of_an_input(angle):
    """The position where the input has a value is that of `solve` there, between the rows too."""
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    keep = [f"at(P.y, motor={angle})", f"at(rocker.angle, motor={angle})", f"at(time, motor={angle})"]
    got = gimcli.sweep(m, {"crank.length": [35.0, 40.0]}, steps=STEPS, keep=keep).table()
    for k, value in enumerate((35.0, 40.0)):
        p = gimcli.solve(m.with_({"crank.length": value}), motor=angle)
        assert got[keep[0]][k] == pytest.approx(p.xy["P"][1], abs=1e-9)
        assert got[keep[1]][k] == pytest.approx(p.angle["rocker"], abs=1e-9)
        assert got[keep[2]][k] == pytest.approx(angle / 360.0, abs=1e-12)


def test_worst_transmission_angle_of_all_joints():
    m = gimcli.load(MODELS / "jansen.yaml")
    names = [head.name for head in gimcli_heads(m)]
    keep = ["min(90 - abs(transmission - 90))", *(f"min(90 - abs({name} - 90))" for name in names)]
    table = gimcli.sweep(m, {"m.length": [14.0, 15.0]}, steps=STEPS, keep=keep).table()
    assert len(names) > 1
    assert np.array_equal(table[keep[0]], np.min([table[text] for text in keep[1:]], axis=0))


@pytest.mark.parametrize("steps", [2, 5, 72])
def test_full_turns_are_counted_with_few_rows(steps):
    """Also of a linkage that is nearly a kite: its rocker turns by half a turn while the crank turns by 0.2 degrees."""
    nodes = {"O": [0, 0], "G": [3, 0], "A": [0, 3], "B": [3, 2]}
    links = {"crank": ["O", "A"], "coupler": ["A", "B"], "rocker": ["G", "B"]}
    data = {
        "nodes": nodes, "ground": ["O", "G"], "links": {k: {"nodes": v, "length": 5.0} for k, v in links.items()},
        "actuators": {"m": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"from": 87.4, "to": 1167.4}}},
    }  # fmt: skip
    vary = {"crank.length": [3.01, 3.3], "rocker.length": [5.001, 5.2]}
    m = gimcli.load(data)
    found = gimcli.sweep(m, vary, steps=steps, keep=["max(rocker.angle)", "range(coupler.angle)"]).table()
    for k, status in enumerate(found["status"]):
        t = gimcli.trace(m.with_({name: float(found[name][k]) for name in vary}), steps, jit="off")
        assert (status == "ok") == t.complete
        if t.complete:
            assert found["max(rocker.angle)"][k] == pytest.approx(np.max(t.angle["rocker"]), abs=1e-6)
            assert found["range(coupler.angle)"][k] == pytest.approx(np.ptp(t.angle["coupler"]), abs=1e-6)
    assert (found["status"] == "ok").sum() > 1


@pytest.mark.parametrize("jit", ["on", "off"])
def test_a_negative_length_is_refused_in_any_number_of_designs(jit):
    """The squares of lengths in the equations do not show it."""
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    found = Family(m, ["crank.length", "coupler.length"]).solve(np.array([[40.0, 120.0], [-40.0, 120.0]]), 12, jit=jit)
    assert [Status(k).word for k in found.status] == ["ok", "not-assembled"]


MOVED = {
    "crank_rocker": {"crank.length": [35.0, 70.0], "P.y": [40.0, -20.0]},
    "five_bar": {},
    "crank_shaper": {},
    "stephenson_3_far": {},
    "excavator": {},
    "chebyshev": {"motor.to": [100.0, 130.0]},
}


@pytest.mark.parametrize("name", MOVED)
def test_velocities_and_their_derivatives_of_many_designs(name):
    """Also of two inputs, of linear ones, of a coupled group, of moving guides, and of laws that differ."""
    m = gimcli.load(MODELS / f"{name}.yaml")
    own = {d.name: d.value for d in m.written.dimensions.values()}
    length = next(n for n in own if n.endswith(".length"))
    vary = {"duration": [1.0, 2.5], **(MOVED[name] or {length: [0.98 * own[length], own[length]]})}
    point, member = m.traced[0], m.members[1].name
    names = [f"{point}.{letter}{axis}" for letter in "vaj" for axis in "xy"]
    names += [f"{member}.{word}" for word in ("omega", "alpha", "jerk")] + ["time"]
    found = gimcli.sweep(m, vary, steps=12, keep=names, rows=True)
    for k in range(4):
        t = gimcli.trace(m.with_({n: float(found[n][13 * k]) for n in vary}), 12, derivatives=3, jit="off")
        for column in names:
            wanted = np.where(t.status == "ok", t[column], np.nan)
            size = np.nanmax(np.abs(wanted), initial=0.0)
            assert found.curves[column][k] == pytest.approx(wanted, abs=1e-9 * size + 1e-10, nan_ok=True), (column, k)


def test_transmission_angle_at_a_moving_guide():
    m = gimcli.load({
        "nodes": {"O": [0, 0], "A": [1, 0], "G": [4, -2], "C": [4, 3], "B": [4, 1]}, "ground": ["O", "G"],
        "links": {"crank": {"nodes": ["O", "A"], "length": 1}, "arm": {"nodes": ["G", "C"], "length": 5},
                  "rod": {"nodes": ["A", "B"], "length": 4}},
        "prismatic": {"s": {"node": "B", "guide": ["G", "C"]}},
        "actuators": {"m": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"from": 0, "to": 120}},
                      "n": {"type": "rotary", "pivot": "G", "arm": "C", "law": {"from": 90, "to": 110}}},
    })  # fmt: skip
    found = gimcli.sweep(m, {"crank.length": [0.9, 1.1]}, steps=STEPS, keep=["min(transmission:rod/s)"])
    for k, value in enumerate((0.9, 1.1)):
        own, t = traced(m, {"crank.length": value}, ["transmission:rod/s"])
        assert t.complete
        assert found["min(transmission:rod/s)"][k] == pytest.approx(own["transmission:rod/s"].min())
        assert np.ptp(own["transmission:rod/s"]) > 5.0


@pytest.mark.parametrize("name", ["excavator", "chebyshev"])
def test_value_of_an_input_of_laws_that_are_not_linear_or_differ(name):
    """The other inputs, and the time, are those of the laws there."""
    m = gimcli.load(MODELS / f"{name}.yaml")
    first, point, member = m.actuators[0].name, m.traced[0], m.members[1].name
    ends = [145.0, 130.0] if name == "excavator" else [90.0, 95.0]
    designs = [m.with_({f"{first}.to": end}) for end in ends]

    def inputs(design, share):
        return {a.name: design.value_to_file(k, a.law(np.array([share])))[0] for k, a in enumerate(design.actuators)}

    value = float(inputs(designs[0], 0.37)[first])
    keep = [f"at({column}, {first}={value!r})" for column in ("time", f"{point}.x", f"{member}.angle")]
    found = gimcli.sweep(m, {f"{first}.to": ends}, steps=12, keep=keep)
    assert found[keep[0]][0] == pytest.approx(0.37 * m.duration, abs=1e-9)
    for k, design in enumerate(designs):
        there = inputs(design, found[keep[0]][k] / m.duration)
        assert there[first] == pytest.approx(value)
        p = gimcli.solve(design, there)
        assert found[keep[1]][k] == pytest.approx(p.xy[point][0], abs=1e-8)
        assert np.cos(np.radians(found[keep[2]][k] - p.angle[member])) == pytest.approx(1.0)


def test_designs_without_a_position_have_empty_quantities():
    m, keep = (
        gimcli.load(MODELS / "crank_rocker.yaml"),
        ["max(coupler.angle)", "range(crank.angle)", "at(P.y, motor=31)"],
    )
    found = gimcli.sweep(m, {"crank.length": [35.0, 40.0, 70.0]}, steps=6, keep=keep)
    for k, length in enumerate((35.0, 40.0)):
        t = gimcli.trace(m.with_({"crank.length": length}), 6)
        assert found[keep[0]][k] == pytest.approx(t.angle["coupler"].max())
        assert found[keep[1]][k] == pytest.approx(np.ptp(t.angle["crank"]))
        assert np.isfinite(found[keep[2]][k])
    assert [found[text][2] for text in keep] == pytest.approx([np.nan] * 3, nan_ok=True)


def test_quantities_use_the_solved_rows_only():
    """The law from 99.462 deg by 40 deg in 24 steps; the second design has 24 of the 25 rows."""
    texts = ["max(motor)", "mean(motor)", "max(motor*2)", "max(motor+0*E.x)", "at(motor, motor=139)", "max(step)"]
    m = gimcli.load(MODELS / "gim_fig13b.yaml")
    got = gimcli.sweep(m, {"G.x": [45, 45.45]}, steps=24, keep=[*texts, "solved"])
    first, second = (np.array([got[text][k] for text in texts]) for k in (0, 1))
    start = first[0] - 40.0
    rows = start + np.arange(25) * 40.0 / 24
    assert got["solved"].tolist() == [25.0, 24.0]
    assert first == pytest.approx([rows[-1], rows.mean(), 2 * rows[-1], rows[-1], 139.0, 24.0])
    kept = rows[:-1]
    assert second == pytest.approx([kept[-1], kept.mean(), 2 * kept[-1], kept[-1], np.nan, 23.0], nan_ok=True)
    assert second[:2] == pytest.approx([137.796, 118.629], abs=5e-4)


def test_whole_columns_are_those_of_a_trace_of_each_design():
    m, values = gimcli.load(MODELS / "crank_rocker.yaml"), [35.0, 40.0, 70.0]
    s = gimcli.sweep(m, {"crank.length": values}, steps=STEPS, keep="P.x, |P.v|, hypot(P.x - 10, P.y)", rows=True)
    assert list(s.curves) == ["P.x", "|P.v|", "hypot(P.x - 10, P.y)"]
    for k, value in enumerate(values):
        t = gimcli.trace(m.with_({"crank.length": value}), STEPS, derivatives=1)
        expected = [t["P.x"], np.hypot(t["P.vx"], t["P.vy"]), np.hypot(t["P.x"] - 10.0, t["P.y"])]
        for found, own in zip(s.curves.values(), expected, strict=True):
            assert found[k] == pytest.approx(own, abs=1e-9, nan_ok=True)
    assert s["crank.length"].tolist() == [value for value in values for _ in range(STEPS + 1)]
    assert s["step"].tolist() == [*range(STEPS + 1)] * len(values)
    assert list(gimcli.sweep(m, {"crank.length": values}, steps=4, rows=True).curves) == ["P.x", "P.y", "B.x", "B.y"]


def test_designs_are_solved_in_the_order_given(tmp_path):
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    designs = [
        {"crank.length": 42.0, "P.x": 20.0},
        {"crank.length": 35.0, "P.x": 30.0},
        {"crank.length": 41.0, "P.x": 5.0},
    ]
    file = tmp_path / "designs.csv"
    file.write_text("crank.length,P.x\n" + "".join(f"{d['crank.length']},{d['P.x']}\n" for d in designs))
    expected = [gimcli.trace(m.with_(design), STEPS)["P.y"].max() for design in designs]
    for given in (designs, file, str(file)):
        found = gimcli.sweep(m, given, steps=STEPS, keep="max(P.y)")
        assert found["max(P.y)"] == pytest.approx(expected)
        assert found["P.x"].tolist() == [20.0, 30.0, 5.0]


def test_an_evaluator_has_the_numbers_of_a_sweep():
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    evaluate = gimcli.evaluator(m, ["crank.length", "rocker"], ["range(P.y)", "max(rocker.omega)"], steps=STEPS)
    values, statuses = evaluate([[40.0, 70.0], [35.0, 69.0], [90.0, 20.0]])
    assert (values.shape, statuses.shape) == ((3, 2), (3,))
    for (crank, rocker), own, word in zip([[40.0, 70.0], [35.0, 69.0]], values, statuses, strict=False):
        t = gimcli.trace(m.with_({"crank.length": crank, "rocker": rocker}), STEPS, derivatives=1)
        assert own == pytest.approx([np.ptp(t["P.y"]), t["rocker.omega"].max()])
        assert word == "ok"
    assert statuses[2] != "ok"
    assert evaluate([40.0, 70.0])[0] == pytest.approx(values[:1])
    with pytest.raises(UsageError):
        evaluate([1.0, 2.0, 3.0])
    with pytest.raises(UsageError):
        gimcli.evaluator(m, ["crank.length"], ["type"])
