"""`gim circuits`: the circuits, and the configurations that each connects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import METHOD, MODEL, NONE, Assembly, Json, ModelPath, Out, PngFile, Seconds, Set
from gimcli.cli.console import print_records
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options
from gimcli.cli.progress import progress_bar

if TYPE_CHECKING:
    from gimcli.library.circuits import CircuitsResult

HELP = (
    "All configurations are found at --samples values of the input, and each is followed through limits and change"
    " points until the circuit closes. A branch is the part of a circuit between two limits of the input."
)
EXAMPLES = ("gim circuits stephenson_2 -o circuits.png",)


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    assembly: Assembly = "",
    samples: Annotated[
        int,
        typer.Option(
            "--samples", metavar="N", min=4, max=100_000, rich_help_panel=METHOD,
            help="Input values at which all configurations are found.",
        ),
    ] = 72,
    seconds: Seconds = None,
    out: Out = NONE,
    png: PngFile = None,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:  # fmt: skip
    """Find the circuits and list them."""
    from gimcli.cli.outputs import Outputs, by_machine
    from gimcli.library.circuits import CircuitsResult, circuits

    outputs = Outputs(CircuitsResult, model, out, png=png, as_json=as_json, drawing=drawing)
    mechanism = outputs.loaded(assembly, changes=changes)
    found = circuits(mechanism, samples=samples, progress=progress_bar, seconds=seconds)
    outputs.finish(found, by_machine(_print))


def _print(result: CircuitsResult) -> None:
    from gimcli.library.circuits import verdict
    from gimcli.structure.rigid_triangles import triangle_hints

    print_records(result.headline(), result.curves)
    if result.initial is not None:
        typer.echo("*: the circuit of the initial configuration")
    typer.echo(verdict(result.found))
    for hint in triangle_hints(result.mechanism):
        typer.echo(hint)
