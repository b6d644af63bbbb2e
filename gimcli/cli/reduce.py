"""`gim reduce`: the equivalent one-degree-of-freedom model."""

from __future__ import annotations

import math

import numpy as np
import typer

from gimcli.canonical import first_greatest
from gimcli.cli.arguments import INPUTS
from gimcli.cli.console import note_doubtful_loading, print_remarks, print_table
from gimcli.cli.from_verb import from_verb
from gimcli.dynamics.reduction import Flywheel
from gimcli.library.reduce import ReduceResult, reduce
from gimcli.rounding import greatest, input_value, number
from gimcli.table import labelled

HELP = (
    "Reduced inertia J, torque tau of weight, loads and springs, potential energy V and their exact derivatives over"
    " the input. The other inputs keep the values at which their laws begin. Writes MODEL.reduced.csv (SI units and"
    " rad) and .png. With --fluctuation and --rpm it sizes a flywheel on the input's shaft."
)
EXAMPLES = (
    "gim reduce watt_durango --steps 360 -o results/",
    "gim reduce watt_durango --fluctuation 0.05 --rpm 300",
)
FLYWHEEL = "Flywheel"


def _print(found: ReduceResult) -> None:
    _print_extremes(found)
    typer.echo(found.headline())
    if found.wheel:
        _print_wheel(found.wheel)
    print_remarks((not found.complete, f"{found._overall.word}: {found._overall.plain_text}"))


def _print_extremes(found: ReduceResult) -> None:
    table, name = found.table(), found.report()["input"]
    q, rows = table.floats("q"), []
    for column in table.columns[1:-1]:
        values = table.floats(column.name)
        if np.any(np.isfinite(values)):
            low, high = first_greatest(-values), first_greatest(values)
            size = greatest(values)
            ends = [(number(values[k], size), input_value(found.mechanism, name, q[k])) for k in (low, high)]
            rows.append((column.name, column.unit, *ends[0], *ends[1]))
    at = f"at {labelled(name, table.columns[0].unit)}"
    print_table("", ("", "unit", "least", at, "greatest", at), rows, (2, 3, 4, 5))


def _print_wheel(wheel: Flywheel) -> None:
    rpm = wheel.speed * 30.0 / math.pi
    without = (
        f"without a flywheel the fluctuation is {number(wheel.without)}"
        if math.isfinite(wheel.without)
        else "without a flywheel the speed would fall to zero"
    )
    what = f"flywheel of {number(wheel.inertia)} kg m^2" if wheel.inertia else "no flywheel"
    typer.echo(
        f"{what} for a fluctuation of {wheel.fluctuation:g} at {number(rpm)} rev/min ({without}); driving torque"
        f" {number(wheel.torque, wheel.work)} N m, largest change of the work {number(wheel.work)} J"
    )


OPTIONS = {
    "actuator": typer.Option(
        "--input",
        metavar="ACTUATOR",
        rich_help_panel=INPUTS,
        help="Input that remains; default: the first.\nThe others keep their values at the start of their laws.",
    ),
    "fluctuation": typer.Option("--fluctuation", metavar="C", rich_help_panel=FLYWHEEL),
    "rpm": typer.Option("--rpm", metavar="N", rich_help_panel=FLYWHEEL),
}
command = from_verb(reduce, ReduceResult, _print, OPTIONS, writes=True, loaded=(note_doubtful_loading,))
