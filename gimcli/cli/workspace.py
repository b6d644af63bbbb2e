"""`gim workspace`: what a point reaches."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import MODEL, Jit, JitOption, Json, ModelPath
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.mechanism import ComplexArray, Mechanism
    from gimcli.motion.scatter import Scatterer
    from gimcli.reach.boundary import Workspace
    from gimcli.reach.reach import Reach

NAME = "workspace"
HELP = (
    "Find what a point reaches, over all configurations: for two or more inputs the region, its boundary, holes and"
    " inner curves on which some configuration is held back, traced by continuation; for one input the paths, their"
    " extent and the interval of the input. Writes the curves as CSV and PNG.\n\n"
    "An input's range is that of its law; a rotary input without a law, or over a full turn, is free. --orientation"
    " keeps a member's direction (first -> second node): the workspace of a platform at that orientation. --grid also"
    " solves N values of every input in all combinations and writes the reached places as NPZ.\n\n"
    "Example: gim workspace models/five_bar.yaml --point P --grid 400\n\n"
    "Example: gim workspace models/platform_3rpr.yaml --point M --orientation platform=0"
)

UNSOLVED = 5


def command(
    model: ModelPath = MODEL,
    point: Annotated[str, typer.Option("--point", "-p", help="Node or point; default: the first of `trace`.")] = "",
    orientation: Annotated[
        list[str],
        typer.Option("--orientation", metavar="MEMBER=ANGLE", help="Keep a member's direction; may be repeated."),
    ] = [],  # noqa: B006 - typer wants a list; nothing changes it
    grid: Annotated[int, typer.Option("--grid", min=0, help="Values of every input to solve; 0: none.")] = 0,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the --grid of an interrupted run.")] = False,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder to write into.")] = Path(),
    png: Annotated[bool, typer.Option("--png/--no-png", help="Draw the picture.")] = True,
    jit: JitOption = Jit.AUTO,
    as_json: Json = False,
) -> None:
    """Find a workspace."""
    from gimcli.errors import StructureError
    from gimcli.model import load
    from gimcli.output import refuse_unwritable
    from gimcli.structure.drive_check import explained
    from gimcli.structure.plan import make_plan

    mechanism = load(model)
    name = _point(mechanism, point)
    held = _orientations(mechanism, orientation)
    if resume and not grid:
        raise UsageError("--resume goes on with a grid: add --grid N as before")
    if grid and held:
        raise UsageError("--grid spaces the inputs evenly, which --orientation does not leave free: choose one of them")
    with explained(mechanism):
        make_plan(mechanism)
    if not mechanism.actuators:
        raise StructureError(f"{mechanism.name} has no actuator: nothing moves; add one")
    stem = out / f"{model.stem}.workspace"
    files = {kind: stem.with_name(f"{stem.name}.{kind}") for kind in ("csv", "png", "npz")}
    refuse_unwritable(
        mechanism.files, files["csv"], *([files["png"]] if png else []), *([files["npz"]] if grid else [])
    )
    report, complete = _answer(mechanism, name, held, model, files, (grid, resume, jit.value), png)
    _tell(mechanism, report, as_json)
    if not complete:
        raise typer.Exit(UNSOLVED)


def _answer(
    mechanism: Mechanism, name: str, held: dict[str, float], model: Path, files: dict[str, Path],
    asked: tuple[int, bool, str], png: bool,
) -> tuple[dict[str, Any], bool]:  # fmt: skip
    """Do the work, write the files and return the report."""
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.output import write
    from gimcli.reach.boundary import survey, task_of
    from gimcli.reach.reach import reach
    from gimcli.reach.report import reach_report, reach_table, region_report, region_table

    freedoms = task_of(mechanism, name, held).freedoms
    grid: dict[str, Any] = {}
    places = _scatter(mechanism, name, model, files["npz"], asked, grid) if asked[0] else None
    found: Workspace | Reach
    if freedoms == 1:
        found = reach(mechanism, name, held, progress_bar("configurations and their circuits"))
        report, table = reach_report(found), reach_table(found)
    else:
        found = survey(mechanism, name, held, progress_bar("curves"))
        report, table = region_report(found), region_table(found)
    write(table, files["csv"])
    if png:
        progress_bar(DRAWING)
        _draw(found, places, files["png"])
    report |= {"csv": str(files["csv"]), "png": str(files["png"]) if png else None} | grid
    return report, bool(report["complete"])


def _point(mechanism: Mechanism, given: str) -> str:
    """Return the point asked for, or the first that is traced."""
    import difflib

    names = [*mechanism.nodes, *(p.name for p in mechanism.points)]
    if not given:
        return mechanism.traced[0]
    if given not in names:
        near = difflib.get_close_matches(given, names, 1)
        hint = f"; did you mean '{near[0]}'?" if near else f"; nodes and points: {', '.join(names)}"
        raise UsageError(f"--point {given}: no such node or point{hint}")
    return given


def _orientations(mechanism: Mechanism, given: list[str]) -> dict[str, float]:
    """Return the members whose direction is held, and the angles [rad]."""
    import math

    held: dict[str, float] = {}
    for text in given:
        name, equals, number = text.partition("=")
        try:
            angle = float(number)
        except ValueError:
            angle = math.nan
        if not equals or not math.isfinite(angle):
            raise UsageError(f"--orientation {text}: write MEMBER=ANGLE, such as platform=0")
        if name in held:
            raise UsageError(f"--orientation {text}: '{name}' has an angle already; give it once")
        held[name] = math.radians(angle) if mechanism.angle_unit == "deg" else angle
    return held


def _scatter(
    mechanism: Mechanism, name: str, model: Path, path: Path, asked: tuple[int, bool, str], report: dict[str, Any]
) -> ComplexArray:
    """Solve a grid of inputs part by part, write it, and return the places in the file's coordinates."""
    import numpy as np

    from gimcli.cli.console import note
    from gimcli.cli.progress import progress_bar
    from gimcli.motion.scatter import Scatterer, readied, scattered
    from gimcli.output import Parts, write_npz
    from gimcli.reach.grid import carried_by, input_grid

    count, resume, jit = asked
    job = readied(Scatterer(mechanism, carried_by(mechanism, name), input_grid(mechanism, count)), jit, note)
    parts = Parts(path.with_suffix(".parts"), _header(job, model, name), resume)
    done, progress = parts.done, progress_bar("positions")
    kept = len(done)
    for k, values in scattered(job, [k for k in range(job.parts) if k not in done]):
        parts.put(k, values)
        kept += 1
        progress(kept, job.parts)
    z = np.concatenate([parts.get(k) for k in range(job.parts)], axis=1)
    places = mechanism.to_file(z).reshape(len(z), *job.grid.counts)
    axes = {a.name: mechanism.value_to_file(k, job.grid.axis(k)) for k, a in enumerate(mechanism.actuators)}
    write_npz({"x": places.real, "y": places.imag, **{f"input_{n}": v for n, v in axes.items()}}, path)
    parts.clear()
    report["npz"] = str(path)
    report["grid"] = {
        "positions": job.grid.rows, "configurations": len(z), "solved": int(np.isfinite(z).sum()),
        "reached": int(np.isfinite(z).any(axis=0).sum()), "resumed_parts": len(done), "parts": job.parts,
    }  # fmt: skip
    return places.ravel()


