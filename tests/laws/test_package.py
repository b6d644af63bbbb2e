"""The package as a whole: its modules form no cycle of imports, and no class name stands twice."""

import ast
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

import gimcli

ROOT = Path(gimcli.__file__).parent
TREES = {
    ".".join(path.relative_to(ROOT.parent).with_suffix("").parts).removesuffix(".__init__"): ast.parse(path.read_text())
    for path in ROOT.rglob("*.py")
}


def imported(tree: ast.Module) -> set[str]:
    """Return the modules that one imports anywhere, for its types too."""
    froms = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    named = {
        name if (name := f"{node.module}.{one.name}") in TREES else node.module for node in froms for one in node.names
    }
    return named & TREES.keys()


def test_no_cycle_of_imports() -> None:
    """Types count too: modules that need each other are one module, or need a third."""
    needed = {name: imported(tree) - {name} for name, tree in TREES.items()}
    tuple(TopologicalSorter(needed).static_order())


def test_no_class_name_twice() -> None:
    names = Counter(node.name for tree in TREES.values() for node in tree.body if isinstance(node, ast.ClassDef))
    assert not [name for name, count in names.items() if count > 1 or "Policy" in name]
