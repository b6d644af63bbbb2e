"""The options of a command for the completion of a shell, from its section of the manual: no analysis is imported."""

from __future__ import annotations

import re
from collections.abc import Callable
from enum import StrEnum
from typing import Annotated, Any, cast

import typer

from gimcli.cli.arguments import declared
from gimcli.manual.pages import option_rows

END = r"(?<=[^.]\.) |(?<=\.) (?=[A-Z])"
"""Where the first sentence of a meaning ends; the others are for the manual."""


def completed(name: str) -> Callable[..., None]:
    """Return a function with the options of a command, as typer reads them; its values are words, or any texts."""

    def command(**_: Any) -> None:
        """Do nothing: a shell only lists the options."""

    return declared(command, *(_parameter(*row) for row in option_rows(name)))


def _parameter(forms: str, values: str, _: str, meaning: str) -> tuple[str, Any, Any]:
    """Return name, annotation and default of the option of a row.

    It is a switch if its forms have no value, else one of the words, a text, or several texts.
    """
    flags, help_text = re.findall(r"`([^`, ]+)", forms), re.split(END, meaning, maxsplit=1)[0]
    words, form = re.findall(r"`(.+?)`", values), typer.Option(*flags, help=help_text)
    kind: Any = str
    usual: Any = ""
    if not flags[0].startswith("-"):
        form = typer.Argument(help=help_text)
    elif words:
        kind, usual = cast(Any, StrEnum)(flags[-1], words), words[0]
    elif values == "repeatable":
        kind, usual = list[str], []
    elif " " not in forms.replace(", ", ""):
        kind, usual, form = bool, False, typer.Option("/".join(flags), help=help_text)
    return flags[0].strip("-").replace("-", "_"), Annotated[kind, form], usual
