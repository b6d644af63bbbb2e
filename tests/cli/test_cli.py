"""The command line: reports, imports, help, completion, exit statuses."""

import json
import os
import shlex
import subprocess
import sys
from importlib import import_module

import processes
import pytest
from bundled import FEWEST, MODELS, README
from in_process import SERVERS, printed as gim, ran

import gimcli
from gimcli.cli import COMMANDS, GROUPS

ENDING = [name for name in COMMANDS if name not in SERVERS]
"""The commands that end by themselves."""


def test_help_imports_nothing_heavy():
    code = (
        "import sys; sys.argv = ['gim', '--help']\n"
        "from gimcli.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "heavy = {'numba', 'matplotlib', 'scipy', 'numpy', 'pydantic', 'yaml'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_a_trace_by_dyads_imports_only_what_it_uses(tmp_path):
    code = (
        f"import sys; sys.argv = ['gim', 'trace', {str(MODELS / 'crank_rocker.yaml')!r}]\n"
        f"sys.argv += ['--no-png', '-o', {str(tmp_path)!r}]\n"
        "from gimcli.cli import main\n"
        "main_exit = None\n"
        "try: main()\n"
        "except SystemExit as e: main_exit = e.code\n"
        "assert not main_exit, main_exit\n"
        "import numpy; own = {'numpy.ma'} if numpy.__version__ < '2' else set()\n"  # numpy 1 imports it itself
        "heavy = {'numba', 'matplotlib', 'scipy', 'rich', 'pydantic', 'numpy.ma'} & set(sys.modules) - own\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_the_mobility_is_found_without_the_solution_of_motions():
    code = (
        f"import sys; sys.argv = ['gim', 'mobility', {str(MODELS / 'crank_rocker.yaml')!r}]\n"
        "from gimcli.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "surplus = {'gimcli.motion', 'gimcli.continuation', 'gimcli.dynamics'} & set(sys.modules)\n"
        "assert not surplus, surplus\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_fits_a_terminal_and_begins_with_examples(command):
    """At most 50 lines of 80 columns; usage and examples in the first 24; groups of options have names."""
    lines = gim(command, "--help").splitlines()
    assert len(lines) <= 50
    assert max(map(len, lines)) <= 80
    head = "\n".join(lines[:24])
    examples = import_module(f"gimcli.cli.{command}").EXAMPLES
    assert all(f"  {example}\n" in head + "\n" and example.startswith(f"gim {command}") for example in examples)
    assert head.startswith(f"Usage: gim {command} ")
    assert COMMANDS[command] in " ".join(head.split())
    assert lines[-1] == f"More: gim manual {command}"
    assert "Options:" not in lines or command in ("schema", "manual")


@pytest.mark.few(8)
@pytest.mark.parametrize("example", [e for name in ENDING for e in import_module(f"gimcli.cli.{name}").EXAMPLES])
def test_the_examples_of_the_help_run(example, tmp_path):
    (tmp_path / "models").symlink_to(MODELS)
    words = shlex.split(example.partition(" | ")[0].partition(" > ")[0])
    assert gim(*words[1:], cwd=tmp_path)


def test_commands_are_listed_in_groups():
    lines = gim("--help").splitlines()
    assert len(lines) <= 50
    assert max(map(len, lines)) <= 80
    for title, commands in GROUPS.items():
        start = lines.index(f"{title}:")
        listed = " ".join(" ".join(lines[start + 1 : start + 2 * len(commands) + 1]).split())
        assert all(f"{name} {line}" in listed for name, line in commands.items())


def test_the_package_runs_as_a_module():
    done = subprocess.run([sys.executable, "-m", "gimcli", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("gim ")


@pytest.mark.parametrize(
    ("words", "complete"),
    [
        ("gim tr", ["trace", "tradeoff"]), ("gim trace --at", ["--at-limit"]), ("gim sim", ["simulate"]),
        ("gim trace --at-limit s", ["stop", "skip"]), ("gim view --no", ["--no-browser"]),
        ("gim fit --timing given --any", ["--any-order"]), ("gim forces --circ", []),
    ],
)  # fmt: skip
def test_a_shell_completes_commands_options_and_words(words, complete):
    """Nothing of the analyses is imported for it."""
    shell = {"_GIM_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(len(words.split()) - 1)}
    python = [sys.executable, "-X", "importtime", "-m", "gimcli"]
    done = subprocess.run(python, env=os.environ | shell, capture_output=True, text=True)
    assert done.stdout.split() == complete
    imported = {line.split("|")[-1].strip() for line in done.stderr.splitlines()}
    assert "gimcli.cli" in imported
    assert not imported & {"numpy", "pydantic", "yaml", "gimcli.library", "gimcli.mechanism"}


def test_completion_can_be_shown(monkeypatch):
    monkeypatch.setattr("shellingham.detect_shell", lambda: ("bash", "/bin/bash"))  # whatever runs the tests
    assert "_GIM_COMPLETE" in gim("--show-completion")


DRIVEN = "actuators: {motor: {type: rotary, pivot: O, arm: A}}\n"
MASSES = "masses: {crank: {mass: 1, inertia: 1}}\n"


@pytest.mark.parametrize(
    ("more", "command", "code"),
    [(text, command, 3) for text in ("", DRIVEN) for command in ("forces", "simulate", "reduce")]
    + [(MASSES, command, 4) for command in ("forces", "simulate", "reduce", "solve", "trace", "tradeoff", "workspace")]
    + [(MASSES + DRIVEN, "simulate", 4)],
)
def test_a_model_without_masses_ends_with_3_and_without_actuators_with_4(more, command, code, tmp_path):
    text = "nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 3]}\nground: [O, G]\n"
    (tmp_path / "m.yaml").write_text(text + "links: {crank: [O, A], rod: [A, B], rocker: [G, B]}\n" + more)
    assert ran(command, "m.yaml", cwd=tmp_path).code == code


def test_trace_json(tmp_path):
    report = json.loads(processes.gim("trace", MODELS / "crank_rocker.yaml", "--steps", 8, "--json", cwd=tmp_path))
    assert report["steps"] == 8
    assert report["solved"] == 9
    assert report["residual"] < 1e-10
    assert report["reachable"] == {"motor": [[0.0, 360.0]]}
    assert report["events"] == []
    assert (tmp_path / report["csv"]).is_file()
    assert (tmp_path / report["png"]).is_file()
    head, first = (tmp_path / report["csv"]).read_text().splitlines()[:2]
    assert head == "step,time,motor,P.x,P.y,B.x,B.y,residual,sweeps,status"
    assert first.startswith("0,0.0,0.0,")
    assert first.endswith(",0,ok")


def test_a_trace_beyond_a_limit_keeps_its_rows_and_reports_the_interval(tmp_path):
    """Triple rocker: the limit of the crank is where coupler and follower are in line (law of cosines)."""
    import math

    (tmp_path / "model.yaml").write_text(
        "nodes: {A: [0,0], B: [4,0.5], C: [5.2,2.4], D: [4,0]}\nground: [A,D]\n"
        "links: {a: {nodes: [A,B], length: 4}, b: {nodes: [B,C], length: 1.5}, c: {nodes: [D,C], length: 2}}\n"
        "actuators: {m: {type: rotary, pivot: A, arm: B, law: {from: 20, to: 200}}}\ntrace: [C]\n"
    )
    report = json.loads(gim("trace", "--steps", 90, "--no-png", "--json", cwd=tmp_path, code=5))
    limit = math.degrees(math.acos((4**2 + 4**2 - 3.5**2) / (2 * 4 * 4)))
    (start, end) = report["reachable"]["m"][0]
    assert start == 20.0
    assert end == pytest.approx(limit, abs=1e-8)
    assert report["events"][-1]["kind"] == "limit"
    rows = (tmp_path / "model.csv").read_text().splitlines()[1:]
    assert len(rows) == 91
    for k, row in enumerate(rows):
        cells = row.split(",")
        if 20 + 2 * k <= limit:
            assert cells[-1] == "ok"
        else:
            assert cells[3:6] == ["", "", ""]
            assert cells[-1] == "unreachable"


def test_solve_json_at_an_input(tmp_path):
    import math

    report = json.loads(gim("solve", MODELS / "crank_rocker.yaml", "--at", "motor=40", "--json"))
    assert report["status"] == "ok"
    a = complex(*report["nodes"]["A"])
    assert abs(a - 40 * complex(math.cos(math.radians(40)), math.sin(math.radians(40)))) < 1e-10
    b = complex(*report["nodes"]["B"])
    assert abs(b - a) == pytest.approx(120, abs=1e-9)
    assert abs(b - 100) == pytest.approx(80, abs=1e-9)
    assert set(report["points"]) == {"P"}


def test_sequence_json():
    report = json.loads(gim("sequence", MODELS / "stephenson_3_far.yaml", "--json"))
    (group,) = report["groups"]
    assert group["kind"] == "coupled"
    assert set(group["nodes"]) == {"B", "C", "E"}
    assert {"node", "about", "constraint", "rule"} <= set(group["steps"][0])
    classic = json.loads(gim("sequence", MODELS / "stephenson_3_far.yaml", "--strategy", "classic", "--json"))
    (by_rules,) = classic["groups"]
    assert 0.0 < group["radius"] <= by_rules["radius"]
    assert (by_rules["kind"], by_rules["incomplete"]) == ("strongly coupled", "")
    kinds = [g["kind"] for g in json.loads(gim("sequence", MODELS / "jansen.yaml", "--json"))["groups"]]
    assert set(kinds) == {"dyad"}


def test_mobility_json():
    report = json.loads(gim("mobility", MODELS / "parallelogram_third_crank.yaml", "--json"))
    assert (report["gruebler"], report["mobility"], report["actuators"]) == (0, 1, 1)
    assert len(report["redundant"]) == 1
    assert report["undriven"] == []


def test_a_random_start_is_repeatable_and_assembles():
    reports = [
        json.loads(gim("solve", MODELS / "platform_3rrr.yaml", "--start", "random", "--seed", 3, "--json"))
        for _ in range(2)
    ]
    assert reports[0] == reports[1]
    assert reports[0]["status"] == "ok"


def test_history_ends_below_the_tolerance(tmp_path):
    report = json.loads(
        gim("solve", MODELS / "gim_fig11.yaml", "--at", "FD=120", "--at", "OA=118.99494936611666", "--method", "gim",
            "--tolerance", "1e-5", "--history", "--strategy", "classic", "--json", "--png", tmp_path / "h.png")
    )  # fmt: skip
    assert report["sweeps"] == 13
    assert len(report["history"]) == 14
    assert max(report["history"][-1]) < 1e-5 <= max(report["history"][-2])
    assert report["rate"] == pytest.approx(report["radius"], rel=0.1)
    assert (tmp_path / "h.png").stat().st_size > 1000


@pytest.mark.few
@pytest.mark.parametrize("command", ["trace", "solve", "sequence", "mobility"])
def test_every_model_passes_through_every_command(command, model, tmp_path):
    extra = ["--steps", 12, "--out", tmp_path, "--no-png"] if command == "trace" else []
    if command == "sequence":
        extra.append("--explain")
    gim(command, model, *extra)


@pytest.mark.few(*FEWEST)
def test_every_model_is_drawn(model, tmp_path):
    path = tmp_path / "motion.png"
    gimcli.trace(gimcli.load(model), 12).save(path)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_the_example_of_the_readme_runs_and_its_error_is_the_printed_one(tmp_path):
    text = README.read_text()
    example = text.split("```yaml\n")[1].split("```")[0]
    (tmp_path / "model.yaml").write_text(example)
    assert json.loads(gim("trace", "--no-png", "--json", cwd=tmp_path))["solved"] == 361
    (tmp_path / "model.yaml").write_text(example.replace("[A, B], length", "[A, Bb], length"))
    message = text.split("```text\n")[1].split("\n```")[0]
    command = [sys.executable, "-c", "from gimcli.cli import main; main()", "trace"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert message in done.stderr


@pytest.mark.parametrize("model", ["crank_rocker", "double_butterfly", "parallelogram", "platform_3rrr"])
def test_solve_prints_errors_that_it_has_computed_only(model):
    """An estimate of the position error is rarely within a factor of 10 of the true one."""
    output = gim("solve", MODELS / f"{model}.yaml")
    assert "length error" in output
    assert "estimated" not in output
