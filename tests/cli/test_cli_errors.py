"""Errors on the command line: exit status, message, no text on standard output, no files left behind."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import signal
import subprocess
import sys
import time

import pytest
import yaml
from bundled import MODELS
from in_process import ANALYSES, refused

from gimcli.cli import main
from gimcli.model.source import read_source

FOUR = """\
units: {length: mm}
nodes: {O: [0, 0], G: [100, 0], A: [0, 40], B: [100, 80]}
ground: [O, G]
links: {crank: [O, A], coupler: [A, B], rocker: [G, B]}
"""


def more(link, nodes="Z: [9, 9]"):
    """Return the four-bar with another link and other nodes."""
    return FOUR.replace("B: [100, 80]", f"B: [100, 80], {nodes}").replace("rocker: [G, B]", f"rocker: [G, B], {link}")


CRANK = "actuators:\n  motor: {type: rotary, pivot: O, arm: A, law: {by: 10}}\n"
BOTH = CRANK + "  brake: {type: rotary, pivot: G, arm: B, law: {by: 10}}\n"

FIVE = """\
nodes: {O: [0, 0], G: [4, 0], A: [-1, 2], B: [2, 4], C: [5, 2]}
ground: [O, G]
links: {left: [O, A], a: [A, B], b: [B, C], right: [G, C]}
"""

THIRD_CRANK = """\
nodes: {{A: [0, 0], E: [1, 0], D: [2, 0], B: [0.5, 0.866], F: [1.5, 0.866], C: [2.5, 0.866]}}
ground: [A, E, D]
links:
  left: {{nodes: [A, B], length: 1}}
  middle: {{nodes: [E, F], length: {length!r}}}
  right: {{nodes: [D, C], length: 1}}
elements:
  bar: {{nodes: [B, F, C], shape: {{B: [0, 0], F: [1, 0], C: [2, 0]}}}}
actuators:
  motor: {{type: rotary, pivot: A, arm: B, law: {{from: 60, to: 120}}}}
"""

STRUCTURE = """\
nodes: {O: [0, 0], G: [2, 0], A: [1, 1]}
ground: [O, G]
links: {a: [O, A], b: [G, A]}
actuators:
  motor: {type: rotary, pivot: O, arm: A, law: {by: 10}}
