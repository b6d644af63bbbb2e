"""A range between two limits is never a full turn, however wide; the trace names what the other side of it has."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from gimcli.cli import app

RANGE = "10.412 to 398.469 deg"
"""Range of the motor of this assembly, wider than a turn: its closed curve has two limits and makes no turn."""


@pytest.mark.parametrize("command", ["trace", "check", "singularities", "circuits"])
def test_a_range_between_limits_wider_than_a_turn(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    output = CliRunner().invoke(app, [command, "double_butterfly", "--assembly", "6"]).stdout
    assert RANGE in output
    assert not [line for line in output.splitlines() if RANGE in line and "full turn" in line]
