"""`gim fit`: dimensions for which the motion passes targets."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import INPUTS, METHOD, MODEL, NONE, Assembly, Json, ModelPath, Out, Png, Seconds, Set
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.library.fit_result import FitResult

TARGETS = "Targets"


class TargetTiming(StrEnum):
    """What is known of the inputs of the targets."""

    FREE = "free"
    GIVEN = "given"
    STEP = "step"


HELP = (
    "The targets are a CSV file with a header: x,y (places of a point), x,y,x2,y2 (pairs of places), x,y,angle (poses"
    " of a member) or input,output (a function). The fitted motion passes them in order, on one branch, over the whole"
    " law of the input; this is checked on its trace. Writes MODEL.fit.csv and .png; -o fitted.yaml writes the model."
)
EXAMPLES = (
    "gim fit examples/four_bar.yaml --vary r2=1:3 --through examples/arc.csv",
    "gim fit MODEL --vary a=5:60 --vary b=5:60 --through t.csv -o fitted.yaml",
    "gim fit MODEL --vary a=5:60 --through f.csv --output rocker.angle",
)


@with_picture_options
def command(
    model: ModelPath = MODEL,
    assembly: Assembly = "",
    set_: Set = NONE,
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary", metavar="NAME=LOW:HIGH", help="Dimension to fit and its bounds; repeatable.",
            rich_help_panel=INPUTS,
        ),
    ] = NONE,
    through: Annotated[
        Path | None,
        typer.Option("--through", metavar="FILE", help="CSV file of targets.", rich_help_panel=TARGETS),
    ] = None,
    timing: Annotated[
        TargetTiming | None,
        typer.Option(
            "--timing", metavar="WORD", rich_help_panel=TARGETS,
            help="Inputs of the targets: free (unknown), given, or step (their differences are given).",
        ),
    ] = None,
    point: Annotated[
        str,
        typer.Option(
            "--point", "-p", metavar="NAME", help="Node or point; default: the first of `trace`.",
            rich_help_panel=TARGETS,
        ),
    ] = "",
    output: Annotated[
        str,
        typer.Option("--output", metavar="NAME", help="Output of a function: rocker.angle, P.x.",
                     rich_help_panel=TARGETS),
    ] = "",
    goal: Annotated[
        str,
        typer.Option("--goal", metavar="TEXT", help="Quantity that is least, instead of targets: -range(P.y).",
                     rich_help_panel=TARGETS),
    ] = "",
    where: Annotated[
        list[str],
        typer.Option("--where", metavar="TEXT", help="Condition: range(P.y) > 40; repeatable.",
                     rich_help_panel=TARGETS),
    ] = NONE,
    any_order: Annotated[
        bool, typer.Option("--any-order", help="The targets may follow in any order.", rich_help_panel=TARGETS)
    ] = False,
    starts: Annotated[
        int, typer.Option("--starts", metavar="N", min=1, help="Number of random designs.", rich_help_panel=METHOD)
    ] = 25_000,
    seed: Annotated[
        int, typer.Option("--seed", metavar="N", min=0, help="Seed of the random designs.", rich_help_panel=METHOD)
    ] = 0,
    seconds: Seconds = None,
    out: Out = NONE,
    png: Png = True,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:  # fmt: skip
    """Fit dimensions."""
    from gimcli.cli.console import note
    from gimcli.cli.outputs import Outputs
    from gimcli.cli.progress import progress_bar
    from gimcli.library.fit import fit
    from gimcli.library.fit_result import FitResult

    outputs = Outputs(FitResult, model, out, writes=True, picture=png, as_json=as_json, drawing=drawing)
    bounds = _bounds(vary)
    outputs.files.refuse(() if through is None else (through,))
    found = fit(
        outputs.loaded(assembly, changes=set_), bounds, through, timing=timing.value if timing else "", point=point,
        output=output, goal=goal, where=where, any_order=any_order, starts=starts, seed=seed,
        notify=note, progress=progress_bar, seconds=seconds,
    )  # fmt: skip
    outputs.finish(found, _print)


def _bounds(given: list[str]) -> dict[str, tuple[float, float]]:
    """Return the bounds of --vary by the names of the dimensions."""
    bounds: dict[str, tuple[float, float]] = {}
    for text in given:
        name, equals, values = text.partition("=")
        try:
            low, high = map(float, values.split(":"))
        except ValueError:
            equals = ""
        if not equals:
            raise UsageError(f"--vary {text}: expected NAME=LOW:HIGH, such as a=10:60")
        if name in bounds:
            raise UsageError(f"--vary {text}: '{name}' already has bounds; give them once")
        bounds[name] = low, high
    return bounds


def _print(result: FitResult) -> None:
    from gimcli.cli.console import print_table
    from gimcli.library.rounding import number
    from gimcli.table import labelled

    typer.echo(result.headline())
    if result._found is None:
        return
    rows = [(name, f"{value:.12g}") for name, value in result.dimensions.items()]
    print_table("", ("dimension", "value"), rows, right=(1,))
    if result.kind != "goal":
        table = result.table()
        heads = [labelled(column.name, column.unit) for column in table.columns]
        cells = [[number(float(v)) for v in column.values] for column in table.columns]
        print_table("", heads, zip(*cells, strict=True), right=range(len(heads)))
    for line in result.checks():
        typer.echo(line)
    counts, what = result.counts, "goal" if result.kind == "goal" else "error"
    hits = f"{counts.hits} {'fit has' if counts.hits == 1 else 'fits have'}"
    typer.echo(
        f"{hits} this {what}; {counts.started} of {counts.drawn} random designs were refined (seed {counts.seed})"
    )
