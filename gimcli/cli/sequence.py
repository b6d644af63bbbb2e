"""`gim sequence`: in which order restrictions are imposed, and why."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, At, Json, ModelPath, Strategy, StrategyOption, Tolerance, pairs

if TYPE_CHECKING:
    from gimcli.gim.report import SequenceGroupReport
    from gimcli.library.sequence import SequenceResult

NAME = "sequence"
HELP = (
    "Show the sequence of the Geometrical-Iterative Method: groups in order of solution, which node is moved about"
    " what, and how fast a sweep converges.\n\n"
    "Example: gim sequence models/double_butterfly.yaml --explain"
)


def command(
    model: ModelPath = MODEL,
    explain: Annotated[bool, typer.Option("--explain", help="Say for every step which rule placed it.")] = False,
    strategy: StrategyOption = Strategy.SPECTRAL,
    at: At = [],  # noqa: B006 - typer wants a list; nothing changes it
    tolerance: Tolerance = 1e-10,
    png: Annotated[Path | None, typer.Option("--png", help="Draw the mechanism with the steps numbered.")] = None,
    as_json: Json = False,
) -> None:
    """Search and show the sequence."""
    from gimcli.cli.console import finish, loaded, write_picture
    from gimcli.library.sequence import sequence

    found = sequence(loaded(model, None, png), pairs(at), strategy=strategy.value, tolerance=tolerance)
    finish(found, write_picture(found, png), as_json, partial(_print, explain))


def _print(explain: bool, found: SequenceResult) -> None:
    typer.echo(found.headline())
    for number, group in enumerate(found.groups, start=1):
        _print_group(number, group, explain)


def _print_group(number: int, group: SequenceGroupReport, explain: bool) -> None:
    from gimcli.cli.console import print_table

    predicted = "never" if group.predicted_sweeps is None else f"{group.predicted_sweeps:.0f}"
    observed = "did not converge" if group.observed_sweeps is None else str(group.observed_sweeps)
    title = f"{number}. {group.kind} {' '.join(group.nodes)}"
    head = ["step", "move", "about", "by", "rule"] + (["states after it"] if explain else [])
    rows = []
    for k, s in enumerate(group.steps, start=1):
        row = [str(k), s.node, " ".join(s.about), s.constraint, s.rule]
        if explain:
            row.append(" ".join(f"{n}:{t}" for n, t in s.states.items()))
        rows.append(row)
    print_table(title, head, rows)
    typer.echo(
        f"   spectral radius {group.radius:.4f} (classic {group.classic_radius:.4f}), {group.candidates} candidates;"
        f" sweeps predicted {predicted}, observed {observed}"
    )
    if explain:
        for k, s in enumerate(group.steps, start=1):
            typer.echo(f"   {k}. {s.reason}")
    typer.echo("")
