"""What `gim forces` prints: extremes, statistics, work, bearing loads, dry friction, one position at rest."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import typer

from gimcli.cli.console import print_records, print_remarks, print_table
from gimcli.dynamics.forces import MOST
from gimcli.library.forces import ForcesResult, bearing_loads, statistics, works
from gimcli.library.record import quantity_rows
from gimcli.rounding import at_inputs, greatest, number

if TYPE_CHECKING:
    from gimcli.dynamics.efficiency import FrictionSummary
    from gimcli.library.holding_forces import HoldingResult


def print_holding(result: HoldingResult) -> None:
    """Print efforts, reactions and the shaking force of one position."""
    size = greatest(abs(value) for value, _ in result.forces.values())
    rows = [
        (name, number(value.real, size), number(value.imag, size), number(abs(value), size), unit)
        if isinstance(value, complex)
        else (name, "", "", number(value, size), unit)
        for name, (value, unit) in result.forces.items()
        if abs(value) < math.inf or result.status == "ok"
    ]
    if result.complete:
        print_table(result.headline(), ("", "x", "y", "value", "unit"), rows, (1, 2, 3))
    else:
        typer.echo(result.headline())
        typer.echo(result.reason)
    print_records("", quantity_rows(result._measured))
    print_open(result.open if result.complete else [])
    print_remarks(
        (
            result.status == "standstill",
            "dry friction holds the mechanism: each effort may have any value from INPUT.effort.least to .greatest, and"
            " reactions that depend on it are empty",
        )
    )


def print_friction(found: FrictionSummary) -> None:
    """Print efficiency, works, lost energies, self-locking intervals and rows at a standstill."""
    from gimcli.dynamics.coulomb_solver import FrictionStatus

    _print_works(found)
    unit = (
        found.mechanism.unit_of(found.mechanism.actuators[found.mechanism.drivers[0]]) if found.over != "time" else "s"
    )
    ranges = ", ".join(f"{first:.6g} to {end:.6g}" for first, end in found.locked)
    count = found.counts[FrictionStatus.STANDSTILL]
    print_remarks(
        (
            found.locked,
            f"self-locking at {found.over} {ranges} {unit}: at rest without an effort, friction holds the mechanism"
            " against its loads",
        ),
        (count, f"standstill in {count} row{'s' * (count > 1)}: {FrictionStatus.STANDSTILL.text}"),
        (found.works, f"residual of the equations with dry friction: {found.residual:.1e} (relative)"),
    )


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


SHOWN = 30
SHORT = ("name", "mean", "rms", "peak", "unit", "peak at")
LONG = ("name", "unit", "mean", "rms", "least", "least at", "greatest", "greatest at")
"""Columns of the statistics, and all of them."""


def print_statistics(result: ForcesResult, full: bool) -> None:
    """Print mean, RMS and peak of every effort and reaction; or all statistics, works, and mean bearing loads."""
    title, found = f"{result.mechanism.name}: forces", result._summary
    listed = statistics(result.mechanism, found.statistics)
    print_records(title, listed, *(LONG if full else SHORT), most=None if full else SHOWN)
    _print_part(result)
    if full:
        own = {name: one for name, one in found.work.items() if one.positive or one.negative}
        print_table("Work [J]", *works(own).cells())
        if found.bearings:
            print_records("Mean bearing loads", bearing_loads(found.bearings))


def print_open(names: list[str]) -> None:
    """Print which reactions are not unique, if any."""
    print_remarks(
        (
            names,
            f"redundant constraints: the reactions at {', '.join(names)} are not determined; NODE.unique is the"
            " component of a pin's reaction that is still determined",
        )
    )


def _print_part(result: ForcesResult) -> None:
    """Print the part of the time over which means are taken, if any is missing, and why rows are left out."""
    part = min((one.part for one in result.statistics.values()), default=1.0)
    found, mechanism = result._found, result.mechanism
    places = [at_inputs(mechanism, mechanism.inputs_to_file(at)) for at in found.left_out_at]
    more = ["..."] * (found.left_out > len(places))
    print_remarks(
        (part < 1.0, f"means over the determined rows, {100.0 * part:.3g} % of the time of the motion"),
        (
            found.left_out,
            f"{found.left_out} row{'s are' if found.left_out > 1 else ' is'} in the table but not in these values"
            f" and the picture: near a singular position the estimated relative error of the forces exceeds"
            f" {100.0 * MOST:.0f} % (at {'; '.join([*places, *more])})",
        ),
    )
