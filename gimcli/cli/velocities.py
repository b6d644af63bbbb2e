"""What `gim solve --velocities` tells."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gimcli.output.vectors import Arrows
    from gimcli.rates.instant import Instant

SINGULAR = "singular: the equations tell no velocity in this position; take one beside it"


def velocities_report(found: Instant) -> dict[str, Any]:
    """Return what --json tells: names are the user's, units the file's per second."""
    report: dict[str, Any] = {"velocity_status": "singular" if found.singular else "ok", "input_rates": _rates(found)}
    for order, (linear, angular) in enumerate((("velocities", "omega"), ("accelerations", "alpha")), start=1):
        points = {} if found.singular else found.of_points(order)
        report[linear] = {name: [v.real, v.imag] for name, v in points.items()}
        report[angular] = {} if found.singular else dict(found.of_members(order))
    return report


def _rates(found: Instant) -> dict[str, dict[str, float]]:
    """Return rate, acceleration and time [s] of the inputs; NaN as time where a unit rate was taken."""
    mechanism, rates = found.mechanism, {}
    for k, actuator in enumerate(mechanism.actuators):
        rate, acceleration = (
            float(mechanism.value_to_file(k, v[k : k + 1])[0]) for v in (found.input_rate, found.input_acceleration)
        )
        rates[actuator.name] = {
            "rate": rate, "acceleration": acceleration, "time": float(found.time[k]) * mechanism.duration,
        }  # fmt: skip
    return rates


def tell_velocities(found: Instant) -> None:
    """Print the tables of points and members."""
    import math

    from gimcli.cli.console import number, print_table
    from gimcli.mechanism import Drive

    if found.singular:
        typer.echo(SINGULAR)
        return
    mechanism = found.mechanism
    length = "" if mechanism.length_unit == "unit" else mechanism.length_unit
    for actuator, (name, rate) in zip(mechanism.actuators, _rates(found).items(), strict=True):
        unit = mechanism.angle_unit if actuator.drive is Drive.ROTARY else length
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


def velocity_arrows(found: Instant, places: Mapping[str, complex]) -> list[Arrows]:
    """Return the vectors for the picture."""
    from gimcli.output.vectors import Arrows

    length = "1" if found.mechanism.length_unit == "unit" else found.mechanism.length_unit
    kinds = []
    for order, name, unit in ((1, "velocity", f"{length}/s"), (2, "acceleration", f"{length}/s²")):
        vectors = found.of_points(order)
        kinds.append(Arrows(name, unit, {n: (z, vectors[n]) for n, z in places.items()}))
    return kinds
