"""`gim simulate`: forward dynamics."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

import typer

from gimcli.cli.arguments import INPUTS, OUTPUT
from gimcli.cli.console import end_bars, note_doubtful_loading, print_records, print_remarks
from gimcli.cli.force_tables import print_open
from gimcli.cli.from_verb import Run, from_verb
from gimcli.cli.measures import PLOTS_ONLY, print_ranges
from gimcli.dynamics.integrators import INTEGRATORS, STEPPED, USUAL, WITH_DRY_FRICTION
from gimcli.dynamics.simulation_table import column_names
from gimcli.library.record import Records, RowField
from gimcli.library.simulate import SimulateResult, simulate
from gimcli.mechanism import Mechanism
from gimcli.output.csv import refuse_repeated
from gimcli.rounding import greatest, input_value, number

HELP = (
    "Inputs with `free: true` move under weight, loads, springs, friction and driving efforts; the other inputs follow"
    " their laws. Events are standstills and dead points of free inputs, pairs with dry friction that stick or slide,"
    " and the event that ends the motion. Writes"
    " MODEL.simulation.csv and .png."
)
EXAMPLES = (
    "gim simulate watt_durango --time 4 --dt 0.05 -o results/",
    "gim simulate watt_durango --integrator radau --reactions",
)
INTEGRATION = "Integration"
EVENTS = 12


def _print(result: SimulateResult) -> None:
    end_bars()
    found = result._found
    print_records("", _events(result), most=EVENTS)
    typer.echo(
        f"{found.mechanism.name}: {len(found.time)} of {len(result.times)} rows, {found.steps} steps,"
        f" {found.evaluations} evaluations; energy drift {found.worst_drift:.1e}, relative to the greatest energy"
    )
    turning, sliding = result.slip or (0.0, 0.0)
    slip = f"dry friction with a slip speed of {turning:.1e} rad/s in pins, {sliding:.1e} m/s in guides"
    print_remarks((result.slip is not None, slip))
    print_ranges(result.mechanism, result.measured)
    print_open(result.open)
    ended = f"ended at {number(found.end)} s, {found.status.word}: {found.status.plain_text}"
    print_remarks((found.status.word != "ok", ended))


def _kind(event: dict[str, Any]) -> str:
    """Return the kind of an event with the input or the pair that has it."""
    if "pair" in event:
        return f"{event['pair']} {event['kind']}"
    return str(event["kind"]) + (f" of {event['actuator']}" if "actuator" in event else "")


def _events(result: SimulateResult) -> Records:
    """Return the events, one row each: kind, time, inputs and their speeds."""
    events, own, names = result.events, result.mechanism, [actuator.name for actuator in result.mechanism.actuators]
    return Records(
        RowField("kind", list(map(_kind, events)), head="event"),
        RowField("time", [one["time"] for one in events], float, "s", head="time"),
        *(
            RowField(name, [one["at"][name] for one in events], float, head=name, text=partial(input_value, own, name))
            for name in names
        ),
        *(
            RowField(f"{name}.speed", [one["speed"][name] for one in events], float, head=f"{name}.speed",
                     size=greatest(result[f"{name}.speed"].tolist()))
            for name in names
        ),
    )  # fmt: skip


def _refuse_repeated(mechanism: Mechanism) -> None:
    """Refuse names of columns that are the same."""
    refuse_repeated(column_names(mechanism))


def _run(run: Run) -> Any:
    run.arguments |= {"integrator": older} if (older := run.switches.pop("method")) else {}
    return run.written()


OPTIONS = {
    "duration": typer.Option("--time", "-t", metavar="S", rich_help_panel=INPUTS),
    "standstills": typer.Option(
        "--standstills", metavar="K", rich_help_panel=INPUTS,
        help="Stop at the K-th standstill of a free input; 0: never.\n",
    ),
    "integrator": Annotated[str, typer.Option(
        "--integrator", metavar="NAME", rich_help_panel=INTEGRATION,
        help=f"{', '.join(INTEGRATORS)}; default: {USUAL}, with dry friction {WITH_DRY_FRICTION}.\n"
        "`dop853`, `rk45`, `radau` (the default where damping is stiff) and `lsoda` choose their steps by `--rtol`;"
        " `rk4` has equal steps of time, `euler` and `euler-exact` (with the exact dJ/dq) of the only free input.",
    )],
    "rtol": typer.Option(
        "--rtol", metavar="T", rich_help_panel=INTEGRATION
    ),
    "step": typer.Option(
        "--step", metavar="S", rich_help_panel=INTEGRATION,
        help=f"Step of {STEPPED}; default: 0.001.\n"
        "For a length 0.001 of about the size of the mechanism.",
    ),
    "slip": typer.Option(
        "--slip", metavar="V", rich_help_panel=INTEGRATION,
        help="Slip speed below which dry friction grows smoothly [rad/s]; default: 1e-6 rad / --time.\n"
        "In guides times about the size of the mechanism, see [dry"
        " friction](dynamics.md#dry-friction-in-a-simulation).",
    ),
    "dt": typer.Option(
        "--dt", metavar="S", rich_help_panel=OUTPUT
    ),
    "reactions": typer.Option("--reactions", rich_help_panel=OUTPUT),
    "plot": PLOTS_ONLY,
}  # fmt: skip
METHOD = Annotated[str, typer.Option("--method", hidden=True)]
"""The older name of --integrator."""
NOTES = (_refuse_repeated, note_doubtful_loading)
command = from_verb(
    simulate, SimulateResult, _print, OPTIONS, writes=True, loaded=NOTES, extra={"method": METHOD}, run=_run
)
