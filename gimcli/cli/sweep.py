"""`gim sweep`: many designs of a mechanism."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import (
    INPUTS,
    METHOD,
    MODEL,
    NONE,
    Assembly,
    Json,
    ModelPath,
    Out,
    Png,
    Set,
    Tolerance,
    pairs,
)
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.library.sweep import SweepResult

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


class Points(StrEnum):
    """Kinds of samples."""

    RANDOM = "random"
    LATIN = "latin"
    SOBOL = "sobol"


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary", metavar="NAME=VALUES", rich_help_panel=DESIGNS,
            help="FIRST:LAST:COUNT, a list, uniform(LOW,HIGH) or normal(MEAN,SD); repeatable.",
        ),
    ] = NONE,
    designs: Annotated[
        Path | None, typer.Option("--designs", metavar="CSV", rich_help_panel=DESIGNS,
                                  help="Designs in their order: a column for each dimension.")
    ] = None,
    samples: Annotated[
        int | None, typer.Option("--samples", metavar="N", help="Designs drawn from distributions.",
                                 rich_help_panel=DESIGNS, min=1, max=10_000_000)
    ] = None,
    points: Annotated[
        Points, typer.Option("--points", metavar="KIND", help="random (default), latin or sobol.",
                             rich_help_panel=DESIGNS, show_default=False)
    ] = Points.RANDOM,
    seed: Annotated[int, typer.Option("--seed", metavar="S", help="Seed of the sample.", min=0,
                                      rich_help_panel=DESIGNS)] = 0,
    steps: Annotated[
        int, typer.Option("--steps", "-n", metavar="N", min=1, max=10_000_000, help="Steps of each motion.",
                          rich_help_panel=INPUTS)
    ] = 72,
    assembly: Assembly = "",
    keep: Annotated[
        list[str],
        typer.Option("--keep", metavar="QUANTITY", rich_help_panel=KEPT,
                     help='Such as "range(P.y)", "min(transmission)", type; repeatable.'),
    ] = NONE,
    where: Annotated[str, typer.Option("--where", metavar="CONDITION", help='Such as "range(P.y) > 40".',
                                       rich_help_panel=KEPT)] = "",
    goal: Annotated[str, typer.Option("--goal", metavar="QUANTITY", help="Least in the best designs.",
                                      rich_help_panel=KEPT)] = "",
    best: Annotated[int, typer.Option("--best", metavar="N", help="Keep the N best by the goal; 0: all.",
                                      rich_help_panel=KEPT, min=0, max=10_000_000)] = 0,
    rows: Annotated[
        bool, typer.Option("--rows", help="Keep whole columns, such as P.x: a row for each step.", rich_help_panel=KEPT)
    ] = False,
    workers: Annotated[
        int, typer.Option("--workers", metavar="N", min=1, max=1024, help="Processes on this machine.",
                          rich_help_panel=METHOD)
    ] = 1,
    scheduler: Annotated[
        str, typer.Option("--scheduler", metavar="ADDRESS", help="Dask scheduler of a cluster.",
                          rich_help_panel=METHOD)
    ] = "",
    resume: Annotated[
        bool, typer.Option("--resume", help="Resume an interrupted sweep.", rich_help_panel=METHOD)
    ] = False,
    tolerance: Tolerance = 1e-10,
    out: Out = NONE,
    png: Png = True,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:  # fmt: skip
    """Sweep dimensions."""
    from gimcli.cli.console import note
    from gimcli.cli.outputs import Outputs
    from gimcli.cli.progress import progress_bar
    from gimcli.library.sweep import SweepResult, swept

    outputs = Outputs(SweepResult, model, out, writes=True, picture=png, as_json=as_json, drawing=drawing)
    given = pairs(vary, "--vary", "NAME=VALUES, such as crank.length=30:50:21")
    if designs is not None and given:
        raise UsageError("--designs: a list of designs; remove --vary")
    mechanism = outputs.loaded(assembly, tolerance=tolerance, changes=changes)
    tables = outputs.files.of("table", "arrays")
    folder = tables[0].with_suffix(".parts") if tables else None
    begun = swept(
        mechanism, designs or given, steps=steps, samples=samples, points=points.value, seed=seed, keep=keep,
        where=where, goal=goal, best=best, rows=rows, tolerance=tolerance, workers=workers, scheduler=scheduler,
        folder=folder, resume=resume, notify=note, progress=progress_bar,
    )  # fmt: skip
    begun.draws = outputs.draws
    try:
        found: SweepResult = outputs.stream(begun)
    except KeyboardInterrupt:
        _print_interrupted(begun.run.done, begun.job.chunks, folder)
        raise typer.Exit(130) from None
    begun.clear()
    outputs.show(found, _print)


def _print_interrupted(done: int, chunks: int, folder: Path | None) -> None:
    from gimcli.cli.progress import end_bars

    end_bars()
    kept = f", kept in {folder}; --resume continues" if folder is not None else ""
    typer.echo(f"gim: interrupted: {done} of {chunks} chunks are done{kept}", err=True)


def _print(found: SweepResult) -> None:
    from gimcli.cli.console import print_table
    from gimcli.library.result import cells
    from gimcli.library.rounding import number
    from gimcli.status import Status
    from gimcli.table import labelled

    typer.echo(found.headline())
    for word, count in found.counts.items():
        if word != Status.OK.word:
            typer.echo(f"{word}: {count}")
    rows = []
    for name, one in found.ranges.items():
        size = max(abs(one["least"]), abs(one["greatest"]))
        empty = str(one["empty"]) if one["empty"] else ""
        rows.append((labelled(name, one["unit"]), number(one["least"], size), number(one["greatest"], size), empty))
    print_table("", ("", "least", "greatest", "empty"), rows, (1, 2, 3))
    if found._found.best is not None:
        head, *best = cells(found._found.best)
        print_table("best designs", head, best, range(len(head) - 1))
