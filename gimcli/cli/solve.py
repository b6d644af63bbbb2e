"""`gim solve`: one position."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import SHARED
from gimcli.cli.console import end_bars, note, print_records, print_remarks, print_table
from gimcli.cli.from_verb import Run, from_verb
from gimcli.errors import refuse
from gimcli.library.record import Records, quantity_rows
from gimcli.library.solve import SolveResult, input_rates, solve
from gimcli.rounding import number, titled
from gimcli.table import per_second

if TYPE_CHECKING:
    from gimcli.rates.derivatives import Instant

SHOWN = 25
HELP = (
    "With --all every configuration at these inputs, with a proof that the list is complete. --velocities adds"
    " velocities and accelerations of nodes, points and members at the input rates of the laws. -o NEW.yaml writes the"
    " model file with the solved coordinates."
)
EXAMPLES = (
    "gim solve crank_rocker --at motor=45",
    "gim solve crank_rocker --at motor=40 --velocities -o v.png",
    "gim solve double_butterfly --all --at motor=145 -o all.png",
    "gim solve gim_fig11 --at FD=120 --at OA=119 --method gim --history",
)
RESULTS, START = "Results", "Start"
SINGULAR = "singular: velocities are not determined in this position; choose an input value beside it"


def _run(run: Run) -> Any:
    """Find one position, or all; print what the model file with the solved coordinates leaves out."""
    if run.switches.pop("all"):
        return _run_all(run)
    run.drop("all configurations: add --all", "seconds")
    refuse(
        (run.assembly and run.arguments["start"] != "drawn", "--assembly gives the initial coordinates: remove --start")
    )
    solved = run.written()
    text = solved.model() if run.outputs.files.of("model") else None
    for remark in text.remarks if text is not None else ():
        note(remark)
    run.show = partial(_print, run.arguments["method"])
    return solved


def _run_all(run: Run) -> Any:
    """Find all configurations."""
    from gimcli.cli.configurations import print_configurations
    from gimcli.library.configurations import ConfigurationsResult, configurations

    refuse((run.assembly, "--all lists every assembly: remove --assembly"))
    run.given.pop("all")
    run.instead(
        configurations, ConfigurationsResult, print_configurations, "a single position, --all for all configurations"
    )
    run.open = True
    found = run.written()
    pictures = run.outputs.files.of("picture") if isinstance(found, ConfigurationsResult) else ()
    run.show = partial(print_configurations, next(iter(pictures), None))
    return found


def _print(method: str, found: SolveResult) -> None:
    end_bars()
    position, residual, law = found._found, found._found.residual, found._law
    typer.echo(titled(position.mechanism, found.inputs))
    typer.echo(
        f"{position.status.word}; length error {_error(residual.lengths[0])} (eq. 1),"
        f" angle error {_error(residual.angles[0])} rad (eq. 2); {_iterations(position.sweeps, method)}"
    )
    print_remarks((found.reason, found.reason))
    _print_known(found._records, "node", "")
    if found._moving is None:
        _print_known(found._members)
    print_records("", quantity_rows(found._measured))
    if law is not None:
        rows = [(str(k), f"{a:.3e}", f"{b:.3e}") for k, (a, b) in enumerate(law.errors)]
        if len(rows) > 2 * SHOWN:
            rows = [*rows[:SHOWN], ("...", "...", "..."), *rows[-SHOWN:]]
        print_table("Error per sweep", ("sweep", "eq. (1)", "eq. (2) [rad]"), rows, right=(0, 1, 2))
        typer.echo(
            f"eq. (3): E = {law.c1:.3g} exp(-{law.c2:.4g} n): factor {law.rate:.4f} per sweep,"
            f" predicted spectral radius {law.radius:.4f}"
            if math.isfinite(law.c1)
            else "too few sweeps to fit eq. (3): E = C1 exp(-C2 n)"
        )
    if found._moving is not None:
        _print_velocities(found, found._moving)


def _print_known(records: Records, *names: str) -> None:
    """Print the rows whose numbers are known: those of a machine that is not solved are not."""
    head, rows, right = records.cells(*names)
    known = [row for row in rows if "-" not in row[1:]]
    if known:
        print_table("", head, known, right)


def _iterations(sweeps: int, method: str) -> str:
    """Return in words how many iterations a position needed."""
    if not sweeps:
        return "no iteration"
    word = "sweep" if method == "gim" else "iteration"
    return f"{sweeps} {word}{'s' * (sweeps != 1)}"


def _error(value: float) -> str:
    return f"{value:.1e}" if value else "0"


def _print_velocities(result: SolveResult, found: Instant) -> None:
    """Print the rates of the inputs, and the tables of points and members."""
    from gimcli.library.inputs import leaders

    if found.singular:
        typer.echo(SINGULAR)
        return
    mechanism = found.mechanism
    for k, (actuator, (name, rate)) in enumerate(zip(mechanism.actuators, input_rates(found).items(), strict=True)):
        v, a = (per_second(mechanism.unit_of(actuator), order) for order in (1, 2))
        source = "unit speed" if math.isnan(rate["time"]) else f"as in its law at {number(rate['time'])} s"
        source = source if k in mechanism.drivers else f"with {' and '.join(leaders(mechanism, k))}"
        values = f"speed {number(rate['rate'])} {v}, acceleration {number(rate['acceleration'])} {a}"
        typer.echo(f"{name}: {values} ({source})")
    print_records("", result._records, "node", "v", "a")
    print_records("", result._members)


OPTIONS = {
    "velocities": typer.Option("--velocities", rich_help_panel=RESULTS),
    "history": typer.Option(
        "--history", rich_help_panel=RESULTS,
        help="Add the error after every sweep (--method gim).\n"
        "Also the fitted law E = C1 exp(-C2 n).",
    ),
    "start": typer.Option(
        "--start", metavar="drawn|random", help="Start from the initial (drawn) or from random coordinates.",
        rich_help_panel=START,
    ),
    "seed": typer.Option("--seed", metavar="N", rich_help_panel=START),
}  # fmt: skip
EXTRA = {
    "all": Annotated[
        bool,
        typer.Option(
            "--all",
            rich_help_panel=RESULTS,
            help="Find all configurations; report if that is proved.\n"
            "See [below](#gim-solve---all); `--seconds` ends the search.",
        ),
    ],
    "seconds": Annotated[float | None, SHARED["seconds"]],
}
command = from_verb(solve, SolveResult, _print, OPTIONS, files="csv png", extra=EXTRA, run=_run)
