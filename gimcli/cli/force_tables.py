"""What `gim forces` prints: extremes, statistics, work, bearing loads, dry friction, one position at rest."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import typer

from gimcli.cli.console import print_records, print_table
from gimcli.dynamics.forces import MOST
from gimcli.library.record import Records, RowField
from gimcli.rounding import at_inputs, greatest, input_value, number
from gimcli.table import labelled

if TYPE_CHECKING:
    from gimcli.dynamics.efficiency import FrictionSummary
    from gimcli.dynamics.force_statistics import Extremum
    from gimcli.library.forces import ForcesResult
    from gimcli.library.holding_forces import HoldingResult
    from gimcli.mechanism import Mechanism


def print_holding(result: HoldingResult) -> None:
    """Print efforts, reactions and the shaking force of one position."""
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


def print_friction(found: FrictionSummary) -> None:
    """Print efficiency, works, lost energies, self-locking intervals and rows at a standstill."""
    from gimcli.dynamics.coulomb_solver import FrictionStatus

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


SHOWN = 30


def print_statistics(result: ForcesResult) -> None:
    """Print mean, RMS and peak of every effort and reaction."""
    shown = ("name", "mean", "RMS", "peak", "unit", "peak at")
    print_records(f"{result.mechanism.name}: forces", _statistics(result), *shown, most=SHOWN)
    _print_part(result)


def print_full(result: ForcesResult) -> None:
    """Print all statistics, the work of all forces, and the mean bearing loads."""
    shown = ("name", "unit", "mean", "RMS", "least", "least at", "greatest", "greatest at")
    print_records(f"{result.mechanism.name}: forces", _statistics(result), *shown)
    _print_part(result)
    _print_work(result)
    _print_bearings(result)


def _statistics(result: ForcesResult) -> Records:
    """Return the statistics, one row for each effort, reaction or moment."""
    sizes, every, mechanism = _sizes(result), list(result.statistics.values()), result.mechanism
    at = f"at {', '.join(labelled(a.name, mechanism.unit_of(a)) for a in mechanism.actuators)}"
    ends = {word: [getattr(one, word) for one in every] for word in ("peak", "least", "greatest")}
    values = {"mean": [one.mean for one in every], "RMS": [one.rms for one in every]}
    values |= {word: [one.value for one in own] for word, own in ends.items()}
    return Records(
        RowField("name", list(result.statistics), head=""),
        RowField("unit", [one.unit for one in every], head="unit"),
        *(
            RowField(word, own, float, head=word,
                     text=[number(v, sizes[one.unit]) for v, one in zip(own, every, strict=True)])
            for word, own in values.items()
        ),
        *(
            RowField(f"{word} at", own, float, head=at, text=[_place(mechanism, one) for one in own])
            for word, own in ends.items()
        ),
    )  # fmt: skip


def print_open(names: list[str]) -> None:
    """Print which reactions are not unique."""
    typer.echo(
        f"redundant constraints: the reactions at {', '.join(names)} are not determined; NODE.unique is the component"
        " of a pin's reaction that is still determined"
    )


def _print_work(result: ForcesResult) -> None:
    size = greatest(value for work in result.work.values() for value in (work.positive, work.negative))
    rows = [
        (name, *(number(value, size) for value in (work.positive, work.negative, work.net)))
        for name, work in result.work.items()
        if work.positive or work.negative
    ]
    print_table("Work [J]", ("", "positive", "negative", "net"), rows, (1, 2, 3))


def _print_bearings(result: ForcesResult) -> None:
    size = greatest(load for one in result.bearings.values() for load in (one.ball, one.roller))
    rows = [
        (name, number(one.speed), number(one.ball, size), number(one.roller, size))
        for name, one in result.bearings.items()
    ]
    if rows:
        head = ("", "mean speed [1/min]", "ball, p = 3 [N]", "roller, p = 10/3 [N]")
        print_table("Mean bearing loads", head, rows, (1, 2, 3))


def _print_part(result: ForcesResult) -> None:
    """Print the part of the time over which means are taken, if any is missing, and why rows are left out."""
    part = min((one.part for one in result.statistics.values()), default=1.0)
    if part < 1.0:
        typer.echo(f"means over the determined rows, {100.0 * part:.3g} % of the time of the motion")
    balance, mechanism = result._found.balance, result.mechanism
    if balance.left_out:
        places = [at_inputs(mechanism, mechanism.inputs_to_file(at)) for at in balance.left_out_at]
        more = ["..."] * (balance.left_out > len(places))
        typer.echo(
            f"{balance.left_out} row{'s are' if balance.left_out > 1 else ' is'} in the table but not in these values"
            f" and the picture: near a singular position the estimated relative error of the forces exceeds"
            f" {100.0 * MOST:.0f} % (at {'; '.join([*places, *more])})"
        )


def _sizes(result: ForcesResult) -> dict[str, float]:
    """Return the greatest value of each unit; a torque is zero in comparison with the forces, too."""
    sizes: dict[str, float] = {}
    for one in result.statistics.values():
        sizes[one.unit] = max(sizes.get(one.unit, 0.0), abs(one.peak.value))
    arm = result.mechanism.size * (result.mechanism.dynamics.metre or 0.0)
    return sizes | ({"N m": max(sizes["N m"], sizes.get("N", 0.0) * arm)} if "N m" in sizes else {})


def _place(mechanism: Mechanism, one: Extremum) -> str:
    return ", ".join(input_value(mechanism, name, value) for name, value in one.inputs.items())
