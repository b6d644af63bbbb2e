"""`gim tradeoff`: which method and tolerance serve a motion best."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import MODEL, Jit, JitOption, Json, ModelPath
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.comparison.tradeoff import Entry, Tradeoff

NAME = "tradeoff"
HELP = (
    "Compare every method at tolerances from 1e-2 to 1e-14 on the motion along the actuators' laws: sweeps or"
    " iterations, operations, time and true error; say which to use for 3, 6, 9 and 12 digits.\n\n"
    "Errors are those of the traced points against positions refined to 40 digits, relative to the mechanism's size. A"
    " position on another branch is not solved. Newton-Raphson in joint, absolute and natural coordinates, as"
    " multibody programs have it, is there for comparison only. Times are processor times, the least of some runs,"
    " without what a method prepares once. Writes MODEL.tradeoff.csv and MODEL.tradeoff.png.\n\n"
    "Example: gim tradeoff models/platform_3rrr.yaml --tolerances 1e-3,1e-6,1e-9 --out results"
)

FINEST, COARSEST = 1e-14, 1.0


def command(
    model: ModelPath = MODEL,
    steps: Annotated[int, typer.Option("--steps", "-n", min=1, max=100_000, help="Steps of the motion.")] = 72,
    tolerances: Annotated[
        str, typer.Option("--tolerances", help="Separated by commas; default every second decade, 1e-2 to 1e-14.")
    ] = "",
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder to write into.")] = Path(),
    png: Annotated[bool, typer.Option("--png/--no-png", help="Draw the picture.")] = True,
    seconds: Annotated[
        float,
        typer.Option("--seconds", min=1.0, help="Processor time it is meant to take; more runs slow methods too."),
    ] = 10.0,
    jit: JitOption = Jit.AUTO,
    as_json: Json = False,
) -> None:
    """Compare methods."""
    from gimcli.cli.console import note
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.comparison.tradeoff import TOLERANCES, tradeoff, tradeoff_table
    from gimcli.errors import StructureError
    from gimcli.model import load
    from gimcli.output import CsvStream, refuse_unwritable
    from gimcli.structure.drive_check import explained

    asked = _tolerances(tolerances) or TOLERANCES
    mechanism = load(model)
    csv_path, png_path = out / f"{model.stem}.tradeoff.csv", out / f"{model.stem}.tradeoff.png"
    with explained(mechanism):
        if not mechanism.actuators:
            raise StructureError(f"{mechanism.name} has no actuator: nothing moves; add one")
        refuse_unwritable(mechanism.files, csv_path, *([png_path] if png else []))
        found = tradeoff(mechanism, steps, asked, jit.value, note, progress_bar("comparing"), seconds=seconds)
    table = tradeoff_table(found)
    drawn = png and any(e.drawable for e in found.entries)
    with CsvStream(csv_path, table.names) as stream:  # appears when the picture has been written too
        stream.append(table)
        if drawn:
            progress_bar(DRAWING)
            _draw(found, png_path)
    paths = {"csv": str(csv_path), "png": str(png_path) if drawn else None}
    if as_json:
        _print_json(found, steps, paths)
    else:
        _print(found, steps, paths)
    if not found.reached:
        raise typer.Exit(5)


def _tolerances(text: str) -> tuple[float, ...]:
    """Return the tolerances that the user lists, each once."""
    values: list[float] = []
    for word in text.replace(",", " ").split():
        try:
            value = float(word)
        except ValueError:
            value = float("nan")
        if not FINEST <= value < COARSEST:
            raise UsageError(f"--tolerances: '{word}' is not a number from 1e-14 to below 1")
        values.append(value)
    return tuple(dict.fromkeys(values))


def _draw(found: Tradeoff, path: Path) -> None:
    import numpy as np

    from gimcli.output import draw_tradeoff

    curves: dict[str, list[tuple[float, float, float]]] = {}
    for e in found.entries:
        if e.drawable:
            curves.setdefault(e.method.label, []).append((e.seconds, e.error, float(e.complete)))
    front = np.array([(e.seconds, e.error) for e in found.entries if e.efficient]).reshape(-1, 2)
    title = f"{found.mechanism.name}: error and time, {'compiled' if found.compiled else 'not compiled'}"
    draw_tradeoff({name: np.array(points) for name, points in curves.items()}, front, path, title)


def _print_json(found: Tradeoff, steps: int, paths: dict[str, Any]) -> None:
    from gimcli.cli.console import print_json
    from gimcli.comparison.tradeoff import advise

    advice = [
        {
            "digits": a.digits, "text": a.text, "options": a.best.method.options if a.best else None,
            "tolerance": a.best.tolerance if a.best else None,
        }
        for a in advise(found)
    ]  # fmt: skip
    entries = [
        {
            "method": e.method.name, "tolerance": e.tolerance, "unknowns": list(e.unknowns),
            "iteration_operations": list(e.iterations), "iterations": e.work,
            "most_iterations": e.most, "paper_operations": e.paper, "operations": e.operations, "seconds": e.seconds,
            "error": e.error, "solved": e.solved, "positions": e.rows, "efficient": e.efficient, "reason": e.reason,
        }
        for e in found.entries
    ]  # fmt: skip
    print_json(
        {
            **paths, "steps": steps, "solved": found.motion.solved, "status": found.motion.overall.word,
            "compiled": found.compiled, "untold": found.untold, "entries": entries, "advice": advice,
        }
    )  # fmt: skip


def _print(found: Tradeoff, steps: int, paths: dict[str, Any]) -> None:
    from gimcli.cli.console import print_table
    from gimcli.comparison.tradeoff import advise

    head = (
        "method", "unknowns", "tolerance", "iterations", "most", "paper's count", "operations", "time [µs]",
        "true error", "solved", "",
    )  # fmt: skip
    rows, last = [], ""
    for e in found.entries:
        name = e.method.label if e.method.name != last else ""
        rows.append(_row(e, name))
        last = e.method.name
    how = "compiled kernels" if found.compiled else "kernels not compiled"
    print_table(f"{found.mechanism.name}: a position of {steps} steps, {how}", head, rows, range(2, 10))
    typer.echo("iterations: sweeps with gim; paper's count: operations, 12 a moving node and sweep, 9 E^3 an iteration")
    typer.echo("* efficient: no other that solves all positions is both faster and more accurate")
    if found.untold:
        typer.echo(f"{found.untold} positions are too near to a singular one for a true error and left out")
    if not found.reached:
        worst = f" (worst: {found.motion.worst})" if found.motion.worst else ""
        typer.echo(f"{found.motion.overall.word}: {found.motion.overall.text}{worst}")
    for advice in advise(found):
        typer.echo(advice.text)
    typer.echo("wrote " + " and ".join(path for path in paths.values() if path))


def _row(e: Entry, name: str) -> tuple[str, ...]:
    from gimcli.cli.console import number

    unknowns = " + ".join(map(str, e.unknowns))
    if not e.solved:
        return (name, unknowns, number(e.tolerance, 3), *["-"] * 6, f"{e.solved}/{e.rows}", e.reason)
    remark = e.reason + ("*" if e.efficient else "")
    return (
        name, unknowns, number(e.tolerance, 3), f"{e.work:.2f}", f"{e.most:.0f}", f"{e.paper:.0f}",
        f"{e.operations:.0f}", f"{1e6 * e.seconds:.1f}", f"{e.error:.1e}", f"{e.solved}/{e.rows}", remark,
    )  # fmt: skip
