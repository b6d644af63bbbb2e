"""`gim workspace`: the region or the paths that a point can reach."""

from __future__ import annotations

from functools import partial
from typing import Any

import typer

from gimcli.cli.arguments import INPUTS, pairs
from gimcli.cli.console import print_records, print_remarks, print_table
from gimcli.cli.from_verb import Run, from_verb
from gimcli.library.workspace import WorkspaceResult, workspace
from gimcli.mechanism import Mechanism
from gimcli.rounding import at_inputs

HELP = (
    "With two or more inputs it finds the region that a point reaches in all assemblies, its boundary, holes and inner"
    " curves; with one input it finds the paths of the initial configuration, or of all assemblies, and the range of"
    " the input. The range of an input is that of its law; a rotary input without a law turns fully. Writes"
    " MODEL.workspace.csv and .png."
)
EXAMPLES = (
    "gim workspace five_bar --point P --grid 400 -o results/",
    "gim workspace platform_3rpr --point M --orientation platform=0",
)
GRID = "Grid"


def _run(run: Run) -> Any:
    """Find a workspace; the parts of a grid are kept beside its file until it is complete."""
    if run.arguments["grid"]:
        run.files["more"] = [".npz"]
        arrays = run.outputs.files.of("arrays")
        run.arguments["folder"] = arrays[0].with_suffix(".parts") if arrays else None
    found = run.written()
    if found._grid is not None:
        found._grid.clear()
    return found


HELD = partial(
    pairs, option="--orientation", form="MEMBER=ANGLE, such as platform=0", what="an angle; give it", read=float
)


def _print(result: WorkspaceResult) -> None:
    report = result.report()
    (_print_paths if "paths" in report else _print_region)(result, report)
    if "grid" in report:
        grid = report["grid"]
        typer.echo(
            f"grid: {grid['positions']} combinations of inputs, {grid['reached']} can be assembled;"
            f" {grid['solved']} positions solved in {grid['configurations']} configurations"
        )


def _print_region(result: WorkspaceResult, report: dict[str, Any]) -> None:
    names = ("area", "bounds", "regions", "holes", "perimeter", "barriers")
    print_table(result.headline(), ("", ""), result._facts.pairs(*names))
    print_records("", result._records)
    whole, regions = report["complete"], report["regions"]
    print_remarks(
        (not regions and whole, "the region is a single point: the mechanism can be assembled in one position only"),
        (not regions and not whole, "no boundary was found"),
        (regions and not whole, "the boundary is not complete: a curve is missing or could not be classified"),
    )


def _print_paths(result: WorkspaceResult, report: dict[str, Any]) -> None:
    print_records(result.headline(), result._records, "path", "x", "y", "length", "inputs")
    every, whole = report["all"], report["complete"]
    print_remarks(
        (any(path["drawn"] for path in report["paths"]), "*: the path of the initial configuration"),
        (not every, "" if every else _left_out(result.mechanism, report["assemblies"])),
        (not every and not whole, "there may be more: a path, or a path that crosses it, was not followed to its end"),
        (
            every and not whole,
            "there may be more paths: at some input values the list of configurations is not proved complete, or a"
            " configuration is on no path",
        ),
    )


def _left_out(mechanism: Mechanism, found: dict[str, Any]) -> str:
    """Return in words how many assemblies at the start of the law are on other paths."""
    count, left, where = found["count"], found["left_out"], at_inputs(mechanism, found["at"])
    if count is None:
        return "other assemblies were not counted and are left out: --all has them"
    least = "" if found["complete"] else "at least "
    if not left:
        return f"no other assembly{'' if found['complete'] else ' was found'} at {where}; --all also searches elsewhere"
    return f"left out: {least}{left} of {count} assemblies at {where}; --all has them"


OPTIONS = {
    "point": typer.Option(
        "--point", "-p", metavar="NAME", rich_help_panel=INPUTS
    ),
    "orientation": typer.Option(
        "--orientation", metavar="MEMBER=ANGLE", rich_help_panel=INPUTS,
        help="Keep a member's direction; repeatable.\n"
        "From its first to its second node, such as `platform=0`, in the file's unit of angles.",
    ),
    "every": typer.Option("--all", rich_help_panel=INPUTS),
    "grid": typer.Option(
        "--grid", metavar="N", rich_help_panel=GRID,
        help="Also solve N values of every input in all combinations, for an .npz file.",
    ),
    "resume": typer.Option(
        "--resume", help="Resume an interrupted --grid.\nWith the same model and options.", rich_help_panel=GRID
    ),
}  # fmt: skip
command = from_verb(workspace, WorkspaceResult, _print, OPTIONS, writes=True, read={"orientation": HELD}, run=_run)
