"""Run commands in this process: exit status, printed text, and rows of their files."""

import csv
import io
import json
import math
import shutil
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import yaml
from typer.testing import CliRunner

from gimcli import GimError, load
from gimcli.cli import COMMANDS, app, main
from gimcli.model.source import read_source

SERVERS = ("view",)
"""The commands that run until they are ended; tests/view has their tests."""

FAMILIES = ("fit",)
"""The commands that solve many designs; tests of their packages have their tests."""

RESTING = ("modes",)
"""The commands that need a position of equilibrium; tests of their packages have their tests."""

OTHERS = ("schema", "manual", "new", "convert", *SERVERS, *FAMILIES, *RESTING)

ANALYSES = [name for name in COMMANDS if name not in OTHERS]
"""The commands that read a model, need no other argument, and report in JSON."""


@dataclass(frozen=True)
class Ran:
    """Exit status and texts of a command."""

    code: int
    text: str  # standard output
    error: str

    @property
    def json(self):
        """The report of a command with --json."""
        return json.loads(self.text)


def gim(*arguments):
    """Run a command; unexpected exceptions are raised."""
    done = CliRunner().invoke(app, [str(a) for a in arguments])
    if isinstance(done.exception, GimError):
        return Ran(done.exception.exit_code, done.stdout, str(done.exception))
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return Ran(done.exit_code, done.stdout, done.stderr)


def ran(*arguments, cwd="."):
    """Run a command line in a folder; exit status and error messages are those of a process."""
    out, err, code = io.StringIO(), io.StringIO(), 0
    with chdir(cwd), patch("sys.argv", ["gim", *map(str, arguments)]), redirect_stdout(out), redirect_stderr(err):
        try:
            main()
        except SystemExit as stop:
            code = stop.code or 0
    return Ran(code, out.getvalue(), err.getvalue())


def printed(*arguments, cwd=".", code=0):
    """Return the text that a command line prints; it must end with `code`."""
    done = ran(*arguments, cwd=cwd)
    assert done.code == code, done.error
    return done.text


def refused(*arguments, code=2):
    """Return the error message of a command line that must end with `code`, without text on standard output."""
    done = ran(*arguments)
    assert (done.code, done.text) == (code, "")
    return done.error


def read_rows(path):
    """Return the rows of a CSV file; an empty list if there is no file."""
    if not Path(path).exists():
        return []
    with open(path, newline="") as handle:
        return list(csv.DictReader(handle))


def position(row, nodes):
    """Return the nodes of a CSV row."""
    return {n: complex(_number(row[f"{n}.x"]), _number(row[f"{n}.y"])) for n in nodes}


def _number(cell):
    return float(cell) if cell else math.nan


def copied(model, folder, change=None):
    """Copy a model, with all nodes traced, and its tables; return its path and data."""
    data = read_source(model).data
    data.pop("points", None)
    if change:
        change(data)
    data["trace"] = list(load(model).nodes)
    for table in model.parent.glob("*.csv"):
        shutil.copy(table, folder)
    path = folder / model.name
    path.write_text(yaml.safe_dump(data, sort_keys=False))
    return path, data
