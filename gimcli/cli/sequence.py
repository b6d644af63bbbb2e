"""`gim sequence`: the order in which restrictions are imposed, with reasons."""

from __future__ import annotations

from typing import Annotated

import typer

from gimcli.cli.arguments import OUTPUT
from gimcli.cli.console import print_table
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
    for number, group in enumerate(found.groups, start=1):
        _print_group(number, group, explain)


def _print_group(number: int, group: SequenceGroupReport, explain: bool) -> None:
    predicted = "no convergence" if group.predicted_sweeps is None else f"{group.predicted_sweeps:.0f}"
    observed = "no convergence" if group.observed_sweeps is None else str(group.observed_sweeps)
    head = ["step", "move", "about", "by", "rule"] + (["states after it"] if explain else [])
    rows = [
        (str(k), s.node, " ".join(s.about), s.constraint, s.rule, " ".join(f"{n}:{t}" for n, t in s.states.items()))
        for k, s in enumerate(group.steps, start=1)
    ]
    print_table(f"{number}. {group.kind} {' '.join(group.nodes)}", head, (row[: len(head)] for row in rows))
    typer.echo(
        f"   spectral radius {group.radius:.4f}, {group.candidates} candidate{'s' * (group.candidates != 1)};"
        f" sweeps: predicted {predicted}, observed {observed}" + f"\n   {group.incomplete}" * bool(group.incomplete)
    )
    if explain:
        for k, s in enumerate(group.steps, start=1):
            typer.echo(f"   {k}. {s.reason}")
    typer.echo("")


EXPLAIN = Annotated[
    bool, typer.Option("--explain", help="Name the rule that placed each step.", rich_help_panel=OUTPUT)
]
command = from_verb(sequence, SequenceResult, _print, extra={"explain": EXPLAIN})
