"""Machine code on disk: shared by processes that run at once, done without where nothing can be written."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gimcli.kernels import jit
from gimcli.motion import effort

USE = """
import sys, tempfile
import numpy as np
from gimcli.kernels import jit, linear
if {nowhere}:
    tempfile.tempdir = "/dev/null/nowhere"
solve = jit.compiled(linear.lu_factor)
sign = solve(np.array([[0.0, 2.0], [3.0, 1.0]]), 2, np.zeros(4))
print(sign, sum(solve.stats.cache_hits.values()), jit.cache_folder())
"""


def process(home, nowhere=False):
    env = os.environ | {"XDG_CACHE_HOME": str(home)}
    script = USE.format(nowhere=nowhere)
    return subprocess.Popen([sys.executable, "-c", script], env=env, stdout=subprocess.PIPE, text=True)


def told(running):
    out, _ = running.communicate(timeout=120)
    assert running.returncode == 0
    sign, hits, folder = out.split()
    return float(sign), int(hits), folder


def test_processes_that_run_at_once_share_no_broken_cache(tmp_path):
    first = [process(tmp_path) for _ in range(3)]
    assert {told(p)[0] for p in first} == {-1.0}
    sign, hits, folder = told(process(tmp_path))
    assert (sign, hits) == (-1.0, 1)  # it was on disk
    assert Path(folder).parent == tmp_path / "gimcli"


@pytest.mark.skipif(sys.platform == "win32", reason="no /dev/null")
def test_a_home_that_cannot_be_written_is_done_without():
    sign, _, folder = told(process("/dev/null/home"))
    assert sign == -1.0
    assert not folder.startswith("/dev/null")


@pytest.mark.skipif(sys.platform == "win32", reason="no /dev/null")
def test_nowhere_to_write_compiles_without_a_cache():
    assert told(process("/dev/null/home", nowhere=True)) == (-1.0, 0, "None")


def test_nothing_is_written_beside_the_package(tmp_path):
    told(process(tmp_path))
    assert not list(Path(jit.__file__).parents[1].rglob("*.nb[ci]"))


def test_an_edit_of_any_kernel_has_a_folder_of_its_own(tmp_path, monkeypatch):
    (tmp_path / "a.py").write_text("x = 1\n")
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "jit.py"))
    before = jit.source_stamp()
    (tmp_path / "a.py").write_text("x = 2\n")
    assert jit.source_stamp() != before


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users")
def test_a_folder_of_somebody_else_is_not_trusted(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    owner = os.getuid()
    assert jit.cache_folder.__wrapped__().parent == tmp_path / "gimcli"
    monkeypatch.setattr(os, "getuid", lambda: owner + 1)
    folder = jit.cache_folder.__wrapped__()
    assert folder is None or tmp_path not in folder.parents


def test_compiling_is_told_once(monkeypatch):
    heard = []
    for cached, expected in ((False, 1), (True, 0)):
        monkeypatch.setattr(jit, "is_cached", lambda *kernels, cached=cached: cached)
        heard.clear()
        assert effort.choose("on", 0.0, heard.append) is jit.compiled
        assert len(heard) == expected
    assert effort.choose("auto", 0.1, heard.append) is effort.plain
    assert effort.choose("off", 1e9, heard.append) is effort.plain
    monkeypatch.setattr(jit, "is_cached", lambda *kernels: False)
    assert effort.choose("auto", effort.COMPILING - 1.0, heard.append) is effort.plain
    assert not heard
    assert effort.choose("auto", effort.COMPILING + 1.0, heard.append) is jit.compiled
    assert "compiling" in heard[0]


def test_only_kernels_on_disk_count_as_cached(tmp_path, monkeypatch):
    monkeypatch.setattr(jit, "cache_folder", lambda: tmp_path)
    assert not jit.is_cached("lu_factor")
    (tmp_path / "linear.lu_factor-16.py311.1.nbc").write_bytes(b"")
    assert jit.is_cached("lu_factor")
    assert not jit.is_cached("lu_factor", "lu_solve")
