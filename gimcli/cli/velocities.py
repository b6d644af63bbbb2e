"""The tables of `gim solve --velocities`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import typer

from gimcli.cli.console import print_table
from gimcli.library.rounding import greatest, number

if TYPE_CHECKING:
    from gimcli.rates.instant import Instant

SINGULAR = "singular: velocities are not determined in this position; choose an input value beside it"


def print_velocities(found: Instant) -> None:
    """Print the tables of points and members."""
    from gimcli.library.inputs import leaders
    from gimcli.library.solve import input_rates
    from gimcli.table import per_second

    if found.singular:
        typer.echo(SINGULAR)
        return
    mechanism = found.mechanism
    for k, (actuator, (name, rate)) in enumerate(zip(mechanism.actuators, input_rates(found).items(), strict=True)):
        v, a = (per_second(mechanism.unit_of(actuator), order) for order in (1, 2))
        source = "unit speed" if math.isnan(rate["time"]) else f"as in its law at {number(rate['time'])} s"
        source = source if k in mechanism.drivers else f"with {' and '.join(leaders(mechanism, k))}"
        values = f"speed {number(rate['rate'])} {v}, acceleration {number(rate['acceleration'])} {a}"
        typer.echo(f"{name}: {values} ({source})")
    first, second = found.of_points(1), found.of_points(2)
    sizes = [greatest(abs(value) for value in vectors.values()) for vectors in (first, second)]
    places = [(n, *_cells(v, sizes[0]), *_cells(second[n], sizes[1])) for n, v in first.items()]
    v, a = (per_second(mechanism.length_unit, order) for order in (1, 2))
    heads = (
        "node",
        *(f"{name} [{v}]" for name in ("vx", "vy", "speed")),
        *(f"{name} [{a}]" for name in ("ax", "ay", "acceleration")),
    )
    print_table("", heads, places, right=range(1, 7))
    omega, alpha = found.of_members(1), found.of_members(2)
    sizes = [greatest(values.values()) for values in (omega, alpha)]
    rows = [(name, number(w, sizes[0]), number(alpha[name], sizes[1])) for name, w in omega.items()]
    unit = mechanism.angle_unit
    print_table("", ("member", f"omega [{unit}/s]", f"alpha [{unit}/s^2]"), rows, right=(1, 2))


def _cells(v: complex, size: float) -> tuple[str, str, str]:
    return number(v.real, size), number(v.imag, size), number(abs(v), size)
