"""`gim solve`: one position."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    pairs,
)
from gimcli.cli.velocities import print_velocities
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.library.solve import SolveResult

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
    from gimcli.cli.console import finish, loaded, write_files
    from gimcli.library.solve import solve

    if every:
        if method is not Method.AUTO or start != "drawn" or sequence:
            raise UsageError("--all has its own method: leave out --method, --start and --sequence")
        if velocities or history:
            raise UsageError(f"--{'velocities' if velocities else 'history'} belongs to one position: leave out --all")
        from gimcli.cli.configurations import solve_all

        solve_all(model, pairs(at), tolerance, csv, png, as_json)
        return
    mechanism = loaded(model, csv, png)
    found = solve(
        mechanism, pairs(at), method=method.value, strategy=strategy.value, tolerance=tolerance, start=start, seed=seed,
        history=history, velocities=velocities, jit=jit.value, sequence=sequence,
    )  # fmt: skip
    finish(found, write_files(found, csv, png), as_json, _print)


def _print(found: SolveResult) -> None:
    import math

    from gimcli.cli.console import number, print_table
    from gimcli.cli.progress import end_bars
    from gimcli.library.inputs import at_inputs
    from gimcli.table import labelled

    end_bars()
    position, law = found.position, found.law
    mechanism, status = position.mechanism, position.status
    typer.echo(at_inputs(mechanism.name, found.inputs))
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
        nodes, points = found.places()
        rows = [(k, number(v.real, 12), number(v.imag, 12)) for k, v in (nodes | points).items()]
        print_table("", ("node", *(labelled(axis, mechanism.length_unit) for axis in "xy")), rows, right=(1, 2))
    if law is not None:
        rows = [(str(k), f"{a:.3e}", f"{b:.3e}") for k, (a, b) in enumerate(law.errors)]
        if len(rows) > 2 * SHOWN:
            rows = [*rows[:SHOWN], ("...", "...", "..."), *rows[-SHOWN:]]
        print_table("Error per sweep", ("sweep", "eq. (1)", "eq. (2) [rad]"), rows, right=(0, 1, 2))
        typer.echo(
            f"eq. (3): E = {law.c1:.3g} exp(-{law.c2:.4g} n): factor {law.rate:.4f} per sweep,"
            f" predicted spectral radius {law.radius:.4f}"
        )
    if found.moving is not None:
        print_velocities(found.moving)
