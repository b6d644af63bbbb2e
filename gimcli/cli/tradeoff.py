"""`gim tradeoff`: which method and tolerance serve a motion best."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, Jit, JitOption, Json, ModelPath, Out, Png
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.comparison.tradeoff import Entry
    from gimcli.library.tradeoff import TradeoffResult

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


def command(
    model: ModelPath = MODEL,
    steps: Annotated[int, typer.Option("--steps", "-n", min=1, max=100_000, help="Steps of the motion.")] = 72,
    tolerances: Annotated[
        str, typer.Option("--tolerances", help="Separated by commas; default every second decade, 1e-2 to 1e-14.")
    ] = "",
    out: Out = Path(),
    png: Png = True,
    seconds: Annotated[
        float,
        typer.Option("--seconds", min=1.0, help="Processor time it is meant to take; more runs slow methods too."),
    ] = 10.0,
    jit: JitOption = Jit.AUTO,
    as_json: Json = False,
) -> None:
    """Compare methods."""
    from gimcli.cli.console import files_in, finish, note, write_files
    from gimcli.cli.progress import progress_bar
    from gimcli.library.load import load
    from gimcli.library.tradeoff import tradeoff

    chosen = _tolerances(tolerances)
    mechanism = load(model)
    csv_path, png_path = files_in(out, f"{model.stem}.tradeoff", png, mechanism)
    found = tradeoff(
        mechanism, steps, tolerances=chosen, seconds=seconds, jit=jit.value, notify=note, progress=progress_bar
    )
    finish(found, write_files(found, csv_path, png_path), as_json, _print, paths_first=True)


def _tolerances(text: str) -> list[float]:
    """Return the tolerances that the user lists."""
    values: list[float] = []
    for word in text.replace(",", " ").split():
        try:
            values.append(float(word))
        except ValueError:
            raise UsageError(f"--tolerances: '{word}' is not a number from 1e-14 to below 1") from None
    return values


def _print(result: TradeoffResult) -> None:
    from gimcli.cli.console import print_status, print_table
    from gimcli.comparison.tradeoff import advise

    head = (
        "method", "unknowns", "tolerance", "iterations", "most", "paper's count", "operations", "time [µs]",
        "true error", "solved", "",
    )  # fmt: skip
    found, rows, last = result.found, [], ""
    for e in found.entries:
        name = e.method.label if e.method.name != last else ""
        rows.append(_row(e, name))
        last = e.method.name
    print_table(result.headline(), head, rows, range(2, 10))
    typer.echo("iterations: sweeps with gim; paper's count: operations, 12 a moving node and sweep, 9 E^3 an iteration")
    typer.echo("* efficient: no other that solves all positions is both faster and more accurate")
    if found.untold:
        typer.echo(f"{found.untold} positions are too near to a singular one for a true error and left out")
    if not found.reached:
        print_status(found.motion)
    for advice in advise(found):
        typer.echo(advice.text)


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
