"""`gim trace`: follow the motion, write coupler curves."""

from __future__ import annotations

from enum import StrEnum
from functools import partial
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
from gimcli.cli.asked import MEASURE_HELP, MeasureOption, PlotOption, tell_measures
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.cli.asked import Asked
    from gimcli.motion.motion import Motion
    from gimcli.motion.summary import Summary


class AtLimit(StrEnum):
    """What is done at the limit of an input."""

    STOP = "stop"
    SKIP = "skip"
    REVERSE = "reverse"


NAME = "trace"
HELP = (
    "Follow the motion along the actuators' laws; write the traced points as CSV and PNG.\n\n"
    "N steps are N+1 rows. A step that cannot be solved keeps its row and its reason. With --derivatives the CSV"
    " also has velocities (vx, vy), accelerations (ax, ay) and jerks (jx, jy) of the traced points and omega, alpha and"
    " jerk of every member, by the real time of `duration`.\n\n"
    "At the limit of an input rows are empty from there on (--at-limit stop), or until the law comes back into reach"
    " (skip), or the input turns back and the motion goes on through its dead point (reverse: the CSV then has the"
    " input as it really is). --circuit leaves the law: N+1 rows at even distances along the whole circuit, through"
    " limits and dead points until the whole drawing is home; `time` is then the part of the way, times `duration`."
    " --all-branches follows every circuit that meets it too, its rows one after another with a last column `branch`;"
    " --branch K takes the K-th of them as `gim singularities` numbers them, or, without --circuit, turns off at the"
    " first change point of the law (1 goes straight on). Measures go with all of these;"
    " derivatives by the time need a law, and go with neither --circuit nor reverse.\n\n"
    f"{MEASURE_HELP}\n\n"
    "Example: gim trace models/crank_rocker.yaml --steps 360 --out results\n\n"
    "Example: gim trace models/crank_rocker.yaml -m transmission -m centre:frame/coupler --plot velocity,transmission"
    "\n\nExample: gim trace models/chebyshev.yaml --circuit"
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
    plot: PlotOption = "",
    measure: MeasureOption = [],  # noqa: B006 - typer wants a list; nothing changes it
    at_limit: Annotated[
        AtLimit, typer.Option("--at-limit", help="At the limit of an input: stop, skip what is out of reach, reverse.")
    ] = AtLimit.STOP,
    circuit: Annotated[bool, typer.Option("--circuit", help="Follow the whole circuit, not the law.")] = False,
    branch: Annotated[int, typer.Option("--branch", min=1, help="Branch taken where branches meet.")] = 1,
    all_branches: Annotated[
        bool, typer.Option("--all-branches", help="Follow every circuit that meets the drawn one.")
    ] = False,
    method: MethodOption = Method.AUTO,
    strategy: StrategyOption = Strategy.SPECTRAL,
    tolerance: Tolerance = 1e-10,
    jit: JitOption = Jit.AUTO,
    sequence: SequenceText = "",
    as_json: Json = False,
) -> None:
    """Trace a motion."""
    import numpy as np

    if "help" in measure:
        tell_measures()
    from gimcli.cli.asked import Asked
    from gimcli.cli.console import note
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.errors import StructureError
    from gimcli.model import load
    from gimcli.motion.motion import stream
    from gimcli.motion.motion import trace as follow
    from gimcli.motion.summary import Summary
    from gimcli.output import CsvStream, refuse_unwritable
    from gimcli.rates.motion_table import motion_table
    from gimcli.structure.drive_check import explained, refuse_contradiction

    chosen = options(method, strategy, tolerance, jit, sequence)
    if plot and not png:
        raise UsageError("--plot draws into the picture: leave --no-png out")
    mechanism = load(model)
    asked = Asked(mechanism, measure, plot, derivatives)
    csv_path, png_path = out / f"{model.stem}.csv", out / f"{model.stem}.png"
    refuse_unwritable(mechanism.files, csv_path, *([png_path] if png else []))
    with explained(mechanism):
        if not mechanism.actuators:
            _refuse_undriven(mechanism)
            raise StructureError(f"{mechanism.name} has no actuator: nothing moves; add one, or use `gim solve`")
        if circuit or all_branches:
            from gimcli.cli.circuit import trace_circuit

            _refuse_mixed(method, asked.order, at_limit, branch, all_branches)
            paths = csv_path, png_path if png else None
            ask = partial(Asked, mechanism, measure, plot, derivatives)
            if not trace_circuit(mechanism, steps, tolerance, branch, all_branches, paths, as_json, ask):
                raise typer.Exit(5)
            return
        show = progress_bar("tracing")
        if at_limit is not AtLimit.STOP or branch > 1:
            _refuse_mixed(method, asked.order if at_limit is AtLimit.REVERSE else 0)
            pieces = iter([follow(mechanism, steps, chosen, note, show, at_limit.value, branch)])
        else:
            pieces = stream(mechanism, steps, chosen, tell=note, progress=show)
        piece: Motion | None = next(pieces)
    assert piece is not None
    refuse_contradiction(mechanism, piece.start, piece.inputs[:, 0], piece.first_status, tolerance)
    summary = Summary(steps + 1)
    rates = _rates(mechanism, asked.order, steps + 1, jit) if asked.order else None
    row = piece.rows(np.arange(1))
    with CsvStream(
        csv_path, motion_table(row, rates=rates, more=asked.head(row)).names
    ) as table:  # appears when the picture has been written too
        while piece is not None:
            more = asked.columns(piece)
            table.append(motion_table(piece, first=summary.seen, rates=rates, more=more))
            summary.add(piece)
            piece = next(pieces, None)
        drawn = png and summary.solved > 0
        if drawn:
            progress_bar(DRAWING)
            _draw(summary.motion, png_path, asked)
    _report(summary, csv_path, png_path if drawn else None, steps, as_json, asked)
    if summary.solved < summary.rows:
        raise typer.Exit(5)


