"""`gim tradeoff`: speed and accuracy of every method for a motion."""

from __future__ import annotations

import typer

from gimcli.cli.arguments import METHOD
from gimcli.cli.console import print_records, print_remarks, print_status
from gimcli.cli.from_verb import from_verb
from gimcli.comparison.tradeoff import advise
from gimcli.errors import UsageError
from gimcli.library.tradeoff import TradeoffResult, tradeoff

HELP = (
    "Every method solves the motion of the model at each tolerance: iterations, operations, time, and the true error"
    " against positions refined to 40 digits; then a recommendation for 3, 6, 9 and 12 digits. Writes"
    " MODEL.tradeoff.csv and .png."
)
EXAMPLES = ("gim tradeoff platform_3rrr --tolerances 1e-3,1e-6,1e-9 -o results/",)
SEEN = (
    "method", "unknowns", "tolerance", "iterations", "operations", "fixed", "seconds", "spread", "error", "solved",
    "reason",
)  # fmt: skip
"""Fields of the table of methods."""


def _tolerances(text: str) -> list[float]:
    """Return the tolerances of --tolerances."""
    values: list[float] = []
    for word in text.replace(",", " ").split():
        try:
            values.append(float(word))
        except ValueError:
            raise UsageError(f"tolerances: expected numbers from 1e-14 to below 1, got '{word}'") from None
    return values


def _print(result: TradeoffResult) -> None:
    found = result._found
    print_records(result.headline(), result._records, *SEEN)
    print_remarks(
        (
            found.entries,
            "iterations: of all systems, sweeps for gim; call: its fixed part, to which each position adds its time\n"
            "*: efficient: no other entry that solves all positions is both faster and more accurate",
        ),
        (
            found.unrefined,
            f"{found.unrefined} positions are not compared: they are too near to a singular position to determine a"
            " true error",
        ),
    )
    if not found.reached:
        print_status(found.motion)
    print_remarks(*(advice.text for advice in advise(found)))


OPTIONS = {
    "tolerances": typer.Option(
        "--tolerances", metavar="T,T,...", rich_help_panel=METHOD,
        help="Default: 1e-2, 1e-4 ... 1e-14.\n"
        "From 1e-14 to below 1.",
    ),
    "seconds": typer.Option(
        "--seconds", metavar="S", min=1.0, rich_help_panel=METHOD,
        help="Processor time for all; slow methods get fewer runs.\n"
        "Slow methods are not run at finer tolerances.",
    ),
}  # fmt: skip
command = from_verb(tradeoff, TradeoffResult, _print, OPTIONS, writes=True, read={"tolerances": _tolerances})