def _header(job: Scatterer, model: Path, name: str) -> dict[str, Any]:
    """Return what parts of a grid belong to: the model's contents, its laws' ranges, and the options."""
    import hashlib

    from gimcli import __version__

    return {
        "version": __version__, "model": hashlib.sha256(model.read_bytes()).hexdigest(), "point": name,
        "grid": job.grid.count, "low": job.grid.low.tolist(), "high": job.grid.high.tolist(),
        "configurations": len(job.sides), "positions a part": job.part,
    }  # fmt: skip


def _draw(found: Workspace | Reach, places: ComplexArray | None, path: Path) -> None:
    from gimcli.output import draw_paths, draw_workspace
    from gimcli.reach.reach import Reach
    from gimcli.reach.report import outlines, placed

    mechanism, name = found.task.mechanism, found.task.point
    pose, at = _pose(found.task)
    title = f"{mechanism.name}: what {name} reaches"
    if isinstance(found, Reach):
        paths = [placed(mechanism, run.points()) for run in found.runs]
        draw_paths(mechanism, pose, paths, (name, at), path, title)
    else:
        if not found.loops:  # nothing else would show what is reached
            reached = placed(mechanism, found.positions)
            at = complex(reached.mean()) if found.single is not None else at
            places = reached if places is None and found.single is None else places
        draw_workspace(mechanism, pose, outlines(found), (name, at), places, path, title)


