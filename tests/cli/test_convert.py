"""`gim convert` with model files: the text, changed dimensions, refusals."""

import json

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim

import gimcli


def test_a_model_file_is_printed_as_it_is():
    done = gim("convert", MODELS / "crank_rocker.yaml")
    assert (done.code, done.text) == (0, (MODELS / "crank_rocker.yaml").read_text(encoding="utf-8"))


def test_changed_dimensions_are_written(tmp_path):
    out = tmp_path / "new.yaml"
    assert gim("convert", MODELS / "crank_rocker.yaml", "--set", "crank.length=35", "-o", out).code == 0
    assert abs(gimcli.load(out).members[1].reach(*gimcli.load(out).members[1].nodes)) * gimcli.load(out).scale == 35


def test_json_has_the_text_or_the_files(tmp_path):
    report = json.loads(gim("convert", MODELS / "jansen.yaml", "--json").text)
    assert (report["to"], report["left_out"], report["files"]) == ("yaml", [], [])
    assert report["text"].startswith("name: Jansen leg")
    report = json.loads(gim("convert", MODELS / "jansen.yaml", "--json", "-o", tmp_path / "j.yml").text)
    assert (report["files"], "text" in report) == ([str(tmp_path / "j.yml")], False)


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["-o", "x.xyz"], 2, ["x.xyz", ".yaml", ".yml"]),
        (["--to", "cad"], 2, ["cad", "yaml"]),
        (["-o", "no.yaml/x.yaml"], 6, ["no.yaml"]),
    ],
)
def test_what_is_refused(options, code, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "no.yaml").write_text("")
    done = gim("convert", MODELS / "crank_rocker.yaml", *options)
    assert done.code == code
    assert all(word in done.error for word in words)


def test_the_model_itself_is_not_overwritten(tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text((MODELS / "crank_rocker.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    assert gim("convert", path, "-o", path).code == 2
    assert path.read_text(encoding="utf-8") == (MODELS / "crank_rocker.yaml").read_text(encoding="utf-8")


@pytest.mark.parametrize("command", ["convert", "solve", "trace", "check"])
def test_an_address_without_a_mechanism_is_refused(command):
    done = gim(command, "https://example.org/?q=1")
    assert done.code == 3
    assert "address" in done.error


def test_an_address_in_a_file_of_pmks_plus_is_the_text_that_the_program_opens(tmp_path):
    address = gim("convert", MODELS / "crank_rocker.yaml", "--to", "pmks+").text.strip()
    for words in (("--to", "pmks+"), ()):
        out = tmp_path / "leg.pmks"
        assert gim("convert", MODELS / "crank_rocker.yaml", *words, "-o", out).code == 0
        assert address == "https://app.pmksplus.com/?" + out.read_text().strip()
    assert gim("trace", out, "--steps", "2", "-o", tmp_path / "leg.csv").code == 0
    assert gim("trace", address, "--steps", "2", "-o", tmp_path / "leg.csv").code == 0


def test_another_assembly_is_written_as_coordinates():
    """The two assemblies of the four-bar are mirror images over the line from A to O4."""
    texts = [gim("convert", "crank_rocker", "--assembly", k).text for k in (1, 2)]
    a, b, o4 = (
        np.array([gimcli.solve(gimcli.loads(t), motor=0).xy[n] for t in texts]) @ [1, 1j] for n in ("A", "B", "O4")
    )
    ratio = (b - a) / (o4 - a)
    assert ratio[0] == pytest.approx(ratio[1].conjugate(), abs=1e-9)
    assert abs(ratio[0].imag) > 0.1
