"""`gim sequence`: the order in which restrictions are imposed, with reasons."""

from __future__ import annotations

from typing import Annotated

import typer

from gimcli.cli.arguments import OUTPUT
from gimcli.cli.console import print_remarks, print_table
from gimcli.cli.from_verb import from_verb
from gimcli.gim.report import SequenceGroupReport
from gimcli.library.sequence import SequenceResult, sequence

HELP = (
    "Groups in order of solution; for each step of the Geometrical-Iterative Method the node that is moved, about"
    " which nodes, by which constraint and rule; and the spectral radius: the error's factor per sweep."
)
EXAMPLES = ("gim sequence double_butterfly --explain",)


def _print(found: SequenceResult, explain: bool) -> None:
    typer.echo(found.headline())
    names = ("step", "node", "about", "constraint", "rule", *(["states"] if explain else []))
    for number, group in enumerate(found._found, start=1):
        print_table(f"{number}. {group.kind} {' '.join(group.nodes)}", *found._moves(group).cells(*names))
        _print_sweeps(group)
        print_remarks(*(f"   {k}. {one.reason}" for k, one in enumerate(group.steps, 1) if explain), "")


def _print_sweeps(group: SequenceGroupReport) -> None:
    predicted = "no convergence" if group.predicted_sweeps is None else f"{group.predicted_sweeps:.0f}"
    observed = "no convergence" if group.observed_sweeps is None else str(group.observed_sweeps)
    typer.echo(
        f"   spectral radius {group.radius:.4f}, {group.candidates} candidate{'s' * (group.candidates != 1)};"
        f" sweeps: predicted {predicted}, observed {observed}" + f"\n   {group.incomplete}" * bool(group.incomplete)
    )


EXPLAIN = Annotated[
    bool, typer.Option("--explain", help="Name the rule that placed each step.", rich_help_panel=OUTPUT)
]
command = from_verb(sequence, SequenceResult, _print, extra={"explain": EXPLAIN})
