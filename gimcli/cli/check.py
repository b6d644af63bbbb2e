"""`gim check`: what a mechanism is, what its motion does, and what in the file is doubtful."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from gimcli.cli.console import print_more, print_remarks, print_table
from gimcli.cli.from_verb import Run, from_verb
from gimcli.errors import refuse
from gimcli.library.check import CheckResult, check

HELP = (
    "Type, mobility, ranges of the inputs, strokes and time ratios, worst transmission angles and greatest speeds of"
    " the motion along the laws; warnings about the file. The exit status is 0 with warnings too."
)
EXAMPLES = (
    "gim check crank_rocker",
    "gim check whitworth -o check.html",
    "gim check crank_rocker --long > explicit.yaml",
)


def _run(run: Run) -> Any:
    """Check the model, or print it in long form."""
    if run.switches.pop("long"):
        text = "--long prints the model file, it cannot be used with"
        refuse((run.files["out"], f"{text} -o"), (run.files["as_json"], f"{text} --json"))
        from gimcli.model.long_text import long_form

        typer.echo(long_form(run.mechanism), nl=False)
        raise typer.Exit
    return run.written()


def _print(result: CheckResult) -> None:
    typer.echo(f"{result.mechanism.name}\n")
    for section in result._sections():
        print_table(section.heading, section.head, section.rows)
        print_more(len(section.rows) + section.left_out, len(section.rows))
    print_remarks(*result.remarks)


EXTRA = {
    "long": Annotated[
        bool, typer.Option("--long", help="Print the model file in long form, with everything explicit; no check.")
    ]
}
command = from_verb(check, CheckResult, _print, files="", extra=EXTRA, run=_run)
