"""`gim new`: a shipped model as the template of an own one."""

from __future__ import annotations

from typing import Annotated

import typer

from gimcli.cli.arguments import INPUTS, OUTPUT
from gimcli.cli.console import end_bars, note, print_json, print_written
from gimcli.errors import refuse
from gimcli.library.shipped_models import ShippedModel, shipped_model, shipped_models

HELP = (
    "The model is written to standard output with all its comments, or with -o to a file, with the tables that it"
    " reads beside it. Without a name the command lists the models. Every command finds a shipped model by its name:"
    " `gim trace crank_rocker`."
)
EXAMPLES = ("gim new --list", "gim new crank_rocker > model.yaml", "gim new slider_crank -o press/")


def command(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="A shipped model.", show_default=False, rich_help_panel=INPUTS)
    ] = "",
    listed: Annotated[
        bool,
        typer.Option("--list", help="List the shipped models by themes.\nAs without a name.", rich_help_panel=INPUTS),
    ] = False,
    out: Annotated[
        str,
        typer.Option(
            "--out", "-o", metavar="PATH", show_default=False, rich_help_panel=OUTPUT,
            help="File (.yaml, .yml), or folder for NAME.yaml, or - for standard output.",
        ),
    ] = "",
    force: Annotated[bool, typer.Option("--force", help="Replace files that exist.", rich_help_panel=OUTPUT)] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the list, or the model, as one JSON object.", rich_help_panel=OUTPUT)
    ] = False,
) -> None:  # fmt: skip
    """Write a shipped model, or list all."""
    to_file = out not in ("", "-")
    refuse(
        (name and listed, f"new {name} --list: give a name, or --list"),
        (not name and (to_file or force), "new: which model? Give a name; `gim new --list` lists the models"),
        (force and not to_file, "--force replaces files: give one with -o"),
    )
    if name:
        _write(shipped_model(name), out if to_file else "", force, as_json)
    else:
        _list(as_json)


def _write(model: ShippedModel, out: str, force: bool, as_json: bool) -> None:
    files = model.write(out, force) if out else ()
    end_bars()
    if as_json:
        print_json({**model.report(), "text": model.text, "files": [str(path) for path in files]})
        return
    if out:
        print_written(files)
        return
    typer.echo(model.text, nl=False)
    if model.tables:
        note(f"gim: this model reads {', '.join(model.tables)}: use -o FILE to write the model and its tables")


def _list(as_json: bool) -> None:
    models = shipped_models()
    end_bars()
    if as_json:
        print_json({"models": [model.report() for model in models]})
        return
    width = max(len(model.name) for model in models)
    theme = ""
    for model in models:
        if model.theme != theme:
            typer.echo("\n" * bool(theme) + model.theme)
            theme = model.theme
        typer.echo(f"  {model.name:{width}}  {model.title}")
    typer.echo("\n`gim new NAME > model.yaml` writes one; all commands take its name: `gim trace NAME`.")
