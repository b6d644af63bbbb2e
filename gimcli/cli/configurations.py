"""What `gim solve --all` prints and writes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from gimcli.assemblies import Configurations
    from gimcli.mechanism import FloatArray, Mechanism

COLUMNS = 3
"""Traced points whose places stand in the table, where there is room for them."""

BESIDE, EACH = 45, 28
"""Characters of a table's line beside the places, and of a place."""

ROWS = 60
"""Configurations that the table shows; --json and --csv hold all."""


PANELS = 36
"""Configurations that one picture has room for."""


def solve_all(
    mechanism: Mechanism, inputs: FloatArray, tolerance: float, csv: Path | None, png: Path | None, as_json: bool
) -> None:
    """Find every configuration at inputs (actuators,), print and write it; exit with 5 where there is none."""
    from gimcli.assemblies import ConfigurationConstants, all_configurations, drawn_configuration
    from gimcli.cli.console import tell_written
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.output import refuse_files
    from gimcli.structure.drive_check import explained

    refuse_files(mechanism.files, csv, png)
    with explained(mechanism):
        found = all_configurations(
            mechanism, inputs, ConfigurationConstants(fits=tolerance), progress_bar("configurations")
        )
    drawn = drawn_configuration(found)
    places = _places(found)
    if csv is not None:
        _write_csv(found, places, csv)
    if png is not None:
        progress_bar(DRAWING)
    undrawn = _write_png(found, drawn, png) if png is not None and len(found) else 0
    paths = {"csv": csv, "png": png if len(found) else None}
    if as_json:
        _print_json(found, drawn, places, paths)
    else:
        _print(found, drawn, places)
        tell_written(*paths.values())
        if undrawn:
            typer.echo(f"{png} shows the first {len(found) - undrawn}; {undrawn} are not drawn")
    if not len(found):
        raise typer.Exit(5)


def _places(found: Configurations) -> dict[str, Any]:
    """Return nodes, then points, as (configurations,) places in the file's units."""
    from gimcli.motion.coupler_points import carried_point

    mechanism = found.mechanism
    names = [*mechanism.nodes, *(p.name for p in mechanism.points)]
    return {n: mechanism.to_file(carried_point(mechanism, n, found.z.T)) for n in names}


def _inputs(found: Configurations) -> dict[str, float]:
    mechanism = found.mechanism
    return {
        a.name: float(mechanism.value_to_file(k, found.inputs[k : k + 1])[0]) for k, a in enumerate(mechanism.actuators)
    }


def _print_json(
    found: Configurations, drawn: int | None, places: dict[str, Any], paths: dict[str, Path | None]
) -> None:
    from gimcli.cli.console import print_json

    mechanism = found.mechanism
    points = [p.name for p in mechanism.points]

    def pairs(names: Any, k: int) -> dict[str, list[float]]:
        return {n: [float(places[n][k].real), float(places[n][k].imag)] for n in names}

    print_json(
        {
            "complete": found.complete,
            "bound": found.bound,
            "configurations": [
                {
                    "residual": float(found.residual[k]), "nodes": pairs(mechanism.nodes, k),
                    "points": pairs(points, k), "assembly": found.signs[k], "radius": float(found.radius[k]),
                    "drawn": k == drawn,
                }
                for k in range(len(found))
            ],
            "level": found.level,
            "verdict": verdict(found),
            "unaccounted": found.missing,
            "groups": [
                {
                    "nodes": list(g.nodes), "loops": g.loops, "bound": g.count, "solved": g.solved, "complex": g.roots,
                    "real": g.real, "infinite": g.infinite, "multiple": g.doubtful, "unaccounted": g.missing,
                    "level": g.level,
                }
                for g in found.groups
            ],
            "surplus": list(found.surplus),
            "inputs": _inputs(found),
            **{kind: str(path) if path else None for kind, path in paths.items()},
        }
    )  # fmt: skip


