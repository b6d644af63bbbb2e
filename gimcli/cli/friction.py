"""What `gim forces` prints of dry friction: efficiency, energy lost in each pair, and where friction locks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from gimcli.cli.console import print_table
from gimcli.library.rounding import greatest, number

if TYPE_CHECKING:
    from gimcli.dynamics.efficiency import FrictionSummary


def print_friction(found: FrictionSummary) -> None:
    """Print efficiency, works, lost energies, self-locking intervals and rows at a standstill."""
    from gimcli.dynamics.coulomb_status import FrictionStatus

    _print_works(found)
    unit = (
        found.mechanism.unit_of(found.mechanism.actuators[found.mechanism.drivers[0]]) if found.over != "time" else "s"
    )
    if found.locked:
        ranges = ", ".join(f"{first:.6g} to {end:.6g}" for first, end in found.locked)
        typer.echo(
            f"self-locking at {found.over} {ranges} {unit}: at rest without an effort, friction holds the mechanism"
            " against its loads"
        )
    if count := found.counts[FrictionStatus.STANDSTILL]:
        typer.echo(f"standstill in {count} row{'s' * (count > 1)}: {FrictionStatus.STANDSTILL.text}")
    if found.works:
        typer.echo(f"residual of the equations with dry friction: {found.residual:.1e} (relative)")


def _print_works(found: FrictionSummary) -> None:
    """Print the works and the lost energies, and the efficiency."""
    if not found.complete:
        typer.echo("efficiency: not determined, because some rows have no forces")
        return
    size = greatest([*found.works.values(), *found.lost.values()])
    rows = [
        *((name, number(value, size), "J") for name, value in found.works.items() if value),
        *((f"lost in {name}", number(-value, size), "J") for name, value in found.lost.items() if value),
    ]
    print_table("work over the motion", ("", "work", "unit"), rows, (1,))
    if found.efficiency is not None:
        typer.echo(f"efficiency {100 * found.efficiency:.4g} %: outputs / inputs of the works above")
