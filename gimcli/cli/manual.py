"""`gim manual`: the manual of the package."""

from __future__ import annotations

import os
import re
import sys

import typer

from gimcli.cli.console import end_bars
from gimcli.manual.pages import manual_text, page_names, summary

HELP = "Without a name it lists the pages; the name of a command shows the section on it."
EXAMPLES = ("gim manual tutorial", "gim manual trace")
WIDEST = 100
"""Columns of a page on a terminal, at most."""


def command(page: str = typer.Argument("", metavar="PAGE", help="A page or a command.", show_default=False)) -> None:
    """List the pages or show one."""
    end_bars()
    if not page:
        _list()
        return
    text = manual_text(page)
    if sys.stdout.isatty():
        _show(text)
    else:
        typer.echo(re.sub(r"(?m)^```(\w+) .*$", r"```\1", _without_links(text)), nl=False)  # words are for the tests


def _list() -> None:
    names = page_names()
    width = max(map(len, names))
    for name in names:
        typer.echo(f"{name:{width}}  {summary(name)}")
    typer.echo("\n`gim manual PAGE` shows a page, `gim manual COMMAND` the section on a command.")


def _show(text: str) -> None:
    """Show Markdown on the terminal, a screen at a time."""
    from rich.console import Console
    from rich.markdown import Markdown

    os.environ.setdefault("LESS", "FRX")  # keep colours; show a text that fits on the screen without waiting
    console = Console()
    console.width = min(console.width, WIDEST)
    with console.pager(styles=True):
        console.print(Markdown(_without_links(text), code_theme="ansi_dark"))


def _without_links(text: str) -> str:
    """Return Markdown whose links are words: a terminal cannot follow them."""
    text = re.sub(r"!\[([^]]*)\]\((?:\.\./)*([^)]*)\)", r"(Picture \2: \1)", text)
    text = re.sub(r"\[`?([^]`]*)`?\]\(([\w-]+)\.md[^)]*\)", _reference, text)
    return re.sub(r"\[([^]]*)\]\((?!https?:)[^)]*\)", r"\1", text)


def _reference(link: re.Match[str]) -> str:
    words, page = link[1], link[2]
    return words if words.lower() == page else f"{words} (`gim manual {page}`)"
