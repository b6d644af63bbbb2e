"""Outputs: one rule for `-o` in every command; no command writes over a file that its model is read from."""

from __future__ import annotations

import csv
import io
import json
import os
import shutil

import numpy as np
import pytest
from in_process import ANALYSES

from gimcli import UsageError, load, solve
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
    "sensitivity": ["--steps", "2"],
    "sweep": ["--steps", "2", "--vary", "crank.length=1,1.1"],
}  # fmt: skip
CASES = [(name, ()) for name in ANALYSES]
CASES += [("trace", ("--circuit",)), ("trace", ("--at-limit", "skip")), ("solve", ("--all",))]


def writing(name, more):
    """Return the arguments for which a command writes its usual files into the current folder."""
    return [name, "m.yaml", *FEW.get(name, []), *more, "--out=./"]


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


@pytest.mark.usefixtures("unrendered")
@pytest.mark.few(6)
@pytest.mark.parametrize(("name", "more"), CASES)
def test_no_command_overwrites_a_file_that_its_model_is_read_from(name, more, folder, monkeypatch, capsys):
    before = contents(folder)
    assert run(monkeypatch, writing(name, more)) == 0, capsys.readouterr().err
    written = sorted(set(contents(folder)) - set(before))
    assert written
    for output in written:
        (folder / output).unlink()
    for output in written:
        for source in before:
            for join in (os.link, os.symlink):
                join(folder / source, folder / output)
                capsys.readouterr()
                assert run(monkeypatch, writing(name, more)) == 2
                out, err = capsys.readouterr()
                assert out == ""
                assert output in err
                assert source in err
                (folder / output).unlink()
                assert contents(folder) == before


@pytest.mark.parametrize("key", ["law", "effort", "load"])
def test_a_table_with_the_name_of_the_output_is_not_overwritten(key, folder, monkeypatch, capsys):
    shutil.move(folder / f"{key}.txt", folder / "m.csv")
    (folder / "m.yaml").write_text(MODEL.replace(f"{key}.txt", "m.csv"))
    assert run(monkeypatch, ["trace", "m.yaml", "--steps", "2", "--no-png"]) == 2
    assert "m.csv" in capsys.readouterr().err
    assert (folder / "m.csv").read_text() == TABLES[f"{key}.txt"]


def test_the_files_of_a_model_are_known(folder):
    mechanism = load(folder / "m.yaml")
    assert set(mechanism.files) == {folder / name for name in ("m.yaml", *TABLES)}


WRITERS = {
    "trace": "m", "forces": "m.forces", "simulate": "m.simulation", "reduce": "m.reduced", "workspace": "m.workspace",
    "tradeoff": "m.tradeoff", "sweep": "m.sweep",
    "sensitivity": "m.sensitivity",
}  # fmt: skip
"""Commands that write files by default, and the stems of the files."""
TEXTS = ("check", "mobility")
"""Commands without a picture."""
DRAWN = {name: (".png", ".svg", ".pdf") for name in ANALYSES if name not in TEXTS}
MOVING = {name: (".html",) for name in ("trace", "solve", "circuits", "singularities", "simulate", "check", "sweep")}
KINDS = {name: (".csv", ".npz", ".json", *DRAWN.get(name, ()), *MOVING.get(name, ())) for name in ANALYSES}


def named(folder):
    return {path.name for path in folder.rglob("*") if path.is_file()} - {"m.yaml", *TABLES}


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("name", ANALYSES)
def test_only_some_commands_write_files_by_default(name, folder, monkeypatch, capsys):
    assert run(monkeypatch, [name, "m.yaml", *FEW.get(name, [])]) == 0
    kinds = [".csv", *[".png"] * (name not in TEXTS), *([".npz"] if name == "workspace" else [])]
    assert named(folder) == ({WRITERS[name] + kind for kind in kinds} if name in WRITERS else set())


