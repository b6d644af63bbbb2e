"""`gim reduce`: what a mechanism is from its input's point of view."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, Jit, JitOption, Json, ModelPath, Out, Png

if TYPE_CHECKING:
    from gimcli.dynamics.flywheel import Flywheel
    from gimcli.library.reduce import ReduceResult
    from gimcli.table import Table

NAME = "reduce"
HELP = (
    "Reduce the mechanism to one input: inertia J, torque tau of weight, loads and springs, potential V, and their"
    " exact derivatives over the input's law. Writes MODEL.reduced.csv (q in the file's unit, SI units and rad beside"
    " it) and MODEL.reduced.png. Other inputs stand where their laws begin.\n\n"
    "With --fluctuation and --rpm: the flywheel on the input's shaft that keeps the speed of a cycle within"
    " mean x (1 +- fluctuation / 2) at a constant driving torque.\n\n"
    "Example: gim reduce models/watt_durango.yaml --steps 360 --fluctuation 0.05 --rpm 300"
)


def command(
    model: ModelPath = MODEL,
    steps: Annotated[int, typer.Option("--steps", "-n", min=1, max=1_000_000, help="Steps of the input.")] = 360,
    name: Annotated[str, typer.Option("--input", help="Actuator; default: the first.")] = "",
    fluctuation: Annotated[
        float | None, typer.Option("--fluctuation", help="Coefficient of speed fluctuation for a flywheel.")
    ] = None,
    rpm: Annotated[float | None, typer.Option("--rpm", help="Mean speed for a flywheel [1/min].")] = None,
    out: Out = Path(),
    png: Png = True,
    jit: JitOption = Jit.AUTO,
    as_json: Json = False,
) -> None:
    """Reduce a mechanism to one input."""
    from gimcli.cli.console import files_in, finish, note, note_point_masses, write_files
    from gimcli.cli.progress import progress_bar
    from gimcli.library.load import load
    from gimcli.library.reduce import reduce

    mechanism = load(model)
    csv_path, png_path = files_in(out, f"{model.stem}.reduced", png, mechanism)
    note_point_masses(mechanism)
    found = reduce(
        mechanism, name, steps, fluctuation=fluctuation, rpm=rpm, jit=jit.value, notify=note, progress=progress_bar
    )
    finish(found, write_files(found, csv_path, png_path), as_json, _print, paths_first=True)


def _print(found: ReduceResult) -> None:
    _print_extremes(found.table())
    typer.echo(found.headline())
    if found.wheel:
        _tell_wheel(found.wheel)
    if not found.complete:
        typer.echo(f"{found.overall.word}: {found.overall.plain_text}")


def _print_extremes(table: Table) -> None:
    import numpy as np

    from gimcli.cli.console import number, print_table

    q, rows = table.floats("q"), []
    for column in table.columns[1:-1]:
        values = table.floats(column.name)
        if np.any(np.isfinite(values)):
            low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
            ends = [number(v, 8) for v in (values[low], q[low], values[high], q[high])]
            rows.append((column.name, column.unit, *ends))
    print_table("", ("", "unit", "least", "at q", "greatest", "at q"), rows, (2, 3, 4, 5))


def _tell_wheel(wheel: Flywheel) -> None:
    import math

    rpm = wheel.speed * 30.0 / math.pi
    without = (
        f"without one the fluctuation is {wheel.without:.4g}"
        if math.isfinite(wheel.without)
        else "without one the machine would stop"
    )
    what = f"flywheel of {wheel.inertia:.8g} kg m2" if wheel.inertia else "no flywheel"
    typer.echo(
        f"{what} for a fluctuation of {wheel.fluctuation:g} at {rpm:.6g} 1/min ({without}); driving torque"
        f" {wheel.torque:.8g} N m, work to even out {wheel.work:.8g} J"
    )
