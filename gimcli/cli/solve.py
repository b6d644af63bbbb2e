"""`gim solve`: one position."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import (
    MODEL,
    At,
    Jit,
    JitOption,
    Json,
    Method,
    MethodOption,
    ModelPath,
    SequenceText,
    Strategy,
    StrategyOption,
    Tolerance,
    inputs_at,
    options,
)
from gimcli.cli.velocities import tell_velocities, velocities_report, velocity_arrows
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.positions.position import Position
    from gimcli.rates.instant import Instant

NAME = "solve"
SHOWN = 25
HELP = (
    "Find a position: the initial one, from the drawn coordinates, or one at given inputs; with --all every way to"
    " assemble the mechanism there, and whether that is proved to be all.\n\n"
    "--velocities adds velocities and accelerations of nodes and points, omega and alpha of members, by the real"
    " time. An input moves as its law does at the first time at which the law has the input's value (so a profile that"
    " starts from rest tells 0 at its start); where the law never has it, by one unit of the file (deg, rad, length) a"
    " second, without acceleration. The rates taken are told. A singular position has no velocities: it says so, and"
    " the exit status is 5.\n\n"
    "Example: gim solve models/crank_rocker.yaml --at motor=45\n\n"
    "Example: gim solve models/crank_rocker.yaml --at motor=40 --velocities --png velocities.png\n\n"
    "Example: gim solve models/gim_fig11.yaml --at FD=120 --at OA=119 --method gim --tolerance 1e-5 --history\n\n"
    "Example: gim solve models/double_butterfly.yaml --all --at motor=145 --png all.png"
)


def command(
    model: ModelPath = MODEL,
    at: At = [],  # noqa: B006 - typer wants a list; nothing changes it
    method: MethodOption = Method.AUTO,
    strategy: StrategyOption = Strategy.SPECTRAL,
    tolerance: Tolerance = 1e-10,
    start: Annotated[str, typer.Option("--start", help="drawn, or random: nodes strewn by --seed.")] = "drawn",
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of a random start.")] = 0,
    history: Annotated[
        bool, typer.Option("--history", help="Tell the error after every sweep (--method gim).")
    ] = False,
    velocities: Annotated[
        bool, typer.Option("--velocities", help="Tell velocities and accelerations; with --png draw them.")
    ] = False,
    jit: JitOption = Jit.AUTO,
    sequence: SequenceText = "",
    csv: Annotated[Path | None, typer.Option("--csv", help="Write the positions of the nodes and points.")] = None,
    png: Annotated[Path | None, typer.Option("--png", help="Draw the position; with --history the errors.")] = None,
    every: Annotated[
        bool, typer.Option("--all", help="Every configuration, each proved; --png draws them all.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Solve one position, or all."""
    from gimcli.cli.console import tell_written
    from gimcli.gim.convergence import fit_history
    from gimcli.model import load
    from gimcli.motion.solve import solve
    from gimcli.output import refuse_files
    from gimcli.structure.drive_check import explained, refuse_contradiction

    if start not in ("drawn", "random"):
        raise UsageError(f"--start {start}: choose drawn or random")
    if history and method is not Method.GIM:
        raise UsageError("--history tells the error per sweep: add --method gim")
    chosen = options(method, strategy, tolerance, jit, sequence, seed if start == "random" else None)
    if every:
        if method is not Method.AUTO or start != "drawn" or sequence:
            raise UsageError("--all has its own method: leave out --method, --start and --sequence")
        if velocities:
            raise UsageError("--velocities are those of one position: leave out --all, or ask one by one with --at")
        from gimcli.cli.configurations import solve_all

        mechanism = load(model)
        solve_all(mechanism, inputs_at(mechanism, at), chosen.tolerance, csv, png, as_json)
        return
    mechanism = load(model)
    refuse_files(mechanism.files, csv, png)
    with explained(mechanism):
        position = solve(mechanism, inputs_at(mechanism, at), chosen, history)
    if start == "drawn":
        refuse_contradiction(mechanism, position.z, position.inputs, position.status, tolerance)
    law = fit_history(position) if history else None
    moving = _instant(position) if velocities else None
    drawn = False
    if csv is not None:
        _write_csv(position, csv)
    if png is not None:
        drawn = _write_png(position, law, png, moving)
    paths = {"csv": csv, "png": png if drawn else None}
    if as_json:
        _print_json(position, law, moving, paths)
    else:
        _print(position, law)
        if moving is not None:
            tell_velocities(moving)
        tell_written(*paths.values())
    if position.status.value or (moving is not None and moving.singular):
        raise typer.Exit(5)


def _instant(position: Position) -> Instant | None:
    """Return the velocities of a solved position."""
    from gimcli.rates.instant import instant

    if position.status.value:
        return None
    return instant(position.mechanism, position.inputs, position.z)


