"""`gim forces`: efforts and reactions for a prescribed motion."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import (
    MODEL,
    NONE,
    OUTPUT,
    Assembly,
    Jit,
    JitOption,
    Json,
    ModelPath,
    Out,
    Png,
    Set,
    Steps,
    Tolerance,
)
from gimcli.cli.measures import PlotsOnly, refuse_unseen
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options

if TYPE_CHECKING:
    from gimcli.dynamics.force_motion import ForceMotion
    from gimcli.library.forces import ForcesResult

HELP = (
    "Driving torque [N m] or force [N] of every actuator, reaction in every pair, shaking force and moment, and the"
    " power of all forces. The model needs `masses`, `loads`, `springs`, `dampers` or `friction`. Writes"
    " MODEL.forces.csv and .png."
)
EXAMPLES = (
    "gim forces watt_1 --steps 360 -o results/",
    "gim forces engine --full -o results/",
    'gim forces watt_1 -o pins.png --plot "reactions,hodograph:A"',
)


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    steps: Steps = 360,
    assembly: Assembly = "",
    tolerance: Tolerance = 1e-10,
    jit: JitOption = Jit.AUTO,
    plot: PlotsOnly = NONE,
    full: Annotated[
        bool,
        typer.Option(
            "--full", help="Print least and greatest values, work and mean bearing loads, too.", rich_help_panel=OUTPUT
        ),
    ] = False,
    out: Out = NONE,
    png: Png = True,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:
    """Find efforts and reactions."""
    from gimcli.cli.console import note, note_doubtful_loading
    from gimcli.cli.outputs import Outputs
    from gimcli.cli.progress import progress_bar
    from gimcli.library.forces import ForcesAlong, ForcesResult

    outputs = Outputs(ForcesResult, model, out, writes=True, picture=png, as_json=as_json, drawing=drawing)
    refuse_unseen(plot, outputs.draws)
    mechanism = outputs.loaded(assembly, tolerance=tolerance, changes=changes)
    note_doubtful_loading(mechanism)
    found = outputs.stream(ForcesAlong(mechanism, steps, tolerance, jit.value, plot, note, progress_bar))
    outputs.finish(found, partial(_print, full))


def _print(full: bool, result: ForcesResult) -> None:
    found, check = result.found, result.found.balance
    balance = ""
    if found.determined:
        from gimcli.cli.force_tables import print_full, print_statistics

        (print_full if full else print_statistics)(result)
        balance = f"; power-balance error at most {check.error:.1e} W (relative: {check.drift:.0e})"
    typer.echo(f"forces at {found.determined} of {result.steps + 1} positions{balance}")
    if found.open:
        print_open(found.open)
    if found.friction is not None:
        from gimcli.cli.friction import print_friction

        print_friction(found.friction)
    _print_missing(found, result.steps)


def print_open(names: list[str]) -> None:
    """Print which reactions are not unique."""
    typer.echo(
        f"redundant constraints: the reactions at {', '.join(names)} are not determined; NODE.unique is the component"
        " of a pin's reaction that is still determined"
    )


def _print_missing(found: ForceMotion, steps: int) -> None:
    from gimcli.cli.console import print_status

    if found.summary.solved < steps + 1:
        print_status(found.summary.motion)
    elif found.determined < steps + 1:
        typer.echo(found.failure[1])
