"""`gim sweep`: many designs of a mechanism."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from gimcli.cli.arguments import INPUTS, METHOD, pairs
from gimcli.cli.console import end_bars, print_records, print_remarks, print_table
from gimcli.cli.from_verb import Run, from_verb
from gimcli.errors import refuse
from gimcli.library.sweep import SweepResult, sweep
from gimcli.rounding import cells
from gimcli.status import Status

HELP = (
    "Solves all combinations of listed values, or a sample of distributions; writes one row for each design: its"
    " dimensions, what is kept, its status. Writes MODEL.sweep.csv and .png."
)
EXAMPLES = (
    "gim sweep crank_rocker --vary crank.length=30:50:5 -o sweep.csv",
    'gim sweep crank_rocker --vary crank.length=30,40 --keep "max(P.y)"',
    'gim sweep jansen --vary m=14:16:5 --goal "-range(foot.x)" --best 3',
)
DESIGNS, KEPT = "Designs", "Kept quantities"


def _run(run: Run) -> Any:
    """Solve the designs; those that are done are kept beside the table until it is complete."""
    designs = run.switches.pop("designs")
    refuse((designs is not None and run.arguments["vary"], "--designs: a list of designs; remove --vary"))
    run.arguments["vary"] = designs or run.arguments["vary"]
    tables = run.outputs.files.of("table", "arrays")
    folder = run.arguments["folder"] = tables[0].with_suffix(".parts") if tables else None
    begun = run.found()
    begun.draws = run.outputs.draws
    try:
        found = run.outputs.stream(begun)
    except KeyboardInterrupt:
        _print_interrupted(begun.done, begun.job.chunks, folder)
        raise typer.Exit(130) from None
    begun.clear()
    return found


def _print_interrupted(done: int, chunks: int, folder: Path | None) -> None:
    end_bars()
    kept = f", kept in {folder}; --resume continues" if folder is not None else ""
    typer.echo(f"gim: interrupted: {done} of {chunks} chunks are done{kept}", err=True)


def _print(found: SweepResult) -> None:
    print_remarks(found.headline(), *(f"{word}: {n}" for word, n in found.counts.items() if word != Status.OK.word))
    print_records("", found._spans)
    if found._found.best is not None:
        head, *best = cells(found._found.best)
        print_table("best designs", head, best, range(len(head) - 1))


OPTIONS = {
    "vary": typer.Option(
        "--vary", metavar="NAME=VALUES", rich_help_panel=DESIGNS,
        help="FIRST:LAST:COUNT, a list, uniform(LOW,HIGH) or normal(MEAN,SD); repeatable.\n"
        "Values of a dimension, such as `10:20:21` (21 values from 10 to 20), `3,4,5`, `uniform(10,20)` or"
        " `normal(40,0.05)` (mean and standard deviation). Of listed values all combinations are solved.",
    ),
    "samples": typer.Option(
        "--samples", metavar="N", rich_help_panel=DESIGNS
    ),
    "points": typer.Option(
        "--points", metavar="KIND", rich_help_panel=DESIGNS, show_default=False,
        help="random (default), latin or sobol.\nHow samples are drawn; `latin`: a Latin hypercube.",
    ),
    "seed": typer.Option("--seed", metavar="S", rich_help_panel=DESIGNS),
    "steps": typer.Option("--steps", "-n", metavar="N", rich_help_panel=INPUTS),
    "keep": typer.Option(
        "--keep", metavar="QUANTITY", rich_help_panel=KEPT,
        help='Such as "range(P.y)", "min(transmission)", type; repeatable.\n'
        'Or with commas. By default the ranges of the'
        " traced points, and `solved`.",
    ),
    "where": typer.Option("--where", metavar="CONDITION", rich_help_panel=KEPT),
    "goal": typer.Option("--goal", metavar="QUANTITY", rich_help_panel=KEPT),
    "best": typer.Option("--best", metavar="N", rich_help_panel=KEPT),
    "rows": typer.Option(
        "--rows", help="Keep whole columns, such as P.x: a row for each step.", rich_help_panel=KEPT
    ),
    "workers": typer.Option("--workers", metavar="N", rich_help_panel=METHOD),
    "scheduler": typer.Option("--scheduler", metavar="ADDRESS", rich_help_panel=METHOD),
    "resume": typer.Option(
        "--resume", help="Resume an interrupted sweep.\nWith the same model and options.", rich_help_panel=METHOD
    ),
}  # fmt: skip
LISTED = typer.Option(
    "--designs", metavar="CSV", rich_help_panel=DESIGNS,
    help="Designs in their order: a column for each dimension.\n"
    "Instead of `--vary`; the first row of the file has names.",
)  # fmt: skip
command = from_verb(
    sweep, SweepResult, _print, OPTIONS, writes=True, extra={"designs": Annotated[Path | None, LISTED]}, run=_run,
    read={"vary": partial(pairs, option="--vary", form="NAME=VALUES, such as crank.length=30:50:21")},
)  # fmt: skip
