"""The class of all commands: their help, and values of options that are used without a check by typer.

The help has usage, one sentence, examples, then the options in named groups. Typer checks each value, and each default,
by adapters of pydantic: importing and building them takes longer than a short motion takes to solve. A value that is
not plain is left to typer; messages about wrong numbers and words have the form of the library's.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from enum import Enum
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand

from gimcli.cli.arguments import OUTPUT, PICTURE

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


WORD = r"'(.*?)'"
UNCHECKED = object()
DIGITS = 9
"""Most digits of a number that is used without a check."""


def taking_plain_values(params: Iterable[Any]) -> list[Any]:
    """Return the parameters of a command; plain values are used without a check by typer."""
    return [_taking(param) for param in params]


def _taking(param: Any) -> Any:
    checked = param.process_value

    def process_value(ctx: Any, value: Any) -> Any:
        found = plain_value(param, value)
        if found is UNCHECKED:
            try:
                return checked(ctx, value)
            except typer.BadParameter as error:
                error.message = _expected(param, value, error.message)
                raise
        return param.callback(ctx, param, found) if param.callback else found

    if "process_value" not in vars(param):
        param.process_value = process_value
    return param


def plain_value(param: Any, value: Any) -> Any:
    """Return the value of a parameter in the type of its default (lists have texts), or UNCHECKED."""
    kind = type(param.default)
    if value is None:
        return UNCHECKED if param.required or param.multiple or param.nargs != 1 else None
    if type(value) is kind and value == param.default:
        return value
    if kind is list and isinstance(value, list | tuple) and all(_printable(one) for one in value):
        return list(value)
    return _from_text(param, kind, value) if _printable(value) else UNCHECKED


def _expected(param: Any, value: Any, message: str) -> str:
    """Return the message about a wrong value; that of typer if the value is neither a number nor a word."""
    kind = type(param.default)
    if (words := message.partition(" is not one of ")[2]) != "":
        return f"expected one of {', '.join(re.findall(WORD, words))}, got '{value}'"
    if not message.startswith("Input should be"):
        return message
    number = "a whole number" if kind is int or "integer" in message else "a number"
    low, high = getattr(param, "min", None), getattr(param, "max", None)
    if low is None:
        return f"expected {number}, got '{value}'"
    return f"expected {number} {f'of at least {low:g}' if high is None else f'from {low} to {high}'}, got '{value}'"


def _printable(value: Any) -> bool:
    return isinstance(value, str) and value.isprintable()


def _from_text(param: Any, kind: type[Any], text: str) -> Any:
    if kind is str:
        return text
    if issubclass(kind, Path) and (os.access(text, os.R_OK) or not os.path.lexists(text)):
        return kind(text)
    if kind is int and text.isascii() and text.isdigit() and len(text) <= DIGITS:
        low, high = getattr(param, "min", None), getattr(param, "max", None)
        if low is not None and low <= int(text) and (high is None or int(text) <= high):
            return int(text)
    return kind(text) if issubclass(kind, Enum) and text in {one.value for one in kind} else UNCHECKED
