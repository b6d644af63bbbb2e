"""`gim forces`: efforts and reactions for a prescribed motion."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import (
    INPUTS,
    MODEL,
    NONE,
    OUTPUT,
    Assembly,
    At,
    Jit,
    JitOption,
    Json,
    ModelPath,
    Out,
    Png,
    Set,
    Steps,
    Tolerance,
    pairs,
)
from gimcli.cli.console import note, note_doubtful_loading, print_status
from gimcli.cli.measures import MeasuresOnly, PlotsOnly, measures_of, print_ranges, refuse_unseen
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options
from gimcli.cli.progress import progress_bar
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.dynamics.force_motion import ForceMotion
    from gimcli.library.forces import ForcesResult

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


STEPS = 360


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    at: At = NONE,
    time: Annotated[
        float | None,
        typer.Option(
            "--time",
            metavar="T",
            help="With --at: time of loads with a table over time [s]; default 0.",
            rich_help_panel=INPUTS,
        ),
    ] = None,
    steps: Steps = STEPS,
    assembly: Assembly = "",
    tolerance: Tolerance = 1e-10,
    jit: JitOption = Jit.AUTO,
    measure: MeasuresOnly = NONE,
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
    measures = measures_of(measure)
    if at:
        _refuse_motion(steps, plot, full, measures)
        _hold(model, changes, at, time or 0.0, assembly, tolerance, jit, out, as_json, drawing)
        return
    if time is not None:
        raise UsageError("--time is the time of the loads in one position: add --at ACTUATOR=VALUE")
    from gimcli.cli.outputs import Outputs
    from gimcli.library.forces import ForcesResult, forces_along

    outputs = Outputs(ForcesResult, model, out, writes=True, picture=png, as_json=as_json, drawing=drawing)
    refuse_unseen(plot, outputs.draws)
    mechanism = outputs.loaded(assembly, tolerance=tolerance, changes=changes)
    note_doubtful_loading(mechanism)
    found = outputs.stream(forces_along(mechanism, steps, tolerance, jit.value, measures, plot, note, progress_bar))
    outputs.show(found, partial(_print, full))


def _refuse_motion(steps: int, plot: list[str], full: bool, measure: list[str]) -> None:
    """Refuse options of a motion together with one position."""
    given = {"--steps": steps != STEPS, "--plot": bool(plot), "--measure": bool(measure), "--full": full}
    for option in (name for name, is_given in given.items() if is_given):
        raise UsageError(f"{option} is for a motion, --at for one position: remove one of them")


def _hold(
    model: str, changes: list[str], at: list[str], time: float, assembly: str, tolerance: float, jit: Jit,
    out: list[str], as_json: bool, drawing: Drawing,
) -> None:  # fmt: skip
    """Find the forces of one position at rest."""
    from gimcli.cli.holding import print_holding
    from gimcli.cli.outputs import Outputs
    from gimcli.library.holding_forces import HoldingResult, holding_forces

    outputs, inputs = Outputs(HoldingResult, model, out, as_json=as_json, drawing=drawing), pairs(at)
    mechanism = outputs.loaded(assembly, inputs, tolerance, changes=changes)
    found = holding_forces(mechanism, inputs, time=time, tolerance=tolerance, jit=jit.value)
    outputs.finish(found, print_holding)


def _print(full: bool, result: ForcesResult) -> None:
    found, check = result._found, result._found.balance
    balance = ""
    if found.determined:
        from gimcli.cli.force_tables import print_full, print_statistics

        (print_full if full else print_statistics)(result)
        balance = f"; power-balance error at most {check.error:.1e} W (relative: {check.drift:.0e})"
    typer.echo(f"forces at {found.determined} of {result.steps + 1} positions{balance}")
    print_ranges(result.mechanism, result.measured)
    if found.open:
        from gimcli.cli.force_tables import print_open

        print_open(found.open)
    if found.friction is not None:
        from gimcli.cli.friction import print_friction

        print_friction(found.friction)
    _print_missing(found, result.steps)


def _print_missing(found: ForceMotion, steps: int) -> None:
    if found.summary.solved < steps + 1:
        print_status(found.summary.motion)
    elif found.determined < steps + 1:
        typer.echo(found.failure[1])
