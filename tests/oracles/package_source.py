"""The syntax trees of the package's files, parsed once in a process."""

import ast
import gc
from functools import cache
from pathlib import Path

import gimcli

PACKAGE = Path(gimcli.__file__).parent


@cache
def trees() -> dict[Path, ast.Module]:
    """Return the tree of each Python file, by path relative to the package; the garbage collector never visits them."""
    gc.disable()
    texts = {path.relative_to(PACKAGE): path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    found = {path: ast.parse(text) for path, text in texts.items()}
    gc.freeze()
    gc.enable()
    return found


@cache
def nodes(tree: ast.AST) -> list[ast.AST]:
    """Return all nodes of a tree."""
    return list(ast.walk(tree))


BLOCKS = ("body", "handlers", "orelse", "finalbody", "cases")


@cache
def statements(tree: ast.AST) -> list[ast.AST]:
    """Return a tree and all its statements and handlers, also inner ones; their expressions are not entered."""
    found = [tree]
    for node in found:
        for block in BLOCKS:
            found += getattr(node, block, ())
    return found


@cache
def modules() -> dict[str, ast.Module]:
    """Return the tree of each file, by the name of its module."""
    names = {path: ("gimcli", *path.with_suffix("").parts) for path in trees()}
    return {".".join(names[path]).removesuffix(".__init__"): tree for path, tree in trees().items()}
