"""The help of a command: usage, one sentence, examples, then the options in named groups."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from typer.core import TyperCommand

from gimcli.cli.arguments import OUTPUT, PICTURE
from gimcli.cli.plain_values import taking_plain_values

SUFFIXES = "SUFFIXES"
"""The word of a help text that stands for the suffixes of the files that the command writes."""


class Command(TyperCommand):
    """A command whose help begins with examples; plain values are not checked by typer."""

    examples: tuple[str, ...] = ()
    kind: Any = None
    """The class of the result, which has the suffixes of the files."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the arguments and options."""
        return taking_plain_values(super().get_params(ctx))

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write usage, text, examples and options."""
        self.format_usage(ctx, formatter)
        self.format_help_text(ctx, formatter)
        with formatter.section("Examples" if len(self.examples) > 1 else "Example"):
            for example in self.examples:
                formatter.write(f"{'':{formatter.current_indent}}{example}\n")
        for title, rows in grouped(self.get_params(ctx), ctx).items():
            with formatter.section(title):
                formatter.write_dl([row for row in rows if row[1]])
                for line in (row[0] for row in rows if not row[1]):
                    formatter.write(f"{'':{formatter.current_indent}}{line}\n")
        formatter.write(f"\nMore: gim manual {ctx.info_name}\n")


def grouped(params: Iterable[Any], ctx: Any) -> dict[str, list[tuple[str, str]]]:
    """Return the lines of the help by group title; an option without a group is in the last group.

    The options of pictures have one line together, in the group of the output.
    """
    groups: dict[str, list[tuple[str, str]]] = {}
    form: list[str] = []
    for param in params:
        record = param.get_help_record(ctx)
        if record is not None:
            title = getattr(param, "rich_help_panel", None) or next(reversed(groups), "Options")
            if title == PICTURE:
                form.append(param.opts[0])
            else:
                head = param.metavar if param.param_type_name == "argument" else record[0]
                text = _without_range(brief(record[1]))
                if SUFFIXES in text:
                    text = text.replace(SUFFIXES, " ".join(ctx.command.kind.suffixes()))
                groups.setdefault(title, []).append((head, text))
    if form:
        groups[OUTPUT].append((f"Picture: {' '.join(form)} (see gim manual commands)", ""))
    return groups


def brief(text: str) -> str:
    """Return the help of an option, with its default, from a text whose further lines are for the manual."""
    return re.sub(r"\n.*?(?=  \[|$)", "", text)


def _without_range(text: str) -> str:
    """Return a help text without the range of a number; the error message gives the range."""
    head, bracket, extra = text.rpartition("  [")
    kept = [part for part in extra.removesuffix("]").split("; ") if "x<=" not in part and "x>=" not in part]
    return (f"{head}{bracket}{'; '.join(kept)}]" if kept else head) if bracket else text