def _pose(task: Any) -> tuple[ComplexArray | None, complex | None]:
    """Return an assembled pose next to the drawn one and where the point is in it; none where directions are held."""
    from gimcli.motion.coupler_points import carried_point
    from gimcli.structure.mobility import assembled

    mechanism = task.mechanism
    z = None if task.orientation else assembled(mechanism)
    if z is None:
        return None, None
    return mechanism.to_file(z), complex(mechanism.to_file(carried_point(mechanism, task.point, z[:, None]))[0])


def _tell(mechanism: Mechanism, report: dict[str, Any], as_json: bool) -> None:
    from gimcli.cli.console import print_json, tell_written

    if as_json:
        print_json(report)
        return
    if "paths" in report:
        _tell_paths(mechanism, report)
    else:
        _tell_region(mechanism, report)
    if "grid" in report:
        grid = report["grid"]
        typer.echo(
            f"grid: {grid['positions']} inputs in {grid['configurations']} configurations,"
            f" {grid['reached']} can be assembled; {grid['solved']} positions solved"
        )
    tell_written(*(report.get(kind) for kind in ("csv", "png", "npz")))


def _tell_region(mechanism: Mechanism, report: dict[str, Any]) -> None:
    from gimcli.cli.console import number, print_table

    unit = "" if mechanism.length_unit == "unit" else f" {mechanism.length_unit}"
    square = f"{unit}^2" if unit else ""
    spans = ", ".join(f"{k} {v[0]:.8g} to {v[1]:.8g}{unit}" for k, v in report["bounds"].items())
    rows = [
        ("area", f"{number(report['area'])}{square} (estimated error {report['area_error']:.0e})"),
        ("reaches", spans),
        ("regions, holes", f"{report['regions']}, {report['holes']}"),
        ("length of the edge", f"{number(report['perimeter'])}{unit}"),
        ("inner curves", str(report["barriers"])),
    ]
    print_table(f"{mechanism.name}: what {report['point']} reaches", ("", ""), rows)
    heads = ("curve", "kind", "inputs at an end", f"length{f' [{unit.strip()}]' if unit else ''}")
    ends = [", ".join(f"{n} = {v:.8g}" for n, v in c["held"].items()) or "singular" for c in report["curves"]]
    curves = [
        (str(k), c["kind"], end, number(c["length"]))
        for k, (c, end) in enumerate(zip(report["curves"], ends, strict=True))
    ]
    print_table("", heads, curves, right=(0, 3))
    if not report["regions"] and report["complete"]:
        typer.echo("a single place is reached: the ranges of the inputs only just meet")
    elif not report["regions"]:
        typer.echo("no boundary was found: nothing seems to hold the point back")
    elif not report["complete"]:
        typer.echo("the boundary is not complete: some curve was not found or could not be sorted")


def _tell_paths(mechanism: Mechanism, report: dict[str, Any]) -> None:
    from gimcli.cli.console import number, print_table

    unit = "" if mechanism.length_unit == "unit" else f" [{mechanism.length_unit}]"
    rows = []
    for k, path in enumerate(report["paths"]):
        inputs = [
            f"{n} {'turns fully' if i['full_turn'] else f'''{i['from']:.10g} to {i['to']:.10g}'''}"
            for n, i in path["inputs"].items()
        ]
        spans = [f"{a:.8g} to {b:.8g}" for a, b in path["bounds"].values()]
        rows.append((str(k), "drawn" if path["drawn"] else "", *spans, number(path["length"], 8), ", ".join(inputs)))
    heads = ("path", "", f"x{unit}", f"y{unit}", f"length{unit}", "inputs")
    print_table(f"{mechanism.name}: what {report['point']} reaches", heads, rows, right=(0, 4))
    if not report["complete"]:
        typer.echo(
            "there may be more paths: at some values of the input not all configurations are proved to be known, or one"
            " of them lies on no path"
        )
