"""`gim forces --at`: efforts and reactions of one position at rest."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import typer

from gimcli.cli.console import print_table
from gimcli.library.rounding import greatest, number

if TYPE_CHECKING:
    from gimcli.library.holding_forces import HoldingResult


def print_holding(result: HoldingResult) -> None:
    """Print efforts, reactions and the shaking force of one position."""
    from gimcli.cli.force_tables import print_open

    size = greatest(abs(value) for value, _ in result.forces.values())
    rows = [
        (name, *_axes(value, size), number(abs(value) if isinstance(value, complex) else value, size), unit)
        for name, (value, unit) in result.forces.items()
        if abs(value) < math.inf or result.status == "ok"
    ]
    if result.complete:
        print_table(result.headline(), ("", "x", "y", "value", "unit"), rows, (1, 2, 3))
    else:
        typer.echo(result.headline())
        typer.echo(result.reason)
    if result.complete and result.open:
        print_open(result.open)
    if result.status == "standstill":
        typer.echo(
            "dry friction holds the mechanism: each effort may have any value from INPUT.effort.least to .greatest, and"
            " reactions that depend on it are empty"
        )


def _axes(value: complex | float, size: float) -> tuple[str, str]:
    """Return the components of a pin force; empty cells for a number."""
    return (number(value.real, size), number(value.imag, size)) if isinstance(value, complex) else ("", "")
