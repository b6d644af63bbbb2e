"""`gim trace`: follow the motion, write coupler curves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import (
    MODEL,
    Jit,
    JitOption,
    Json,
    Method,
    MethodOption,
    ModelPath,
    SequenceText,
    Strategy,
    StrategyOption,
    Tolerance,
    options,
)
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.analysis.summary import Summary
    from gimcli.motion.motion import Motion

NAME = "trace"
HELP = (
    "Follow the motion along the actuators' laws; write the traced points as CSV and PNG.\n\n"
    "N steps are N+1 rows. A step that cannot be solved keeps its row and its reason. With --derivatives the CSV"
    " also has velocities (vx, vy), accelerations (ax, ay) and jerks (jx, jy) of the traced points and omega, alpha and"
    " jerk of every member, by the real time of `duration`.\n\n"
    "Example: gim trace models/crank_rocker.yaml --steps 360 --out results"
)

POSES = 6
EVENTS = 6


def command(
    model: ModelPath = MODEL,
    steps: Annotated[int, typer.Option("--steps", "-n", min=1, max=10_000_000, help="Steps of the motion.")] = 360,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder to write into.")] = Path(),
    png: Annotated[bool, typer.Option("--png/--no-png", help="Draw the picture.")] = True,
    derivatives: Annotated[
        int,
        typer.Option("--derivatives", "-d", min=0, max=3, help="1 velocities, 2 accelerations, 3 jerks, by real time."),
    ] = 0,
    method: MethodOption = Method.AUTO,
    strategy: StrategyOption = Strategy.SPECTRAL,
    tolerance: Tolerance = 1e-10,
    jit: JitOption = Jit.AUTO,
    sequence: SequenceText = "",
    as_json: Json = False,
) -> None:
    """Trace a motion."""
    import numpy as np

    from gimcli.analysis.summary import Summary
    from gimcli.analysis.tracing import motion_table
    from gimcli.analysis.verdict import explained, verify
    from gimcli.cli.console import note, progress_bar
    from gimcli.errors import StructureError
    from gimcli.model import load
    from gimcli.motion.motion import stream
    from gimcli.output import CsvStream, refuse_unwritable

    chosen = options(method, strategy, tolerance, jit, sequence)
    mechanism = load(model)
    csv_path, png_path = out / f"{model.stem}.csv", out / f"{model.stem}.png"
    if csv_path.resolve() == model.resolve():
        raise UsageError(f"{csv_path} is the model itself; choose another --out")
    with explained(mechanism):
        if not mechanism.actuators:
            _refuse_undriven(mechanism)
            raise StructureError(f"{mechanism.name} has no actuator: nothing moves; add one, or use `gim solve`")
        pieces = stream(mechanism, steps, chosen, tell=note, progress=progress_bar("tracing"))
        piece: Motion | None = next(pieces)
    assert piece is not None
    verify(mechanism, piece.start, piece.inputs[:, 0], piece.first_status, tolerance)
    refuse_unwritable(csv_path, *([png_path] if png else []))
    summary = Summary(steps + 1)
    rates = _rates(mechanism, derivatives, steps + 1, jit) if derivatives else None
    with CsvStream(
        csv_path, motion_table(piece.rows(np.arange(1)), rates=rates).names
    ) as table:  # appears when the picture has been written too
        while piece is not None:
            table.append(motion_table(piece, first=summary.seen, rates=rates))
            summary.add(piece)
            piece = next(pieces, None)
        drawn = png and summary.solved > 0
        if drawn:
            _draw(summary.motion, png_path)
    _report(summary, csv_path, png_path if drawn else None, steps, as_json)
    if summary.solved < summary.rows:
        raise typer.Exit(5)


def _rates(mechanism: Any, order: int, rows: int, jit: Jit) -> Any:
    from gimcli.analysis.derivatives import TracedRates
    from gimcli.cli.console import note

    return TracedRates(mechanism, mechanism.traced, order, rows, jit.value, note)


def _refuse_undriven(mechanism: Any) -> None:
    from gimcli.structure.plan import make_plan

    make_plan(mechanism)


def _draw(motion: Motion, path: Path) -> None:
    import numpy as np

    from gimcli.analysis.tracing import traced_paths
    from gimcli.output import draw_motion

    good = np.flatnonzero(motion.good)
    chosen = good[np.unique(np.linspace(0, len(good), POSES, endpoint=False).astype(int))]
    poses = motion.mechanism.to_file(motion.z[:, chosen].T)
    draw_motion(motion.mechanism, poses, traced_paths(motion), path, motion.mechanism.name)


def _report(summary: Summary, csv_path: Path, png_path: Path | None, steps: int, as_json: bool) -> None:
    from gimcli.analysis.tracing import events, reachable
    from gimcli.cli.console import print_json
    from gimcli.status import Status

    motion, solved, worst = summary.motion, summary.solved, summary.residual
    reached, found = reachable(motion), events(motion)
    if as_json:
        report = {
            "csv": str(csv_path), "png": str(png_path) if png_path else None, "steps": steps, "solved": solved,
            "residual": worst, "reachable": reached, "events": found, "status": motion.overall.word,
        }  # fmt: skip
        print_json(report)
        return
    where = f"{csv_path} and {png_path}" if png_path else str(csv_path)
    quality = f", worst residual {worst:.1e}" if solved else ""
    typer.echo(f"{motion.mechanism.name}: {solved} of {steps + 1} positions solved{quality}")
    _tell_reach(motion, reached)
    _tell_events([e for e in found if e["kind"] == "change point"], "passed straight through a change point")
    _tell_events([e for e in found if e["kind"] == "sequence exchanged"], "sequence exchanged for a faster one")
    if solved < steps + 1:
        first = Status(int(motion.codes[~motion.good][0]))
        typer.echo(f"{first.word}: {first.text}" + (f" (worst: {motion.worst})" if motion.worst else ""))
    typer.echo(f"wrote {where}")


def _tell_events(found: list[dict[str, Any]], what: str) -> None:
    for event in found[:EVENTS]:
        at = ", ".join(f"{k} = {v:.8g}" for k, v in event["at"].items())
        typer.echo(f"{what} at {at}")
    if len(found) > EVENTS:
        typer.echo(f"... and {len(found) - EVENTS} more (--json names all)")


def _tell_reach(motion: Motion, reached: dict[str, list[list[float]]]) -> None:
    if motion.limit is None:
        return
    for k, actuator in enumerate(motion.mechanism.actuators):
        law = motion.mechanism.value_to_file(k, motion.inputs[k, [0, -1]])
        unit = motion.mechanism.angle_unit if actuator.drive.value == "rotary" else motion.mechanism.length_unit
        for start, end in reached[actuator.name]:
            typer.echo(
                f"{actuator.name} reaches {start:.10g} to {end:.10g} {unit} of its law {law[0]:.10g} to {law[1]:.10g}"
            )
