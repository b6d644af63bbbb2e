"""The options of pictures, which all commands that draw have in common."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import wraps
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


def with_picture_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of pictures to a command (decorator); its argument `drawing` gets those that are given."""

    @wraps(command)
    def extended(**given: Any) -> None:
        values = {option.name: given.pop(option.name) for option in OPTIONS}
        command(**given, drawing={name: value for name, value in values.items() if value is not None})

    own = inspect.signature(command, eval_str=True)
    kept = [p.replace(kind=p.KEYWORD_ONLY) for p in own.parameters.values() if p.name != "drawing"]
    extended.__signature__ = own.replace(parameters=[*kept, *OPTIONS])  # type: ignore[attr-defined]  # read by typer
    return extended
