"""Run the code blocks of Markdown pages. Kinds of blocks:

- `bash`: each line runs, with exit status 0 or the one that a comment at its end names ("# exit status 3");
- `yaml`: a whole model file, which loads and is saved as model.yaml; `yaml more`: entries added to that file, which are
  saved too; `yaml part`: entries that the file loads with (null removes an entry), not saved, or saved under the name
  that follows; `yaml refused`: a file, or entries, that are refused;
- `csv NAME`: a table, saved under its name; `python`: runs, one namespace for each page;
- `output`: what the command or program before it prints, or the message about the refused file;
- `text`: not checked; `setup` after the kind: not run; `soak` after the kind: runs with the long tests only.

Only the long tests run searches with the number of random designs that the page has.
"""

import io
import os
import re
import shlex
import subprocess
import sys
from contextlib import chdir, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml
from bundled import MANUAL, README, ROOT
from in_process import ran

import gimcli
from gimcli import GimError
from gimcli.model.source import read_source

PAGES = [README, *sorted(MANUAL.glob("*.md"))]
KINDS = ("bash", "yaml", "csv", "python", "output", "text")
SHELL = set("|&;<>$`*?~")
QUOTED = r"""'[^']*'|["][^"$`]*["]"""
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
FEWER = {"fit": ("--starts", "500")}
ALONE = rf"(?<![\w.]){NUMBER}(?!\w)"


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    page: Path
    line: int
    kind: str
    words: tuple[str, ...]
    text: str


def blocks(page):
    """Return the blocks of a page; fences stand at the start of their line."""
    found, head, start, body = [], None, 0, []
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        assert line.startswith("```") or not line.lstrip().startswith("```"), f"{page.name}:{number}: indented fence"
        if not line.startswith("```"):
            body.append(line)
        elif head is None:
            head, start, body = line[3:].split(), number, []
            assert head, f"{page.name}:{number}: the kind of the block is missing"
            assert head[0] in KINDS, f"{page.name}:{number}: unknown kind of block '{head[0]}'"
        else:
            found.append(Block(page, start, head[0], tuple(head[1:]), "\n".join(body) + "\n"))
            head = None
    assert head is None, f"{page.name}: a fence is not closed"
    return found