"""


@pytest.fixture
def gim(tmp_path, monkeypatch, capsys):
    """Run the command line in its own folder; return exit status, standard output and standard error."""
    monkeypatch.chdir(tmp_path)

    def run(text, *arguments):
        if text is not None:
            (tmp_path / "m.yaml").write_text(text)
        monkeypatch.setattr("sys.argv", ["gim", *arguments])
        capsys.readouterr()
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code or 0
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return code, out, err

    return run


def started(*arguments, **more):
    """Start the command line in its own process."""
    command = [sys.executable, "-c", "from gimcli.cli import main; main()", *map(str, arguments)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, **more)


def refuse(token):
    raise AssertionError(f"{token} is no JSON")


def one_object(out):
    """Return the only JSON object on standard output."""
    assert out.endswith("\n")
    assert out.count("\n") == 1
    data = json.loads(out, parse_constant=refuse)
    assert isinstance(data, dict)
    return data


def files(folder):
    return sorted(p.name for p in folder.rglob("*") if p.name != "m.yaml")


# -- structure: exit status 4 ----------------------------------------------------------------

UNFIT = {
    "nothing drives a four-bar": FOUR,
    "one motor on a five-bar": FIVE + "actuators:\n  motor: {type: rotary, pivot: O, arm: A, law: {by: 5}}\n",
    "motors on crank and rocker": FOUR + BOTH,
    "two motors on one crank": FIVE + "actuators:\n  one: {type: rotary, pivot: O, arm: A, law: {by: 5}}\n"
        "  two: {type: rotary, pivot: O, arm: A, reference: G, law: {by: 5}}\n",
    "motor and jack on one crank": FIVE + "actuators:\n  one: {type: rotary, pivot: O, arm: A, law: {by: 5}}\n"
        "  two: {type: linear, nodes: [G, A], law: {by: 0.1}}\n",
    "a structure": STRUCTURE,
    "a braced four-bar": more("brace: [O, B]") + CRANK,
    "a dangling link": more("tail: [B, C]", "C: [120, 90]") + CRANK,
    "a loose member": more("far: [C, D]", "C: [120, 90], D: [150, 90]") + CRANK,
    "surplus crank, 1e-3 too long": THIRD_CRANK.format(length=1.001),
    "surplus crank, 1e-6 too long": THIRD_CRANK.format(length=1.000001),
}  # fmt: skip


@pytest.mark.parametrize("command", ["solve", "trace"])
@pytest.mark.parametrize("case", UNFIT)
def test_a_structure_that_cannot_be_driven(case, command, gim, tmp_path):
    more = ("--steps", "8", "--no-png") if command == "trace" else ()
    code, out, err = gim(UNFIT[case], command, "m.yaml", *more)
    assert (code, out) == (4, ""), err
    assert files(tmp_path) == []


FOLLOWING = {
    # name: arguments
    "circuits": ("circuits", "m.yaml", "--samples", "8"),
    "groups": ("groups", "m.yaml"),
    "reduce": ("reduce", "m.yaml", "--no-png"),
    "singularities": ("singularities", "m.yaml"),
    "solve --all": ("solve", "m.yaml", "--all"),
    "trace --branch": ("trace", "m.yaml", "--branch", "2", "--steps", "8", "--no-png"),
    "trace --circuit": ("trace", "m.yaml", "--circuit", "--steps", "8", "--no-png"),
}  # fmt: skip


@pytest.mark.parametrize("command", FOLLOWING)
@pytest.mark.parametrize("case", [case for case in UNFIT if not case.startswith("surplus")])
def test_commands_that_follow_circuits_refuse_the_same_structures(case, command, gim, tmp_path):
    text = UNFIT[case]
    first = next(iter(yaml.safe_load(text)["links"]))
    code, out, err = gim(f"{text}masses: {{{first}: {{mass: 1}}}}\n", *FOLLOWING[command])
    assert (code, out) == (4, ""), err
    assert files(tmp_path) == []


@pytest.mark.parametrize("case", UNFIT)
def test_as_json_a_structure_that_cannot_be_driven_is_an_error(case, gim):
    code, out, err = gim(UNFIT[case], "solve", "m.yaml", "--json")
    assert code == 4
    failed(out, err, 4)


def test_an_exact_surplus_crank_is_accepted(gim):
    code, _, err = gim(THIRD_CRANK.format(length=1), "trace", "m.yaml", "--steps", "8", "--no-png")
    assert code == 0, err


def test_a_surplus_crank_is_accepted_within_the_tolerance(gim):
    text = THIRD_CRANK.format(length=1.000001)
    code, _, err = gim(text, "solve", "m.yaml", "--tolerance", "1e-4")
    assert code == 0, err


def test_mobility_reports_undriven_nodes_and_surplus_actuators(gim):
    data = one_object(gim(UNFIT["one motor on a five-bar"], "mobility", "m.yaml", "--json")[1])
    assert (data["mobility"], data["actuators"], data["undriven"]) == (2, 1, ["B", "C"])
    data = one_object(gim(FOUR + BOTH, "mobility", "m.yaml", "--json")[1])
    assert (data["mobility"], data["gruebler"], data["overdriven"]) == (1, 1, ["brake"])
    data = one_object(gim(STRUCTURE, "mobility", "m.yaml", "--json")[1])
    assert (data["mobility"], data["gruebler"]) == (0, 0)


# -- positions that are not solved: exit status 5 --------------------------------------------

# With base 100, crank 90, coupler 30 and rocker 80 the crank cannot make a full turn.
LIMITED = """\
nodes: {O: [0, 0], G: [100, 0], A: [63.64, 63.64], B: [79, 77.2]}
ground: [O, G]
links:
  crank: {nodes: [O, A], length: 90}
  coupler: {nodes: [A, B], length: 30}
  rocker: {nodes: [G, B], length: 80}
actuators:
  motor: {type: rotary, pivot: O, arm: A, law: {from: 45, to: 360}}
