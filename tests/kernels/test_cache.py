"""Machine code on disk: shared by processes that run at once, done without where nothing can be written."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from bundled import MODELS

from gimcli.kernels import jit, linear, machine_code
from gimcli.positions import dispatch

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
    first = [process(tmp_path) for _ in range(2)]
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


COMMAND = """
import sys
from numba.core import event
from gimcli.cli import main

class Heard(event.Listener):
    count = 0
    def on_start(self, one): Heard.count += 1
    def on_end(self, one): pass

sys.argv = ["gim", "solve", {model!r}, "--method", "gim", "--jit", "on"]
with event.install_listener("numba:compile", Heard()):
    main_ended = None
    try:
        main()
    except SystemExit as end:
        main_ended = end.code
print("compiled", Heard.count, main_ended)
"""


def compiled_by_a_command(home):
    """Return how many functions a process compiles that solves by sweeps, and what it prints before."""
    script = COMMAND.format(model=str(MODELS / "crank_rocker.yaml"))
    env = os.environ | {"XDG_CACHE_HOME": str(home)}
    done = subprocess.run([sys.executable, "-c", script], env=env, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    answer, count = done.stdout.rsplit("compiled ", 1)
    assert count.split()[1] in ("0", "None")
    return int(count.split()[0]), answer


@pytest.mark.soak
def test_a_second_process_compiles_nothing(tmp_path):
    count, answer = compiled_by_a_command(tmp_path)
    assert count > 0
    assert compiled_by_a_command(tmp_path) == (0, answer)


def test_every_kernel_that_is_no_part_of_another_is_kept():
    import importlib
    import pkgutil

    import gimcli.kernels
    from gimcli.kernels.machine_code import MachineCode

    for module in pkgutil.iter_modules(gimcli.kernels.__path__):
        importlib.import_module(f"gimcli.kernels.{module.name}")
    functions = [k for k in jit._KERNELS if k not in jit._SCALAR_FORMS]
    assert len(functions) > 50
    assert [k.__name__ for k in functions if not isinstance(jit.compiled(k)._cache, MachineCode)] == []


def solved(folder, monkeypatch):
    """Compile a kernel with its code in a folder, use it, and return how often the code was there."""
    monkeypatch.setattr(jit, "cache_folder", lambda: folder)
    solve = jit._compiled.__wrapped__(linear.lu_factor, inner=False)
    assert solve(np.array([[0.0, 2.0], [3.0, 1.0]]), 2, np.zeros(4)) == -1.0
    return sum(solve.stats.cache_hits.values())


@pytest.mark.few(2)
@pytest.mark.parametrize("damage", ["empty", "cut", "one bit", "text"])
def test_damaged_machine_code_is_built_again(tmp_path, monkeypatch, damage):
    assert solved(tmp_path, monkeypatch) == 0
    (victim,) = tmp_path.iterdir()
    whole = victim.read_bytes()
    middle = len(whole) // 2
    victim.write_bytes(
        {
            "empty": b"", "cut": whole[:middle], "text": b"no machine code",
            "one bit": whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :],
        }[damage]
    )  # fmt: skip
    assert solved(tmp_path, monkeypatch) == 0
    assert solved(tmp_path, monkeypatch) == 1
    assert list(tmp_path.iterdir()) == [victim]


def test_a_disk_that_is_full_leaves_no_part_and_ends_nothing(tmp_path, monkeypatch):
    def full(self, data):
        with self.open("wb") as handle:
            handle.write(data[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(machine_code.Path, "write_bytes", full)
    assert solved(tmp_path, monkeypatch) == 0
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users")
@pytest.mark.parametrize("mode", [0o777, 0o770, 0o722])
@pytest.mark.parametrize("where", ["gimcli", "gimcli/{stamp}"])
def test_a_folder_that_others_may_write_into_is_not_trusted(tmp_path, monkeypatch, mode, where):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temp"))
    own = jit.cache_folder.__wrapped__()
    assert own.parent == tmp_path / "home/gimcli"
    (tmp_path / "home" / where.format(stamp=own.name)).chmod(mode)
    private = jit.cache_folder.__wrapped__()
    assert private.parent == tmp_path / f"temp/gimcli-{os.getuid()}"
    assert {path.stat().st_mode & 0o777 for path in (private, private.parent)} == {0o700}
    private.chmod(mode)
    assert jit.cache_folder.__wrapped__() is None


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users")
def test_a_folder_in_one_that_others_may_rename_is_not_trusted(tmp_path, monkeypatch):
    home = tmp_path / "home"
    monkeypatch.setenv("XDG_CACHE_HOME", str(home))
    assert jit.cache_folder.__wrapped__().is_relative_to(home)
    home.chmod(0o777)
    folder = jit.cache_folder.__wrapped__()
    assert folder is None or not folder.is_relative_to(home)
    home.chmod(0o1777)  # as /tmp: only its owner renames a folder
    assert jit.cache_folder.__wrapped__().is_relative_to(home)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users")
def test_folders_are_private_whatever_the_mask(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home/cache"))
    before = os.umask(0)
    try:
        folder = jit.cache_folder.__wrapped__()
    finally:
        os.umask(before)
    assert folder is not None
    assert {path.stat().st_mode & 0o777 for path in (folder, folder.parent, *folder.parents[1:3])} == {0o700}


def test_without_a_safe_folder_the_note_says_so(monkeypatch):
    heard = []
    monkeypatch.setattr(jit, "cache_folder", lambda: None)
    assert dispatch.choose("on", 0.0, heard.append) is jit.compiled
    assert len(heard) == 1
    assert "not cached" in heard[0]


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
        assert dispatch.choose("on", 0.0, heard.append) is jit.compiled
        assert len(heard) == expected
    assert dispatch.choose("auto", 0.1, heard.append) is dispatch.plain
    assert dispatch.choose("off", 1e9, heard.append) is dispatch.plain
    monkeypatch.setattr(jit, "is_cached", lambda *kernels: False)
    assert dispatch.choose("auto", dispatch.COMPILING - 1.0, heard.append) is dispatch.plain
    assert not heard
    assert dispatch.choose("auto", dispatch.COMPILING + 1.0, heard.append) is jit.compiled
    assert "compiling" in heard[0]


def test_only_kernels_on_disk_count_as_cached(tmp_path, monkeypatch):
    monkeypatch.setattr(jit, "cache_folder", lambda: tmp_path)
    assert not jit.is_cached("lu_factor")
    (tmp_path / "linear.lu_factor-16.py311.1.nbc").write_bytes(b"")
    assert jit.is_cached("lu_factor")
    assert not jit.is_cached("lu_factor", "lu_solve")
