"""Machine code on disk: shared by parallel processes, and not used if no folder is writable."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from bundled import MODELS

from gimcli.kernels import jit, linear
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


def process(cache, nowhere=False):
    env = os.environ | {"XDG_CACHE_HOME": str(cache)}
    script = USE.format(nowhere=nowhere)
    return subprocess.Popen([sys.executable, "-c", script], env=env, stdout=subprocess.PIPE, text=True)


def result_of(running):
    out, _ = running.communicate(timeout=120)
    assert running.returncode == 0
    sign, hits, folder = out.split()
    return float(sign), int(hits), folder


def test_parallel_processes_do_not_damage_the_cache(tmp_path):
    first = [process(tmp_path) for _ in range(2)]
    assert {result_of(p)[0] for p in first} == {-1.0}
    sign, hits, folder = result_of(process(tmp_path))
    assert (sign, hits) == (-1.0, 1)  # loaded from disk
    assert Path(folder).parent == tmp_path / "gimcli"


@pytest.mark.skipif(sys.platform == "win32", reason="no /dev/null")
def test_a_cache_folder_that_is_not_writable_is_not_used():
    sign, _, folder = result_of(process("/dev/null/cache"))
    assert sign == -1.0
    assert not folder.startswith("/dev/null")


@pytest.mark.skipif(sys.platform == "win32", reason="no /dev/null")
def test_without_a_writable_folder_nothing_is_cached():
    assert result_of(process("/dev/null/cache", nowhere=True)) == (-1.0, 0, "None")


def test_nothing_is_written_to_the_package(tmp_path):
    result_of(process(tmp_path))
    assert not list(Path(jit.__file__).parents[1].rglob("*.nb[ci]"))


def test_an_edit_of_any_kernel_changes_the_folder(tmp_path, monkeypatch):
    (tmp_path / "a.py").write_text("x = 1\n")
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "jit.py"))
    before = jit.source_stamp()
    (tmp_path / "a.py").write_text("x = 2\n")
    assert jit.source_stamp() != before


COMMAND = """
import sys
from numba.core import event
from gimcli.cli import main

class Count(event.Listener):
    count = 0
    def on_start(self, one): Count.count += 1
    def on_end(self, one): pass

sys.argv = ["gim", "solve", {model!r}, "--method", "gim", "--jit", "on"]
with event.install_listener("numba:compile", Count()):
    main_ended = None
    try:
        main()
    except SystemExit as end:
        main_ended = end.code
print("compiled", Count.count, main_ended)
"""


def compiled_by_a_command(cache):
    """Return the number of functions that a `gim solve` process compiles, and the text that it prints."""
    script = COMMAND.format(model=str(MODELS / "crank_rocker.yaml"))
    env = os.environ | {"XDG_CACHE_HOME": str(cache)}
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


def test_every_compiled_kernel_is_cached():
    import importlib
    import pkgutil

    import gimcli.kernels
    from gimcli.kernels.jit import MachineCode

    for module in pkgutil.iter_modules(gimcli.kernels.__path__):
        importlib.import_module(f"gimcli.kernels.{module.name}")
    functions = [k for k in jit._KERNELS if k not in jit._SCALAR_FORMS]
    assert len(functions) > 50
    assert [k.__name__ for k in functions if not isinstance(jit.compiled(k)._cache, MachineCode)] == []


def solved(folder, monkeypatch):
    """Compile a kernel with its cache in a folder, call it, and return the number of cache hits."""
    monkeypatch.setattr(jit, "cache_folder", lambda: folder)
    solve = jit._compiled.__wrapped__(linear.lu_factor, inner=False)
    assert solve(np.array([[0.0, 2.0], [3.0, 1.0]]), 2, np.zeros(4)) == -1.0
    return sum(solve.stats.cache_hits.values())


@pytest.mark.few(2)
@pytest.mark.parametrize("damage", ["empty", "cut", "one bit", "text"])
def test_damaged_machine_code_is_compiled_again(tmp_path, monkeypatch, damage):
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


def test_a_full_disk_leaves_no_partial_file_and_raises_no_error(tmp_path, monkeypatch):
    def full(self, data):
        with self.open("wb") as handle:
            handle.write(data[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(jit.Path, "write_bytes", full)
    assert solved(tmp_path, monkeypatch) == 0
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users")
@pytest.mark.parametrize("mode", [0o777, 0o770, 0o722])
@pytest.mark.parametrize("where", ["gimcli", "gimcli/{stamp}"])
def test_a_folder_writable_by_others_is_not_used(tmp_path, monkeypatch, mode, where):
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
def test_a_folder_that_others_can_replace_is_not_used(tmp_path, monkeypatch):
    home = tmp_path / "home"
    monkeypatch.setenv("XDG_CACHE_HOME", str(home))
    assert jit.cache_folder.__wrapped__().is_relative_to(home)
    home.chmod(0o777)
    folder = jit.cache_folder.__wrapped__()
    assert folder is None or not folder.is_relative_to(home)
    home.chmod(0o1777)  # as /tmp: only its owner can rename a folder
    assert jit.cache_folder.__wrapped__().is_relative_to(home)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users")
def test_folders_are_private_with_any_umask(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home/cache"))
    before = os.umask(0)
    try:
        folder = jit.cache_folder.__wrapped__()
    finally:
        os.umask(before)
    assert folder is not None
    assert {path.stat().st_mode & 0o777 for path in (folder, folder.parent, *folder.parents[1:3])} == {0o700}


def test_without_a_safe_folder_the_user_is_notified(monkeypatch):
    notices = []
    monkeypatch.setattr(jit, "cache_folder", lambda: None)
    assert dispatch.choose("on", 0.0, notices.append) is jit.compiled
    assert len(notices) == 1
    assert "not cached" in notices[0]


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users")
def test_a_folder_of_another_user_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    owner = os.getuid()
    assert jit.cache_folder.__wrapped__().parent == tmp_path / "gimcli"
    monkeypatch.setattr(os, "getuid", lambda: owner + 1)
    folder = jit.cache_folder.__wrapped__()
    assert folder is None or tmp_path not in folder.parents


def test_the_user_is_notified_of_a_compilation_only_once(monkeypatch):
    notices = []
    for cached, expected in ((False, 1), (True, 0)):
        monkeypatch.setattr(jit, "is_cached", lambda *kernels, cached=cached: cached)
        notices.clear()
        assert dispatch.choose("on", 0.0, notices.append) is jit.compiled
        assert len(notices) == expected
    assert dispatch.choose("auto", 0.1, notices.append) is dispatch.plain
    assert dispatch.choose("off", 1e9, notices.append) is dispatch.plain
    monkeypatch.setattr(jit, "is_cached", lambda *kernels: False)
    assert dispatch.choose("auto", dispatch.COMPILING - 1.0, notices.append) is dispatch.plain
    assert not notices
    assert dispatch.choose("auto", dispatch.COMPILING + 1.0, notices.append) is jit.compiled
    assert "compiling" in notices[0]


def test_only_kernels_on_disk_count_as_cached(tmp_path, monkeypatch):
    monkeypatch.setattr(jit, "cache_folder", lambda: tmp_path)
    assert not jit.is_cached("lu_factor")
    (tmp_path / "linear.lu_factor-16.py311.1.nbc").write_bytes(b"")
    assert jit.is_cached("lu_factor")
    assert not jit.is_cached("lu_factor", "lu_solve")
