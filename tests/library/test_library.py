"""The public functions: their results agree with closed forms and with the reports of the commands."""

from __future__ import annotations

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from bundled import MODELS, ROOT
from in_process import gim, read_rows

import gimcli
from gimcli.model.source import read_source
from gimcli.output import json_text

VERBS = {
    "load", "loads", "solve", "trace", "configurations", "circuits", "singularities", "workspace", "sequence",
    "mobility", "groups", "forces", "modes", "simulate", "reduce", "tradeoff",
}  # fmt: skip
NOTHING = {"csv", "png", "npz", "files"}


@pytest.fixture(scope="module")
def four_bar():
    """Return the four-bar O2 (0, 0), O4 (100, 0), crank 40, coupler 120, rocker 80 [mm]."""
    return gimcli.load(MODELS / "crank_rocker.yaml")


def joint(crank, degrees):
    """Return B of the four-bar above as intersection of two circles: rocker around O4, coupler around A."""
    a = crank * np.exp(1j * np.radians(degrees))
    along = a - 100.0
    far = abs(along)
    part = (far**2 + 80.0**2 - 120.0**2) / (2.0 * far)
    unit = along / far
    return 100.0 + unit * (part - 1j * np.sqrt(80.0**2 - part**2))


def test_import_loads_no_large_package():
    code = "import gimcli, sys; print([m for m in ('numpy', 'pydantic', 'yaml', 'typer') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.strip() == "[]"


def test_public_names():
    assert set(dir(gimcli)) >= VERBS | {"Mechanism", "GimError"}
    assert all(callable(getattr(gimcli, name)) and getattr(gimcli, name).__doc__ for name in VERBS)
    with pytest.raises(AttributeError):
        gimcli.solv  # noqa: B018


def test_a_position_by_two_circles(four_bar):
    crank, coupler, rocker = (abs(four_bar.members[k].shape[1]) * four_bar.scale for k in (1, 2, 3))
    assert (crank, rocker) == pytest.approx((40.0, 80.0))
    assert coupler == pytest.approx(120.0)
    found = gimcli.solve(four_bar, motor=45)
    b = joint(40.0, 45.0)
    assert found.status == "ok"
    assert found.xy["B"] == pytest.approx([b.real, b.imag], abs=1e-11)
    assert found.angle["rocker"] == pytest.approx(np.degrees(np.angle(b - 100.0)) % 360.0, abs=1e-11)
    assert dict(found.inputs) == {"motor": pytest.approx(45.0)}
    assert found["x"][list(found["node"]).index("B")] == pytest.approx(b.real, abs=1e-11)


def test_a_motion_by_two_circles(four_bar):
    found = gimcli.trace(four_bar, steps=24, derivatives=1)
    b = np.array([joint(40.0, d) for d in np.linspace(0.0, 360.0, 25)])
    np.testing.assert_allclose(found.xy["B"], np.stack([b.real, b.imag], axis=1), atol=1e-11)
    np.testing.assert_array_equal(found["B.x"], found.xy["B"][:, 0])
    assert set(found.status) == {"ok"}
    assert found["crank.omega"] == pytest.approx(np.full(25, 360.0))


@pytest.mark.parametrize("steps", [1, 2, 7, 90])
def test_full_turns_are_counted_for_any_number_of_rows(steps):
    data = yaml.safe_load((MODELS / "crank_rocker.yaml").read_text())
    data["actuators"]["motor"]["law"] = {"from": 0, "to": 1080}
    found = gimcli.trace(gimcli.load(data), steps=steps)
    assert found.angle["crank"] == pytest.approx(np.linspace(0.0, 1080.0, steps + 1), abs=1e-9)
    assert found.angle["rocker"][-1] == pytest.approx(found.angle["rocker"][0], abs=1e-9)


def test_full_turns_are_counted_along_a_circuit():
    found = gimcli.trace(gimcli.load(MODELS / "crank_rocker.yaml"), steps=3, circuit=True)
    assert abs(found.angle["crank"][-1] - found.angle["crank"][0]) == pytest.approx(360.0, abs=1e-8)


