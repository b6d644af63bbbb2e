"""What `gim solve --velocities` tells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from gimcli.rates.instant import Instant

SINGULAR = "singular: the equations tell no velocity in this position; take one beside it"


def print_velocities(found: Instant) -> None:
    """Print the tables of points and members."""
    import math

    from gimcli.cli.console import number, print_table
    from gimcli.library.solve import input_rates

    if found.singular:
        typer.echo(SINGULAR)
        return
    mechanism = found.mechanism
    length = "" if mechanism.length_unit == "unit" else mechanism.length_unit
    for actuator, (name, rate) in zip(mechanism.actuators, input_rates(found).items(), strict=True):
        unit = mechanism.angle_unit if actuator.rotary else length
        told = "unit rate" if math.isnan(rate["time"]) else f"its law at {rate['time']:.6g} s"
        typer.echo(f"{name}: {rate['rate']:.10g} {unit}/s, {rate['acceleration']:.10g} {unit}/s^2 ({told})")
    first, second = found.of_points(1), found.of_points(2)
    places = [(n, *_cells(v), *_cells(second[n])) for n, v in first.items()]
    v, a = (f" [{length or '1'}/{unit}]" for unit in ("s", "s^2"))
    print_table("", ("node", f"vx{v}", "vy", "speed", f"ax{a}", "ay", "magnitude"), places, right=range(1, 7))
    omega, alpha = found.of_members(1), found.of_members(2)
    rows = [(name, number(w, 12), number(alpha[name], 12)) for name, w in omega.items()]
    unit = mechanism.angle_unit
    print_table("", ("member", f"omega [{unit}/s]", f"alpha [{unit}/s^2]"), rows, right=(1, 2))


def _cells(v: complex) -> tuple[str, str, str]:
    from gimcli.cli.console import number

    return number(v.real, 8), number(v.imag, 8), number(abs(v), 8)
