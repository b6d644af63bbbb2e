"""Run commands in separate processes."""

import subprocess
import sys


def gim(*arguments, cwd=None, code=0):
    """Run a command that must end with `code`; return the printed text."""
    command = [sys.executable, "-c", "from gimcli.cli import main; main()", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=120)
    assert done.returncode == code, done.stderr
    return done.stdout