def test_file_text_and_dict_give_the_same_mechanism(four_bar):
    text = (MODELS / "crank_rocker.yaml").read_text()
    for other in (gimcli.loads(text), gimcli.load(yaml.safe_load(text)), gimcli.load(MODELS / "crank_rocker.yaml")):
        assert gimcli.solve(other, motor=77).xy["P"].tolist() == gimcli.solve(four_bar, motor=77).xy["P"].tolist()


def far_beyond():
    """Return Chebyshev's double rocker with a law of a full turn, which exceeds its limits."""
    data = read_source(MODELS / "chebyshev.yaml").data
    next(iter(data["actuators"].values()))["law"] = {"by": 360}
    return data


def test_rows_that_are_not_solved_have_a_status_and_nan():
    data = yaml.safe_load((MODELS / "crank_rocker.yaml").read_text())
    data["links"]["crank"] = {"nodes": ["O2", "A"], "length": 400}
    found = gimcli.solve(gimcli.load(data), motor=45)
    assert found.status == "not-assembled"
    assert np.isnan(found.xy["B"]).all()
    assert np.isnan(found.angle["rocker"])
    beyond = gimcli.trace(gimcli.load(far_beyond()), steps=12)
    empty = beyond.status != "ok"
    assert empty.any()
    assert not empty.all()
    assert np.isnan(beyond.xy["B"][empty]).all()
    assert np.isfinite(beyond.xy["B"][~empty]).all()


def test_unknown_names_are_refused_with_a_suggestion(four_bar):
    with pytest.raises(gimcli.UsageError):
        gimcli.solve(four_bar, moter=3)
    with pytest.raises(KeyError):
        gimcli.solve(four_bar, motor=3).angle["rockr"]
    with pytest.raises(KeyError):
        gimcli.trace(four_bar, 2)["P.yy"]
    with pytest.raises(KeyError):
        gimcli.solve(four_bar)["zzz"]


def test_a_text_is_limited_to_the_size_of_a_file():
    text = (MODELS / "crank_rocker.yaml").read_text()
    sizes = (4_000_000, 4_000_001)
    fits, larger = (text + "#" * (size - len(text.encode())) for size in sizes)
    assert gimcli.loads(fits).nodes == gimcli.loads(text).nodes
    with pytest.raises(gimcli.ModelError):
        gimcli.loads(larger)


def test_a_notebook_shows_a_table_and_a_picture_with_escaped_names():
    data = yaml.safe_load((MODELS / "crank_rocker.yaml").read_text())
    data["name"] = "<img onerror=alert(1)>"
    shown = gimcli.trace(gimcli.load(data), steps=4)._repr_html_()
    assert "<table>" in shown
    assert "<svg" in shown
    assert "<img" not in shown


def test_saved_files_are_those_of_the_command(four_bar, tmp_path):
    run = gim("trace", MODELS / "crank_rocker.yaml", "--steps", 8, "--out", tmp_path, "--json")
    found = gimcli.trace(four_bar, steps=8)
    found.save(tmp_path / "own.csv", tmp_path / "own.png", tmp_path / "own.json")
    assert (tmp_path / "own.csv").read_bytes() == (tmp_path / "crank_rocker.csv").read_bytes()
    assert (tmp_path / "own.png").read_bytes() == (tmp_path / "crank_rocker.png").read_bytes()
    report = json.loads((tmp_path / "own.json").read_text())
    assert report == {k: v for k, v in run.json.items() if k not in NOTHING}
    assert len(read_rows(tmp_path / "own.csv")) == 9
    with pytest.raises(gimcli.UsageError):
        found.save(tmp_path / "own.xyz")


