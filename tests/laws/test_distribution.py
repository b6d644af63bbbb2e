"""The wheel and the source distribution contain every file that belongs to them."""

import subprocess
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "gimcli"
STANDARD = {"gimcli", "LICENSE", "MANIFEST.in", "README.md", "pyproject.toml", "setup.py"}
"""What setuptools adds to a source distribution without being asked."""


def tracked():
    """Return the files of the repository; in an unpacked source distribution there is none."""
    if not (ROOT / ".git").exists():
        pytest.skip("not a clone")
    done = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_the_source_distribution_has_every_file_of_the_repository():
    lines = (ROOT / "MANIFEST.in").read_text(encoding="utf-8").splitlines()
    words = [line.split() for line in lines if line.startswith(("graft", "include"))]
    added = STANDARD.union(*(names for _, *names in words))
    assert {name.partition("/")[0] for name in tracked()} == added


def test_the_wheel_has_every_file_of_the_package():
    data = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["package-data"]
    folders = {
        "models" if package == "gimcli.models" else package.replace(".", "/"): patterns
        for package, patterns in data.items()
    }
    for name in tracked():
        if name.startswith(("gimcli/", "models/")) and not name.endswith(".py"):
            own = [name.removeprefix(f"{f}/") for f, patterns in folders.items() for p in patterns if _fits(name, f, p)]
            assert own, f"{name}: no pattern in package-data of pyproject.toml"


def _fits(name, folder, pattern):
    inner = name.removeprefix(f"{folder}/")
    return inner != name and inner.count("/") == pattern.count("/") and fnmatch(inner, pattern)


def test_every_folder_with_files_of_its_own_is_a_package():
    text = (ROOT / "setup.py").read_text(encoding="utf-8")
    for path in {path.parent for path in PACKAGE.rglob("*.js")}:
        package = ".".join(path.relative_to(ROOT).parts)
        assert (path / "__init__.py").exists() or f'"{package}"' in text
