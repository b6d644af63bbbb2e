"""The options of pictures, which all commands that draw have in common."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Annotated, Any

import typer

PICTURE = "Picture"
"""Title of the group of options; the help has one line for all of them."""

Drawing = Mapping[str, Any]
"""The options of pictures that were given, by name."""

NO_OPTIONS: Drawing = {}


def _options(
    *,
    size: Annotated[str | None, typer.Option("--size", metavar="WxH", rich_help_panel=PICTURE)] = None,
    dpi: Annotated[int | None, typer.Option("--dpi", metavar="N", rich_help_panel=PICTURE)] = None,
    title: Annotated[str | None, typer.Option("--title", metavar="TEXT", rich_help_panel=PICTURE)] = None,
    ghosts: Annotated[str | None, typer.Option("--ghosts", metavar="N", rich_help_panel=PICTURE)] = None,
    style: Annotated[str | None, typer.Option("--style", metavar="FILE", rich_help_panel=PICTURE)] = None,
) -> None: ...


OPTIONS = list(inspect.signature(_options, eval_str=True).parameters.values())
