"""`gim forces`: efforts and reactions for a prescribed motion."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from gimcli.cli.arguments import INPUTS, OUTPUT, SHARED
from gimcli.cli.console import note_doubtful_loading, print_status
from gimcli.cli.force_tables import print_friction, print_holding, print_open, print_statistics
from gimcli.cli.from_verb import Run, from_verb
from gimcli.cli.measures import PLOTS_ONLY, print_ranges
from gimcli.library.forces import ForcesResult, forces

HELP = (
    "Driving torque [N m] or force [N] of every actuator, reaction in every pair, shaking force and moment, and the"
    " power of all forces; with --at the efforts that hold one position at rest. The model needs `masses`, `loads`,"
    " `springs`, `dampers` or `friction`. Writes MODEL.forces.csv and .png."
)
EXAMPLES = (
    "gim forces watt_1 --steps 360 -o results/",
    "gim forces engine --full -o results/",
    "gim forces lift_table --at cylinder=0.5",
    'gim forces watt_1 -o pins.png --plot "reactions,hodograph:A,hodograph:A@crank"',
)


def _run(run: Run) -> Any:
    """Find the forces of a motion, or those that hold one position at rest."""
    if "at" in run.given:
        from gimcli.library.holding_forces import HoldingResult, holding_forces

        run.instead(holding_forces, HoldingResult, print_holding, "a motion, --at for one position")
        run.files["writes"] = False
    else:
        run.drop("one position: add --at ACTUATOR=VALUE", "at", "time")
    return run.written()


def _print(result: ForcesResult, full: bool) -> None:
    found, balance = result._found, ""
    if found.determined:
        print_statistics(result, full)
        balance = f"; power-balance error at most {found.error:.1e} W (relative: {found.drift:.0e})"
    typer.echo(f"forces at {found.determined} of {result.steps + 1} positions{balance}")
    print_ranges(result.mechanism, result.measured)
    print_open(found.open)
    if found.friction is not None:
        print_friction(found.friction)
    if found.summary.solved < result.steps + 1:
        print_status(found.summary.motion)
    elif not result.complete:
        typer.echo(found.failure[1])


EXTRA = {
    "at": Annotated[list[str], SHARED["at"]],
    "time": Annotated[float | None, typer.Option(
        "--time", metavar="T", rich_help_panel=INPUTS,
        help="With --at: time of loads with a table over time [s]; default 0.",
    )],
    "full": Annotated[bool, typer.Option(
        "--full", rich_help_panel=OUTPUT,
        help="Print least and greatest values, work and mean bearing loads, too.\n"
        "The work is that of actuators and of every kind of force.",
    )],
}  # fmt: skip
command = from_verb(
    forces, ForcesResult, _print, {"plot": PLOTS_ONLY}, writes=True, loaded=(note_doubtful_loading,),
    extra=EXTRA, run=_run,
)  # fmt: skip
