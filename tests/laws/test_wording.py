"""The language of the project: one word for one thing, and no words that the page on contributing advises against."""

from __future__ import annotations

import ast
import re

from bundled import ROOT
from package_source import nodes, statements, trees

AVOIDED = {
    "tell": "report, print, determine", "told": "reported, printed, determined", "tells": "reports, prints",
    "telling": "reporting", "untold": "undetermined", "strewn": "random", "astray": "wrong", "culprit": "cause",
    "mend": "correct", "mended": "corrected", "foreseen": "expected", "lively": "", "busy": "", "nowhere": "",
    "home": "initial configuration",
}  # fmt: skip
"""Words, and what to write."""
PHRASES = (
    "met nothing", "let go", "lets go", "as it will", "lead nowhere", "edge of the numbers", "whole or not at all",
    "unique all the same", "held against", "stands for good",
)  # fmt: skip
ALLOWED = {
    "home": ("home directory", "XDG_CACHE_HOME", "Home, End", "(Home)", "Home:", "Home|End"),
    "untold": ('"untold"', "`untold`"),
}
"""Words in names that are not ours, and in keys that scripts use."""
PATTERNS = (
    "gimcli/**/*.py",
    "gimcli/**/*.md",
    "gimcli/**/*.js",
    "gimcli/**/*.html",
    "models/*.yaml",
    "examples/*.py",
    "README.md",
)
FILES = [path for pattern in PATTERNS for path in sorted(ROOT.glob(pattern))]
WORD = re.compile(r"(?<![A-Za-z])(" + "|".join(AVOIDED) + r")(?![A-Za-z])", re.IGNORECASE)


def test_no_file_has_words_that_the_language_avoids():
    found = []
    for path in FILES:
        if path.name == "contributing.md":  # the page that lists these words
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            place = f"{path.relative_to(ROOT)}:{number}"
            words = [m.group(1).lower() for m in WORD.finditer(line)]
            words = [word for word in words if not any(part in line for part in ALLOWED.get(word, ()))]
            found += [f"{place}: '{word}': write {AVOIDED[word] or 'another word'}" for word in words]
            found += [f"{place}: '{phrase}'" for phrase in PHRASES if phrase in line]
    assert not found, "\n".join(found)


LIBRARY_TEXTS = {"strerror", "msg", "problem", "context"}
"""Attributes of errors whose texts depend on the system and on versions of libraries."""


def test_messages_do_not_pass_on_the_texts_of_libraries():
    """In a handler of an error that is not ours no text has the error or its text; `reason` has the words of files."""
    found = []
    for path, tree in sorted(trees().items()):
        for handler in (n for n in statements(tree) if isinstance(n, ast.ExceptHandler)):
            foreign = handler.type is not None and re.search(r"OSError|JSON|YAML|Unicode", ast.unparse(handler.type))
            for text in (n for n in ast.walk(handler) if foreign and isinstance(n, ast.FormattedValue)):
                value = text.value
                passed = isinstance(value, ast.Name) and value.id == handler.name
                if passed or (isinstance(value, ast.Attribute) and value.attr in LIBRARY_TEXTS):
                    found.append(f"{path.name}:{text.lineno}: {ast.unparse(value)}")
    assert found == []


OPTION = re.compile(r"`gim [^`]*`|((?<![\w-])--[a-z]+)")
TERMINAL = ("cli", "manual", "view")
"""Packages that speak of options; `comparison` lists those of each method."""


def test_messages_of_the_library_speak_of_no_options():
    """Options stand only within a whole command, as in `gim solve --all`: in Python there are none."""
    found = []
    for path, tree in sorted(trees().items()):
        if path.parts[0] in TERMINAL or path.name in ("methods.py", "tradeoff.py"):
            continue
        docs = {id(node.value) for node in statements(tree) if isinstance(node, ast.Expr)}
        for node in nodes(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
                found += [f"{path}:{node.lineno}: {word}" for word in OPTION.findall(node.value) if word]
    assert found == []
