"""Results as Python sees them: mappings and tables of pandas, and mechanisms that are equal or given by their paths."""

from __future__ import annotations

import copy
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bundled import MODELS
from verbs import CALLS, OTHERS, TIMED, result, run

import gimcli


def same(found: Any, wanted: Any) -> bool:
    return list(found) == list(wanted) and all(
        np.array_equal(found[name], wanted[name], equal_nan=found[name].dtype.kind == "f") for name in wanted
    )


def test_the_list_has_all_verbs() -> None:
    own = {name for name in gimcli.__all__ if name.islower()} - {"load", "loads", "shipped_models"}
    assert own == CALLS.keys() | OTHERS.keys()


@pytest.mark.parametrize("verb", CALLS)
def test_a_result_is_a_mapping_a_dict_and_a_table(verb):
    found = result(verb)
    names = list(found)
    assert names == list(found.table().names) == list(found.keys())
    assert (len(found), bool(found)) == (len(names), True)
    assert same(dict(found), found)
    assert same({**found}, found)
    assert same(dict(found.items()), found)
    assert all(value.shape == (len(found.table()),) for value in found.values())
    assert "" not in found
    assert found.get("") is None
    for copied in (copy.copy(found), copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert type(copied) is type(found)
        assert same(copied, found)
    with pytest.raises(TypeError, match="serializable"):
        json.dumps(found)
    changes = (
        found.clear, found.popitem, found.copy, lambda: found.update(a=1), lambda: found.__setitem__("a", 1),
        lambda: found | {}, lambda: {} | found,
    )  # fmt: skip
    for change in changes:
        with pytest.raises(TypeError, match="dict"):
            change()


def test_pandas_makes_columns_of_a_result():
    """Pandas asks whether the data are a dict, and then for keys and values."""
    found = result("trace")
    assert isinstance(found, dict)
    pandas = pytest.importorskip("pandas")
    assert pandas.DataFrame(found).equals(found.to_frame())
    assert list(pandas.DataFrame(found)) == list(found)


@pytest.mark.parametrize("verb", CALLS)
def test_time_inputs_and_status_are_those_of_the_rows_or_of_all_rows(verb):
    found = result(verb)
    rows, inputs = len(found.table()), [one.name for one in found.mechanism.actuators]
    for name in inputs:
        assert name not in found or found.inputs[name] is not None
    for value in [getattr(found, "time", 0.0), *getattr(found, "inputs", {}).values(), found.status]:
        assert np.shape(value) in ((), (rows,)) or verb == "configurations"
    assert set(getattr(found, "inputs", {})) <= set(inputs)


def test_time_and_inputs_follow_the_law():
    """The crank of the model turns once in 1 s."""
    found = result("trace")
    assert found.time == pytest.approx(np.linspace(0.0, 1.0, 5))
    assert found.inputs["motor"] == pytest.approx(np.linspace(0.0, 360.0, 5))
    assert list(found.status) == ["ok"] * 5
    one = gimcli.holding_forces(MODELS / "lift_table.yaml", cylinder=0.5, time=2.0)
    assert (one.time, one.inputs, one.status) == (2.0, {"cylinder": pytest.approx(0.5)}, "ok")
    with pytest.raises(AttributeError, match="time"):
        _ = result("groups").time


def test_a_fit_has_every_quantity_at_its_targets():
    """Driven at unit speed by its law, so that the rates are those of `solve` at the same inputs."""
    m = gimcli.load("crank_rocker")
    targets = gimcli.trace(m, 6).xy["P"][1:4]
    found = gimcli.fit(m, {"crank.length": (38, 42)}, through=targets, starts=2)
    each = [gimcli.solve(found.mechanism, motor=float(q)) for q in found["motor"]]
    assert found["rocker.omega"] == pytest.approx([one["rocker.omega"] for one in each], rel=1e-9)
    least = gimcli.fit(m, {"crank.length": (39, 41)}, goal="max(P.y)", starts=1)
    assert np.max(least["P.y"]) == pytest.approx(least.error, rel=1e-9)


@pytest.mark.parametrize("ask", [
    lambda m: gimcli.trace(m, 4)["motor.effort"],
    lambda m: gimcli.trace(m, 4, plot="motor.effort"),
    lambda m: gimcli.sweep(m, {"crank.length": "39,41"}, keep="max(motor.effort)"),
    lambda m: gimcli.fit(m, {"crank.length": (39, 41)}, goal="max(energy.kinetic)"),
    lambda m: gimcli.sensitivity(m, of="A.fx"),
])  # fmt: skip
def test_without_masses_a_force_is_unknown_with_the_reason(ask):
    with pytest.raises((KeyError, gimcli.UsageError), match="need masses, loads or springs in the model file"):
        ask("crank_rocker")


def test_a_folder_with_the_suffix_of_a_file_is_refused_and_others_are_folders(tmp_path):
    found = gimcli.solve("crank_rocker")
    for name in ("t.csv", "results.v2"):
        (tmp_path / name).mkdir()
    with pytest.raises(gimcli.OutputError, match="a folder has this name"):
        found.save(tmp_path / "t.csv")
    found.save(tmp_path / "results.v2", f"{tmp_path / 't.csv'}/")
    files = [sorted(one.name for one in (tmp_path / name).iterdir()) for name in ("results.v2", "t.csv")]
    assert files == [["crank_rocker.solve.csv", "crank_rocker.solve.png"]] * 2


def test_designs_as_the_text_of_the_terminal_are_refused_with_the_dict():
    with pytest.raises(gimcli.UsageError, match=r"vary: expected a dict of values, such as \{'crank': '39:41:3'\}"):
        gimcli.sweep("crank_rocker", "crank=39:41:3")


def test_inputs_of_several_machines():
    hexagon = gimcli.load(MODELS / "floating_hexagon.yaml")
    found = gimcli.trace(hexagon, 3)
    assert list(found.inputs) == [one.name for one in hexagon.actuators]


@pytest.mark.parametrize("verb", CALLS | OTHERS)
def test_a_verb_takes_what_load_takes(verb):
    wanted = run(verb, path=gimcli.load)
    for found in (result(verb), run(verb, path=Path)):
        if verb in OTHERS:
            assert type(found) is type(wanted)
        elif verb not in TIMED:
            assert same(found, wanted)


def test_a_verb_takes_a_dict_a_name_and_no_other_thing():
    rod = {
        "nodes": {"O": [0, 0], "A": [1, 0]}, "ground": ["O"], "links": {"rod": ["O", "A"]},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
    }  # fmt: skip
    assert gimcli.solve(rod, motor=90).xy["A"] == pytest.approx([0.0, 1.0])
    assert gimcli.mobility("crank_rocker").mobility == 1
    with pytest.raises(gimcli.ModelError, match="no such file"):
        gimcli.solve("none.yaml")
    assert pickle.loads(pickle.dumps(gimcli.solve)) is gimcli.solve


@pytest.mark.parametrize("model", ["crank_rocker", "excavator", "planetary_gear", "punch", "snap_hinge"])
def test_mechanisms_are_equal_if_their_files_say_the_same(model, tmp_path):
    path = MODELS / f"{model}.yaml"
    one = gimcli.load(path)
    assert one == gimcli.load(path)
    assert hash(one) == hash(gimcli.load(path))
    assert one == pickle.loads(pickle.dumps(one))
    remarked = tmp_path / path.name
    remarked.write_text("# a comment\n" + path.read_text(encoding="utf-8"), encoding="utf-8")
    assert gimcli.load(remarked, path.parent) == one
    name = next(name for name, own in one.written.dimensions.items() if isinstance(own.value, float) and own.value)
    value = one.written.dimension(name).value
    other = one.with_({name: value * (1 + 1e-6)})
    assert other != one
    assert other == one.with_({name: value * (1 + 1e-6)})
    assert one != str(path)


def test_another_assembly_and_another_table_make_another_mechanism(tmp_path):
    one = gimcli.load("crank_rocker")
    assert gimcli.assembled(one, assembly=2) != one
    assert gimcli.assembled(one, assembly=2) == gimcli.load("crank_rocker", assembly=2)
    text = (MODELS / "hatch.yaml").read_text(encoding="utf-8")
    found = []
    for factor in (1.0, 1.01):
        rows = (MODELS / "hatch_hand.csv").read_text(encoding="utf-8").splitlines()
        pairs = [[float(cell) for cell in row.split(",")] for row in rows if row[:1] in "-0123456789"]
        table = "".join(f"{at},{factor * value}\n" for at, value in pairs)
        (tmp_path / "hatch_hand.csv").write_text(table, encoding="utf-8")
        found.append(gimcli.loads(text, tmp_path))
    assert found[0] != found[1]
