"""The tables of options on the page of commands, made from the options themselves: run this file to write them anew."""

import re
from collections import Counter
from textwrap import fill

from bundled import MANUAL
from typer.main import get_command

from gimcli.cli import COMMANDS, app

PAGE = MANUAL / "commands.md"
HEAD = "| option | values | default | meaning |\n|---|---|---|---|\n"
TABLE = re.compile(re.escape(HEAD) + r"(?:\|.*\n)*(?:\nAlso: (?:.+\n)+)?")
SECTION = re.compile(r"(?ms)^## gim (\w+)$.*?(?=^## |\Z)")
SEVERAL = 3
"""Least number of commands with the same option for which its text stands once, among the common options."""


def shown(text, kind):
    """Return a text in a table of Markdown: words in quotes are code, and a column does not end within it."""
    words = re.sub(r'(?<!`)"([^"`]+)"(?!`)', r"`\1`", " ".join(text.split()))
    suffixes = " ".join(f"`{suffix}`" for suffix in kind.suffixes()) if "SUFFIXES" in words else ""
    return words.replace("SUFFIXES", suffixes).replace("|", r"\|")


def values(param, command):
    """Return what an option may be: words, a range, or several of them."""
    words = [one.value for one in param.shell_complete(command.context_class(command), "") if one.type == "plain"]
    if words:
        return ", ".join(f"`{word}`" for word in words)
    low, high = getattr(param, "min", None), getattr(param, "max", None)
    if low is None:
        return "repeatable" if param.multiple else ""
    return f"at least {low:g}" if high is None or high >= 2**63 else f"{low:g} to {high:,}".replace(",", " ")


def default(param):
    """Return the value without the option; nothing where its text says it, or for a switch."""
    found = getattr(param.default, "value", param.default)
    if isinstance(found, bool) or found in (None, "", []):
        return ""
    return f"`{found}`" if isinstance(found, str) else f"{found:g}"


def row(param, command):
    """Return the cells of an option: its forms, its values, its default and its whole text."""
    named = [*param.opts, *param.secondary_opts] if param.param_type_name == "option" else [""]
    forms = [f"`{' '.join(filter(None, (form, param.metavar)))}`" for form in sorted(named, key=len)]
    return (
        ", ".join(forms).replace("|", r"\|"),
        values(param, command),
        default(param),
        shown(param.help or "", command.kind),
    )


def rows():
    """Return the rows of each command, and those that stand once: common ones, and those of pictures."""
    group = get_command(app)
    commands = {name: group.get_command(None, name) for name in COMMANDS}
    params = {name: [p for p in one.params if not getattr(p, "hidden", False)] for name, one in commands.items()}
    every = {name: [row(p, commands[name]) for p in own] for name, own in params.items()}
    pictures = dict.fromkeys(row(p, commands["trace"]) for p in params["trace"] if p.rich_help_panel == "Picture")
    count = Counter(one for own in every.values() for one in own)
    once = [one for one, many in count.items() if many >= SEVERAL and one not in pictures and "`--out" not in one[0]]
    return every, once, list(pictures)


def table(own, once=()):
    """Return the table of the options of a command; of those that stand once it has the names below."""
    cells = [f"| {' | '.join(one)} |".replace("|  |", "| |").replace("|  |", "| |") for one in own if one not in once]
    names = [re.findall(r"`([^` ]+)[^`]*`", one[0])[-1] for one in own if one in once]
    also = fill(f"Also: {', '.join(f'`{name}`' for name in names)}.", 120, break_on_hyphens=False)
    return HEAD + "".join(f"{line}\n" for line in [*cells, *(["", also] if names else [])])


def written(page):
    """Return the text of the page of commands with the tables of today."""
    every, once, pictures = rows()
    head, _, sections = page.partition("## gim check")
    common = iter([table(once), table(pictures)])
    head = TABLE.sub(lambda _: next(common), head)
    alone = {name: table(own, [*once, *pictures]) for name, own in every.items()}
    return head + SECTION.sub(lambda part: TABLE.sub(lambda _: alone[part[1]], part[0]), "## gim check" + sections)


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
