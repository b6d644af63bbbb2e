"""`gim equilibrium`: positions in which all forces balance."""

from __future__ import annotations

import typer

from gimcli.cli.arguments import INPUTS, METHOD
from gimcli.cli.console import print_records, print_remarks
from gimcli.cli.from_verb import from_verb
from gimcli.library.equilibrium import EquilibriumResult, equilibrium
from gimcli.rounding import at_inputs, number

HELP = (
    "Inputs with `free: true`, or named by --free, are released, the others are held at --at. With one released input"
    " all equilibria of the circuit are found, each with its potential, its stability, and the effort that pushes the"
    " mechanism over the next one. With several they are searched from random starts. Dampers and friction do not act."
)
EXAMPLES = (
    "gim equilibrium snap_hinge -o hinge.png",
    "gim equilibrium balanced_lamp --set lamp=0.7",
)
SHOWN = 40


def _print(result: EquilibriumResult) -> None:
    mechanism, found = result.mechanism, result._found
    print_records(result.headline(), result._records, most=SHOWN)
    every = enumerate(zip(result.assemblies, result.elsewhere, strict=True), 1)
    others = [f"{k} --assembly {number}" for k, (number, elsewhere) in every if elsewhere]
    where = at_inputs(mechanism, result.report()["at"])
    print_remarks(
        (
            any(one.pushes for one in found.found),
            "up, down: greatest effort on the path to the next equilibrium (-: the input reaches a limit)",
        ),
        *(
            f"effort of {name}{' besides its own' * (name in result.driven)} that holds the mechanism at {where}:"
            f" {number(value, found.size)} {result.unit(k)}"
            for k, (name, value) in zip(found.released, result.holding.items(), strict=True)
        ),
        *remarks(result),
        (others, f"in another assembly than the initial one, at their inputs: equilibrium {', '.join(others)}"),
        *(
            f"equilibrium {k}: {one.status.word}: remaining force {one.residual:.1e} of its contributions"
            for k, one in enumerate(found.found, 1)
            if one.status.value
        ),
    )


def remarks(result: EquilibriumResult) -> tuple[tuple[object, str], ...]:
    """Return what the list of equilibria does not prove, and why: conditions and sentences."""
    found, history, starts = result._found, result._found.history, result._found.starts
    level = history is not None and f"the potential is {history.potential[0]:.10g} J on the whole circuit"
    others = "a force turns with a member or follows a table over an input: the potential is that of the other forces"
    since = ", less the work of this force since the start" * (history is not None)
    failed = f"; {found.failed} did not converge" * bool(found.failed)
    left = f"{found.crossings} change point{'s' * (found.crossings != 1)} on the circuit: the branches that leave"
    return (
        (found.everywhere and found.size and level, level or ""),
        (not found.conservative, others + since),
        (starts and found.everywhere, f"{starts} random positions were examined, which is no proof for all"),
        (
            starts and not found.everywhere,
            f"searched from {starts} starts{failed}: no proof that there are no others (--starts)",
        ),
        (found.crossings, f"{left} there were not searched (gim singularities lists them)"),
        (found.gain, f"the potential changes by {found.gain:.6g} J in each turn of the circuit"),
        (found.cut, "a torsion spring is wound in each turn: equilibria in further turns were not searched"),
        (history is not None and not found.closed, f"the circuit is not closed: {found.ended}"),
    )


OPTIONS = {
    "free": typer.Option(
        "--free", metavar="ACTUATOR", rich_help_panel=INPUTS,
        help="Input that is released; repeatable, or with commas.\n"
        "Besides those with `free: true`; a single input needs no name.",
    ),
    "time": typer.Option("--time", metavar="T", rich_help_panel=INPUTS),
    "starts": typer.Option(
        "--starts", metavar="N", rich_help_panel=METHOD,
        help="Several released inputs: starts in a row that find nothing new before the end.",
    ),
    "seed": typer.Option("--seed", metavar="N", rich_help_panel=METHOD),
}  # fmt: skip
command = from_verb(equilibrium, EquilibriumResult, _print, OPTIONS)
