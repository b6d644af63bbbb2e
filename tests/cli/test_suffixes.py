"""The files that a command writes: its help and its refusal have the same list."""

import re

import pytest
from in_process import gim

from gimcli.cli import COMMANDS

MODEL = "crank_rocker"
ANALYSES = sorted(COMMANDS.keys() - {"convert", "manual", "new", "schema", "view"})
NEEDED = {
    "sweep": ["-n", "4", "--vary", "crank.length=30,31"],
    "fit": ["--goal", "max(motor)=1", "--vary", "crank.length=30:31"],
}


def listed(text):
    """Return the suffixes in a text, in their order."""
    return re.findall(r"\.[a-z0-9]+\b", text)


@pytest.mark.parametrize("command", ANALYSES)
def test_the_help_lists_what_the_refusal_lists(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused = gim(command, MODEL, *NEEDED.get(command, []), "-o", "x.foo").error
    (inside,) = re.findall(r"file \((\.csv.*?)\), or -", re.sub(r"\s+", " ", gim(command, "--help").text))
    assert listed(inside) == listed(re.findall(r"one of the formats (.*?), got", refused)[0])


def test_a_command_does_not_list_what_it_has_not():
    assert ".mp4" not in gim("sweep", "--help").text
    assert ".yaml" in gim("solve", "--help").text
    assert ".png" not in gim("check", "--help").text
