"""The interface for scripts does not change: status words, event kinds, options, JSON keys, CSV columns, file keys."""

from __future__ import annotations

import json

import pytest
from bundled import MODELS, TABLES
from in_process import gim
from typer.main import get_command

from gimcli.branching import singularities
from gimcli.cli import app
from gimcli.dynamics import simulation_types
from gimcli.model.json_schema import json_schema
from gimcli.status import CHANGE, TANGENCY, Status

KNOWN = json.loads((TABLES / "interface.json").read_text(encoding="utf-8"))


def test_status_words():
    assert [status.word for status in Status] == KNOWN["status words"]


def test_event_kinds():
    kinds = KNOWN["event kinds"]
    found = {singularities.LIMIT, singularities.DEAD, singularities.STATIONARY, CHANGE, TANGENCY}
    assert found == set(kinds["positions"])
    kinds_of_simulate = ("STANDSTILL", "DEAD_POINT", "LIMIT", "SINGULAR", "STICKS", "SLIDES", "JAM")
    simulated = {getattr(simulation_types, k) for k in kinds_of_simulate}
    assert simulated == set(kinds["simulate"])


def commands():
    """Return the commands by name."""
    group = get_command(app)
    return {name: group.get_command(None, name) for name in group.list_commands(None)}


def test_every_command_has_its_options():
    found = {n: sorted(o for p in c.params for o in [*p.opts, *p.secondary_opts]) for n, c in commands().items()}
    for name, options in KNOWN["options"].items():
        assert set(options) <= set(found[name]), name


def test_every_option_has_its_default():
    for name, command in commands().items():
        found = {p.opts[0] + " (file)" * (p.hidden and p.opts[0] == "--png"): p.default for p in command.params}
        shown = {option: str(getattr(default, "value", default)) for option, default in found.items()}
        assert KNOWN["defaults"].get(name, {}).items() <= shown.items(), name


def test_every_key_of_a_file_is_still_accepted():
    schema = json_schema()
    found = {"Model": schema["properties"], **{n: d.get("properties", {}) for n, d in schema["$defs"].items()}}
    for part, keys in KNOWN["keys of a file"].items():
        assert set(keys) <= set(found[part]), part


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("name", KNOWN["json"])
def test_keys_and_columns_do_not_change(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command, model, *rest = KNOWN["json"][name]["command"].split()
    report = gim(command, MODELS / f"{model}.yaml", *rest).json
    assert sorted(report) == sorted(KNOWN["json"][name]["keys"])
    if name in KNOWN["columns"]:
        (table,) = tmp_path.glob("*.csv")
        assert table.read_text(encoding="utf-8").splitlines()[0].split(",") == KNOWN["columns"][name]
