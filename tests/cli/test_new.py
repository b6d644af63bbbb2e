"""`gim new`: the list of the shipped models, and templates with their tables."""

from __future__ import annotations

import pytest
from bundled import FILES, MODELS
from in_process import gim, ran

import gimcli
from gimcli import OutputError, UsageError
from gimcli.library.shipped_models import OTHER, THEMES, ShippedModel

NAMES = [path.stem for path in FILES]


def test_each_model_has_one_theme():
    assert sorted(name for own in THEMES.values() for name in own) == NAMES
    assert OTHER not in {model.theme for model in gimcli.shipped_models()}


@pytest.mark.parametrize("arguments", [[], ["--list"]])
def test_the_list_has_one_line_for_each_model(arguments):
    lines = gim("new", *arguments).text.splitlines()
    assert sorted(line.split()[0] for line in lines if line.startswith("  ")) == NAMES
    assert [line for line in lines if line in THEMES] == list(THEMES)
    assert max(map(len, lines)) <= 100


def test_the_list_as_json():
    models = gim("new", "--list", "--json").json["models"]
    assert sorted(model["name"] for model in models) == NAMES
    for model in models:
        found = gimcli.load(model["name"])
        assert model["title"] == found.name
        assert model["masses"] == bool(found.dynamics.inertias)
        assert len(model["tables"]) == len(found.files) - 1


def test_a_model_is_written_to_standard_output_as_it_is():
    for arguments in ([], ["-o", "-"]):
        assert gim("new", "jansen", *arguments).text == (MODELS / "jansen.yaml").read_text()
    report = gim("new", "jansen.yaml", "--json").json
    assert report["text"] == (MODELS / "jansen.yaml").read_text()
    assert report["files"] == []


@pytest.mark.parametrize(
    ("out", "file"),
    [("m.yaml", "m.yaml"), ("a/b.yml", "a/b.yml"), ("own/", "own/jansen.yaml"), ("own", "own/jansen.yaml")],
)
def test_a_model_is_written_to_a_file_or_a_folder(out, file, tmp_path):
    done = ran("new", "jansen", "-o", out, cwd=tmp_path)
    assert done.text == f"wrote {file}\n"
    assert (tmp_path / file).read_bytes() == (MODELS / "jansen.yaml").read_bytes()


def test_an_existing_file_is_kept_without_force(tmp_path):
    (tmp_path / "m.yaml").write_text("mine")
    done = ran("new", "jansen", "-o", "m.yaml", cwd=tmp_path)
    assert (done.code, (tmp_path / "m.yaml").read_text()) == (6, "mine")
    assert "m.yaml: exists already" in done.error
    assert "replace it by force" in done.error
    assert ran("new", "jansen", "-o", "m.yaml", "--force", cwd=tmp_path).code == 0
    assert ran("new", "jansen", "-o", "m.yaml", cwd=tmp_path).code == 0  # the same content


@pytest.fixture
def with_table(tmp_path):
    """A model that reads a table, as if it were shipped."""
    folder = tmp_path / "shipped"
    (folder / "data").mkdir(parents=True)
    (folder / "data" / "law.csv").write_text("0,0\n1,90\n")
    text = (MODELS / "crank_rocker.yaml").read_text().replace("{from: 0, to: 360}", "{table: data/law.csv}")
    (folder / "driven.yaml").write_text(text)
    return ShippedModel("driven", OTHER, folder / "driven.yaml")


def test_tables_are_written_beside_the_model(with_table, tmp_path):
    assert with_table.tables == ("data/law.csv",)
    files = with_table.write(tmp_path / "new.yaml")
    assert files == (tmp_path / "new.yaml", tmp_path / "data" / "law.csv")
    assert gimcli.load(files[0]).actuators[0].law(1.0) == pytest.approx(1.5707963267948966)
    (tmp_path / "data" / "law.csv").write_text("0,0\n1,80\n")
    with pytest.raises(OutputError, match=r"law\.csv: exists already"):
        with_table.write(tmp_path / "other.yaml")
    assert not (tmp_path / "other.yaml").exists()
    with pytest.raises(UsageError, match="read from this file"):
        with_table.write(with_table.path, force=True)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["crank_roker"], "'crank_roker'; did you mean 'crank_rocker'?"),
        (["../models/jansen"], "no shipped model"),
        (["jansen", "--list"], "--list"),
        (["jansen", "-o", "m.csv"], "'.csv'"),
        (["jansen", "--force"], "-o"),
        (["-o", "m.yaml"], "which model?"),
    ],
)
def test_wrong_usage(arguments, words, tmp_path):
    done = ran("new", *arguments, cwd=tmp_path)
    assert done.code == 2
    assert words in done.error
    assert not list(tmp_path.iterdir())
