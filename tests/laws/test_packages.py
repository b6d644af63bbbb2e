"""The docstring of each package states what it knows, which packages it asks and which ask it; the imports agree."""

import ast
import re
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest
from package_source import modules, nodes, trees

PACKAGES = sorted(path.parts[0] for path in trees() if len(path.parts) == 2 and path.name == "__init__.py")
ANY = ("any package below.", "any package above.")


@cache
def asked():
    """Return the packages that each package imports, also inside functions and for types."""
    found = defaultdict(set)
    for path, tree in trees().items():
        for node in nodes(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "gimcli":
                found[path.parts[0]] |= {f"{node.module}.{one.name}".split(".")[1] for one in node.names}
    return {own: (found[own] & set(PACKAGES)) - {own} for own in PACKAGES}


def stated(package, head):
    """Return the packages in a line of the docstring; None for any."""
    text = ast.get_docstring(modules()[f"gimcli.{package}"])
    (line,) = re.findall(rf"^{head}: (.*)$", text, re.M)
    return None if line in ANY else set() if line == "no package." else set(line.removesuffix(".").split(", "))


@pytest.mark.parametrize("package", PACKAGES)
def test_the_docstring_states_whom_a_package_asks(package):
    for head, actual in (
        ("Asks", asked()[package]),
        ("Asked by", {other for other in PACKAGES if package in asked()[other]}),
    ):
        named = stated(package, head)
        assert named is None or named == actual, f"gimcli/{package}/__init__.py, {head}"
    assert "\nKnows: " in ast.get_docstring(modules()[f"gimcli.{package}"])


def test_the_page_for_contributors_names_every_package():
    page = (Path(__file__).parents[2] / "gimcli" / "manual" / "contributing.md").read_text(encoding="utf-8")
    table = page.partition("## Packages")[2].partition("\n## ")[0]
    assert {name for row in re.findall(r"^\| (`.*?) \|", table, re.M) for name in re.findall(r"`(\w+)`", row)} == {
        *PACKAGES
    }
