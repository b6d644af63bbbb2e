"""Shipped models by name: in the package and in a clone, behind paths that exist, with a suggestion for others."""

from __future__ import annotations

import pytest
from bundled import FILES, MODELS
from typer.testing import CliRunner

import gimcli
from gimcli import ModelError, shipped
from gimcli.cli import app

COPY = """
name: Own
nodes: {O: [0, 0], A: [1, 0], B: [3, 1], C: [3, 0]}
ground: [O, C]
links: {crank: [O, A], coupler: [A, B], rocker: [C, B]}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {by: 5}}}
"""


def test_the_package_has_all_models_and_their_tables():
    """In the clone this is the folder itself; in an installed package it is the copy that setup made."""
    assert shipped.names() == tuple(path.stem for path in FILES)
    for path in MODELS.iterdir():
        assert (shipped.folder() / path.name).read_bytes() == path.read_bytes()


@pytest.mark.parametrize("name", ["crank_rocker", "crank_rocker.yaml"])
def test_a_name_gives_the_model_and_files_in_the_current_folder(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["trace", name, "--steps", "6", "--no-png"])
    assert done.exit_code == 0
    assert [path.name for path in tmp_path.iterdir()] == ["crank_rocker.csv"]
    assert gimcli.load(name).name == "Crank-rocker with a coupler point"


def test_a_path_that_exists_wins_over_a_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "crank_rocker.yaml").write_text(COPY)
    assert gimcli.load("crank_rocker.yaml").name == "Own"
    assert gimcli.load("crank_rocker").name == "Crank-rocker with a coupler point"
    (tmp_path / "crank_rocker").write_text(COPY)
    assert gimcli.load("crank_rocker").name == "Own"


def test_a_name_is_no_path_into_the_package(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("", ".", "..", "*", "../models/jansen", "./jansen", "jansen.yaml.yaml", "Jansen"):
        assert shipped.path_of(name) is None


def test_a_misspelt_name_gets_a_suggestion(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError):
        gimcli.load("crank_roker")
    with pytest.raises(ModelError):
        gimcli.load("model.yaml")
    (tmp_path / "jansen").mkdir()
    with pytest.raises(ModelError):
        gimcli.load("jansen")
    assert gimcli.load("jansen.yaml").name == "Jansen leg"
