"""`gim singularities`: limits, dead points, change points and stationary positions of a circuit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from gimcli.cli.arguments import MODEL, NONE, Assembly, Json, ModelPath, Out, PngFile, Set
from gimcli.cli.console import how_it_ends, print_table
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options
from gimcli.cli.progress import end_bars, progress_bar
from gimcli.library.rounding import input_value, intervals

if TYPE_CHECKING:
    from gimcli.branching.singular_positions import Found
    from gimcli.library.singularities import SingularitiesResult

HELP = (
    "The circuit of the initial configuration is followed, and every branch that crosses it. limit: the input turns"
    " back. dead point: the input rate is zero while the mechanism moves. change point: branches cross. tangency: the"
    " constraints lose rank, but only one branch continues. stationary: a rocker or slider turns back."
)
EXAMPLES = ("gim singularities parallelogram -o positions.png",)
MEMBERS = 3
ALIKE = 1e-6
"""Relative differences between branches below this are rounding: tangents are accurate to half the digits or better."""


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    assembly: Assembly = "",
    out: Out = NONE,
    png: PngFile = None,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:
    """Follow the circuits and list the singular positions."""
    from gimcli.cli.outputs import Outputs, by_machine
    from gimcli.library.singularities import SingularitiesResult, singularities

    outputs = Outputs(SingularitiesResult, model, out, png=png, as_json=as_json, drawing=drawing)
    found = singularities(outputs.loaded(assembly, changes=changes), progress=progress_bar)
    outputs.finish(found, by_machine(_print))


def _print(result: SingularitiesResult) -> None:
    from gimcli.branching.singularities import STATIONARY
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
        values = [input_value(mechanism, n, inputs[n]) for n in names]
        rows.append((str(k + 1), kind, *values, where, ", ".join(one.what.about), _rates(result, one)))
    head = ("", "kind", *inputs_head, "branch", "members", "relative rates on each branch")
    if rows:
        if not any(row[-1] for row in rows):
            head, rows = head[:-1], [row[:-1] for row in rows]
        print_table(mechanism.name, head, rows, right=(0, *range(2, 2 + len(names))))
    else:
        typer.echo(mechanism.name)
    if all(one.what.kind == STATIONARY for one in found.found):
        typer.echo("no limit, dead point, change point or tangency")
    for k, (circuit, reach) in enumerate(zip(found.branches.circuits, found.reach, strict=True)):
        how = how_it_ends(circuit.closed, circuit.ended, circuit.turns)
        typer.echo(f"branch {k + 1}: {how}; range of {intervals(mechanism, result.interval(reach), circuit.turns)}")
    if not found.complete:
        typer.echo("there are more branches than were followed")


def _rates(result: SingularitiesResult, one: Found) -> str:
    """Return, for every branch, the members whose rates differ most between branches."""
    tangents = result.tangents(one)
    free = ["more than one freedom in this position"] * one.what.loose
    if not tangents:
        return "".join(free)
    names = list(tangents[0].members)
    spread = {n: max(t.members[n] for t in tangents) - min(t.members[n] for t in tangents) for n in names}
    least = ALIKE * max(spread.values(), default=0.0)
    chosen = [n for n in sorted(names, key=lambda n: -spread[n])[:MEMBERS] if spread[n] > least] or names[:MEMBERS]
    lines = [
        ("with the input at rest: " if t.rests else "") + ", ".join(f"{n} {t.members[n]:+.6g}" for n in chosen)
        for t in tangents
    ]
    return "\n".join(lines + free)
