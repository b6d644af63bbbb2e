"""`gim reduce`: what a mechanism is from its input's point of view."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import MODEL, Jit, JitOption, Json, ModelPath
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.dynamics.flywheel import Flywheel
    from gimcli.dynamics.reduction import Reduction

NAME = "reduce"
HELP = (
    "Reduce the mechanism to one input: inertia J, torque tau of weight, loads and springs, potential V, and their"
    " exact derivatives over the input's law. Writes MODEL.reduced.csv (q in the file's unit, SI units and rad beside"
    " it) and MODEL.reduced.png. Other inputs stand where their laws begin.\n\n"
    "With --fluctuation and --rpm: the flywheel on the input's shaft that keeps the speed of a cycle within"
    " mean x (1 +- fluctuation / 2) at a constant driving torque.\n\n"
    "Example: gim reduce models/watt_durango.yaml --steps 360 --fluctuation 0.05 --rpm 300"
)
WORK = 6e-4
"""Seconds that a row takes without compiling, about."""


def command(
    model: ModelPath = MODEL,
    steps: Annotated[int, typer.Option("--steps", "-n", min=1, max=1_000_000, help="Steps of the input.")] = 360,
    name: Annotated[str, typer.Option("--input", help="Actuator; default: the first.")] = "",
    fluctuation: Annotated[
        float | None, typer.Option("--fluctuation", help="Coefficient of speed fluctuation for a flywheel.")
    ] = None,
    rpm: Annotated[float | None, typer.Option("--rpm", help="Mean speed for a flywheel [1/min].")] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder to write into.")] = Path(),
    png: Annotated[bool, typer.Option("--png/--no-png", help="Draw the picture.")] = True,
    jit: JitOption = Jit.AUTO,
    as_json: Json = False,
) -> None:
    """Reduce a mechanism to one input."""
    import math

    from gimcli.cli.console import note, note_point_masses
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.dynamics.flywheel import flywheel
    from gimcli.dynamics.load_arrays import point_masses
    from gimcli.dynamics.reduction import chosen_input, reduce_to_input, reduction_table
    from gimcli.errors import StructureError
    from gimcli.model import load
    from gimcli.output import refuse_unwritable, write
    from gimcli.positions.dispatch import choose
    from gimcli.structure.drive_check import explained
    from gimcli.structure.mobility import refuse_unfit

    if (fluctuation is None) != (rpm is None):
        raise UsageError("a flywheel needs both --fluctuation and --rpm")
    mechanism = load(model)
    if not mechanism.actuators:
        raise StructureError(f"{mechanism.name} has no actuator: nothing moves; add one")
    actuator = chosen_input(mechanism, name)
    csv_path, png_path = out / f"{model.stem}.reduced.csv", out / f"{model.stem}.reduced.png"
    refuse_unwritable(mechanism.files, csv_path, *([png_path] if png else []))
    run = choose(jit.value, steps * WORK, note, ("move",))
    note_point_masses(point_masses(mechanism))
    with explained(mechanism):
        refuse_unfit(mechanism)
        found = reduce_to_input(mechanism, actuator, steps, run, progress_bar("reducing"))
    wheel = None
    if fluctuation is not None and rpm is not None:
        wheel = flywheel(found, rpm * math.pi / 30.0, fluctuation)
    write(reduction_table(found), csv_path)
    drawn = png and found.solved > 1
    if drawn:
        progress_bar(DRAWING)
        _draw(found, png_path)
    _report(found, wheel, {"csv": str(csv_path), "png": str(png_path) if drawn else None}, as_json)
    if found.solved < steps + 1:
        raise typer.Exit(5)


def _draw(found: Reduction, path: Path) -> None:
    from gimcli.dynamics.reduction import reduction_table
    from gimcli.output import draw_history_sheet
    from gimcli.output.history import Panel

    table, actuator = reduction_table(found), found.mechanism.actuators[found.actuator]
    q = table.floats("q")
    units = {column.name: column.unit for column in table.columns}
    labels = {"J": "reduced inertia J", "dJ_dq": "dJ/dq", "tau": "reduced torque", "V": "potential V"}
    panels = [Panel(f"{label} [{units[n]}]", [("", q, table.floats(n))]) for n, label in labels.items()]
    title = f"{found.mechanism.name}: reduced to {actuator.name}"
    draw_history_sheet(panels, f"{actuator.name} [{units['q']}]", path, title)


def _report(found: Reduction, wheel: Flywheel | None, paths: dict[str, str | None], as_json: bool) -> None:
    from gimcli.cli.console import print_json
    from gimcli.dynamics.reduction import reduction_table
    from gimcli.status import Status

    table, rows = reduction_table(found), len(found.q)
    status = Status(int(found.codes[found.codes != Status.OK][0])) if found.solved < rows else Status.OK
    if as_json:
        columns = {n: table.floats(n).tolist() for n in table.names if n != "status"}
        report: dict[str, Any] = {
            **paths, "input": found.mechanism.actuators[found.actuator].name, "steps": rows - 1,
            "solved": found.solved, "status": status.word, **columns,
        }  # fmt: skip
        print_json({**report, "flywheel": _wheel_report(wheel)} if wheel else report)
        return
    _print_extremes(found)
    typer.echo(f"{found.mechanism.name}: reduced at {found.solved} of {rows} positions")
    if wheel:
        _tell_wheel(wheel)
    if status is not Status.OK:
        typer.echo(f"{status.word}: {status.plain_text}")
    typer.echo("wrote " + " and ".join(path for path in paths.values() if path))


def _print_extremes(found: Reduction) -> None:
    import numpy as np

    from gimcli.cli.console import number, print_table
    from gimcli.dynamics.reduction import reduction_table

    table = reduction_table(found)
    q, rows = table.floats("q"), []
    for column in table.columns[1:-1]:
        values = table.floats(column.name)
        if np.any(np.isfinite(values)):
            low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
            ends = [number(v, 8) for v in (values[low], q[low], values[high], q[high])]
            rows.append((column.name, column.unit, *ends))
    print_table("", ("", "unit", "least", "at q", "greatest", "at q"), rows, (2, 3, 4, 5))


def _wheel_report(wheel: Flywheel) -> dict[str, float]:
    return {
        "inertia": wheel.inertia, "speed": wheel.speed, "fluctuation": wheel.fluctuation, "torque": wheel.torque,
        "work": wheel.work, "without": wheel.without,
    }  # fmt: skip


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
