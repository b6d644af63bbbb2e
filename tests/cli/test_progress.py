"""Progress on a terminal: every command shows a moving bar with the name of its phase, and removes it."""

from __future__ import annotations

import io
import json
import os
import pty
import subprocess
import sys
import time

import pytest
import rich.progress
from in_process import ANALYSES

from gimcli.cli import console as progress, main

MODEL = """\
nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 3]}
ground: [O, G]
links: {crank: [O, A], coupler: [A, B], rocker: [G, B]}
actuators: {m: {type: rotary, pivot: O, arm: A, law: {by: 20}, free: true}}
masses: {coupler: {mass: 1, inertia: 0.1}}
"""
PHASES = {
    "trace": (["--steps", "2"], ["tracing", "drawing"]),
    "forces": (["--steps", "2"], ["forces along the motion", "drawing"]),
    "equilibrium": (["--png", "e.png"], ["forces along the circuit", "drawing"]),
    "reduce": (["--steps", "2"], ["reducing", "drawing"]),
    "tradeoff": (["--steps", "2", "--tolerances", "1e-3"], ["comparing", "drawing"]),
    "simulate": (["--time", "0.02", "--dt", "0.01", "--reactions"], ["simulating", "reactions", "drawing"]),
    "workspace": (["--point", "B"], ["circuit", "drawing"]),
    "workspace --all": (["--point", "B"], ["configurations and their circuits", "drawing"]),
    "sensitivity": (["--steps", "2"], ["drawing"]),
    "sweep": (["--steps", "2", "--vary", "crank.length=1,1.1"], ["designs", "drawing"]),
    "circuits": (["--samples", "4", "--png", "c.png"], ["configurations and their circuits", "drawing"]),
    "singularities": (["--png", "s.png"], ["following branches", "drawing"]),
    "solve --all": (["--png", "a.png"], ["configurations", "drawing"]),
    "trace --all-branches": (
        ["--steps", "2"],
        ["following the circuit", "following branches", "positions along the circuit", "drawing"],
    ),
    "check": ([], ["following the circuit", "searching extremes of the motion"]),
    "solve": ([], []), "sequence": ([], []), "groups": ([], []), "mobility": ([], []), "schema": ([], []),
}  # fmt: skip


def test_every_command_is_here():
    assert set(ANALYSES) <= {name.split()[0] for name in PHASES}


class Bar:
    """Replaces rich's bar; keeps the labels."""

    shown: list[str]
    open = 0

    def __init__(self, *columns, **more):
        self.console = self

    def start(self):
        Bar.open += 1

    def stop(self):
        Bar.open -= 1

    def add_task(self, label, **more):
        Bar.shown.append(label)
        return 0

    def update(self, task, **more):
        pass

    def print(self, text, **more):
        pass


@pytest.fixture
def terminal(monkeypatch, tmp_path):
    """Make standard error look like a terminal, and show bars without delay."""

    class Screen(io.StringIO):
        def isatty(self):
            return True

    class Written(io.StringIO):
        def write(self, text):
            assert not Bar.open, f"{text!r} is written while a bar is on the terminal"
            return super().write(text)

    Bar.shown, Bar.open = [], 0
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.yaml").write_text(MODEL)
    monkeypatch.setattr(progress, "DELAY", 0.0)
    monkeypatch.setattr(progress, "Timer", Now)
    monkeypatch.setattr(rich.progress, "Progress", Bar)

    def run(*arguments):
        """Run the command line; return exit status, standard output and error."""
        out, err = Written(), Screen()
        with monkeypatch.context() as patch:  # here, because pytest replaces both between fixture and test
            patch.setattr(sys, "stderr", err)
            patch.setattr(sys, "stdout", out)
            patch.setattr(sys, "argv", ["gim", *arguments])
            try:
                main()
                code = 0
            except SystemExit as end:
                code = end.code or 0
        return code, out.getvalue(), err.getvalue()

    return run


class Now:
    """A timer that does not wait."""

    def __init__(self, delay, action):
        self.start = action

    def cancel(self):
        pass


@pytest.mark.usefixtures("unrendered")
@pytest.mark.few(15)
@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("name", PHASES)
def test_every_command_shows_its_phases_and_removes_the_bar_before_it_reports(name, as_json, terminal):
    more, phases = PHASES[name]
    if as_json and name != "schema":
        more = [*more, "--json"]
    command, *option = name.split()
    model = [] if name == "schema" else ["m.yaml"]
    code, out, err = terminal(command, *model, *option, *more)
    assert code == 0, err
    assert Bar.shown == [command, *phases]
    assert Bar.open == 0
    assert progress._phases == progress._bars == []
    if as_json:
        json.loads(out)


def test_an_error_removes_the_bar(terminal):
    code, out, err = terminal("solve", "none.yaml")
    assert (code, out) == (3, "")
    assert "none.yaml: no such file" in err
    assert Bar.shown == ["solve"]
    assert progress._phases == progress._bars == []


SILENT = """
import time
from gimcli.cli import console as progress
show = progress.progress_bar("thinking")
time.sleep(2.0)
progress.note("a note")
time.sleep(0.5)
show(1, 4)
time.sleep(0.5)
show(4, 4)
time.sleep(0.5)
progress.end_bars()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals of this kind")
def test_a_computation_without_reports_shows_a_moving_bar():
    """The spinner moves without reports, a note is printed above the bar, and the cursor is shown again at the end."""
    screen, side = pty.openpty()
    began = time.monotonic()
    done = subprocess.Popen([sys.executable, "-c", SILENT], stdout=subprocess.DEVNULL, stderr=side, env=_colours())
    os.close(side)
    shown = b""
    while True:
        try:
            piece = os.read(screen, 65536)
        except OSError:
            break
        if not piece:
            break
        shown += piece
    os.close(screen)
    done.communicate(timeout=20)
    assert done.returncode == 0
    assert time.monotonic() - began > 3.0
    before, _, after = shown.decode().partition("a note")
    assert len({sign for sign in before if "\u2800" < sign < "\u2900"}) > 3  # the spinner's frames
    assert "thinking" in before
    assert "thinking" in after
    assert "25 %" in after
    assert shown.count(b"\x1b[?25l") == shown.count(b"\x1b[?25h") == 1


def _colours():
    return os.environ | {"TERM": "xterm"}


def test_without_a_terminal_nothing_is_shown(monkeypatch, capsys):
    monkeypatch.setattr(progress, "DELAY", 0.0)
    progress.progress_bar("thinking")(1, 2)
    assert progress._phases == progress._bars == []
    assert capsys.readouterr() == ("", "")