CASES = {
    "solve": (
        "crank_rocker", ["--at", "motor=45", "--velocities"],
        lambda m: gimcli.solve(m, motor=45, velocities=True),
    ),
    "solve by sweeps": (
        "gim_fig11", ["--method", "gim", "--history"], lambda m: gimcli.solve(m, method="gim", history=True),
    ),
    "solve --all": ("watt_1", ["--all"], gimcli.configurations),
    "trace": (
        "crank_rocker", ["--steps", 12, "-d", 2, "-m", "transmission", "--no-png"],
        lambda m: gimcli.trace(m, 12, derivatives=2, measure="transmission"),
    ),
    "trace --circuit": (
        "chebyshev", ["--steps", 12, "--circuit", "--no-png"], lambda m: gimcli.trace(m, 12, circuit=True),
    ),
    "trace --all-branches": (
        "parallelogram", ["--steps", 12, "--all-branches", "--no-png"],
        lambda m: gimcli.trace(m, 12, all_branches=True),
    ),
    "sequence": ("crank_rocker", [], gimcli.sequence),
    "mobility": ("parallelogram_third_crank", [], gimcli.mobility),
    "groups": ("watt_1", [], gimcli.groups),
    "singularities": ("parallelogram", [], gimcli.singularities),
    "circuits": ("crank_rocker", ["--samples", 12], lambda m: gimcli.circuits(m, values=12)),
    "workspace": (
        "crank_rocker", ["--point", "P", "--grid", 6, "--no-png"], lambda m: gimcli.workspace(m, "P", grid=6),
    ),
    "forces": ("watt_durango", ["--steps", 12, "--no-png"], lambda m: gimcli.forces(m, 12)),
    "simulate": (
        "watt_durango", ["--time", 0.2, "--reactions", "--no-png"], lambda m: gimcli.simulate(m, 0.2, reactions=True),
    ),
    "modes": ("watt_durango", ["--settle"], lambda m: gimcli.modes(m, settle=True)),
    "reduce": (
        "watt_durango", ["--steps", 12, "--fluctuation", 0.1, "--rpm", 60, "--no-png"],
        lambda m: gimcli.reduce(m, steps=12, fluctuation=0.1, rpm=60),
    ),
    "sensitivity": ("crank_rocker", ["--steps", 4, "--no-png"], lambda m: gimcli.sensitivity(m, steps=4)),
    "sensitivity --at": (
        "crank_rocker", ["--at", "motor=30", "--of", "P", "--by", "crank,motor", "--no-png"],
        lambda m: gimcli.sensitivity(m, of="P", by=["crank", "motor"], motor=30),
    ),
    "tradeoff": (
        "crank_rocker", ["--steps", 4, "--tolerances", "1e-4", "--no-png"],
        lambda m: gimcli.tradeoff(m, 4, tolerances=[1e-4]),
    ),
}  # fmt: skip


