"""A ram whose law goes beyond its limit: the unsolved rows cause no warning of NumPy in any command."""

import warnings

import pytest
import yaml
from bundled import MODELS, plain_data
from in_process import gim

import gimcli

MODEL = {
    "nodes": {"O": [0, 0], "A": [2, 0], "G": [0.5, -1]}, "ground": ["O", "G"], "links": {"arm": ["O", "A"]},
    "actuators": {"ram": {"nodes": ["G", "A"], "law": {"from": 1.8, "to": 4}}},
    "masses": {"arm": {"mass": 2, "inertia": 1}}, "gravity": [0, -9.81], "duration": 1,
}  # fmt: skip
COMMANDS = ("check", "trace", "forces", "reduce", "sensitivity", "singularities", "workspace", "equilibrium")


@pytest.mark.parametrize("command", COMMANDS)
def test_no_warning(command, tmp_path):
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(MODEL), encoding="utf-8")
    assert "Warning" not in gim(command, tmp_path / "m.yaml", "-o", tmp_path / "m.xlsx").error  # warnings are errors


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["excavator", "garage_door", "lift_table", "suspension", "toggle_clamp"])
def test_no_warning_of_shipped_models(name):
    """Laws of three times the length end beyond a limit."""
    model = gimcli.load(name)
    laws = plain_data(MODELS / f"{name}.yaml")["actuators"]
    for actuator, law in ((own, laws[own]["law"]) for own in laws if "to" in laws[own].get("law", {})):
        longer = model.with_({f"{actuator}.to": law["from"] + 3 * (law["to"] - law["from"])})
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = gimcli.forces(longer, steps=36)
            found.table()
            found.report()
            found.picture()
