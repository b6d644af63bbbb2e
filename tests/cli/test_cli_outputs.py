"""Output names: no command writes over a file that its model is read from."""

from __future__ import annotations

import inspect
import os
import shutil

import pytest
from in_process import MODULES

from gimcli import load
from gimcli.cli import main

MODEL = """\
nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 3]}
ground: [O, G]
links: {crank: [O, A], coupler: [A, B], rocker: [G, B]}
actuators:
  motor: {type: rotary, pivot: O, arm: A, law: {table: law.txt}, free: true, effort: {table: effort.txt}}
masses: {coupler: {mass: 1, inertia: 0.1}}
loads: {work: {on: rocker, torque: 1, table: load.txt}}
"""
TABLES = {"law.txt": "0,90\n1,100\n2,110\n", "effort.txt": "0,1\n2,1\n", "load.txt": "0,1\n2,2\n"}
FEW = {
    "trace": ["--steps", "2"], "forces": ["--steps", "2"], "reduce": ["--steps", "2"],
    "tradeoff": ["--steps", "2", "--tolerances", "1e-3"], "simulate": ["--time", "0.02", "--dt", "0.01"],
    "workspace": ["--grid", "2"], "circuits": ["--samples", "4"],
}  # fmt: skip
CASES = [(module.NAME, ()) for module in MODULES if module.NAME not in ("mobility", "schema")]
CASES += [("trace", ("--circuit",)), ("trace", ("--at-limit", "skip")), ("solve", ("--all",))]


def asked(name, more):
    """Return the arguments with which a command writes every file that it can."""
    module = next(module for module in MODULES if name == module.NAME)
    known = inspect.signature(module.command).parameters
    files = [f"--{kind}={name}.{kind}" for kind in ("csv", "png") if kind in known and "out" not in known]
    return [name, "m.yaml", *FEW.get(name, []), *more, *files]


def test_commands_that_are_left_out_write_nothing():
    for module in MODULES:
        if module.NAME in ("mobility", "schema"):
            assert not {"out", "csv", "png"} & set(inspect.signature(module.command).parameters)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in (("m.yaml", MODEL), *TABLES.items()):
        (tmp_path / name).write_text(text)
    return tmp_path


def run(monkeypatch, arguments):
    monkeypatch.setattr("sys.argv", ["gim", *arguments])
    try:
        main()
    except SystemExit as stop:
        return stop.code or 0
    return 0


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.mark.few(6)
@pytest.mark.parametrize(("name", "more"), CASES)
def test_no_command_writes_over_what_its_model_is_read_from(name, more, folder, monkeypatch, capsys):
    before = contents(folder)
    assert run(monkeypatch, asked(name, more)) == 0, capsys.readouterr().err
    written = sorted(set(contents(folder)) - set(before))
    assert written
    for output in written:
        (folder / output).unlink()
    for output in written:
        for source in before:
            for join in (os.link, os.symlink):
                join(folder / source, folder / output)
                capsys.readouterr()
                assert run(monkeypatch, asked(name, more)) == 2
                out, err = capsys.readouterr()
                assert out == ""
                assert output in err
                assert source in err
                (folder / output).unlink()
                assert contents(folder) == before


@pytest.mark.parametrize("key", ["law", "effort", "load"])
def test_a_table_that_has_the_name_of_the_output(key, folder, monkeypatch, capsys):
    shutil.move(folder / f"{key}.txt", folder / "m.csv")
    (folder / "m.yaml").write_text(MODEL.replace(f"{key}.txt", "m.csv"))
    assert run(monkeypatch, ["trace", "m.yaml", "--steps", "2", "--no-png"]) == 2
    assert "m.csv" in capsys.readouterr().err
    assert (folder / "m.csv").read_text() == TABLES[f"{key}.txt"]


def test_the_files_of_a_model_are_known(folder):
    mechanism = load(folder / "m.yaml")
    assert set(mechanism.files) == {folder / name for name in ("m.yaml", *TABLES)}
