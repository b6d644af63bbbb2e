"""A first run where something usual is missing: home folder, cache, terminal, standard streams, a writable folder."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from gimcli.cli import settings_folder
from gimcli.kernels import jit

LINUX = pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="no folder in which nobody can write")


@pytest.fixture
def bare(tmp_path):
    """Return an environment without a home folder: it is a file."""
    (tmp_path / "home").write_text("")
    root = Path(jit.__file__).parents[2]
    return {
        "PATH": os.environ["PATH"], "HOME": str(tmp_path / "home"), "TMPDIR": str(tmp_path),
        "PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1",
    }  # fmt: skip


def run(*arguments, environment, cwd, **streams):
    """Run a command without a terminal."""
    given = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams}
    return subprocess.run(
        [sys.executable, "-m", "gimcli", *map(str, arguments)], env=environment, cwd=cwd, text=True, encoding="utf-8",
        start_new_session=True, **given,
    )  # fmt: skip


def test_without_home_and_terminal_a_report_is_printed(bare, tmp_path):
    (tmp_path / "work").mkdir()
    done = run("solve", "crank_rocker", "--at", "motor=40", environment=bare, cwd=tmp_path / "work")
    assert (done.returncode, done.stderr) == (0, "")
    assert "143.19" in done.stdout  # Norton, example 4-1
    assert "\x1b" not in done.stdout
    assert list((tmp_path / "work").iterdir()) == []


@pytest.mark.soak
def test_without_home_a_picture_is_drawn_without_warnings(bare, tmp_path):
    paths = [tmp_path / "out" / name for name in ("m.png", "m.dxf", "m.xlsx")]
    given = [word for path in paths for word in ("-o", path)]
    done = run("trace", "crank_rocker", "--steps", 12, *given, environment=bare, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert all(path.stat().st_size for path in paths)
    assert not (tmp_path / "~").exists()


@LINUX
def test_a_folder_that_cannot_be_written_needs_another_one(bare):
    done = run("trace", "crank_rocker", "--steps", 12, environment=bare, cwd="/proc")
    assert done.returncode == 6
    assert done.stderr.startswith("gim: crank_rocker.csv: cannot be written: ")
    assert "-o" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.soak
@LINUX
def test_standard_output_is_enough(bare):
    done = run("trace", "crank_rocker", "--steps", 12, "-o", "-", environment=bare, cwd="/proc")
    assert done.returncode == 0
    assert done.stdout.count("\n") == 14
    assert "13 of 13 positions solved" in done.stderr


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("more", "code"), [("2>&-", 0), (">&-", 0), ("<&-", 0), ("-o - >&-", 6), ("--at motor=x 2>&-", 2)]
)
def test_closed_streams(more, code, bare, tmp_path):
    command = f'exec "$0" -m gimcli solve crank_rocker --at motor=40 {more}'
    done = subprocess.run(["sh", "-c", command, sys.executable], env=bare, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == code
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.few(1)
@pytest.mark.parametrize(("encoding", "letter"), [("cp1252", "\\u03c1"), ("utf-8", "ρ")])
def test_letters_that_an_encoding_does_not_have_are_escaped(encoding, letter, bare, tmp_path):
    given = bare | {"PYTHONIOENCODING": encoding}
    command = [sys.executable, "-m", "gimcli", "manual", "method"]
    done = subprocess.run(command, env=given, cwd=tmp_path, capture_output=True)
    assert done.returncode == 0
    assert letter in done.stdout.decode(encoding)


def test_without_any_folder_for_files_there_is_no_cache(monkeypatch, tmp_path):
    def missing():
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "file" / "home"))
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(tempfile, "gettempdir", missing)
    assert jit.user_folder("stamp") is None


def test_a_user_without_a_home_folder_gets_no_folder_named_tilde(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temp"))
    assert jit.user_folder("stamp").is_relative_to(tmp_path / "temp")
    assert [path.name for path in tmp_path.iterdir()] == ["temp"]


def test_matplotlib_gets_a_folder_where_it_cannot_write(monkeypatch, tmp_path):
    monkeypatch.setenv("MPLCONFIGDIR", "own")
    settings_folder.provide_settings_folder()
    assert os.environ["MPLCONFIGDIR"] == "own"
    monkeypatch.delenv("MPLCONFIGDIR")
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("XDG_CONFIG_HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, str(tmp_path / "new" / name))
    settings_folder.provide_settings_folder()
    assert "MPLCONFIGDIR" not in os.environ
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "file"))
    settings_folder.provide_settings_folder()
    assert os.environ["MPLCONFIGDIR"] == str(tmp_path / "new/XDG_CACHE_HOME/gimcli/matplotlib")
