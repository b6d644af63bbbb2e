"""`--set NAME=VALUE`: other dimensions, in every command that reads a model."""

from __future__ import annotations

import pytest
from bundled import MODELS
from in_process import ANALYSES, gim
from typer.main import get_command

from gimcli import load
from gimcli.cli import COMMANDS, app

MODEL = MODELS / "crank_rocker.yaml"


@pytest.mark.parametrize("command", [*ANALYSES, "view"])
def test_every_command_reads_other_values(command):
    """An unknown name is refused only where the values are read."""
    done = gim(command, MODEL, "--set", "crank.lenght=3")
    assert done.code == 2
    assert "'crank.length'" in done.error


def test_only_commands_with_a_model_have_the_option():
    found = {name: get_command(app).get_command(None, name).params for name in COMMANDS}
    named = {name for name, params in found.items() if any("--set" in param.opts for param in params)}
    assert named == {name for name, params in found.items() if any(param.name == "model" for param in params)}


@pytest.mark.parametrize(("given", "code", "text"), [
    (["crank"], 2, "--set crank: expected NAME=VALUE"),
    (["crank=41", "crank=42"], 2, "'crank' already has a value"),
    (["crank=41", "crank.length=42"], 2, "two values for one dimension"),
    (["crank=long"], 2, "crank.length: expected a number, got 'long'; 'long' is not a parameter"),
    (["crank="], 2, "crank.length: expected a number, got ''; expected a name or number, got the end"),
    (["crank=nan"], 2, "'nan' is not a parameter"),
    (["crank=-3"], 3, "crank_rocker.yaml with crank.length = -3: crank.length: expected a number above 0, got -3.0"),
    (["motor.to=1e9", "P.x=3"], 3, "with motor.to = 1e+09, P.x = 3: motor: the law reaches 1e+09"),
])  # fmt: skip
def test_faults(given, code, text):
    done = gim("mobility", MODEL, *(part for one in given for part in ("--set", one)))
    assert (done.code, text in done.error) == (code, True), done.error


def test_another_value_is_an_edit_of_the_file(tmp_path):
    text = MODEL.read_text(encoding="utf-8").replace("length: 40", "length: 35").replace("[60, 40]", "[80, 40]")
    (tmp_path / "crank_rocker.yaml").write_text(text, encoding="utf-8")
    changed = gim("solve", MODEL, "--set", "crank=35", "--set", "P.x=4*20", "--at", "motor=50", "--json").json
    edited = gim("solve", tmp_path / "crank_rocker.yaml", "--at", "motor=50", "--json").json
    assert changed == edited
    assert changed != gim("solve", MODEL, "--at", "motor=50", "--json").json


def test_solved_coordinates_and_other_values_are_written(tmp_path):
    text = MODEL.read_text(encoding="utf-8").replace("length: 40", "length: a/2").replace(
        "O4: [100, 0]", "O4: [a + 20, 0]") + "parameters: {a: 80}  # twice the crank\n"  # fmt: skip
    (tmp_path / "model.yaml").write_text(text, encoding="utf-8")
    new = tmp_path / "new.yaml"
    done = gim("solve", tmp_path / "model.yaml", "--set", "a=70", "--set", "duration=2", "-o", new)
    assert done.code == 0, done.error
    found = new.read_text(encoding="utf-8")
    assert "parameters: {a: 70}  # twice the crank\nduration: 2\n" in found
    assert "O4: [a + 20, 0]" in found
    assert "length: a/2" in found
    mechanism = load(new)
    assert mechanism.written.dimension("crank").value == 35.0
    assert mechanism.written.dimension("A.x").value == pytest.approx(35.0)  # the law starts at 0 deg
    assert abs(mechanism.to_file(mechanism.drawn)[mechanism.nodes.index("B")] - 90.0) == pytest.approx(80.0)
