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

    values = result.forces
    size = greatest(abs(value) for value, _ in values.values())
    rows = []
    for name, (value, unit) in values.items():
        if not abs(value) < math.inf and result.status != "ok":
            continue
        if isinstance(value, complex):
            rows.append((name, *(number(v, size) for v in (value.real, value.imag, abs(value))), unit))
        else:
            rows.append((name, "", "", number(value, size), unit))
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