@pytest.mark.parametrize("at_limit", ["stop", "skip", "reverse"])
def test_at_a_limit_command_and_function_have_the_same_report(at_limit, tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text(yaml.safe_dump(far_beyond(), sort_keys=False))
    run = gim("trace", path, "--steps", 12, "--at-limit", at_limit, "--no-png", "--json", "--out", tmp_path)
    found = gimcli.trace(gimcli.load(path), 12, at_limit=at_limit)
    assert any(event["kind"] == "limit" for event in found.events)
    report = json.loads(json_text(found.report()))
    assert report == {k: v for k, v in run.json.items() if k not in NOTHING}


@pytest.mark.parametrize("case", CASES)
def test_command_and_function_have_the_same_report(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    model, arguments, verb = CASES[case]
    path = MODELS / f"{model}.yaml"
    printed = gim(case.split()[0], path, *arguments, "--json").json
    found = verb(gimcli.load(path))
    report = json.loads(json_text(found.report()))
    assert untimed(report) == untimed({k: v for k, v in printed.items() if k not in NOTHING})
    assert list(found) == list(found.table().names)
    assert found.headline() in repr(found)


def untimed(report):
    """Return a report without entries that depend on the machine."""
    if "entries" not in report:
        return report
    entries = [
        {k: v for k, v in e.items() if k not in ("seconds", "spread", "fixed", "call", "efficient")}
        for e in report["entries"]
    ]
    return {**report, "entries": entries, "advice": None}


def crank_rocker():
    return yaml.safe_load((MODELS / "crank_rocker.yaml").read_text())


def test_a_grid_is_resumed_only_for_the_same_lengths(tmp_path):
    data = crank_rocker()
    data["actuators"]["motor"]["law"] = {"from": 0, "to": 360}
    first = gimcli.load(data)
    data["links"]["rocker"]["length"] = 81
    second = gimcli.load(data)
    gimcli.workspace(first, "B", grid=4, folder=tmp_path / "kept")
    with pytest.raises(gimcli.UsageError):
        gimcli.workspace(second, "B", grid=4, folder=tmp_path / "kept", resume=True)
    assert gimcli.workspace(gimcli.load(MODELS / "crank_rocker.yaml"), "B", grid=4).complete


def test_a_model_is_not_overwritten_from_another_folder(tmp_path, monkeypatch):
    folder = tmp_path / "models"
    folder.mkdir()
    (folder / "m.json").write_text((MODELS / "crank_rocker.yaml").read_text())
    monkeypatch.chdir(folder)
    result = gimcli.trace(gimcli.load("m.json"), 6)
    monkeypatch.chdir(tmp_path)
    before = (folder / "m.json").read_text()
    with pytest.raises(gimcli.UsageError):
        result.save("models/m.json")
    assert (folder / "m.json").read_text() == before


def test_a_pair_may_have_the_name_of_another_pair_and_its_node():
    """In error messages `rail W` is the height of node W over the guide of `rail`, but a pair may have this name."""
    data = yaml.safe_load((MODELS / "scotch_yoke.yaml").read_text())
    expected = gimcli.solve(gimcli.load(data))
    data["prismatic"]["rail W"] = data["prismatic"].pop("slot")
    found = gimcli.solve(gimcli.load(data))
    assert found.status == expected.status == "ok"
    assert all(found.xy[name] == pytest.approx(expected.xy[name]) for name in expected.xy)


def test_turns_of_a_fast_flywheel_are_counted_from_its_speed():
    data = {
        "nodes": {"O": [0, 0], "A": [1, 0]}, "ground": ["O"], "links": {"c": ["O", "A"]},
        "masses": {"c": {"mass": 1, "inertia": 1}},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "free": True, "speed": 9000}},
    }  # fmt: skip
    found = gimcli.simulate(gimcli.load(data), 5.0, dt=0.5)
    assert found.angle["c"] == pytest.approx(9000.0 * np.arange(0.0, 5.25, 0.5), rel=1e-9)


@pytest.mark.parametrize("steps", [1, 2, 7])
def test_turns_are_counted_for_linear_inputs(steps):
    """With few rows the last angle is the same as with many."""
    mechanism = gimcli.load(MODELS / "excavator.yaml")
    assert gimcli.trace(mechanism, steps).angle["bucket"][-1] == pytest.approx(
        gimcli.trace(mechanism, 500).angle["bucket"][-1]
    )


def test_turns_are_counted_through_a_near_change_point():
    """A crank-rocker that is nearly a kite: the follower rotates by more than half a turn within 5 deg of the crank."""
    data = {
        "nodes": {"O": [0, 0], "D": [1, 0], "A": [0.3, 0.95], "B": [1.6, 1.9]}, "ground": ["O", "D"],
        "links": {
            "crank": {"nodes": ["O", "A"], "length": 1.00001}, "cp": {"nodes": ["A", "B"], "length": 2},
            "fo": {"nodes": ["D", "B"], "length": 2},
        },
        "actuators": {"m": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"by": 720}}},
    }  # fmt: skip
    coarse, fine = (gimcli.trace(gimcli.load(data), steps).angle["fo"] for steps in (144, 14400))
    assert coarse == pytest.approx(fine[::100], abs=1e-6)


def test_turns_within_a_gap_are_not_counted():
    """With `at_limit="skip"` an angle continues after a gap with a change of at most half a turn."""
    data = read_source(MODELS / "chebyshev.yaml").data
    data["actuators"]["motor"]["law"] = {"by": 720}
    found = gimcli.trace(gimcli.load(data), 72, at_limit="skip")
    driven, solved = found.angle["left"], found.status == "ok"
    law = driven[0] + np.linspace(0.0, 720.0, 73)
    assert np.flatnonzero(np.diff(solved)).size == 4  # rows: solved, a gap, solved, a gap, solved
    np.testing.assert_allclose((driven - law)[solved] % 360.0 % 360.0, 0.0, atol=1e-8)
    assert np.abs(np.diff(driven[solved])).max() < 180.0


