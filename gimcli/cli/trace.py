"""`gim trace`: follow the motion, write coupler curves."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from gimcli.cli.arguments import (
    MODEL,
    NONE,
    Assembly,
    Jit,
    JitOption,
    Json,
    Method,
    MethodOption,
    ModelPath,
    Out,
    Png,
    SequenceText,
    Set,
    Steps,
    Strategy,
    StrategyOption,
    Tolerance,
)
from gimcli.cli.console import note, print_more, print_status
from gimcli.cli.measures import (
    QUANTITIES,
    MeasureOption,
    PlotOption,
    print_measures,
    print_points,
    print_ranges,
    refuse_unseen,
)
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options
from gimcli.cli.progress import progress_bar
from gimcli.library.rounding import at_inputs, how_it_ends, input_value, interval, intervals
from gimcli.status import CHANGE, TANGENCY

if TYPE_CHECKING:
    from gimcli.library.circuit_trace import CircuitTraceResult
    from gimcli.library.trace import MotionTraceResult
    from gimcli.motion.motion import Motion


AT_START = 1e-12
"""Time, 0..1, up to which a motion passes a position as it starts."""


class AtLimit(StrEnum):
    """Actions at the limit of an input."""

    STOP = "stop"
    SKIP = "skip"
    REVERSE = "reverse"


HELP = (
    "N steps give N + 1 rows; a row that is not solved is kept, with a status and empty cells. Writes MODEL.csv and"
    " MODEL.png."
)
EXAMPLES = (
    "gim trace crank_rocker --steps 360 -o results/",
    "gim trace crank_rocker -o - | head",
    "gim trace crank_rocker --set crank=35 --set P.x=80",
    "gim trace crank_rocker -m transmission --plot transmission",
    "gim trace chebyshev --circuit -o circuit.csv -o circuit.svg",
)
LIMITS = "Limits and branches"
EVENTS = 6


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    steps: Steps = 360,
    assembly: Assembly = "",
    derivatives: Annotated[
        int,
        typer.Option(
            "--derivatives", "-d", metavar="K", min=0, max=3, rich_help_panel=QUANTITIES,
            help="1: velocities; 2: also accelerations; 3: also jerks.",
        ),
    ] = 0,
    measure: MeasureOption = NONE,
    plot: PlotOption = NONE,
    at_limit: Annotated[
        AtLimit,
        typer.Option(
            "--at-limit", metavar="ACTION", rich_help_panel=LIMITS, show_default=False,
            help="At the limit of an input: stop (default), skip, reverse.",
        ),
    ] = AtLimit.STOP,
    circuit: Annotated[
        bool, typer.Option("--circuit", help="Follow the circuit of the start, not the law.", rich_help_panel=LIMITS)
    ] = False,
    branch: Annotated[
        int, typer.Option("--branch", metavar="K", min=1, help="Branch taken at a change point.",
                          rich_help_panel=LIMITS)
    ] = 1,
    all_branches: Annotated[
        bool, typer.Option("--all-branches", help="Follow every circuit that crosses it.", rich_help_panel=LIMITS)
    ] = False,
    method: MethodOption = Method.AUTO,
    strategy: StrategyOption = Strategy.SPECTRAL,
    sequence: SequenceText = "",
    tolerance: Tolerance = 1e-10,
    jit: JitOption = Jit.AUTO,
    out: Out = NONE,
    png: Png = True,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:  # fmt: skip
    """Trace a motion."""
    if "help" in measure:
        print_measures()
    from gimcli.cli.outputs import Outputs
    from gimcli.library.trace import MotionTraceResult, traced

    outputs = Outputs(MotionTraceResult, model, out, writes=True, picture=png, as_json=as_json, drawing=drawing)
    refuse_unseen(plot, outputs.draws)
    mechanism = outputs.loaded(assembly, tolerance=tolerance, changes=changes)
    begun = traced(
        mechanism, steps, derivatives=derivatives, measure=measure, plot=plot, at_limit=at_limit.value,
        circuit=circuit, branch=branch, all_branches=all_branches, method=method.value, strategy=strategy.value,
        tolerance=tolerance, jit=jit.value, sequence=sequence, notify=note, progress=progress_bar,
    )  # fmt: skip
    found: Any = outputs.stream(cast(Any, begun))
    outputs.show(found, _print if isinstance(found, MotionTraceResult) else _print_circuits)


def _print(found: MotionTraceResult) -> None:
    from gimcli.status import Status

    typer.echo(found.headline())
    for part, machine in zip(found.motion.machines, found.machines, strict=True):
        if len(found.machines) > 1:
            typer.echo(f"{machine['name']}: {machine['solved']} of {found.rows} positions solved")
        _print_machine(found, part, machine)
    print_ranges(found.mechanism, found.measured)
    print_points(found.mechanism, found.points)
    if found.motion.overall is not Status.OK:
        print_status(found.motion)


def _print_machine(found: MotionTraceResult, motion: Motion, machine: dict[str, Any]) -> None:
    """Print what is reachable, and the events, of a machine."""
    events = machine["events"]
    _print_reach(motion, machine["reachable"])
    stops = [e for e in events if e["kind"] == "limit"]
    if motion.limit is None:
        _print_events(found, stops, "the law ends exactly at a limit,")
    for name, ends in (stops[-1]["interval"] if stops else {}).items():
        whole = interval(found.mechanism, name, ends[0], ends[1], 0.0)
        typer.echo(f"range of {name} on this circuit: {whole} (--circuit follows the whole circuit)")
    _print_other_side(motion, stops)
    meetings = [e for e in events if e["kind"] in (CHANGE, TANGENCY)]
    if motion.bridged and motion.bridged[0] < AT_START:
        which = "on the first branch (--branch 2: another) of the" if meetings[0]["kind"] == CHANGE else "at a"
        _print_events(found, meetings[:1], f"the motion starts {which} {meetings[0]['kind']}")
        meetings = meetings[1:]
    for kind in (CHANGE, TANGENCY):
        _print_events(found, [e for e in meetings if e["kind"] == kind], f"passed straight through a {kind}")
    _print_events(found, [e for e in events if e["kind"] == "sequence exchanged"], "sequence replaced by a faster one")


def _print_circuits(found: CircuitTraceResult) -> None:
    typer.echo(found.headline())
    for one in found.circuits:
        how = how_it_ends(one["closed"], one["ended"], one["turns"])
        typer.echo(
            f"branch {one['branch']}: {how}; range of {intervals(found.mechanism, one['interval'], one['turns'])}"
        )
        for e in one["events"]:
            typer.echo(f"  {e['kind']} at " + at_inputs(found.mechanism, e["at"]))
        print_ranges(found.mechanism, one)
        print_points(found.mechanism, one["points"])


def _print_events(found: MotionTraceResult, events: list[dict[str, Any]], what: str) -> None:
    for event in events[:EVENTS]:
        typer.echo(f"{what} at {at_inputs(found.mechanism, event['at'])}")
    print_more(len(events), EVENTS)


def _print_other_side(motion: Motion, stops: list[dict[str, Any]]) -> None:
    """Print which of the values that were not reached the circuit has, some of them a number of whole turns away."""
    import numpy as np

    from gimcli.rates.member_angles import full_turn

    mechanism = motion.mechanism
    moving = np.flatnonzero(np.ptp(motion.inputs, axis=1))  # of others, the same values are elsewhere on the curve
    if not stops or len(moving) != 1 or motion.good.all():
        return
    (k,) = moving.tolist()
    actuator, values = mechanism.actuators[k], mechanism.value_to_file(k, motion.inputs[k])
    turn = full_turn(mechanism) if actuator.rotary else np.finfo(float).max  # no value is one turn away
    own = values[~motion.good]
    for low, high in [stops[-1]["interval"][actuator.name]]:
        within = (own >= low) & (own <= high)
        moved = np.where(within, own, own - np.where(within, 0.0, turn) * np.ceil((own - high) / turn))
        also = moved[~within & (moved >= low)]
        if len(also):
            part = interval(mechanism, actuator.name, float(also.min()), float(also.max()), 0.0)
            end = input_value(mechanism, actuator.name, float(also[np.argmax(np.abs(also - values[0]))]))
            typer.echo(f"the circuit reaches these angles from the other side, as {part}: write `to: {end}` in the law")
        if within.any():
            part = interval(mechanism, actuator.name, float(own[within].min()), float(own[within].max()), 0.0)
            typer.echo(f"the law returns into the range of the circuit, {part}: --at-limit skip solves these rows too")


def _print_reach(motion: Motion, reached: dict[str, list[list[float]]]) -> None:
    from gimcli.positions.inputs import law_inputs

    if motion.limit is None:
        return
    ends = law_inputs(motion.mechanism)(motion.time[[0, -1]])
    for k, actuator in enumerate(motion.mechanism.actuators):
        first, last = motion.mechanism.value_to_file(k, ends[k])
        whole = interval(motion.mechanism, actuator.name, first, last, 0.0)
        for start, end in reached[actuator.name]:
            part = interval(motion.mechanism, actuator.name, start, end, 0.0)
            typer.echo(f"{actuator.name} reaches {part}; its law is {whole}")
