"""`gim singularities`: limits, dead points, change points and stationary positions of a circuit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, Json, ModelPath

if TYPE_CHECKING:
    from gimcli.branching.singular_positions import Found
    from gimcli.library.singularities import SingularitiesResult

NAME = "singularities"
HELP = (
    "List where the mechanism is singular, along the whole circuit that it is drawn on and along every branch that"
    " meets it.\n\n"
    "limit: the input turns back, and cannot drive there. dead point: the input rests, the motion goes on. change"
    " point: branches cross, with the turning rates of the members on each. tangency: the constraints lose rank but one"
    " branch alone goes on. stationary: a member hinged to the frame, or a slider on it, turns back. Several inputs"
    " follow their laws together.\n\n"
    "Example: gim singularities models/parallelogram.yaml --png positions.png"
)
MEMBERS = 3
ALIKE = 1e-6
"""Part of the greatest difference between branches that is none: tangents are told to half the digits at the worst."""


def command(
    model: ModelPath = MODEL,
    png: Annotated[
        Path | None, typer.Option("--png", help="Draw the positions over the curves of the traced points.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Follow the circuits and list what is singular."""
    from gimcli.cli.console import finish, loaded, write_picture
    from gimcli.cli.progress import progress_bar
    from gimcli.library.singularities import singularities

    found = singularities(loaded(model, None, png), progress=progress_bar)
    finish(found, write_picture(found, png), as_json, _print)


def _print(result: SingularitiesResult) -> None:
    from gimcli.cli.console import how_it_ends, intervals, number, print_table
    from gimcli.cli.progress import end_bars
    from gimcli.table import labelled

    end_bars()
    found, mechanism = result.found, result.mechanism
    names = [a.name for a in mechanism.actuators]
    inputs_head = [labelled(a.name, mechanism.unit_of(a)) for a in mechanism.actuators]
    rows = []
    for k, one in enumerate(found.found):
        inputs = result.inputs(one)
        kind = f"{one.what.kind}{' (' + one.what.end + ')' if one.what.end else ''}"
        where = ", ".join(str(b + 1) for b in one.circuits)
        values = [number(inputs[n], 12) for n in names]
        rows.append((str(k + 1), kind, *values, where, ", ".join(one.what.about), _rates(result, one)))
    head = ("", "kind", *inputs_head, "branch", "about", "rates")
    if rows:
        print_table(mechanism.name, head, rows, right=(0, *range(2, 2 + len(names))))
    else:
        typer.echo(f"{mechanism.name}: nothing is singular")
    for k, (circuit, reach) in enumerate(zip(found.branches.circuits, found.reach, strict=True)):
        how = how_it_ends(circuit.closed, circuit.ended, circuit.turns)
        typer.echo(f"branch {k + 1}: {how}; {intervals(result.interval(reach))}")
    if not found.complete:
        typer.echo("more branches meet than are followed")


def _rates(result: SingularitiesResult, one: Found) -> str:
    """Return, for every branch, the members whose rates differ most between branches."""
    told = result.tangents(one)
    free = ["more than one freedom"] * one.what.loose
    if not told:
        return "".join(free)
    names = list(told[0].members)
    spread = {n: max(t.members[n] for t in told) - min(t.members[n] for t in told) for n in names}
    least = ALIKE * max(spread.values(), default=0.0)
    chosen = [n for n in sorted(names, key=lambda n: -spread[n])[:MEMBERS] if spread[n] > least] or names[:MEMBERS]
    lines = []
    for t in told:
        rest = "input rests: " if t.rests else ""
        lines.append(rest + ", ".join(f"{n} {t.members[n]:+.6g}" for n in chosen))
    return "\n".join(lines + free)
