"""`gim forces`: which efforts and reactions the prescribed motion asks for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, Jit, JitOption, Json, ModelPath, Out, Png

if TYPE_CHECKING:
    from gimcli.dynamics.force_motion import ForceMotion
    from gimcli.library.forces import ForcesResult

NAME = "forces"
HELP = (
    "Inverse dynamics along the actuators' laws: driving torque [N m] or force [N] of every actuator, reaction in every"
    " pair, force and moment on the frame, power of all forces. Writes MODEL.forces.csv and MODEL.forces.png.\n\n"
    "The model needs `masses`, `loads`, `springs`, `dampers` or `friction`. NODE.fx and NODE.fy are the force that the"
    " second-named member at a node receives from the first (the frame is the first, then as in the file); where more"
    " parts meet, NODE.MEMBER.fx is what each member receives from the pin. PAIR.normal is the force on what slides, to"
    " the left of the guide, PAIR.moment its moment about the first sliding node; shaking.fx, .fy and .moment are what"
    " the frame receives, about the first ground node. Reactions that redundant constraints leave open stay empty and"
    " are named; NODE.unique.fx and .fy are the component of such a reaction that is unique all the same.\n\n"
    "Example: gim forces models/watt_1.yaml --steps 360 --out results"
)
SHOWN = 30


def command(
    model: ModelPath = MODEL,
    steps: Annotated[int, typer.Option("--steps", "-n", min=1, max=10_000_000, help="Steps of the motion.")] = 360,
    out: Out = Path(),
    png: Png = True,
    tolerance: Annotated[
        float, typer.Option("--tolerance", help="Of the positions, relative to the mechanism's size.")
    ] = 1e-10,
    jit: JitOption = Jit.AUTO,
    as_json: Json = False,
) -> None:
    """Find efforts and reactions."""
    from gimcli.cli.console import files_in, finish, note, note_point_masses, write_stream
    from gimcli.cli.progress import progress_bar
    from gimcli.library.forces import ForcesAlong
    from gimcli.library.load import load

    mechanism = load(model)
    note_point_masses(mechanism)
    csv_path, png_path = files_in(out, f"{model.stem}.forces", png, mechanism)
    along = ForcesAlong(mechanism, steps, tolerance, jit.value, note, progress_bar)
    found, paths = write_stream(along, csv_path, png_path)
    finish(found, paths, as_json, _print, paths_first=True)


def _print(result: ForcesResult) -> None:
    found, peaks = result.found, result.found.peaks
    _print_peaks(found)
    typer.echo(
        f"forces at {found.told} of {result.steps + 1} positions; power of all forces less the change of the kinetic"
        f" energy: {peaks.power_error:.1e} W at most, {peaks.drift:.0e} of the greatest power"
    )
    if found.open:
        print_open(found.open)
    _tell_missing(found, result.steps)


def print_open(names: list[str]) -> None:
    """Print which reactions are not unique."""
    typer.echo(
        f"redundant constraints leave open the reactions at {', '.join(names)}; NODE.unique is the component of a pin's"
        " reaction that is unique all the same"
    )


def _print_peaks(found: ForceMotion) -> None:
    from gimcli.cli.console import number, print_more, print_table

    mechanism = found.statics.mechanism
    rows = [
        (name, number(value, 8), unit, ", ".join(number(v, 8) for v in at))
        for name, (value, unit, at) in found.peaks.greatest.items()
    ]
    inputs = ", ".join(a.name for a in mechanism.actuators)
    print_table(f"{mechanism.name}: peak values", ("", "peak", "", f"at {inputs}"), rows[:SHOWN], (1, 3))
    print_more(len(rows), SHOWN)
    if found.peaks.left_out:
        typer.echo(
            f"{found.peaks.left_out} rows beside singular positions, where forces grow without bound, are in the table,"
            " not among the peak values and not drawn"
        )


def _tell_missing(found: ForceMotion, steps: int) -> None:
    from gimcli.cli.console import print_status

    if found.summary.solved < steps + 1:
        print_status(found.summary.motion)
    elif found.told < steps + 1:
        typer.echo(
            "singular: where the mechanism passes a singular position or a dead point of its drive, velocities or"
            " reactions are not unique or without bound: shift the law or the number of steps"
        )
