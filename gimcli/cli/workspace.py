"""`gim workspace`: the region or the paths that a point can reach."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import typer

from gimcli.cli.arguments import INPUTS, pairs
from gimcli.cli.console import print_table
from gimcli.cli.from_verb import Run, from_verb
from gimcli.library.workspace import WorkspaceResult, workspace
from gimcli.mechanism import Mechanism
from gimcli.rounding import at_inputs, interval, length, number
from gimcli.table import labelled

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
    if found.grid is not None:
        found.grid.clear()
    return found


def _angle(text: str) -> float:
    """Return a direction [file's angle unit]."""
    if not math.isfinite(angle := float(text)):
        raise ValueError(text)
    return angle


HELD = partial(
    pairs, option="--orientation", form="MEMBER=ANGLE, such as platform=0", what="an angle; give it", read=_angle
)


def _print(result: WorkspaceResult) -> None:
    mechanism, report = result.mechanism, result.report()
    if "paths" in report:
        _print_paths(mechanism, report)
    else:
        _print_region(mechanism, report)
    if "grid" in report:
        grid = report["grid"]
        typer.echo(
            f"grid: {grid['positions']} combinations of inputs, {grid['reached']} can be assembled;"
            f" {grid['solved']} positions solved in {grid['configurations']} configurations"
        )


def _print_region(mechanism: Mechanism, report: dict[str, Any]) -> None:
    unit = "" if mechanism.length_unit == "unit" else f" {mechanism.length_unit}"
    square = f"{unit}^2" if unit else ""
    size = mechanism.size * mechanism.scale
    spans = ", ".join(
        f"{k} {length(mechanism, low)} to {length(mechanism, high)}{unit}"
        for k, (low, high) in report["bounds"].items()
    )
    rows = [
        ("area", f"{number(report['area'], size**2)}{square} (estimated error {report['area_error']:.0e})"),
        ("extent", spans),
        ("regions", str(report["regions"])),
        ("holes", str(report["holes"])),
        ("length of the boundary", f"{length(mechanism, report['perimeter'])}{unit}"),
        ("inner curves", str(report["barriers"])),
    ]
    print_table(f"{mechanism.name}: workspace of {report['point']}", ("", ""), rows)
    heads = ("curve", "kind", "cause", labelled("length", mechanism.length_unit))
    ends = [("range ends: " + at_inputs(mechanism, c["held"])) if c["held"] else "singular" for c in report["curves"]]
    curves = [
        (str(k), c["kind"], end, length(mechanism, c["length"]))
        for k, (c, end) in enumerate(zip(report["curves"], ends, strict=True))
    ]
    if curves:
        print_table("", heads, curves, right=(0, 3))
    if not report["regions"] and report["complete"]:
        typer.echo("the region is a single point: the mechanism can be assembled in one position only")
    elif not report["regions"]:
        typer.echo("no boundary was found")
    elif not report["complete"]:
        typer.echo("the boundary is not complete: a curve is missing or could not be classified")


def _print_paths(mechanism: Mechanism, report: dict[str, Any]) -> None:
    rows = []
    for k, path in enumerate(report["paths"]):
        inputs = [
            f"{n}: {'full turn' if i['full_turn'] else interval(mechanism, n, i['from'], i['to'])}"
            for n, i in path["inputs"].items()
        ]
        spans = [f"{length(mechanism, a)} to {length(mechanism, b)}" for a, b in path["bounds"].values()]
        rows.append(
            (f"{k}{' *' if path['drawn'] else ''}", *spans, length(mechanism, path["length"]), ", ".join(inputs))
        )
    heads = ("path", *(labelled(what, mechanism.length_unit) for what in ("x", "y", "length")), "inputs")
    print_table(f"{mechanism.name}: workspace of {report['point']}", heads, rows, right=(3,))
    if any(path["drawn"] for path in report["paths"]):
        typer.echo("*: the path of the initial configuration")
    if not report["all"]:
        typer.echo(_left_out(mechanism, report["assemblies"]))
        if not report["complete"]:
            typer.echo("there may be more: a path, or a path that crosses it, was not followed to its end")
    elif not report["complete"]:
        typer.echo(
            "there may be more paths: at some input values the list of configurations is not proved complete, or a"
            " configuration is on no path"
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
