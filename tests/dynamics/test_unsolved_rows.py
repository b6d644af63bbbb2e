"""A ram whose law goes beyond its limit: the unsolved rows cause no warning of NumPy in any command."""

import pytest
import yaml
from in_process import gim

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