@pytest.mark.usefixtures("unrendered")
@pytest.mark.few(4)
@pytest.mark.parametrize("name", ANALYSES)
def test_only_named_files_are_written(name, folder, monkeypatch, capsys):
    files = [f"deep/{name}{kind}" for kind in KINDS[name]]
    assert run(monkeypatch, [name, "m.yaml", *FEW.get(name, []), *(f"--out={path}" for path in files), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert {str(path.relative_to(folder)) for path in (folder / "deep").iterdir()} == set(files)
    assert set(report["files"]) == set(files)
    assert (report["csv"], report["png"]) == (files[0], next((f for f in files if f.endswith(".png")), None))
    saved = json.loads((folder / f"deep/{name}.json").read_text())
    assert set(saved) == set(report) - {"csv", "png", "npz", "files"}
    with np.load(folder / f"deep/{name}.npz") as arrays:
        with open(folder / f"deep/{name}.csv", newline="") as handle:
            rows = list(csv.DictReader(handle))
        if "grid" in report:
            assert {"x", "y", "input_motor"} == set(arrays)
        else:
            assert list(arrays) == list(rows[0])
            assert {len(arrays[column]) for column in arrays} == {len(rows)}


@pytest.mark.few(4)
@pytest.mark.parametrize("name", ANALYSES)
@pytest.mark.parametrize("place", ["new", "made/", "there", "a.b/"])
def test_a_folder_gets_the_usual_files(place, name, folder, monkeypatch, capsys):
    (folder / "there").mkdir()
    assert run(monkeypatch, [name, "m.yaml", *FEW.get(name, []), "--out", place]) == 0
    kinds = {".csv", *([".png"] if name not in TEXTS else []), *([".npz"] if name == "workspace" else [])}
    stem = WRITERS.get(name, f"m.{name}")
    assert {path.name for path in (folder / place).iterdir()} == {stem + kind for kind in kinds}
    assert named(folder) == {stem + kind for kind in kinds}


@pytest.mark.few(4)
@pytest.mark.parametrize("name", ANALYSES)
def test_standard_output_has_only_the_table(name, folder, monkeypatch, capsys):
    options = ["--out=file.csv"] if name != "tradeoff" else []  # its times differ
    assert run(monkeypatch, [name, "m.yaml", *FEW.get(name, []), "-o", "-", *options]) == 0
    out, err = capsys.readouterr()
    rows = list(csv.reader(io.StringIO(out)))
    assert len(rows) > 1
    assert {len(row) for row in rows} == {len(rows[0])}
    assert err.strip()
    if options:
        assert out == (folder / "file.csv").read_text()
    assert named(folder) == {"file.csv"} & {option.removeprefix("--out=") for option in options}


@pytest.mark.parametrize("name", ANALYSES)
@pytest.mark.parametrize("place", ["m.xyz", "m.yaml.bak", "x.csvv"])
def test_an_unknown_format_is_refused_with_the_known_ones(place, name, folder, monkeypatch, capsys):
    assert run(monkeypatch, [name, "m.yaml", "-o", place]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert all(word in err for word in (place, ".csv", ".npz", ".json"))
    assert named(folder) == set()


def test_standard_output_cannot_have_both_table_and_report(folder, monkeypatch, capsys):
    assert run(monkeypatch, ["trace", "m.yaml", "-o", "-", "--json"]) == 2
    assert json.loads(capsys.readouterr().out)["exit"] == 2


def test_a_motion_that_is_written_in_several_formats_is_the_same(folder, monkeypatch, capsys):
    assert run(monkeypatch, ["trace", "m.yaml", "--steps=20", "--out=a.csv", "--out=b.csv", "--out=c.npz"]) == 0
    assert (folder / "a.csv").read_bytes() == (folder / "b.csv").read_bytes()
    rows = list(csv.DictReader(io.StringIO((folder / "a.csv").read_text())))
    with np.load(folder / "c.npz") as arrays:
        assert [float(row["A.x"]) for row in rows] == arrays["A.x"].tolist()


OLD = [
    (["trace", "--steps=2", "--png", "-o", "old"], {"m.csv", "m.png"}),
    (["trace", "--steps=2", "--no-png", "-o", "old"], {"m.csv"}),
    (["solve", "--csv=old/a.csv", "--png=old/b.svg"], {"a.csv", "b.svg"}),
    (["solve", "--all", "--csv=old/a.csv", "--png=old/b.png"], {"a.csv", "b.png"}),
    (["circuits", "--samples=4", "--png=old/c.png"], {"c.png"}),
    (["singularities", "--png=old/c.pdf"], {"c.pdf"}),
    (["sequence", "--png=old/c.png"], {"c.png"}),
    (["groups", "--png=old/c.png"], {"c.png"}),
    (["simulate", "--time=0.02", "--dt=0.01", "--method=rk4", "--no-png", "--out=old"], {"m.simulation.csv"}),
]


@pytest.mark.few(4)
@pytest.mark.parametrize(("arguments", "files"), OLD)
def test_options_of_existing_scripts_are_accepted(arguments, files, folder, monkeypatch, capsys):
    name, *more = arguments
    assert run(monkeypatch, [name, "m.yaml", *more]) == 0
    assert {path.name for path in (folder / "old").iterdir()} == files


def test_a_result_is_saved_by_the_same_rule(folder):
    found = solve(load(folder / "m.yaml"))
    found.save("here.csv", "here.npz", "here.json", "here.svg", "all/")
    assert named(folder) == {"here.csv", "here.npz", "here.json", "here.svg", "m.solve.csv", "m.solve.png"}
    for place in ("-", "x.xyz", "m.yaml"):
        with pytest.raises(UsageError):
            found.save(place)
