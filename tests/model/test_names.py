"""Names: spreadsheet formulas and control characters are rejected; no file has two columns of the same name."""

from __future__ import annotations

import csv
import json
import re

import pytest

from gimcli import ModelError, load
from gimcli.cli import main

MODEL = """\
nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 3], C: [6, 0.5], D: [5, 0]}
ground: [O, G, D]
links: {crank: [O, A], rocker: [G, B]}
elements: {plate: [A, B, C]}
prismatic: {}
actuators: {m: {type: rotary, pivot: O, arm: A, law: {by: 10}, free: true}}
points: {P: {on: crank, at: [1, 1]}}
masses: {crank: {mass: 1, inertia: 1}}
loads: {push: {on: rocker, torque: 1}}
springs: {coil: {nodes: [O, B], stiffness: 1}}
dampers: {shock: {nodes: [O, B], damping: 1}}
friction: {A: 0.1}
"""
NAMED = {"nodes": "D", "links": "rocker", "elements": "plate", "actuators": "m", "points": "P", "loads": "push",
         "springs": "coil", "dampers": "shock"}  # fmt: skip
FEW = {
    "trace": ["--steps", "2"], "forces": ["--steps", "2"], "reduce": ["--steps", "2"],
    "simulate": ["--time", "0.02", "--dt", "0.01"], "workspace": [], "solve": ["--csv", "m.csv"],
}  # fmt: skip


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run a command on a model text; return exit status, standard output and error, and the heads of its tables."""
    monkeypatch.chdir(tmp_path)

    def run(text, command, *more):
        (tmp_path / "m.yaml").write_text(text, encoding="utf-8")
        monkeypatch.setattr("sys.argv", ["gim", command, "m.yaml", *FEW.get(command, []), *more])
        try:
            main()
            code = 0
        except SystemExit as stop:
            code = stop.code or 0
        heads = []
        for path in tmp_path.glob("*.csv"):
            with path.open(newline="", encoding="utf-8") as handle:
                heads.append(next(csv.reader(handle)))
            path.unlink()
        return code, *capsys.readouterr(), heads

    return run


def renamed(model, name, new):
    """Return a model in which a name is replaced everywhere; the new name is written with escapes."""
    return re.sub(rf"(?<=[{{\[ ]){name}(?=[:,\]}}])", json.dumps(new).replace("\\", "\\\\"), model)


def with_name(section, new):
    return renamed(MODEL, NAMED[section], new)


@pytest.mark.parametrize("section", NAMED)
@pytest.mark.parametrize("name", ["=1+1", "+a", "-5", "@SUM(A1)", " =1", "-"])
def test_a_name_that_a_spreadsheet_reads_as_a_formula_is_rejected(section, name, tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text(with_name(section, name))
    with pytest.raises(ModelError) as caught:
        load(path)
    messages = [fault for fault in caught.value.faults if "formula" in fault and repr(name)[1:-1] in fault]
    assert len(messages) == 1, caught.value.faults
    assert caught.value.exit_code == 3


@pytest.mark.parametrize("section", NAMED)
@pytest.mark.parametrize("sign", ["\x07", "\x1b", "\n", "\t", "\x7f", "\x9b", "\u2028", "\u202e"])
def test_a_name_with_a_control_character_is_rejected_and_not_printed(section, sign, run):
    code, out, err, heads = run(with_name(section, f"a{sign}b"), "solve")
    assert (code, out, heads) == (3, "", [])
    assert f"contains the control character {ord(sign):#04x}; remove it" in err
    assert sign not in err.replace("\n", "") or sign == "\n"
    assert all(line.startswith(("gim:", "m.yaml:")) for line in err.splitlines())


def test_a_title_with_a_control_character_is_rejected(run):
    code, _, err, _ = run('name: "a\\x07b"\n' + MODEL, "solve")
    assert code == 3
    assert "\x07" not in err
    assert run('name: "=1+1"\nsource: |\n  two\n  lines\n' + MODEL, "solve")[0] == 0


@pytest.mark.parametrize("name", ["a=b", "a+b", "a-b", "a@b", "Ä", "1", "x y", "'a", "#a", "a.b"])
def test_special_characters_within_a_name_are_accepted(name, tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text(with_name("points", name), encoding="utf-8")
    assert name in load(path).traced


TRACED = MODEL.replace("points: {P: {on: crank, at: [1, 1]}}\n", "trace: [A]\n")
"""MODEL with A traced; PINNED has two more links, one pinned at D."""
PINNED = TRACED.replace("C: [6, 0.5],", "C: [6, 0.5], E: [7, 3],").replace("B]}\nel", "B], e: [D, E], f: [C, E]}\nel")


@pytest.mark.parametrize(
    ("command", "more"),
    [
        *((command, ["--no-png"] if command != "solve" else []) for command in FEW),
        ("trace", ["--no-png", "--derivatives=3", "-m", "curvature:A", "-m", "transmission"]),
        ("trace", ["--no-png", "--all-branches"]), ("simulate", ["--no-png", "--reactions"]),
    ],
)  # fmt: skip
def test_the_columns_of_every_command_have_different_names(command, more, run):
    code, _, err, heads = run(PINNED, command, *more)
    assert code == 0, err
    assert len(heads) == 1
    assert len(set(heads[0])) == len(heads[0])
