"""`gim --version --verbose`: what a report of an error should contain."""

import os
import platform
import subprocess
import sys
from importlib import metadata

import numpy
import pytest
from in_process import gim, ran

HEAVY = ("numpy", "scipy", "numba", "matplotlib", "pydantic", "ezdxf", "pyarrow")


def test_versions_of_everything():
    lines = gim("--version", "--verbose").text.splitlines()
    assert lines[0] == gim("--version").text.strip()
    assert lines[1].startswith(f"Python {platform.python_version()} ")
    assert f"numpy {numpy.__version__}" in lines
    named = {line.split()[0].rstrip(":"): line for line in lines}
    assert {"platform", "package", "ffmpeg", "cache", "cores", "pyarrow", "ezdxf", "distributed"} <= set(named)
    assert named["cores"].startswith(f"cores: {os.cpu_count()}, ")


def test_required_libraries_are_those_of_the_package():
    found = {line.split()[0].lower() for line in gim("--version", "--verbose").text.splitlines()}
    required = {need.split(";")[0].strip() for need in metadata.requires("gimcli") if "extra ==" not in need}
    names = {name.split(">")[0].split("<")[0].lower() for name in required} - {"pydantic-core"}
    assert names <= found


def test_a_library_that_is_missing_has_its_extra(monkeypatch):
    def version(name):
        if name == "ezdxf":
            raise metadata.PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(metadata, "version", version)
    assert "ezdxf is not installed (pip install 'gimcli[dxf]')" in gim("--version", "--verbose").text


def test_size_of_the_cache(monkeypatch, tmp_path):
    own = tmp_path / "gimcli"
    (own / "stamp").mkdir(parents=True)
    (own / "stamp" / "a.nbc").write_bytes(bytes(2_500_000))
    monkeypatch.setattr("gimcli.kernels.jit.cache_folder", lambda: own / "stamp")
    assert f"cache: {own}, 1 files, 2.5 MB" in gim("--version", "--verbose").text
    monkeypatch.setattr("gimcli.kernels.jit.cache_folder", lambda: None)
    assert "cache: none (" in gim("--version", "--verbose").text


@pytest.mark.parametrize("given", [["--verbose", "trace", "m.yaml"], ["--verbose"]])
def test_verbose_belongs_to_version(given, tmp_path):
    done = ran(*given, cwd=tmp_path)
    assert done.code == 2
    assert "gim --version --verbose" in done.error or "Missing command" in done.error


def test_no_library_is_imported():
    program = f"""
import sys
sys.argv = ["gim", "--version", "--verbose"]
from gimcli.cli import main
try:
    main()
except SystemExit:
    print("imported:", [name for name in {HEAVY!r} if name in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "imported: []"
