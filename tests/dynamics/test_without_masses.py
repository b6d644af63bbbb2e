"""A model without masses or without a physical unit: exit status 3, and a message with the lines to add."""

from __future__ import annotations

import pytest

from gimcli.cli import main

MODEL = """\
nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 3]}
ground: [O, G]
links: {crank: [O, A], "the rod's": [A, B], c: [G, B]}
actuators: {m: {type: rotary, pivot: O, arm: A, law: {by: 10}, free: true}}
"""
COMMANDS = {
    "forces": ["--steps", "2"], "simulate": ["--time", "0.02", "--dt", "0.01"], "reduce": ["--steps", "2"],
}  # fmt: skip


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run a command on a model text; return exit status, standard output and the lines on standard error."""
    monkeypatch.chdir(tmp_path)

    def run(text, command):
        (tmp_path / "m.yaml").write_text(text)
        monkeypatch.setattr("sys.argv", ["gim", command, "m.yaml", "--no-png", *COMMANDS[command]])
        try:
            main()
            code = 0
        except SystemExit as stop:
            code = stop.code or 0
        out, err = capsys.readouterr()
        return code, out, err.splitlines()

    return run


@pytest.mark.parametrize("command", COMMANDS)
def test_the_lines_of_the_message_complete_the_model(command, run):
    code, out, lines = run(MODEL, command)
    assert (code, out) == (3, "")
    at = lines.index("masses:")
    assert "no masses" in lines[at - 1]
    assert len(lines) == at + 4
    assert run(MODEL + "\n".join(lines[at:]) + "\n", command)[0] == 0


@pytest.mark.parametrize("command", COMMANDS)
def test_the_unit_of_the_message_completes_the_model(command, run):
    text = "units: {length: unit}\n" + MODEL + "masses: {crank: {mass: 1, inertia: 1}}\n"
    code, out, lines = run(text, command)
    assert (code, out) == (3, "")
    assert run(text.replace("units: {length: unit}", lines[-1]), command)[0] == 0


@pytest.mark.parametrize("command", ["simulate", "reduce"])
def test_zero_masses_count_as_absent(command, run):
    code, _, lines = run(MODEL + "masses: {crank: {mass: 0, inertia: 0}}\n", command)
    assert code == 3
    assert "no masses" in lines[1]
