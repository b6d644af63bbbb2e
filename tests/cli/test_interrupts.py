"""An interrupt from the terminal ends a command with status 130 and without a traceback, whatever is imported then."""

import subprocess
import sys

import pytest

INTERRUPTED = """
import os, signal, sys

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Interrupt())
from gimcli.cli import main
sys.argv = ["gim", "trace", "crank_rocker", "-o", os.devnull + "/"]
main()
"""


@pytest.mark.parametrize("name", ["typer", "gimcli.cli.trace", "numpy"])
def test_an_interrupt_during_an_import(name):
    done = subprocess.run([sys.executable, "-c", INTERRUPTED.format(name=name)], capture_output=True, text=True)
    assert done.returncode == 130
    assert "Traceback" not in done.stderr
