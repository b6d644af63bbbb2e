"""`gim simulate`: how a mechanism moves by itself."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import MODEL, Jit, JitOption, Json, ModelPath, Out, Png
from gimcli.dynamics.integrators import INTEGRATORS

if TYPE_CHECKING:
    from gimcli.library.simulate import SimulateResult

NAME = "simulate"
HELP = (
    "Forward dynamics: the motion of the inputs with `free: true` under weight, loads, springs, friction and driving"
    " torques; the other inputs follow their laws. Writes MODEL.simulation.csv and MODEL.simulation.png.\n\n"
    "It begins at `start` (or where the input's law begins) with `speed`. Events are the standstills of free inputs,"
    " their dead points, which are passed, and what ends the motion: the limit of a law, a singular position.\n\n"
    "Methods: dop853, rk45, radau and lsoda choose their steps by --rtol; rk4 takes steps of --step seconds; euler is"
    " the scheme of Durango et al. over the input, in steps of 1e-3 rad.\n\n"
    "Example: gim simulate models/watt_durango.yaml --time 4 --dt 0.05 --reactions"
)
EVENTS = 12


def _registered(name: str) -> str:
    """Return the name of an integrator; refuse others."""
    if name not in INTEGRATORS:
        raise typer.BadParameter(f"{name!r} is not one of {', '.join(map(repr, INTEGRATORS))}.")
    return name


def command(
    model: ModelPath = MODEL,
    time: Annotated[float, typer.Option("--time", "-t", help="Seconds of motion.")] = 5.0,
    dt: Annotated[float | None, typer.Option("--dt", help="Seconds between rows; default: --time / 200.")] = None,
    method: Annotated[
        str, typer.Option("--method", metavar=f"<{'|'.join(INTEGRATORS)}>", callback=_registered, help="Integrator.")
    ] = "dop853",
    rtol: Annotated[float, typer.Option("--rtol", help="Relative tolerance of inputs and speeds.")] = 1e-9,
    step: Annotated[float, typer.Option("--step", help="Step of rk4 [s].")] = 1e-3,
    until: Annotated[
        int, typer.Option("--standstills", min=0, help="End at this standstill of a free input; 0: go on.")
    ] = 0,
    reactions: Annotated[bool, typer.Option("--reactions", help="Write the reactions in all pairs too.")] = False,
    out: Out = Path(),
    png: Png = True,
    jit: JitOption = Jit.AUTO,
    as_json: Json = False,
) -> None:
    """Simulate."""
    from gimcli.cli.console import files_in, finish, note, note_point_masses, write_files
    from gimcli.cli.progress import progress_bar
    from gimcli.dynamics.simulation_table import column_names
    from gimcli.library.load import load
    from gimcli.library.simulate import simulate
    from gimcli.output import refuse_repeated

    mechanism = load(model)
    refuse_repeated(column_names(mechanism))
    csv_path, png_path = files_in(out, f"{model.stem}.simulation", png, mechanism)
    note_point_masses(mechanism)
    found = simulate(
        mechanism, time, dt=dt, method=method, rtol=rtol, step=step, standstills=until, reactions=reactions,
        jit=jit.value, notify=note, progress=progress_bar,
    )  # fmt: skip
    finish(found, write_files(found, csv_path, png_path), as_json, _print, paths_first=True)


def _print(result: SimulateResult) -> None:
    from gimcli.cli.forces import print_open
    from gimcli.cli.progress import end_bars

    end_bars()
    found = result.found
    _tell_events(result.events)
    typer.echo(
        f"{found.mechanism.name}: {len(found.time)} of {len(result.times)} rows, {found.steps} steps,"
        f" {found.evaluations} evaluations; energy drift {found.worst_drift:.1e} of the greatest energy"
    )
    if result.open:
        print_open(result.open)
    if found.status.word != "ok":
        typer.echo(f"ended at {found.end:.10g} s, {found.status.word}: {found.status.plain_text}")


def _tell_events(events: list[dict[str, Any]]) -> None:
    from gimcli.cli.console import number, print_more, print_table

    if not events:
        return
    names = list(events[0]["at"])
    rows = [
        (e["kind"] + (f" of {e['actuator']}" if "actuator" in e else ""), number(e["time"], 12),
         *(number(e["at"][n], 12) for n in names), *(number(e["speed"][n], 8) for n in names))
        for e in events[:EVENTS]
    ]  # fmt: skip
    head = ("event", "time [s]", *names, *(f"{n}.speed" for n in names))
    print_table("", head, rows, range(1, len(head)))
    print_more(len(events), EVENTS)