def _print(found: Configurations, drawn: int | None, places: dict[str, Any]) -> None:
    import math

    from gimcli.cli.console import number, print_table, room
    from gimcli.cli.progress import end_bars

    end_bars()
    mechanism = found.mechanism
    at = ", ".join(f"{k} = {v:.10g}" for k, v in _inputs(found).items())
    typer.echo(f"{mechanism.name}" + (f" at {at}" if at else ""))
    typer.echo(verdict(found))
    if not len(found):
        return
    fit = max(1, min(COLUMNS, (room() - BESIDE) // EACH))
    shown = [n for n in mechanism.traced if n in places][:fit]
    unit = "" if mechanism.length_unit == "unit" else f" [{mechanism.length_unit}]"
    head = ["", "assembly", "residual", "proved within", *(f"{n}.{axis}{unit}" for n in shown for axis in "xy")]
    rows = []
    for k in range(min(len(found), ROWS)):
        radius = f"{found.radius[k]:.0e}" if math.isfinite(found.radius[k]) else "multiple"
        z = [number(part, 8) for n in shown for part in (places[n][k].real, places[n][k].imag)]
        mark = f"{k + 1}{' *' if k == drawn else ''}"
        rows.append((mark, found.signs[k] or "-", f"{found.residual[k]:.0e}", radius, *z))
    print_table("", head, rows, right=(0, 2, 3, *range(4, len(head))))
    if len(found) > ROWS:
        typer.echo(f"... and {len(found) - ROWS} more (--json and --csv hold all)")
    if drawn is not None:
        typer.echo("* is the drawn one, moved to these inputs")


def verdict(found: Configurations) -> str:
    """Return in plain words how many there are and whether that is proved to be all."""
    count = f"{len(found)} configuration{'s' * (len(found) != 1)}"
    spare = f"; {', '.join(found.surplus)} left out and then checked" if found.surplus else ""
    largest = max((g.loops for g in found.groups), default=0)
    if found.level == 1:
        roots = f" all {found.bound} complex roots of the structure are accounted for" if found.bound > 1 else " linear"
        return f"{count}, proved complete:{roots if found.groups else ' nothing has a choice'}{spare}"
    if found.level == 2 and any(g.count is None for g in found.groups):
        return f"{count}, proved complete: intervals leave room for no other real one{spare}"
    if found.level == 2:
        return f"{count}, proved complete: the others of {found.bound} roots are not real or at infinity{spare}"
    if found.level == 3:
        why = (
            f"the number of roots of a group with {largest} loops is not known"
            if any(g.count is None for g in found.groups)
            else f"{sum(g.infinite for g in found.groups)} of the roots are at infinity for these dimensions"
        )
        return f"{count}, not proved complete: two independent searches agree, but {why}{spare}"
    return f"{count}, not proved complete: {_open(found)}{spare}"


def _open(found: Configurations) -> str:
    """Return what keeps a list from being proved complete."""
    multiple, free = sum(g.doubtful for g in found.groups), [", ".join(g.nodes) for g in found.groups if g.free]
    reasons = []
    if found.missing:
        reasons.append(f"{found.missing} root{'s' * (found.missing != 1)} unaccounted for")
    if multiple:
        reasons.append(f"{multiple} multiple root{'s' * (multiple != 1)}")
    if found.unfit:
        reasons.append(f"{found.unfit} of the roots did not fulfil all constraints")
    told = ", ".join(reasons) or "roots that are neither proved real nor proved not to be"
    turning = f"; where a dyad is folded onto itself {' and '.join(free)} can turn freely" if free else ""
    return f"{told} (singular, or a motion with the inputs held){turning}"


def _write_csv(found: Configurations, places: dict[str, Any], path: Path) -> None:
    import numpy as np

    from gimcli.output import write
    from gimcli.table import Column, Table

    names, unit = list(places), found.mechanism.length_unit
    z = np.array([places[n] for n in names]).T.ravel()
    each = len(names)
    columns = (
        Column("configuration", np.repeat(np.arange(1, len(found) + 1), each)),
        Column("node", np.array(names * len(found), dtype=str)),
        Column("x", z.real, unit), Column("y", z.imag, unit),
        Column("residual", np.repeat(found.residual, each)),
    )  # fmt: skip
    write(Table(columns), path)


def _write_png(found: Configurations, drawn: int | None, path: Path) -> int:
    """Draw the configurations; return how many there was no room for."""
    from gimcli.output import draw_configurations

    mechanism, shown = found.mechanism, min(len(found), PANELS)
    titles = [f"{k + 1}{' (as drawn)' if k == drawn else ''}" for k in range(shown)]
    count = f"{len(found)} configurations" if len(found) > 1 else "one configuration"
    count += f", the first {PANELS}" if len(found) > PANELS else ""
    draw_configurations(mechanism, mechanism.to_file(found.z[:shown]), titles, path, f"{mechanism.name}: {count}")
    return len(found) - shown