class Reader:
    """Runs the blocks of a page in its own folder."""

    def __init__(self, folder, soak=False):
        self.folder, self.soak = folder, soak
        self.model, self.names, self.printed = {}, {"__name__": "page"}, ""
        for name in ("models", "examples"):
            (folder / name).symlink_to(ROOT / name)
        (folder / ".bin").mkdir()
        command = folder / ".bin" / "gim"
        command.write_text(f'#!/bin/sh\nexec {sys.executable} -c "from gimcli.cli import main; main()" "$@"\n')
        command.chmod(0o755)

    def read(self, page):
        """Run all blocks in order."""
        with chdir(self.folder):
            for block in blocks(page):
                if "setup" not in block.words and ("soak" not in block.words or self.soak):
                    try:
                        getattr(self, block.kind)(block)
                    except (Exception, pytest.fail.Exception) as error:
                        error.add_note(f"{page}:{block.line}: block of {block.kind}")
                        raise

    def text(self, block):
        """Ignore the block."""

    def csv(self, block):
        """Save a table."""
        Path(block.words[0]).write_text(block.text)

    def bash(self, block):
        """Run each line."""
        for line in block.text.replace("\\\n", " ").splitlines():
            command, _, comment = line.partition(" #")
            status = re.search(r"exit status (\d)", comment)
            if command.strip() and not command.startswith("#"):
                self.run(command.strip(), int(status[1]) if status else 0)

    def run(self, command, status):
        """Run a command, in this process if it needs no shell."""
        words = shlex.split(command)
        words += () if self.soak or words[0] != "gim" or "--starts" in words else FEWER.get(words[1], ())
        if words[0] == "gim" and not SHELL & set(re.sub(QUOTED, "", command)):
            done = ran(*words[1:], cwd=self.folder)
            code, self.printed, error = done.code, done.text, done.error
        else:
            path = {
                "PATH": f"{self.folder / '.bin'}:{Path(sys.executable).parent}:{os.environ['PATH']}",
                "PYTHONPATH": str(ROOT),
            }
            process = subprocess.run(
                ["bash", "-c", command], capture_output=True, text=True, env={**os.environ, **path}, timeout=600
            )
            code, self.printed, error = process.returncode, process.stdout, process.stderr
        assert code == status, f"{command}: exit status {code}\n{self.printed}\n{error}"

    def python(self, block):
        """Run a program."""
        with redirect_stdout(io.StringIO()) as out:
            exec(compile(block.text, f"{block.page.name}:{block.line}", "exec"), self.names)
        self.printed = out.getvalue()

    def yaml(self, block):
        """Load a model file, or add entries to the last one."""
        if "refused" in block.words:
            self.printed = self.refused(block.text)
            return
        data = parsed(block.text)
        if {"part", "more"} & set(block.words):
            data = merged(self.model, data)
        gimcli.load(data)
        if "part" in block.words:
            for name in block.words[1:]:
                Path(name).write_text(yaml.safe_dump(data, sort_keys=False))
            return
        self.model = data
        text = block.text if not block.words else yaml.safe_dump(data, sort_keys=False)
        Path("model.yaml").write_text(text)

    def refused(self, text):
        """Return the message about an invalid file, or about invalid entries that are added to the last one."""
        Path("model.yaml").write_text(text)
        try:
            data = parsed(text)
            if "nodes" in data:
                gimcli.solve(gimcli.load("model.yaml"))
            else:
                gimcli.solve(gimcli.load(merged(self.model, data)))
        except GimError as error:
            return str(error)
        finally:
            Path("model.yaml").write_text(yaml.safe_dump(self.model, sort_keys=False))
        pytest.fail("the file is not refused")

    def output(self, block):
        """Compare the block with the printed text."""
        compare(block.text, self.printed)


def parsed(text):
    """Return the data of a model file; keys may be YAML words such as `on`."""
    Path(".part.yaml").write_text(text)
    return read_source(Path(".part.yaml")).data


def merged(base, part):
    """Return the data of a file with entries added, replaced, or removed if they are null."""
    if not (isinstance(base, dict) and isinstance(part, dict)):
        return part
    both = {**base, **{key: merged(base.get(key), value) for key, value in part.items()}}
    return {key: value for key, value in both.items() if value is not None}


def compare(expected, printed):
    """Compare texts apart from spaces and rounding of numbers; three dots stand for anything.

    Each piece between dots is looked for behind the one before: nothing is tried twice.
    """
    expected, printed = (re.sub(r"[─━-]{3,}", "", text).strip() for text in (expected, printed))
    parts, at = expected.split("..."), 0
    for k, part in enumerate(parts):
        first, last = k == 0, k == len(parts) - 1
        pattern = re.compile(r"\s*" * (not first) + _pattern(part) + (r"\Z" if last else ""))
        match = pattern.match(printed, at) if first else pattern.search(printed, at)
        assert match, f"the page has\n{part}\nin\n{expected}\nprinted is\n{printed}"
        for a, b in zip(re.findall(ALONE, part), match.groups(), strict=True):
            assert is_near(a, b), f"the page has {a}, printed is {b} in\n{printed}"
        at = match.end()


def is_near(a, b):
    """Return whether two printed numbers agree to 1e-6, or to one unit of the last digit that either has."""
    return abs(float(a) - float(b)) <= 1.01 * max(1e-6 * abs(float(a)), min(_unit(a), _unit(b)), 1e-12)


def _unit(number):
    """Return one unit of the last printed digit."""
    digits, _, exponent = number.lower().partition("e")
    return 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))


def _pattern(part):
    """Return a pattern of words and numbers."""
    pieces = [piece for piece in re.split(rf"(\s+|{ALONE})", part) if piece]
    return "".join(
        r"\s+" if piece.isspace() else f"({ALONE})" if re.fullmatch(NUMBER, piece) else re.escape(piece)
        for piece in pieces
    )