"""


def test_an_unreachable_law_keeps_every_row(gim, tmp_path):
    code, out, err = gim(LIMITED, "trace", "m.yaml", "--steps", "20", "--no-png", "--json")
    assert code == 5, err
    data = one_object(out)
    with (tmp_path / "m.csv").open(newline="") as handle:
        rows = list(csv.DictReader(handle))
    assert [int(row["step"]) for row in rows] == list(range(21))
    assert rows[0]["status"] == "ok"
    lost = [row for row in rows if row["status"] != "ok"]
    assert len(lost) == 21 - data["solved"] > 0
    for row in lost:
        assert row["status"] == "unreachable"
        assert [row[key] for key in ("A.x", "A.y", "B.x", "B.y")] == [""] * 4
        assert row["motor"] != ""
    for row in rows:
        if row["status"] == "ok":
            assert abs(complex(float(row["A.x"]), float(row["A.y"]))) == pytest.approx(90.0, rel=1e-9)
    # A is farthest from G, at 30 + 80, where the coupler and the rocker are in line (law of cosines)
    limit = math.degrees(math.acos((90**2 + 100**2 - 110**2) / (2 * 90 * 100)))
    assert data["reachable"]["motor"] == [[pytest.approx(45.0), pytest.approx(limit, abs=1e-6)]]


PARALLELOGRAM = """\
nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 1]}
ground: [O, G]
links: {a: [O, A], b: [A, B], c: [B, G]}
actuators: {m: {type: rotary, pivot: O, arm: A, law: {from: 90, to: END}}}
"""


@pytest.mark.few(2)
@pytest.mark.parametrize("end", [360, 3600, 36_000])
def test_a_long_law_passes_change_points_like_a_short_one(end, gim):
    code, _, err = gim(PARALLELOGRAM.replace("END", str(end)), "trace", "m.yaml", "--steps", "8", "--no-png")
    assert code == 0, err


TOO_SHORT = """\
nodes: {O: [0, 0], G: [100, 0], A: [0, 40], B: [100, 80]}
ground: [O, G]
links:
  crank: {nodes: [O, A], length: 40}
  coupler: {nodes: [A, B], length: 5}
  rocker: {nodes: [G, B], length: 10}
actuators:
  motor: {type: rotary, pivot: O, arm: A, law: {from: 90, to: 100}}
"""


@pytest.mark.parametrize("command", ["solve", "trace", "tradeoff"])
def test_dimensions_that_cannot_be_assembled_name_the_worst_constraint(command, gim):
    more = ("--steps", "4", "--no-png") if command != "solve" else ()
    code, out, err = gim(TOO_SHORT, command, "m.yaml", *more)
    assert code == 5, err
    assert "not-assembled" in out
    assert "coupler" in out or "rocker" in out


def test_as_json_dimensions_that_cannot_be_assembled(gim):
    code, out, _ = gim(TOO_SHORT, "solve", "m.yaml", "--json")
    data = one_object(out)
    assert code == 5
    assert data["status"] == "not-assembled"
    assert data["worst"] in ("coupler", "rocker")
    assert data["nodes"] == {}
    assert data["residual"] is None or data["residual"] > 1e-3
    code, out, _ = gim(TOO_SHORT, "trace", "m.yaml", "--json", "--steps", "4", "--no-png")
    data = one_object(out)
    assert (code, data["solved"], data["residual"]) == (5, 0, None)


FAR_START = """\
units: {length: m}
nodes: {A: [7, 4], B: [31, 23], C: [-7, -22], D: [23, 10], E: [1, -9], F: [25, -17], G: [45, 17]}
ground: [A, D, G]
links:
  AB: {nodes: [A, B], length: 12.16552506059644}
  CD: {nodes: [C, D], length: 15.132745950421556}
  EF: {nodes: [E, F], length: 25.179356624028344}
  FG: {nodes: [F, G], length: 15.132745950421556}
elements:
  BCE: {nodes: [B, C, E], shape: {B: [5, 16], C: [25, 25], E: [18, 35]}}
actuators:
  motor: {type: rotary, pivot: A, arm: B, law: {from: 42, to: 140}}
