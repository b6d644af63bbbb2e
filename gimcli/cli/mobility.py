"""`gim mobility`: freedoms, redundant constraints, undriven nodes."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from gimcli.cli.console import print_remarks, print_table
from gimcli.cli.from_verb import Run, from_verb
from gimcli.library.mobility import NATURAL, SHOWN, JacobianMatrix, MobilityResult, mobility
from gimcli.rounding import number
from gimcli.status import Status

WIDEST = 8
"""Most columns of a printed matrix."""

HELP = (
    "Grübler's formula, the rank of the constraint Jacobian and the mobility that follows from it, at the assembled"
    " position nearest to the initial configuration."
)
EXAMPLES = (
    "gim mobility parallelogram_third_crank",
    "gim mobility parallelogram_third_crank --jacobian --coordinates joint",
)


def _run(run: Run) -> Any:
    """Find the mobility, and the Jacobian if it is asked for."""
    shows, coordinates = run.switches.pop("jacobian"), run.switches.pop("coordinates")
    run.arguments["coordinates"] = coordinates or NATURAL
    found = run.found()
    found.shows_jacobian = bool(shows or coordinates) and found.jacobian is not None  # refused before output
    run.outputs.write(found)
    return found


def _print(result: MobilityResult) -> None:
    found, everywhere = result._found, result.start == Status.TANGENT.word
    print_table(result.mechanism.name, ("", ""), result._records.pairs(*SHOWN))
    print_remarks(
        (everywhere, f"The initial configuration is {Status.TANGENT.text}."),
        (
            found.stuck and not found.undriven and not everywhere,
            f"The inputs do not determine the initial configuration: {result.start}. `gim singularities` lists such"
            " positions; use other initial coordinates.",
        ),
        (
            found.singular and not everywhere,
            f"The initial configuration is singular: {found.apparent} apparent freedoms there, {found.mobility} in"
            " nearby positions.",
        ),
    )
    if result.shows_jacobian:
        _print_jacobian(result.jacobian)


def _print_jacobian(found: JacobianMatrix) -> None:
    """Print the matrix; a wide one as the list of what is not 0 in each row."""
    head, rows, right = found._equations.cells()
    if len(right) > WIDEST:
        listed = (", ".join(f"{c}: {v}" for c, v in zip(head[1:], row[1:], strict=True) if v != "0") for row in rows)
        rows = [(row[0], text) for row, text in zip(rows, listed, strict=True)]
        head, right = ["equation", "derivatives that are not 0"], []
    print_table(f"Jacobian of the constraints, {found.coordinates} coordinates", head, rows, right)
    last = found.rank_by_singular_values
    gap = " and ".join(number(one, 1.0) for one in found.singular_values[max(0, last - 1) : last + 1].tolist())
    print_remarks(
        f"rank of {len(found.rows)} equations in {len(found.columns)} coordinates: {found.rank} by elimination with"
        f" full pivoting,\n{last} by singular values (at the gap {gap})",
        *(
            f"dependent: {name}; one of several choices, instead of it: {', '.join(others) or 'none'}"
            for name, others in found.dependent.items()
        ),
    )


EXTRA = {
    "jacobian": Annotated[bool, typer.Option("--jacobian", help="Print the Jacobian of the constraints.")],
    "coordinates": Annotated[
        str,
        typer.Option(
            "--coordinates",
            metavar="NAME",
            help="The Jacobian in joint, absolute or natural ones.\nDefault: natural. It implies `--jacobian`.",
        ),
    ],
}
command = from_verb(mobility, MobilityResult, _print, files="", extra=EXTRA, run=_run)
