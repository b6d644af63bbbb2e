"""`gim forces`: which efforts and reactions the prescribed motion asks for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, Jit, JitOption, Json, Method, ModelPath, Strategy, options

if TYPE_CHECKING:
    from gimcli.dynamics.force_motion import ForceMotion
    from gimcli.motion.motion import Motion

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
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder to write into.")] = Path(),
    png: Annotated[bool, typer.Option("--png/--no-png", help="Draw the picture.")] = True,
    tolerance: Annotated[
        float, typer.Option("--tolerance", help="Of the positions, relative to the mechanism's size.")
    ] = 1e-10,
    jit: JitOption = Jit.AUTO,
    as_json: Json = False,
) -> None:
    """Find efforts and reactions."""
    import numpy as np

    from gimcli.cli.console import note, note_point_masses
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.dynamics.force_motion import ForceMotion
    from gimcli.dynamics.force_table import force_table
    from gimcli.dynamics.forces import motion_forces
    from gimcli.dynamics.load_arrays import point_masses
    from gimcli.dynamics.physical import require_action
    from gimcli.errors import StructureError
    from gimcli.model import load
    from gimcli.motion.motion import stream
    from gimcli.output import CsvStream, refuse_unwritable
    from gimcli.structure.drive_check import explained, refuse_contradiction

    chosen = options(Method.AUTO, Strategy.SPECTRAL, tolerance, jit)
    mechanism = load(model)
    require_action(mechanism)
    note_point_masses(point_masses(mechanism))
    csv_path, png_path = out / f"{model.stem}.forces.csv", out / f"{model.stem}.forces.png"
    with explained(mechanism):
        if not mechanism.actuators:
            raise StructureError(f"{mechanism.name} has no actuator: nothing moves; add one")
        pieces = stream(mechanism, steps, chosen, tell=note, progress=progress_bar("forces along the motion"))
        piece: Motion | None = next(pieces)
    assert piece is not None
    refuse_contradiction(mechanism, piece.start, piece.inputs[:, 0], piece.first_status, tolerance)
    refuse_unwritable(mechanism.files, csv_path, *([png_path] if png else []))
    found = ForceMotion(mechanism, steps + 1, jit.value, note)
    start = piece.rows(np.arange(1))
    with CsvStream(
        csv_path, force_table(start, motion_forces(start)).names
    ) as table:  # appears when the picture has been written too
        while piece is not None:
            first = found.summary.seen
            table.append(force_table(piece, found.take(piece), first))
            piece = next(pieces, None)
        drawn = png and found.told > 0
        if drawn:
            progress_bar(DRAWING)
            _draw(found, png_path)
    _report(found, {"csv": str(csv_path), "png": str(png_path) if drawn else None}, steps, as_json)
    if found.told < steps + 1:
        raise typer.Exit(5)


def _draw(found: ForceMotion, path: Path) -> None:
    from gimcli.measures.graphs import input_or_time
    from gimcli.mechanism import Drive
    from gimcli.output import draw_forces
    from gimcli.table import Column, Table

    mechanism = found.statics.mechanism
    time, inputs, efforts, shaking = found.kept
    over = input_or_time(mechanism, time, inputs)
    panels: dict[str, list[Column]] = {}
    for k, actuator in enumerate(mechanism.actuators):
        name, unit = ("driving torque", "N m") if actuator.drive is Drive.ROTARY else ("driving force", "N")
        panels.setdefault(name, [over]).append(Column(actuator.name, efforts[k], unit))
    tables = {name: Table(tuple(columns)) for name, columns in panels.items()}
    draw_forces(tables, shaking, path, f"{mechanism.name}: forces")


def _report(found: ForceMotion, paths: dict[str, str | None], steps: int, as_json: bool) -> None:
    from gimcli.cli.console import print_json
    from gimcli.rates.motion_table import events, reachable

    motion, summary, peaks = found.summary.motion, found.summary, found.peaks
    status = motion.overall.word if summary.solved < steps + 1 or found.told == steps + 1 else "singular"
    if as_json:
        print_json(
            {
                **paths, "steps": steps, "solved": found.told, "residual": summary.residual,
                "reachable": reachable(motion), "events": events(motion), "status": status,
                "energy_drift": peaks.drift, "power_error": peaks.power_error, "peaks": peaks.report(),
                "left_out": peaks.left_out, "open": found.open,
            }
        )  # fmt: skip
        return
    _print_peaks(found)
    typer.echo(
        f"forces at {found.told} of {steps + 1} positions; power of all forces less the change of the kinetic energy:"
        f" {peaks.power_error:.1e} W at most, {peaks.drift:.0e} of the greatest power"
    )
    if found.open:
        tell_open(found.open)
    _tell_missing(found, steps)
    typer.echo("wrote " + " and ".join(path for path in paths.values() if path))


def tell_open(names: list[str]) -> None:
    """Print which reactions are not unique."""
    typer.echo(
        f"redundant constraints leave open the reactions at {', '.join(names)}; NODE.unique is the component of a pin's"
        " reaction that is unique all the same"
    )


def _print_peaks(found: ForceMotion) -> None:
    from gimcli.cli.console import number, print_table

    mechanism = found.statics.mechanism
    rows = []
    for name, (value, unit, at) in found.peaks.greatest.items():
        where = ", ".join(number(v, 8) for v in at)
        rows.append((name, number(value, 8), unit, where))
    inputs = ", ".join(a.name for a in mechanism.actuators)
    shown = rows if len(rows) <= SHOWN else rows[:SHOWN]
    print_table(f"{mechanism.name}: peak values", ("", "peak", "", f"at {inputs}"), shown, (1, 3))
    if len(rows) > len(shown):
        typer.echo(f"... and {len(rows) - len(shown)} more (--json names all)")
    if found.peaks.left_out:
        typer.echo(
            f"{found.peaks.left_out} rows beside singular positions, where forces grow without bound, are in the table,"
            " not among the peak values and not drawn"
        )


def _tell_missing(found: ForceMotion, steps: int) -> None:
    from gimcli.status import Status

    motion = found.summary.motion
    if found.summary.solved < steps + 1:
        first = Status(int(motion.codes[~motion.good][0]))
        typer.echo(f"{first.word}: {first.text}" + (f" (worst: {motion.worst})" if motion.worst else ""))
    elif found.told < steps + 1:
        typer.echo(
            "singular: where the mechanism passes a singular position or a dead point of its drive, velocities or"
            " reactions are not unique or without bound: shift the law or the number of steps"
        )
