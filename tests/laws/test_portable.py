"""What can be checked of other systems without them: encodings, functions that only Unix has, names of files."""

import ast
import re
from pathlib import Path

import pytest
from package_source import nodes, trees

ROOT = Path(__file__).parents[2]

UNIX = {"chown", "fork", "forkpty", "getgid", "geteuid", "getpgid", "getuid", "kill", "killpg", "mkfifo", "nice",
        "sched_getaffinity", "setsid", "uname", "wait", "WNOHANG"}  # fmt: skip
"""Functions of `os` that Windows does not have, or that do something else there."""

UNIX_MODULES = {"fcntl", "grp", "pty", "pwd", "resource", "termios", "tty"}

REFUSED = r'[<>:"|?*\\\x00-\x1f]|[. ]$|^(?:con|prn|aux|nul|com\d|lpt\d)(?:\.|$)'
"""Names that Windows refuses. Source: Microsoft, Naming Files, Paths, and Namespaces."""


def calls(tree):
    return [node for node in nodes(tree) if isinstance(node, ast.Call)]


def opens_text(call):
    """Return whether a call opens a file as text, and has no encoding."""
    function, keywords = call.func, {word.arg for word in call.keywords}
    if isinstance(function, ast.Attribute) and function.attr in ("read_text", "write_text"):
        return "encoding" not in keywords
    name = function.id if isinstance(function, ast.Name) else getattr(function, "attr", "")
    modes = [arg.value for arg in call.args if isinstance(arg, ast.Constant) and isinstance(arg.value, str)]
    textual = [mode for mode in modes if re.fullmatch(r"[rwxa]\+?t?", mode)]
    plain = isinstance(function, ast.Name) and name == "open" and not [m for m in modes if "b" in m]
    return (plain or (name in ("open", "fdopen") and textual)) and "encoding" not in keywords


def is_entry(call):
    """Return whether a call opens an entry of an archive, which has no encoding."""
    return any(word.arg == "force_zip64" for word in call.keywords)


def test_text_files_have_an_encoding():
    found = [
        f"{path}:{call.lineno}"
        for path, tree in trees().items()
        for call in calls(tree)
        if opens_text(call) and not is_entry(call)
    ]
    assert not found


@pytest.mark.parametrize("text", ["open(name)", 'open(name, "w")', "path.read_text()", 'path.open("r")'])
def test_calls_without_an_encoding_are_found(text):
    assert opens_text(calls(ast.parse(text))[0])


def test_functions_of_unix_are_used_only_where_they_exist():
    for path, tree in trees().items():
        asked = {
            call.args[1].value for call in calls(tree) if isinstance(call.func, ast.Name) and call.func.id == "hasattr"
            and isinstance(call.args[1], ast.Constant)
        }  # fmt: skip
        used = {
            node.attr for node in nodes(tree)
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "os"
        }  # fmt: skip
        assert used & UNIX <= asked, path
        imported = {
            name.name for node in nodes(tree) if isinstance(node, ast.Import | ast.ImportFrom) for name in node.names
        } | {node.module for node in nodes(tree) if isinstance(node, ast.ImportFrom)}
        assert not imported & UNIX_MODULES, path


def test_names_of_files_are_allowed_everywhere():
    folders = ("gimcli", "models", "examples", "tests")
    paths = [path.relative_to(ROOT) for folder in folders for path in (ROOT / folder).rglob("*")]
    paths = [path for path in paths if "__pycache__" not in path.parts]
    assert paths
    assert not [path for path in paths for part in path.parts if re.search(REFUSED, part, re.IGNORECASE)]
    assert len({str(path).casefold() for path in paths}) == len(paths)
