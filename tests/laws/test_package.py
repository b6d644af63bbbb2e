"""The whole package: there is no cycle of imports, and each class name is unique."""

import ast
import re
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

from package_source import modules, statements


def imported(tree: ast.Module) -> set[str]:
    """Return the modules that a module imports, also inside functions and for types."""
    froms = [node for node in statements(tree) if isinstance(node, ast.ImportFrom) and node.module]
    named = {
        name if (name := f"{node.module}.{one.name}") in modules() else node.module
        for node in froms
        for one in node.names
    }
    return named & modules().keys()


def test_no_cycle_of_imports() -> None:
    """Imports for types count: modules that import each other should be one module, or use a third."""
    needed = {name: imported(tree) - {name} for name, tree in modules().items()}
    tuple(TopologicalSorter(needed).static_order())


def test_no_class_name_twice() -> None:
    names = Counter(node.name for tree in modules().values() for node in tree.body if isinstance(node, ast.ClassDef))
    assert not [name for name, count in names.items() if count > 1 or "Policy" in name]


STATEMENTS = 43_909
"""Most statements of the package: 46 763 at first; each change of the structure lowers the number."""

DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def number(tree: ast.Module) -> int:
    """Return the number of statements without docstrings."""
    docs = sum(isinstance(node, DOCUMENTED) and ast.get_docstring(node) is not None for node in statements(tree))
    return sum(isinstance(node, ast.stmt) for node in statements(tree)) - docs


def test_the_package_has_no_more_statements_than_agreed() -> None:
    assert sum(map(number, modules().values())) <= STATEMENTS


INNER = 551
"""Most names that tests import from inside of the package: those beside gimcli, calculus, language and quantities."""

OPEN = ("gimcli.calculus", "gimcli.language", "gimcli.quantities")


def test_tests_import_no_more_inner_names_than_agreed() -> None:
    texts = [path.read_text(encoding="utf-8") for path in Path(__file__).parents[1].rglob("*.py")]
    froms = [
        line for text in texts for line in re.findall(r"^ *(from gimcli\.[\w.]+ import (?:\([^)]*\)|.*))", text, re.M)
    ]
    nodes = [node for line in froms for node in ast.parse(line).body if isinstance(node, ast.ImportFrom)]
    names = {f"{node.module}.{one.name}" for node in nodes for one in node.names if not node.module.startswith(OPEN)}
    assert len(names) <= INNER, "a test of behaviour uses the public library"