def test_rows_that_are_not_solved_have_no_angle():
    found = gimcli.trace(gimcli.load(MODELS / "gim_fig13c.yaml"), 9, method="gim")
    bad = np.array([word != "ok" for word in found.status])
    assert bad.any()
    assert np.isnan(found.angle["QU"][bad]).all()
    assert np.isfinite(found.angle["QU"][~bad]).all()


def test_a_position_has_velocities_and_accelerations_as_columns(four_bar):
    """The crank's end turns about the origin at one turn a second: v = i w r, a = -w^2 r."""
    found = gimcli.solve(four_bar, motor=30, velocities=True)
    row = found["node"].tolist().index("A")
    turn, arm = 2.0 * np.pi, 40.0 * np.exp(1j * np.pi / 6.0)
    assert found["vx"][row] + 1j * found["vy"][row] == pytest.approx(1j * turn * arm, rel=1e-12)
    assert found["ax"][row] + 1j * found["ay"][row] == pytest.approx(-(turn**2) * arm, rel=1e-12)
    assert {c.name: c.unit for c in found.table().columns}["ay"] == "mm/s^2"
    assert "vx" not in gimcli.solve(four_bar, motor=30)


def test_nothing_is_written_if_there_is_nothing_to_draw(tmp_path):
    crank_rocker = gimcli.load(MODELS / "crank_rocker.yaml")
    unreachable = read_source(MODELS / "crank_rocker.yaml").data
    unreachable["links"]["coupler"] = {"nodes": ["A", "B"], "length": 1000}
    for found in (gimcli.mobility(crank_rocker), gimcli.solve(gimcli.load(unreachable))):
        with pytest.raises(gimcli.UsageError):
            found.save(tmp_path / "m.csv", tmp_path / "m.png")
        assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("verb", ["solve", "trace", "configurations", "circuits", "workspace", "mobility"])
def test_results_are_pickled_and_copied(verb):
    import copy
    import pickle

    mechanism = gimcli.load(MODELS / "crank_rocker.yaml")
    found = getattr(gimcli, verb)(mechanism, **({"steps": 6} if verb == "trace" else {}))
    if verb in ("solve", "trace"):
        assert np.isfinite(found.xy["B"]).all()
    assert pickle.loads(pickle.dumps(found)).report() == found.report() == copy.deepcopy(found).report()
    assert len({mechanism, gimcli.load(MODELS / "crank_rocker.yaml")}) == 1


FAULTY = [
    (lambda d: d["nodes"].update(O2=[float("nan"), 0.0]), "<dict>: nodes.O2.0: expected a finite number, got nan"),
    (lambda d: d["links"].update({7: ["O2", "A"], "7": ["O4", "B"]}), "<dict>: links.7: given twice; remove one"),
    (
        lambda d: d.update(ground=b"O2"),
        "<dict>: ground: expected a number, text, a list or a dict, got a value of type bytes",
    ),
]


@pytest.mark.parametrize(("spoil", "text"), FAULTY)
def test_errors_of_a_dict_name_its_keys_once(spoil, text):
    data = crank_rocker()
    spoil(data)
    with pytest.raises(gimcli.ModelError) as found:
        gimcli.load(data)
    assert str(found.value) == text


def test_text_in_a_dict_is_not_read_as_a_number():
    data = crank_rocker()
    data["name"] = np.str_("1e3")
    assert gimcli.load(data).name == "1e3"


def test_several_columns_at_once_and_a_frame_of_pandas(four_bar, monkeypatch):
    found = gimcli.trace(four_bar, steps=3)
    assert np.array_equal(found[["B.x", "motor"]], np.column_stack([found["B.x"], found["motor"]]))
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=dict))
    frame = found.to_frame()
    assert list(frame) == list(found)
    assert np.array_equal(frame["B.y"], found["B.y"])
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(gimcli.GimError):
        found.to_frame()
