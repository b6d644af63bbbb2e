"""`gim mobility`: freedoms, redundant constraints, undriven nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from gimcli.cli.arguments import MODEL, NONE, Assembly, Json, ModelPath, Out, Set
from gimcli.cli.console import print_table
from gimcli.status import Status

if TYPE_CHECKING:
    from gimcli.library.mobility import MobilityResult

HELP = (
    "Grübler's formula, the rank of the constraint Jacobian and the mobility that follows from it, at the assembled"
    " position nearest to the initial configuration."
)
EXAMPLES = ("gim mobility parallelogram_third_crank",)


def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    assembly: Assembly = "",
    out: Out = NONE,
    as_json: Json = False,
) -> None:
    """Analyse the mobility at the assembled position nearest to the initial coordinates."""
    from gimcli.cli.outputs import Outputs
    from gimcli.library.mobility import MobilityResult, mobility

    outputs = Outputs(MobilityResult, model, out, as_json=as_json)
    outputs.finish(mobility(outputs.loaded(assembly, changes=changes)), _print)


def _print(result: MobilityResult) -> None:
    found = result.found
    everywhere = result.start == Status.TANGENT.word
    print_table(result.mechanism.name, ("", ""), result.rows())
    if everywhere:
        typer.echo(f"The initial configuration is {Status.TANGENT.text}.")
    elif found.stuck and not found.undriven:
        typer.echo(
            f"The inputs do not determine the initial configuration: {result.start}. `gim singularities` lists such"
            " positions; use other initial coordinates."
        )
    if found.singular and not everywhere:
        typer.echo(
            f"The initial configuration is singular: {found.apparent} apparent freedoms there, {found.mobility} in"
            " nearby positions."
        )
