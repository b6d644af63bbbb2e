"""`gim check`: what a mechanism is, what its motion does, and what in the file is doubtful."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, NONE, Assembly, Json, ModelPath, Out, Set
from gimcli.cli.console import print_more, print_table
from gimcli.cli.progress import progress_bar
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.library.check import CheckResult

HELP = (
    "Type, mobility, ranges of the inputs, strokes and time ratios, worst transmission angles and greatest speeds of"
    " the motion along the laws; warnings about the file. The exit status is 0 with warnings too."
)
EXAMPLES = (
    "gim check crank_rocker",
    "gim check whitworth -o check.html",
    "gim check crank_rocker --long > explicit.yaml",
)


def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    assembly: Assembly = "",
    long: Annotated[
        bool, typer.Option("--long", help="Print the model file in long form, with everything explicit; no check.")
    ] = False,
    out: Out = NONE,
    as_json: Json = False,
) -> None:
    """Check a model."""
    from gimcli.cli.outputs import Outputs
    from gimcli.library.check import CheckResult, check

    if long and (out or as_json):
        raise UsageError(f"--long prints the model file, it cannot be used with {'-o' if out else '--json'}")
    outputs = Outputs(CheckResult, model, out, as_json=as_json)
    if long:
        from gimcli.library.long_form import long_form

        typer.echo(long_form(outputs.loaded(assembly, changes=changes)), nl=False)
        return
    outputs.finish(check(outputs.loaded(assembly, changes=changes), progress=progress_bar), _print)


def _print(result: CheckResult) -> None:
    typer.echo(f"{result.mechanism.name}\n")
    for section in result.sections():
        print_table(section.heading, section.head, section.rows)
        print_more(len(section.rows) + section.left_out, len(section.rows))
    for one in result.warnings:
        typer.echo(": ".join(filter(None, ("warning", one["where"], one["text"]))))
