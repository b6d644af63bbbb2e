"""`gim trace`: follow the motion, write coupler curves."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from gimcli.cli.arguments import (
    MODEL,
    Jit,
    JitOption,
    Json,
    Method,
    MethodOption,
    ModelPath,
    Out,
    Png,
    SequenceText,
    Strategy,
    StrategyOption,
    Tolerance,
)
from gimcli.cli.measures import MEASURE_HELP, MeasureOption, PlotOption, print_measures, print_ranges
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from gimcli.library.circuit_trace import CircuitTraceResult
    from gimcli.library.trace import MotionTraceResult
    from gimcli.library.trace_result import TraceResult


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

EVENTS = 6


def command(
    model: ModelPath = MODEL,
    steps: Annotated[int, typer.Option("--steps", "-n", min=1, max=10_000_000, help="Steps of the motion.")] = 360,
    out: Out = Path(),
    png: Png = True,
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
    if "help" in measure:
        print_measures()
    from gimcli.cli.console import files_in, finish, note, write_stream
    from gimcli.cli.progress import progress_bar
    from gimcli.library.load import load
    from gimcli.library.trace import MotionTraceResult, traced

    if plot and not png:
        raise UsageError("--plot draws into the picture: leave --no-png out")
    mechanism = load(model)
    csv_path, png_path = files_in(out, model.stem, png, mechanism)
    begun = traced(
        mechanism, steps, derivatives=derivatives, measure=measure, plot=plot, at_limit=at_limit.value, circuit=circuit,
        branch=branch, all_branches=all_branches, method=method.value, strategy=strategy.value, tolerance=tolerance,
        jit=jit.value, sequence=sequence, notify=note, progress=progress_bar,
    )  # fmt: skip
    found, paths = write_stream(begun, csv_path, png_path)
    law = isinstance(found, MotionTraceResult)
    finish(found, paths, as_json, cast("Callable[[TraceResult], None]", _print if law else _print_circuits), True)


def _print(found: MotionTraceResult) -> None:
    from gimcli.cli.console import print_status

    motion, events = found.motion, found.events
    typer.echo(found.headline())
    _tell_reach(found)
    stops = [e for e in events if e["kind"] == "limit"]
    if motion.limit is None:
        _tell_events(stops, "the law comes to a limit")
    for name, ends in (stops[-1]["interval"] if stops else {}).items():
        typer.echo(
            f"{name} can be anywhere from {ends[0]:.12g} to {ends[1]:.12g} on this circuit (--circuit follows it)"
        )
    meetings = [e for e in events if e["kind"] == "change point"]
    if motion.bridged[:1] == (0.0,):
        _tell_events(meetings[:1], "starts at a change point, on its first branch (--branch 2 takes another)")
        meetings = meetings[1:]
    _tell_events(meetings, "passed straight through a change point")
    _tell_events([e for e in events if e["kind"] == "sequence exchanged"], "sequence exchanged for a faster one")
    print_ranges(found.measured)
    if not found.complete:
        print_status(motion)


def _print_circuits(found: CircuitTraceResult) -> None:
    from gimcli.cli.console import how_it_ends, intervals

    typer.echo(found.headline())
    for one in found.circuits:
        how = how_it_ends(one["closed"], one["ended"], one["turns"])
        typer.echo(f"branch {one['branch']}: {how}; {intervals(one['interval'])}")
        for e in one["events"]:
            typer.echo(f"  {e['kind']} at " + ", ".join(f"{n} = {v:.12g}" for n, v in e["at"].items()))
        print_ranges(one)


def _tell_events(found: list[dict[str, Any]], what: str) -> None:
    from gimcli.cli.console import print_more

    for event in found[:EVENTS]:
        at = ", ".join(f"{k} = {v:.8g}" for k, v in event["at"].items())
        typer.echo(f"{what} at {at}")
    print_more(len(found), EVENTS)


def _tell_reach(found: MotionTraceResult) -> None:
    from gimcli.positions.inputs import law_inputs

    motion, reached = found.motion, found.reachable
    if motion.limit is None:
        return
    ends = law_inputs(motion.mechanism)(motion.time[[0, -1]])
    for k, actuator in enumerate(motion.mechanism.actuators):
        law = motion.mechanism.value_to_file(k, ends[k])
        unit = motion.mechanism.unit_of(actuator)
        for start, end in reached[actuator.name]:
            typer.echo(
                f"{actuator.name} reaches {start:.10g} to {end:.10g} {unit} of its law {law[0]:.10g} to {law[1]:.10g}"
            )
