"""`gim tradeoff`: speed and accuracy of every method for a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import METHOD, MODEL, NONE, Assembly, Jit, JitOption, Json, ModelPath, Out, Png, Set, Steps
from gimcli.cli.console import note, print_records, print_status
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options
from gimcli.cli.progress import progress_bar
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.library.tradeoff import TradeoffResult

HELP = (
    "Every method solves the motion of the model at each tolerance: iterations, operations, time, and the true error"
    " against positions refined to 40 digits; then a recommendation for 3, 6, 9 and 12 digits. Writes"
    " MODEL.tradeoff.csv and .png."
)
EXAMPLES = ("gim tradeoff platform_3rrr --tolerances 1e-3,1e-6,1e-9 -o results/",)
SEEN = (
    "method", "unknowns", "tolerance", "iterations", "operations", "fixed", "seconds", "spread", "error", "solved",
    "reason",
)  # fmt: skip
"""Fields of the table of methods."""


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    assembly: Assembly = "",
    steps: Steps = 90,
    tolerances: Annotated[
        str,
        typer.Option(
            "--tolerances", metavar="T,T,...", help="Default: 1e-2, 1e-4 ... 1e-14.", rich_help_panel=METHOD
        ),
    ] = "",
    seconds: Annotated[
        float,
        typer.Option(
            "--seconds", metavar="S", min=1.0, help="Processor time for all; slow methods get fewer runs.",
            rich_help_panel=METHOD,
        ),
    ] = 10.0,
    jit: JitOption = Jit.AUTO,
    out: Out = NONE,
    png: Png = True,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:  # fmt: skip
    """Compare methods."""
    from gimcli.cli.outputs import Outputs, by_machine
    from gimcli.library.tradeoff import TradeoffResult, tradeoff

    chosen = _tolerances(tolerances)
    outputs = Outputs(TradeoffResult, model, out, writes=True, picture=png, as_json=as_json, drawing=drawing)
    found = tradeoff(
        outputs.loaded(assembly, changes=changes),
        steps,
        tolerances=chosen,
        seconds=seconds,
        jit=jit.value,
        notify=note,
        progress=progress_bar,
    )
    outputs.finish(found, by_machine(_print))


def _tolerances(text: str) -> list[float]:
    """Return the tolerances of --tolerances."""
    values: list[float] = []
    for word in text.replace(",", " ").split():
        try:
            values.append(float(word))
        except ValueError:
            raise UsageError(f"tolerances: expected numbers from 1e-14 to below 1, got '{word}'") from None
    return values


def _print(result: TradeoffResult) -> None:
    from gimcli.comparison.tradeoff import advise

    found = result.found
    print_records(result.headline(), result.records, *SEEN)
    if found.entries:
        typer.echo(
            "iterations: of all systems, sweeps for gim; call: its fixed part, to which each position adds its time"
        )
        typer.echo("*: efficient: no other entry that solves all positions is both faster and more accurate")
    if found.unrefined:
        typer.echo(
            f"{found.unrefined} positions are not compared: they are too near to a singular position to determine a"
            " true error"
        )
    if not found.reached:
        print_status(found.motion)
    for advice in advise(found):
        typer.echo(advice.text)
