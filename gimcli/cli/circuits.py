"""`gim circuits`: which configurations the motion joins."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, Json, ModelPath

if TYPE_CHECKING:
    from gimcli.library.circuits import CircuitsResult

NAME = "circuits"
HELP = (
    "Find the circuits of a mechanism: which of its configurations the motion joins without taking it apart.\n\n"
    "All configurations are listed at --samples values of the input, and each is followed through limits and change"
    " points until it is home. A branch is a stretch of a circuit between two limits of the input. Circuits that meet"
    " at change points count as one, of several curves. A circuit whose input moves by less than the spacing of the"
    " samples may be missed: the report says how fine that is. Several inputs follow their laws together.\n\n"
    "Example: gim circuits models/stephenson_2.yaml --png circuits.png"
)


def command(
    model: ModelPath = MODEL,
    samples: Annotated[
        int, typer.Option("--samples", min=4, max=100_000, help="Values of the input at which all are listed.")
    ] = 72,
    png: Annotated[
        Path | None, typer.Option("--png", help="Draw the curves of the traced points, one circuit a line style.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Find the circuits and list them."""
    from gimcli.cli.console import finish, loaded, write_picture
    from gimcli.cli.progress import progress_bar
    from gimcli.library.circuits import circuits

    found = circuits(loaded(model, None, png), samples=samples, progress=progress_bar)
    finish(found, write_picture(found, png), as_json, _print)


def _print(result: CircuitsResult) -> None:
    from gimcli.cli.console import how_it_ends, intervals, number, print_table
    from gimcli.library.circuits import curve_label, inputs_at, span, verdict

    found = result.found
    rows = []
    for k, strand in enumerate(found.strands):
        own = strand.circuit
        how, ends = how_it_ends(own.closed, own.ended, own.turns), intervals(span(found, strand), "\n")
        there = [
            f"{i + 1}" + (f" (branch {b + 1})" if len(strand.branches) > 1 else "")
            for i, at in enumerate(found.places) for j, b in at if j == k
        ]  # fmt: skip
        rows.append((curve_label(found, k), how, ends, str(len(strand.branches)), ", ".join(there) or "none"))
    at = ", ".join(f"{name} = {number(value)}" for name, value in inputs_at(found, found.curve.begin()).items())
    print_table(result.headline(), ("circuit", "", "input", "branches", f"configurations at {at}"), rows, right=(3,))
    typer.echo(verdict(found))
