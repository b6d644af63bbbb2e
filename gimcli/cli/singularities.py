"""`gim singularities`: limits, dead points, change points and stationary positions of a circuit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from gimcli.cli.arguments import MODEL, NONE, Assembly, Json, ModelPath, Out, PngFile, Set
from gimcli.cli.console import print_records
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options
from gimcli.cli.progress import progress_bar
from gimcli.library.rounding import how_it_ends, intervals

if TYPE_CHECKING:
    from gimcli.library.singularities import SingularitiesResult

HELP = (
    "The circuit of the initial configuration is followed, and every branch that crosses it. limit: the input turns"
    " back. dead point: the input rate is zero while the mechanism moves. change point: branches cross. tangency: the"
    " constraints lose rank, but only one branch continues. stationary: a rocker or slider turns back."
)
EXAMPLES = ("gim singularities parallelogram -o positions.png",)


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    assembly: Assembly = "",
    out: Out = NONE,
    png: PngFile = None,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:
    """Follow the circuits and list the singular positions."""
    from gimcli.cli.outputs import Outputs, by_machine
    from gimcli.library.singularities import SingularitiesResult, singularities

    outputs = Outputs(SingularitiesResult, model, out, png=png, as_json=as_json, drawing=drawing)
    found = singularities(outputs.loaded(assembly, changes=changes), progress=progress_bar)
    outputs.finish(found, by_machine(_print))


def _print(result: SingularitiesResult) -> None:
    from gimcli.branching.singularities import STATIONARY

    found, mechanism = result.found, result.mechanism
    print_records(mechanism.name, result.records, "number", "kind", "at", "branches", "about", "rates")
    if all(one.what.kind == STATIONARY for one in found.found):
        typer.echo("no limit, dead point, change point or tangency")
    for k, (circuit, reach) in enumerate(zip(found.branches.circuits, found.reach, strict=True)):
        how = how_it_ends(circuit.closed, circuit.ended, circuit.turns)
        typer.echo(f"branch {k + 1}: {how}; range of {intervals(mechanism, result.interval(reach), circuit.turns)}")
    if not found.complete:
        typer.echo("there are more branches than were followed")
