"""`gim solve --all`: all configurations."""

from __future__ import annotations

from pathlib import Path

import typer

from gimcli.cli.console import end_bars, print_records, print_remarks, print_turns, room
from gimcli.library.configurations import ConfigurationsResult, verdict
from gimcli.motion.unassembled import reason
from gimcli.rounding import titled
from gimcli.status import Status
from gimcli.structure.rigid_triangles import triangle_hints

COLUMNS = 3
"""Traced points with coordinates in the table, at most; fewer on a narrow terminal."""

BESIDE, EACH = 45, 28
"""Characters of a row without coordinates, and of a pair of coordinates."""

ROWS = 60
"""Rows of the table; --json and -o write all configurations."""


def print_configurations(png: Path | None, result: ConfigurationsResult) -> None:
    """Print all configurations; `png` is the picture, if one is written."""
    end_bars()
    found, mechanism = result._found, result.mechanism
    typer.echo(titled(mechanism, result.inputs))
    typer.echo(verdict(found))
    if not len(found):
        if not found.limited:
            typer.echo(reason(mechanism, Status.NOT_ASSEMBLED, found.inputs, tried=("all",)))
        return
    fit = max(1, min(COLUMNS, (room() - BESIDE) // EACH))
    shown = [n for n in mechanism.traced if n in result.places][:fit]
    names = ("number", "assembly", "residual", "radius", *(f"{name}." for name in shown))
    print_records("", result._records, *names, most=ROWS, where="--json and -o write all")
    print_turns(mechanism)
    print_remarks(
        (result.drawn is not None, "*: the initial configuration, moved to these inputs"),
        *triangle_hints(mechanism),
        (
            result.undrawn and png is not None,
            f"{png} shows the first {result.count - result.undrawn}; {result.undrawn} are not drawn",
        ),
    )
