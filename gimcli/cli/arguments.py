"""Arguments and options that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.errors import refuse

if TYPE_CHECKING:
    from gimcli.mechanism import Mechanism


INPUTS, METHOD, OUTPUT = "Inputs", "Method", "Output"
"""Titles of groups of options."""

ModelPath = Annotated[
    str,
    typer.Argument(metavar="MODEL", help="Model file, or a shipped model.", show_default=True, rich_help_panel=INPUTS),
]
MODEL = "model.yaml"

NONE: list[str] = []
"""The default of options that may be repeated: typer needs a list, and nothing changes it."""

Set = Annotated[
    list[str],
    typer.Option(
        "--set", metavar="NAME=VALUE", rich_help_panel=INPUTS,
        help="Another value of a parameter or dimension; repeatable.\n"
        "Of any [dimension](model-file.md#dimensions) of the file, such as `--set a=40 --set crank.length=42"
        " --set B.x=90`. This is the same as an edit of the file, which is"
        ' not changed. VALUE may be a formula, such as `"2*b + 3"`.',
    ),
]  # fmt: skip


def _given(context: typer.Context, assembly: str) -> str:
    """Refuse an empty text, such as that of a shell variable that is not set."""
    source = context.get_parameter_source("assembly")
    refuse(
        (
            source is not None and source.name == "COMMANDLINE" and not assembly.strip(),
            "--assembly: expected the number or the signs of a configuration, got ''",
        )
    )
    return assembly


Assembly = Annotated[
    str,
    typer.Option(
        "--assembly", metavar="K", rich_help_panel=INPUTS, callback=_given,
        help="Number or signs of `gim solve --all`, or MACHINE=K,...\n"
        "The command starts from this configuration, see [choosing the assembly](#choosing-the-assembly).",
    ),
]  # fmt: skip
Json = Annotated[
    bool,
    typer.Option("--json", help="Print the report as one JSON object.\nSee [JSON](#json).", rich_help_panel=OUTPUT),
]
Out = Annotated[
    list[str],
    typer.Option(
        "--out", "-o", metavar="PATH", rich_help_panel=OUTPUT,
        help="Folder, or file (SUFFIXES), or - for CSV on standard output; repeatable.",
    ),
]  # fmt: skip
Png = Annotated[
    bool,
    typer.Option(
        "--png/--no-png", help="Write the picture too, if PATH is a folder.", show_default=False, rich_help_panel=OUTPUT
    ),
]  # fmt: skip
PngFile = Annotated[Path | None, typer.Option("--png", hidden=True)]
CsvFile = Annotated[Path | None, typer.Option("--csv", hidden=True)]

SHARED = {
    "at": typer.Option(
        "--at", metavar="ACTUATOR=VALUE", rich_help_panel=INPUTS,
        help="Input value in the file's unit; repeatable.\n"
        "The other inputs have the start of their laws.",
    ),
    "steps": typer.Option(
        "--steps", "-n", metavar="N", rich_help_panel=INPUTS,
        help="Steps of the motion: N + 1 rows.\n"
        "The first row is at the start of the law, the last at its end.",
    ),
    "method": typer.Option(
        "--method", metavar="METHOD", rich_help_panel=METHOD, show_default=False,
        help="auto (default), gim (geometric iteration) or newton.\n"
        "`auto`: closed forms for dyads, Newton-Raphson for strongly coupled groups. `gim`: sweeps alone, as in"
        " the paper. `newton`: Newton-Raphson without closed forms.",
    ),
    "strategy": typer.Option(
        "--strategy", metavar="STRATEGY", rich_help_panel=METHOD, show_default=False,
        help="For gim: spectral (default) or classic (the paper).\n"
        "The sequence is the admissible one with the least spectral radius, or that by the rules of the paper.",
    ),
    "sequence": typer.Option(
        "--sequence", metavar="TEXT", rich_help_panel=METHOD,
        help='Steps for --method gim, such as "A>B D>C C^B>E".\n'
        'Your own sequence, moves in order: FROM>TO imposes a'
        " distance, ARM^VERTEX>TO an angle, see [gim sequence](#gim-sequence). By default the best one is"
        " searched.",
    ),
    "tolerance": typer.Option(
        "--tolerance", metavar="T", rich_help_panel=METHOD,
        help="Allowed error, relative to the size.\n"
        "The error of a constraint, angles in rad; from 1e-14 to below 1.",
    ),
    "seconds": typer.Option(
        "--seconds", metavar="S", min=0.0, help="End after this time with what was found.", rich_help_panel=METHOD
    ),
    "jit": typer.Option(
        "--jit", metavar="WHEN", rich_help_panel=METHOD,
        help="Compile the kernels: auto, on or off.\n"
        "`auto`: where this saves time. The numbers are the same.",
    ),
}  # fmt: skip
"""Options that have the same form in all commands, by the names of the arguments of verbs."""


def pairs(
    given: list[str], option: str = "--at", form: str = "ACTUATOR=VALUE", what: str = "a value; give it",
    read: Callable[[str], Any] = str,
) -> dict[str, Any]:  # fmt: skip
    """Return the values of --at by the names of the actuators, or those of another option of this kind.

    `read` returns a value from its text; its ValueError is that of a text without the form. `what` a name has already
    is in the message for a name that is given twice.
    """
    values: dict[str, Any] = {}
    for text in given:
        name, equals, value = text.partition("=")
        try:
            own = read(value)
        except ValueError:
            equals = ""
        refuse(
            (not equals, f"{option} {text}: expected {form}"),
            (name in values, f"{option} {text}: '{name}' already has {what} once"),
        )
        values[name] = own
    return values


def assignments(given: list[str]) -> dict[str, str]:
    """Return the values of --set by the names of the dimensions."""
    return {name.strip(): value for name, value in pairs(given, "--set", "NAME=VALUE").items()}


def changed(mechanism: Mechanism, given: list[str]) -> Mechanism:
    """Return a mechanism with the values of --set."""
    return mechanism.with_(assignments(given)) if given else mechanism


PICTURE = "Picture"
"""Title of the group of options; the help has one line for all of them."""

Drawing = Mapping[str, Any]
"""The options of pictures that were given, by name."""

NO_OPTIONS: Drawing = {}


DRAWN = (
    ("size", Annotated[str | None, typer.Option(
        "--size", metavar="WxH", rich_help_panel=PICTURE,
        help="Width and height of the whole picture with a unit (mm, cm, in), such as `160x90mm`.\n"
        "Texts and symbols keep their size.",
    )], None),
    ("dpi", Annotated[int | None, typer.Option(
        "--dpi", metavar="N", rich_help_panel=PICTURE,
        help="Dots per inch of a PNG picture.\nDefault: 150, or more so that the picture is 1000 pixels wide.",
    )], None),
    ("title", Annotated[str | None, typer.Option(
        "--title", metavar="TEXT", help='Title; `""` for none.', rich_help_panel=PICTURE
    )], None),
    ("ghosts", Annotated[str | None, typer.Option(
        "--ghosts", metavar="N", rich_help_panel=PICTURE,
        help="At most N light poses beside the first one, or none; default: 3.\n"
        "`--ghosts 4:coupler,rocker` shows only these members in them.",
    )], None),
    ("style", Annotated[str | None, typer.Option(
        "--style", metavar="FILE", rich_help_panel=PICTURE,
        help="A matplotlib style file, or the name of a style of matplotlib, such as `grayscale`.",
    )], None),
)  # fmt: skip
"""Options of pictures: name, annotation and default."""


def declared(function: Callable[..., None], *options: tuple[str, Any, Any]) -> Callable[..., None]:
    """Return a function with the signature that typer reads: name, annotation and default of each option."""
    listed = [Parameter(name, Parameter.KEYWORD_ONLY, annotation=form, default=value) for name, form, value in options]
    function.__signature__ = Signature(listed)  # type: ignore[attr-defined]  # functions have none in their type
    return function
