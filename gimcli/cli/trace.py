"""`gim trace`: follow the motion, write coupler curves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer

from gimcli.cli.console import print_more, print_remarks, print_status
from gimcli.cli.from_verb import from_verb
from gimcli.cli.measures import PLOT, QUANTITIES, print_points, print_ranges
from gimcli.library.trace import MotionTraceResult, trace
from gimcli.rounding import at_inputs, how_it_ends, input_value, interval, intervals
from gimcli.status import CHANGE, TANGENCY, Status

if TYPE_CHECKING:
    from gimcli.library.circuit_trace import CircuitTraceResult
    from gimcli.motion.motion import Motion


AT_START = 1e-12
"""Time, 0..1, up to which a motion passes a position as it starts."""


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


def _shown(found: MotionTraceResult | CircuitTraceResult) -> None:
    return _print(found) if isinstance(found, MotionTraceResult) else _print_circuits(found)


def _print(found: MotionTraceResult) -> None:
    typer.echo(found.headline())
    for part, machine in zip(found._motion.machines, found.machines, strict=True):
        solved = f"{machine['name']}: {machine['solved']} of {found.rows} positions solved"
        print_remarks((len(found.machines) > 1, solved))
        _print_machine(found, part, machine)
    print_ranges(found.mechanism, found.measured)
    print_points(found.mechanism, found.points)
    if found._motion.overall is not Status.OK:
        print_status(found._motion)


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
        print_remarks(
            f"branch {one['branch']}: {how}; range of {intervals(found.mechanism, one['interval'], one['turns'])}",
            *(f"  {event['kind']} at {at_inputs(found.mechanism, event['at'])}" for event in one["events"]),
        )
        print_ranges(found.mechanism, one)
        print_points(found.mechanism, one["points"])


def _print_events(found: MotionTraceResult, events: list[dict[str, Any]], what: str) -> None:
    print_remarks(*(f"{what} at {at_inputs(found.mechanism, event['at'])}" for event in events[:EVENTS]))
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


OPTIONS = {
    "derivatives": typer.Option(
        "--derivatives", "-d", metavar="K", rich_help_panel=QUANTITIES
    ),
    "measure": typer.Option(
        "--measure", "-m", metavar="QUANTITY", rich_help_panel=QUANTITIES,
        help="Add a quantity, such as |A.f|; repeatable; `-m help` lists kinds.\n"
        "Its columns, its range, its curve in the picture, see [measures](#measures).",
    ),
    "plot": PLOT,
    "at_limit": typer.Option(
        "--at-limit", metavar="ACTION", rich_help_panel=LIMITS, show_default=False,
        help="At the limit of an input: stop (default), skip, reverse.",
    ),
    "circuit": typer.Option(
        "--circuit", rich_help_panel=LIMITS
    ),
    "branch": typer.Option(
        "--branch", metavar="K", rich_help_panel=LIMITS
    ),
    "all_branches": typer.Option(
        "--all-branches", rich_help_panel=LIMITS
    ),
}  # fmt: skip
command = from_verb(trace, MotionTraceResult, _shown, OPTIONS, writes=True)