def _places(position: Position) -> tuple[dict[str, complex], dict[str, complex]]:
    from gimcli.motion.coupler_points import carried_point

    mechanism = position.mechanism
    z = position.z[:, None]
    nodes = {n: complex(mechanism.to_file(position.z[k : k + 1])[0]) for k, n in enumerate(mechanism.nodes)}
    points = {p.name: complex(mechanism.to_file(carried_point(mechanism, p.name, z))[0]) for p in mechanism.points}
    return nodes, points


def _print_json(position: Position, law: Any, moving: Instant | None, paths: dict[str, Path | None]) -> None:
    from gimcli.cli.console import print_json

    nodes, points = _places(position)
    good = position.status.value == 0
    report: dict[str, Any] = {
        "status": position.status.word,
        "residual": float(position.residual.total[0]),
        "sweeps": position.sweeps,
        "nodes": {k: [v.real, v.imag] for k, v in nodes.items()} if good else {},
        "points": {k: [v.real, v.imag] for k, v in points.items()} if good else {},
        "inputs": _inputs(position),
    }
    if not good:
        report |= {"worst": position.worst, "reason": position.status.text}
    if law is not None:
        report |= {"history": law.errors.tolist(), "C1": law.c1, "C2": law.c2, "rate": law.rate, "radius": law.radius}
    if moving is not None:
        report |= velocities_report(moving)
    print_json(report | {kind: str(path) if path else None for kind, path in paths.items()})


def _inputs(position: Position) -> dict[str, float]:
    mechanism = position.mechanism
    return {
        a.name: float(mechanism.value_to_file(k, position.inputs[k : k + 1])[0])
        for k, a in enumerate(mechanism.actuators)
    }


def _print(position: Position, law: Any) -> None:
    import math

    from gimcli.cli.console import number, print_table
    from gimcli.cli.progress import end_bars

    end_bars()
    mechanism, status = position.mechanism, position.status
    at = ", ".join(f"{k} = {v:.10g}" for k, v in _inputs(position).items())
    typer.echo(f"{mechanism.name}" + (f" at {at}" if at else ""))
    residual = position.residual
    typer.echo(
        f"{status.word}; eq. (1) {residual.lengths[0]:.1e}, eq. (2) {residual.angles[0]:.1e} rad;"
        f" {position.sweeps} sweeps"
        + (
            f"; estimated error of the nodes {position.error:.1e} of the size"
            if math.isfinite(position.error) and not status.value
            else ""
        )
    )
    if status.value:
        typer.echo(f"{status.text}\nworst off: {position.worst}, by {residual.total[0]:.3g}")
    else:
        nodes, points = _places(position)
        unit = "" if mechanism.length_unit == "unit" else f" [{mechanism.length_unit}]"
        rows = [(k, number(v.real, 12), number(v.imag, 12)) for k, v in (nodes | points).items()]
        print_table("", ("node", f"x{unit}", f"y{unit}"), rows, right=(1, 2))
    if law is not None:
        rows = [(str(k), f"{a:.3e}", f"{b:.3e}") for k, (a, b) in enumerate(law.errors)]
        if len(rows) > 2 * SHOWN:
            rows = [*rows[:SHOWN], ("...", "...", "..."), *rows[-SHOWN:]]
        print_table("Error per sweep", ("sweep", "eq. (1)", "eq. (2) [rad]"), rows, right=(0, 1, 2))
        typer.echo(
            f"eq. (3): E = {law.c1:.3g} exp(-{law.c2:.4g} n): factor {law.rate:.4f} per sweep,"
            f" predicted spectral radius {law.radius:.4f}"
        )


def _write_csv(position: Position, path: Path) -> None:
    import numpy as np

    from gimcli.output import write
    from gimcli.table import Column, Table

    nodes, points = _places(position)
    places = nodes | points
    good = position.status.value == 0
    z = np.array(list(places.values())) if good else np.full(len(places), complex(np.nan, np.nan))
    unit = position.mechanism.length_unit
    status = np.array([position.status.word] * len(z))
    columns = (
        Column("node", np.array(list(places))), Column("x", z.real, unit), Column("y", z.imag, unit),
        Column("status", status),
    )  # fmt: skip
    write(Table(columns), path)


def _write_png(position: Position, law: Any, path: Path, moving: Instant | None) -> bool:
    """Draw the position, or its errors; return whether there was anything to draw."""
    from gimcli.output import draw_history, draw_position

    mechanism = position.mechanism
    if law is not None:
        errors = law.errors.max(axis=1)
        draw_history(errors, (law.c1, law.c2), path, f"{mechanism.name}: error per sweep", predicted=law.radius)
    elif position.status.value == 0:
        nodes, points = _places(position)
        arrows = velocity_arrows(moving, nodes | points) if moving is not None and not moving.singular else []
        draw_position(mechanism, mechanism.to_file(position.z), path, mechanism.name, points, arrows)
    else:
        return False
    return True