def _refuse_mixed(
    method: Method, rates: Any, at_limit: AtLimit = AtLimit.STOP, branch: int = 1, every: bool = False
) -> None:
    """Refuse what does not go with following a circuit."""
    if method is Method.GIM:
        raise UsageError("--method gim: circuits, branches and limits are followed by continuation; leave it out")
    if rates:
        raise UsageError(
            "--derivatives and graphs of velocities belong to a motion by its law: leave out --circuit and"
            " --at-limit reverse"
        )
    if at_limit is not AtLimit.STOP:
        raise UsageError(f"--at-limit {at_limit}: a circuit goes through limits; leave out one of both")
    if every and branch > 1:
        raise UsageError("--all-branches follows all; leave out --branch")


def _rates(mechanism: Any, order: int, rows: int, jit: Jit) -> Any:
    from gimcli.cli.console import note
    from gimcli.rates.derivatives import TracedRates

    return TracedRates(mechanism, mechanism.traced, order, rows, jit.value, note)


def _refuse_undriven(mechanism: Any) -> None:
    from gimcli.structure.plan import make_plan

    make_plan(mechanism)


def _draw(motion: Motion, path: Path, asked: Asked) -> None:
    import numpy as np

    from gimcli.output import draw_motion
    from gimcli.rates.motion_table import traced_paths

    good = np.flatnonzero(motion.good)
    chosen = good[np.unique(np.linspace(0, len(good), POSES, endpoint=False).astype(int))]
    poses = motion.mechanism.to_file(motion.z[:, chosen].T)
    draw_motion(
        motion.mechanism, poses, traced_paths(motion), path, motion.mechanism.name, asked.curves(motion),
        asked.outlines(motion), asked.panels(motion),
    )  # fmt: skip


def _report(summary: Summary, csv_path: Path, png_path: Path | None, steps: int, as_json: bool, asked: Asked) -> None:
    from gimcli.cli.console import print_json
    from gimcli.cli.progress import end_bars
    from gimcli.rates.motion_table import events, reachable
    from gimcli.status import Status

    end_bars()
    motion, solved, worst = summary.motion, summary.solved, summary.residual
    if motion.bridged:
        from gimcli.branching.event_refinement import sharpened

        motion = sharpened(motion)
    reached, found, measured = reachable(motion), events(motion), asked.report(motion)
    stops = [event for event in found if event["kind"] == "limit"]
    if stops:
        from gimcli.branching.event_refinement import reach

        interval = reach(motion)
        for event in stops:
            event["interval"] = interval
    if as_json:
        report = {
            "csv": str(csv_path), "png": str(png_path) if png_path else None, "steps": steps, "solved": solved,
            "residual": worst, "reachable": reached, "events": found, "status": motion.overall.word, **measured,
        }  # fmt: skip
        print_json(report)
        return
    where = f"{csv_path} and {png_path}" if png_path else str(csv_path)
    quality = f", worst residual {worst:.1e}" if solved else ""
    typer.echo(f"{motion.mechanism.name}: {solved} of {steps + 1} positions solved{quality}")
    _tell_reach(motion, reached)
    if motion.limit is None:
        _tell_events(stops, "the law comes to a limit")
    for name, ends in (stops[-1]["interval"] if stops else {}).items():
        typer.echo(
            f"{name} can be anywhere from {ends[0]:.12g} to {ends[1]:.12g} on this circuit (--circuit follows it)"
        )
    meetings = [e for e in found if e["kind"] == "change point"]
    if motion.bridged[:1] == (0.0,):
        _tell_events(meetings[:1], "starts at a change point, on its first branch (--branch 2 takes another)")
        meetings = meetings[1:]
    _tell_events(meetings, "passed straight through a change point")
    _tell_events([e for e in found if e["kind"] == "sequence exchanged"], "sequence exchanged for a faster one")
    asked.tell(measured)
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
    from gimcli.positions.inputs import law_inputs

    if motion.limit is None:
        return
    ends = law_inputs(motion.mechanism)(motion.time[[0, -1]])
    for k, actuator in enumerate(motion.mechanism.actuators):
        law = motion.mechanism.value_to_file(k, ends[k])
        unit = motion.mechanism.angle_unit if actuator.drive.value == "rotary" else motion.mechanism.length_unit
        for start, end in reached[actuator.name]:
            typer.echo(
                f"{actuator.name} reaches {start:.10g} to {end:.10g} {unit} of its law {law[0]:.10g} to {law[1]:.10g}"
            )
