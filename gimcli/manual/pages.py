"""Pages of the manual and sections of its page of commands, by their names."""

from __future__ import annotations

import re
from pathlib import Path

from gimcli.errors import UsageError
from gimcli.nearest import near

FOLDER = Path(__file__).parent
INDEX, COMMANDS = "index", "commands"
"""The page that links all others in the order of reading, and the page with one section for each command."""

OPTIONS_HEAD = "| option | values | default | meaning |\n|---|---|---|---|\n"
"""The head of the table of options in the section of a command."""

HEADS = r"(?ms)^```.*?^```|^(?P<level>##?) (?:`?gim (?P<name>\w+))?"
"""Headings of sections; text between fences is skipped."""


def page_names() -> list[str]:
    """Return the names of all pages: the index, the pages in its order, then any other page."""
    present = {path.stem for path in FOLDER.glob("*.md")}
    linked = re.findall(r"\]\(([\w-]+)\.md", _text(INDEX)) if INDEX in present else []
    return [name for name in dict.fromkeys([INDEX, *linked, *sorted(present)]) if name in present]


def summary(name: str) -> str:
    """Return the first sentence under the title of a page."""
    paragraphs = (part for part in _text(name).split("\n\n") if not part.startswith(("#", "!", "```")))
    words = " ".join(next(paragraphs, "").split())
    return re.split(r"(?<=[.?!])\s", words, maxsplit=1)[0]


def command_names() -> list[str]:
    """Return the commands that have a section."""
    return list(_sections())


def manual_text(name: str) -> str:
    """Return a page or the section of a command as Markdown; both, the section first, where they share the name.

    Raises UsageError where there is neither.
    """
    found = [_sections().get(name, ""), _text(name) if name in page_names() else ""]
    if not any(found):
        known = [*page_names(), *command_names()]
        hint = near(name.lower().removesuffix(".md"), known) or f"; pages: {', '.join(page_names())}"
        raise UsageError(f"manual {name}: there is no such page{hint}")
    return "\n".join(text for text in found if text)


def option_rows(name: str) -> list[list[str]]:
    """Return the cells of the options of a command: its forms, its values, its default and its meaning."""
    own, (common, _, _) = _sections()[name], _text(COMMANDS).partition("\n## gim ")
    also = re.search(r"(?m)^Also: (?:.+\n)+", own)
    others = {re.findall(r"`([^` ]+)", row[0])[-1]: row for row in _rows(common)}
    return [*_rows(own), *(others[flag] for flag in re.findall(r"`(.+?)`", also[0] if also else ""))]


def _rows(text: str) -> list[list[str]]:
    """Return the cells of the tables of options in a text."""
    tables = "\n".join(part.partition("\n\n")[0] for part in text.split(OPTIONS_HEAD)[1:])
    cells = (re.split(r" ?(?<!\\)\| ?", line[2:-2]) for line in tables.splitlines() if line)
    return [[cell.replace(r"\|", "|") for cell in row] for row in cells]


def _text(name: str) -> str:
    return (FOLDER / f"{name}.md").read_text(encoding="utf-8")


def _sections() -> dict[str, str]:
    """Return the sections `## gim NAME` of the page of commands by their names."""
    text = _text(COMMANDS) if (FOLDER / f"{COMMANDS}.md").exists() else ""
    heads = [head for head in re.finditer(HEADS, text) if head["level"]]
    ends = [*(head.start() for head in heads[1:]), len(text)]
    return {head["name"]: text[head.start() : end] for head, end in zip(heads, ends, strict=False) if head["name"]}
