"""`gim fit`: dimensions for which the motion passes targets."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from gimcli.cli.arguments import INPUTS, METHOD, pairs
from gimcli.cli.console import print_records, print_remarks
from gimcli.cli.from_verb import Run, from_verb
from gimcli.library.fit import fit
from gimcli.library.fit_result import FitResult

TARGETS = "Targets"


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


def _run(run: Run) -> Any:
    """Fit dimensions; the file of targets is not overwritten."""
    run.outputs.files.refuse([run.arguments["through"]] if "through" in run.arguments else ())
    return run.written()


def _bounds(text: str) -> tuple[float, float]:
    """Return the bounds of a dimension."""
    low, high = map(float, text.split(":"))
    return low, high


VARIED = partial(pairs, option="--vary", form="NAME=LOW:HIGH, such as a=10:60", what="bounds; give them", read=_bounds)


def _print(result: FitResult) -> None:
    typer.echo(result.headline())
    if result._found is None:
        return
    print_records("", result._design)
    if result.kind != "goal":
        print_records("", result._records)
    counts, what = result._counts, "goal" if result.kind == "goal" else "error"
    hits = f"{counts.hits} {'fit has' if counts.hits == 1 else 'fits have'}"
    print_remarks(
        *result.checks(),
        f"{hits} this {what}; {counts.started} of {counts.drawn} random designs were refined (seed {counts.seed})",
    )


OPTIONS = {
    "vary": typer.Option(
        "--vary", metavar="NAME=LOW:HIGH", rich_help_panel=INPUTS,
        help="Dimension to fit and its bounds; repeatable.\n"
        "A [dimension](model-file.md#dimensions) of the file, in its units.",
    ),
    "through": Annotated[Path | None, typer.Option(
        "--through", metavar="FILE", rich_help_panel=TARGETS,
        help="CSV file of targets.\n"
        "The names in its first row say what they are, see [targets](fit.md#targets).",
    )],
    "timing": typer.Option(
        "--timing", metavar="WORD", rich_help_panel=TARGETS,
        help="Inputs of the targets: free (unknown), given, or step (their differences are given).\n"
        "Default: `given` if there is a column `input`, else `free`.",
    ),
    "point": typer.Option(
        "--point", "-p", metavar="NAME", rich_help_panel=TARGETS
    ),
    "output": typer.Option(
        "--output", metavar="NAME", rich_help_panel=TARGETS
    ),
    "goal": typer.Option(
        "--goal", metavar="TEXT", rich_help_panel=TARGETS
    ),
    "where": typer.Option(
        "--where", metavar="TEXT", rich_help_panel=TARGETS,
        help="Condition: range(P.y) > 40; repeatable.\n"
        "In the form of `gim sweep`, also `type == 'crank-rocker'`. Inequalities can be active.",
    ),
    "any_order": typer.Option(
        "--any-order", rich_help_panel=TARGETS
    ),
    "starts": typer.Option("--starts", metavar="N", rich_help_panel=METHOD),
    "seed": typer.Option("--seed", metavar="N", rich_help_panel=METHOD),
}  # fmt: skip
command = from_verb(fit, FitResult, _print, OPTIONS, writes=True, run=_run, read={"vary": VARIED})