"""
"""Stephenson III (models/stephenson_3.yaml) drawn far from where its crank can stand."""


def test_a_start_too_far_away_names_two_cures_that_work(gim):
    code, out, _ = gim(FAR_START, "solve", "m.yaml")
    assert code == 5
    assert "not-assembled" in out
    for cure in ("gim solve --all", "gim solve --start random"):
        assert cure in out
        code, found, _ = gim(FAR_START, *cure.split()[1:], "m.yaml", "--json")
        assert code == 0, cure
        assert json.loads(found).get("status", "ok") == "ok"


# -- output: exit status 6 -------------------------------------------------------------------


def test_the_output_folder_is_a_file(gim, tmp_path):
    (tmp_path / "taken").write_text("mine")
    code, out, err = gim(FOUR + CRANK, "trace", "m.yaml", "--steps", "4", "--out", "taken")
    assert (code, out) == (6, ""), err
    assert "taken" in err
    assert files(tmp_path) == ["taken"]
    assert (tmp_path / "taken").read_text() == "mine"


def test_a_folder_has_the_name_of_the_output(gim, tmp_path):
    (tmp_path / "m.csv").mkdir()
    code, out, err = gim(FOUR + CRANK, "trace", "m.yaml", "--steps", "4")
    assert (code, out) == (6, ""), err
    assert "m.csv" in err
    assert files(tmp_path) == ["m.csv"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root writes everywhere")
def test_a_folder_that_cannot_be_written(gim, tmp_path):
    (tmp_path / "locked").mkdir(mode=0o555)
    code, out, err = gim(FOUR + CRANK, "trace", "m.yaml", "--steps", "4", "--out", "locked")
    assert (code, out) == (6, ""), err
    assert "locked" in err
    assert files(tmp_path) == ["locked"]


def test_a_folder_that_cannot_be_created(gim, tmp_path):
    code, out, err = gim(FOUR + CRANK, "trace", "m.yaml", "--steps", "4", "--out", "/proc/nothing/here")
    assert (code, out) == (6, ""), err
    assert "/proc/nothing" in err
    assert files(tmp_path) == []


def test_if_the_picture_cannot_be_written_the_table_is_not_written(gim, tmp_path):
    (tmp_path / "m.png").mkdir()
    code, out, err = gim(FOUR + CRANK, "trace", "m.yaml", "--steps", "4")
    assert (code, out) == (6, ""), err
    assert "m.png" in err
    assert [name for name in files(tmp_path) if name.endswith(".part")] == []
    assert files(tmp_path) == ["m.png"]


@pytest.mark.parametrize(("command", "name"), [("trace", "m"), ("tradeoff", "m.tradeoff")])
@pytest.mark.parametrize("kind", ["csv", "png"])
def test_an_unwritable_file_is_refused_before_the_computation(command, name, kind, gim, tmp_path, monkeypatch):
    def late(*_):
        raise AssertionError("the computation has begun")

    monkeypatch.setattr("gimcli.library.tradeoff.compare", late)
    monkeypatch.setattr("gimcli.motion.summary.Summary.add", late)
    (tmp_path / f"{name}.{kind}").mkdir()
    code, out, err = gim(FOUR + CRANK, command, "m.yaml", "--steps", "4")
    assert (code, out) == (6, ""), err
    assert f"{name}.{kind}" in err
    assert files(tmp_path) == [f"{name}.{kind}"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_trace_that_is_stopped_leaves_nothing(number, tmp_path):
    (tmp_path / "m.yaml").write_text(FOUR + CRANK)

    def receive() -> None:
        """Accept the signal: processes started in the background ignore it."""
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    arguments = ("trace", "m.yaml", "--steps", 10_000_000, "--no-png")
    running = started(*arguments, cwd=tmp_path, stdout=subprocess.PIPE, preexec_fn=receive)
    deadline = time.monotonic() + 60
    while not files(tmp_path) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert [name.endswith(".part") for name in files(tmp_path)] == [True]
    running.send_signal(number)
    out, err = running.communicate(timeout=60)
    assert (running.returncode, out, err) == (128 + number, b"", b"")
    assert files(tmp_path) == []


@pytest.mark.few(4)
@pytest.mark.parametrize("command", ["solve", "trace", "sequence", "mobility"])
@pytest.mark.parametrize("more", [(), ("--json",)])
def test_a_closed_pipe_is_not_an_error(command, more, tmp_path):
    (tmp_path / "m.yaml").write_text(FOUR + CRANK)
    reading, writing = os.pipe()
    os.close(reading)
    running = started(command, "m.yaml", *more, cwd=tmp_path, stdout=writing)
    os.close(writing)
    _, err = running.communicate(timeout=60)
    assert (running.returncode, err) == (0, b"")
    assert files(tmp_path) == (["m.csv", "m.png"] if command == "trace" else [])


@pytest.mark.parametrize("kind", ["csv", "png"])
def test_a_position_that_cannot_be_written(kind, gim, tmp_path):
    (tmp_path / f"there.{kind}").mkdir()
    code, out, err = gim(FOUR + CRANK, "solve", "m.yaml", f"--{kind}", f"there.{kind}")
    assert (code, out) == (6, ""), err
    assert files(tmp_path) == [f"there.{kind}"]


def test_a_trace_replaces_its_earlier_files(gim, tmp_path):
    for _ in range(2):
        assert gim(FOUR + CRANK, "trace", "m.yaml", "--steps", "4", "--out", "new/deep", "--no-png")[0] == 0
    assert files(tmp_path) == ["deep", "m.csv", "new"]


def test_the_model_is_not_overwritten(gim, tmp_path):
    (tmp_path / "m.csv").write_text(FOUR + CRANK)
    code, out, err = gim(None, "trace", "m.csv", "--steps", "4", "--no-png")
    assert (code, out) == (2, ""), err
    assert (tmp_path / "m.csv").read_text() == FOUR + CRANK


# -- usage: exit status 2 --------------------------------------------------------------------


# -- JSON ------------------------------------------------------------------------------------

REPORTS = {
    "solve": (["solve", "m.yaml", "--json"], ["status", "residual", "sweeps", "nodes", "points"]),
    "solve, gim": (
        ["solve", "m.yaml", "--json", "--method", "gim", "--history", "--tolerance", "1e-6"],
        ["status", "nodes"],
    ),
    "trace": (
        ["trace", "m.yaml", "--json", "--steps", "4"],
        ["csv", "png", "steps", "solved", "residual", "reachable", "events"],
    ),
    "mobility": (
        ["mobility", "m.yaml", "--json"],
        ["gruebler", "rank", "mobility", "redundant", "undriven", "actuators"],
    ),
    "sequence": (["sequence", "m.yaml", "--json"], ["groups"]),
}  # fmt: skip


@pytest.mark.parametrize("case", REPORTS)
def test_json_is_one_object_and_nothing_else(case, gim):
    arguments, keys = REPORTS[case]
    code, out, err = gim(FOUR + CRANK, *arguments)
    assert code == 0, err
    assert err == ""
    assert set(keys) <= set(one_object(out))


BAR = """
import sys, time, typer
from gimcli.cli import console as progress
clock, beats = time.monotonic, iter(range(0, 1000, 10))
time.monotonic = lambda: clock() + next(beats)
show = progress.progress_bar("working")
show(1, 10)
assert progress._bars
typer.echo("report")
"""


def test_an_unfinished_progress_bar_is_removed():
    """Standard output is a file, standard error a terminal: the file has only the report, the cursor is shown again."""
    pty = pytest.importorskip("pty")
    screen, terminal = pty.openpty()
    done = subprocess.run([sys.executable, "-c", BAR], stdout=subprocess.PIPE, stderr=terminal, timeout=60)
    os.close(terminal)
    shown = os.read(screen, 65536)
    os.close(screen)
    assert (done.returncode, done.stdout) == (0, b"report\n")
    assert b"working" in shown
    assert shown.count(b"\x1b[?25l") == shown.count(b"\x1b[?25h") == 1


HEAVY = CRANK.replace("law: {by: 10}", "law: {by: 10}, free: true") + "masses: {crank: {mass: 1, inertia: 1}}\n"


def failed(out, err, status):
    """Check the object that a failure prints: the message of standard error, and the exit status."""
    report = one_object(out)
    assert set(report) == {"error", "exit"}
    assert report["exit"] == status
    assert report["error"].splitlines()[-1] in err


@pytest.mark.parametrize("command", ANALYSES)
def test_json_for_an_invalid_model_is_an_error(command, gim):
    code, out, err = gim("nodes: {}\n", command, "m.yaml", "--json")
    assert code == 3
    failed(out, err, 3)


@pytest.mark.parametrize("command", ANALYSES)
def test_json_for_wrong_usage_is_an_error(command, gim):
    code, out, err = gim(FOUR + CRANK, command, "m.yaml", "--json", "--nothing")
    assert code == 2
    failed(out, err, 2)


@pytest.mark.parametrize("command", ANALYSES)
@pytest.mark.parametrize("case", ["undriven", "too short", "cannot be written"])
def test_json_for_every_failure_is_one_object(case, command, gim, tmp_path):
    (tmp_path / "taken").write_text("")
    text = {"undriven": FOUR, "too short": TOO_SHORT, "cannot be written": FOUR + HEAVY}[case]
    unwritable = ["--out=taken/m.csv"] if case == "cannot be written" else []
    code, out, err = gim(text, command, "m.yaml", "--json", *unwritable)
    data = one_object(out)
    if "error" in data:
        failed(out, err, code)
        assert code != 0
    if unwritable:
        assert (code, set(data)) == (6, {"error", "exit"})


def test_the_model_defaults_to_model_yaml(gim, tmp_path):
    (tmp_path / "model.yaml").write_text(FOUR + CRANK)
    code, out, err = gim(None, "solve", "--json")
    assert code == 0, err
    assert one_object(out)["nodes"]["G"] == [100.0, 0.0]
    code, out, err = gim(None, "trace", "--steps", "4", "--no-png", "--json")
    assert code == 0, err
    assert one_object(out)["csv"] == "model.csv"
    assert (tmp_path / "model.csv").is_file()


def test_names_may_have_commas_quotes_and_spaces(gim, tmp_path):
    data = yaml.safe_load(FOUR)
    names = {"A": "a,b", "B": 'say "Ä"', "O": "1", "G": "x y"}
    data["nodes"] = {names[k]: v for k, v in data["nodes"].items()}
    data["ground"] = ["1", "x y"]
    data["links"] = {k: [names[n] for n in v] for k, v in data["links"].items()}
    data["actuators"] = {"motor 1": {"type": "rotary", "pivot": "1", "arm": "a,b", "law": {"by": 10}}}
    text = yaml.safe_dump(data, allow_unicode=True, sort_keys=False)
    assert gim(text, "trace", "m.yaml", "--steps", "2")[0] == 0
    assert list(read_source(tmp_path / "m.yaml").data["nodes"]) == list(data["nodes"])
    with (tmp_path / "m.csv").open(newline="", encoding="utf-8") as handle:
        head = next(csv.reader(handle))
    assert head[2:7] == ["motor 1", "a,b.x", "a,b.y", 'say "Ä".x', 'say "Ä".y']
    code, out, _ = gim(None, "solve", "m.yaml", "--json", "--at", "motor 1=91")
    assert code == 0
    assert set(one_object(out)["nodes"]) == set(names.values())


# -- requested files -------------------------------------------------------------------------


def test_a_table_is_never_written_over_the_model(gim, tmp_path):
    text = FOUR + CRANK
    for more in ((), ("--all",)):
        code, out, _ = gim(text, "solve", "m.yaml", "--csv", "m.yaml", *more)
        assert (code, out) == (2, "")
        assert (tmp_path / "m.yaml").read_text() == text


@pytest.mark.parametrize("command", ["solve", "singularities", "circuits", "groups", "sequence"])
def test_an_impossible_picture_is_refused_before_the_computation(command, gim, tmp_path):
    """Suffix and folder are checked first: the computation would report that nothing drives the mechanism."""
    (tmp_path / "file").write_text("")
    more = ("--csv", "m.csv") if command == "solve" else ()
    for png, status in (("m.foo", 2), ("file/m.png", 6)):
        code, out, err = gim(FOUR, command, "m.yaml", "--png", png, *more)
        assert (code, out) == (status, ""), err
        assert png in err
    assert files(tmp_path) == ["file"]


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("command", ["solve", "solve --all", "sequence", "groups", "circuits --samples 8"])
def test_written_files_are_reported(command, gim, tmp_path):
    name, *more = command.split()
    code, out, err = gim(FOUR + CRANK, name, "m.yaml", "--png", "m.png", *more)
    assert code == 0, err
    assert out.endswith("wrote m.png\n")
    code, out, _ = gim(FOUR + CRANK, name, "m.yaml", "--png", "m.png", "--json", *more)
    assert (code, one_object(out)["png"]) == (0, "m.png")
    assert files(tmp_path) == ["m.png"]


# -- reports ---------------------------------------------------------------------------------


def test_the_reached_interval_of_a_law_that_turns_back_has_its_maximum(gim, tmp_path):
    """The motor moves from 90 deg to 130 deg and back to 100 deg: the interval ends at 130 deg."""
    (tmp_path / "law.csv").write_text("0,90\n0.5,130\n1,100\n")
    text = FOUR + "actuators:\n  motor: {type: rotary, pivot: O, arm: A, law: {table: law.csv}}\n"
    code, out, err = gim(text, "trace", "m.yaml", "--steps", "4", "--no-png", "--json")
    assert code == 0, err
    assert one_object(out)["reachable"]["motor"] == [pytest.approx([90.0, 130.0], abs=1e-9)]


def test_the_reached_interval_of_a_decreasing_law_keeps_its_direction(gim):
    text = FOUR + "actuators:\n  motor: {type: rotary, pivot: O, arm: A, law: {from: 90, to: 60}}\n"
    code, out, err = gim(text, "trace", "m.yaml", "--steps", "4", "--no-png", "--json")
    assert code == 0, err
    assert one_object(out)["reachable"]["motor"] == [pytest.approx([90.0, 60.0], abs=1e-9)]


def test_at_change_points_only_members_with_different_rates_are_listed(gim):
    """The crank of a parallelogram has the same rate on both branches at both change points."""
    code, out, err = gim(None, "singularities", str(MODELS / "parallelogram.yaml"))
    assert code == 0, err
    assert "follower -0.5, coupler +0.5" in out
    assert "crank +1" not in out


NARROW = """
from gimcli.cli import console
console.print_table("t", ("name", *"abcdef"), [("a long name that may be broken", *["-1.2345678901"] * 6)], range(1, 7))
"""


def test_numbers_are_not_wrapped_on_a_narrow_terminal():
    """A name may be wrapped; a wrapped number would look like two numbers."""
    pty = pytest.importorskip("pty")
    screen, terminal = pty.openpty()
    done = subprocess.run(
        [sys.executable, "-c", NARROW], stdout=terminal, env={**os.environ, "COLUMNS": "60"}, timeout=60
    )
    os.close(terminal)
    shown = os.read(screen, 65536).decode()
    os.close(screen)
    assert done.returncode == 0
    assert shown.count("-1.2345678901") == 6


def test_forces_of_a_mechanism_that_cannot_be_assembled_have_no_table_of_peaks(gim):
    text = TOO_SHORT + "masses: {crank: {mass: 1, inertia: 1}}\n"
    code, out, err = gim(text, "forces", "m.yaml", "--steps", "4")
    assert code == 5, err
    assert "peak" not in out


ROCKER = """
nodes: {O: [0, 0], A: [40, 0], B: [136.67, 71.1], G: [100, 0]}
ground: [O, G]
links: {crank: [O, A], coupler: [A, B], rocker: [G, B]}
actuators: {motor: {type: rotary, pivot: G, arm: B, law: {by: 120}}}
masses: {crank: {mass: 1, inertia: 0.01}}
"""
GIVEN = {"step", "time", "motor", "q", "sweeps", "status"}
"""Columns that have values without a position."""


@pytest.mark.parametrize(
    "arguments", [("trace", "-d", "3", "-m", "transmission", "-m", "area:coupler"), ("forces",), ("reduce",)]
)
def test_rows_that_are_not_solved_have_empty_cells(arguments, gim):
    """A driven rocker reaches its limit within the law; complex columns have two cells."""
    code, out, err = gim(ROCKER, arguments[0], "m.yaml", *arguments[1:], "--steps", "8", "-o", "-")
    assert code == 5, err
    rows = [row for row in csv.DictReader(io.StringIO(out)) if row["status"] != "ok"]
    assert rows
    for row in rows:
        assert {name for name, cell in row.items() if cell} <= GIVEN


def test_a_coarse_position_is_not_written_into_a_model_file(tmp_path):
    coarse = ["--method=gim", "--tolerance=1e-2"]
    text = refused("solve", MODELS / "crank_rocker.yaml", *coarse, "-o", tmp_path / "new.yaml")
    assert "use a smaller tolerance" in text
    assert not list(tmp_path.iterdir())
