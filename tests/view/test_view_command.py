"""`gim view` as a process: the address, the ends, the port, the examples of its help."""

from __future__ import annotations

import re
import shlex
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager
from http.client import HTTPConnection

import pytest
from bundled import MODELS
from in_process import refused

from gimcli.cli.view import EXAMPLES


@contextmanager
def viewing(*words, cwd):
    """Run the command (context manager); yields the process and the port that it prints."""
    command = [sys.executable, "-m", "gimcli", "view", *map(str, words), "--no-browser"]
    process = subprocess.Popen(
        command, cwd=cwd, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        line = process.stdout.readline()
        found = re.search(r"http://127\.0\.0\.1:(\d+)/ \(Ctrl-C ends\)", line)
        assert found, line + process.stderr.read()
        yield process, int(found[1])
    finally:
        process.kill()
        process.wait()


def ends(process, number):
    """Send a signal; return the exit status and what standard error has."""
    process.send_signal(number)
    more, error = process.communicate(timeout=10)
    assert more == ""
    return process.returncode, error


def test_ctrl_c_ends_it_while_a_page_listens(tmp_path):
    with viewing(MODELS / "crank_rocker.yaml", "--port", 0, cwd=tmp_path) as (process, port):
        connection = HTTPConnection("127.0.0.1", port, timeout=10)
        connection.request("GET", "/events")
        answer = connection.getresponse()
        assert answer.readline() + answer.readline() == b"retry: 500\n\n"
        assert answer.readline().startswith(b"data: {")
        code, error = ends(process, signal.SIGINT)
        assert code == 0
        assert re.fullmatch(r"Crank-rocker.*: 361 of 361 positions solved.*\n", error), error
        assert answer.read().strip() in (b"", b":")
        with socket.socket() as again:
            again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            again.bind(("127.0.0.1", port))
    assert not list(tmp_path.iterdir())


def test_the_first_example_of_the_help_runs_and_a_signal_ends_it(tmp_path):
    (tmp_path / "models").symlink_to(MODELS)
    with viewing(*shlex.split(EXAMPLES[1])[2:], "--port", 0, cwd=tmp_path) as (process, _):
        code, error = ends(process, signal.SIGTERM)
        assert code == 128 + signal.SIGTERM
        assert "Traceback" not in error


def test_a_port_in_use_is_refused(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        message = refused("view", MODELS / "crank_rocker.yaml", "--no-browser", "--port", port)
    assert message == f"gim: port {port}: the port is in use; choose another, or 0 for any free port\n"


@pytest.mark.parametrize(
    ("words", "code"), [(["none.yaml"], 3), ([MODELS], 3), ([MODELS / "crank_rocker.yaml", "--plot", "speed"], 2)]
)
def test_what_no_saving_could_correct_ends_it(words, code):
    refused("view", *words, "--no-browser", "--port", "0", code=code)


def test_an_address_is_refused():
    assert "gim convert" in refused("view", "https://example.org/?q=1")
