"""`gim simulate`: how a mechanism moves by itself."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import MODEL, Jit, JitOption, Json, ModelPath
from gimcli.dynamics.integrators import INTEGRATORS
from gimcli.errors import UsageError

if TYPE_CHECKING:
    from gimcli.dynamics.simulation_types import Simulation
    from gimcli.mechanism import FloatArray, Mechanism

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
ROWS = 200
MOST_ROWS = 1_000_000
EVENTS = 12
LEAST = 3e-14
"""Relative tolerance below which steps are no more exact."""
WORK = 6e-4
"""Seconds that one evaluation takes without compiling, about."""
A_SECOND = 1500
"""Evaluations for a second of motion, about."""


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
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder to write into.")] = Path(),
    png: Annotated[bool, typer.Option("--png/--no-png", help="Draw the picture.")] = True,
    jit: JitOption = Jit.AUTO,
    as_json: Json = False,
) -> None:
    """Simulate."""
    from gimcli.cli.console import note, note_point_masses
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.dynamics.force_table import open_reactions
    from gimcli.dynamics.load_arrays import point_masses
    from gimcli.dynamics.simulation import simulate
    from gimcli.dynamics.simulation_table import column_names, simulation_table
    from gimcli.dynamics.simulation_table import reactions as find_reactions
    from gimcli.dynamics.simulation_types import Settings
    from gimcli.model import load
    from gimcli.output import refuse_repeated, refuse_unwritable, write
    from gimcli.positions.dispatch import choose
    from gimcli.structure.drive_check import explained

    times = _times(time, dt)
    if not 1e-14 <= rtol <= 1e-2:
        raise UsageError(f"--rtol {rtol:g}: a number from 1e-14 to 1e-2 is needed")
    if not 0.0 < step <= time:
        raise UsageError(f"--step {step:g}: a number above 0 and at most --time is needed")
    mechanism = load(model)
    refuse_repeated(column_names(mechanism))
    csv_path, png_path = out / f"{model.stem}.simulation.csv", out / f"{model.stem}.simulation.png"
    refuse_unwritable(mechanism.files, csv_path, *([png_path] if png else []))
    run = choose(jit.value, time * A_SECOND * WORK, note, ("move",))
    settings = Settings(method, max(rtol, LEAST), step, until)
    note_point_masses(point_masses(mechanism))
    with explained(mechanism):
        found = simulate(mechanism, times, settings, run, progress_bar("simulating"))
    if until and found.status.word == "ok":
        times = times[: len(found.time)]
    if reactions:
        progress_bar("reactions")
    forces = find_reactions(found) if reactions and len(found.time) else None
    write(simulation_table(found, times, forces), csv_path)
    drawn = png and len(found.time) > 1
    if drawn:
        progress_bar(DRAWING)
        _draw(found, png_path)
    open_ones = open_reactions(forces) if forces else []
    _report(found, times, csv_path, png_path if drawn else None, open_ones, as_json)
    if len(found.time) < len(times):
        raise typer.Exit(5)


def _times(time: float, dt: float | None) -> FloatArray:
    import numpy as np

    every = time / ROWS if dt is None else dt
    if not 0.0 < time < 1e9:
        raise UsageError(f"--time {time:g}: a number of seconds above 0 is needed")
    if not 0.0 < every <= time:
        raise UsageError(f"--dt {every:g}: a number of seconds above 0 and at most --time is needed")
    count = int(time / every * (1.0 + 1e-12))
    if count > MOST_ROWS:
        raise UsageError(f"--dt {every:g}: that are {count} rows, above {MOST_ROWS}; take a longer --dt")
    return np.asarray(np.arange(count + 1) * every, dtype=np.float64)


def _draw(found: Simulation, path: Path) -> None:
    from gimcli.dynamics.simulation_table import ENERGIES
    from gimcli.mechanism import Drive
    from gimcli.output import draw_history_sheet
    from gimcli.output.history import Panel

    mechanism, panels = found.mechanism, []
    for drive, unit in ((True, mechanism.angle_unit), (False, mechanism.length_unit)):
        own = [k for k, a in enumerate(mechanism.actuators) if (a.drive is Drive.ROTARY) is drive]
        for order, what in enumerate((f"[{unit}]", f"[{unit}/s]")):
            curves = [
                (mechanism.actuators[k].name, found.time, mechanism.value_to_file(k, found.inputs[order, k]))
                for k in own
            ]
            name = mechanism.actuators[own[0]].name if len(own) == 1 else "inputs"
            marks = [
                _mark(mechanism, event, k, order) for k in own for event in found.events if event.time <= found.end
            ]
            if own:
                panels.append(Panel(f"{name} {what}", curves, marks))
    energies = [(n, found.time, e) for n, e in zip(ENERGIES, found.energy, strict=True) if e.any()]
    panels.append(Panel("energy [J]", [*energies, ("total", found.time, found.total)]))
    draw_history_sheet(panels, "time [s]", path, f"{mechanism.name}: simulation")


def _mark(mechanism: Mechanism, event: Any, k: int, order: int) -> complex:
    values = event.inputs if order == 0 else event.speeds
    return complex(event.time, float(mechanism.value_to_file(k, values[k : k + 1])[0]))


def _report(
    found: Simulation, times: FloatArray, csv_path: Path, png_path: Path | None, open_ones: list[str], as_json: bool
) -> None:
    from gimcli.cli.console import print_json
    from gimcli.cli.forces import tell_open
    from gimcli.cli.progress import end_bars
    from gimcli.dynamics.simulation_table import event_report

    end_bars()
    events = [event_report(found.mechanism, event) for event in found.events]
    if as_json:
        print_json(
            {
                "csv": str(csv_path), "png": str(png_path) if png_path else None, "steps": len(times) - 1,
                "solved": len(found.time), "residual": found.contradiction, "status": found.status.word,
                "end": found.end, "events": events, "energy_drift": found.worst_drift,
                "energy_corrected": found.corrected, "evaluations": found.evaluations, "integrator_steps": found.steps,
                "reachable": _reached(found), "open": open_ones,
            }
        )  # fmt: skip
        return
    _tell_events(events)
    typer.echo(
        f"{found.mechanism.name}: {len(found.time)} of {len(times)} rows, {found.steps} steps,"
        f" {found.evaluations} evaluations; energy drift {found.worst_drift:.1e} of the greatest energy"
    )
    if open_ones:
        tell_open(open_ones)
    if found.status.word != "ok":
        typer.echo(f"ended at {found.end:.10g} s, {found.status.word}: {found.status.plain_text}")
    typer.echo(f"wrote {csv_path}" + (f" and {png_path}" if png_path else ""))


def _reached(found: Simulation) -> dict[str, list[list[float]]]:
    """Return the interval that each input has passed over at the rows, in the file's unit."""
    rows = [found.mechanism.value_to_file(k, found.inputs[0, k]) for k in range(len(found.mechanism.actuators))]
    names = [a.name for a in found.mechanism.actuators]
    return {
        name: [[float(values.min()), float(values.max())]] if len(values) else []
        for name, values in zip(names, rows, strict=True)
    }


def _tell_events(events: list[dict[str, Any]]) -> None:
    from gimcli.cli.console import number, print_table

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
    if len(events) > EVENTS:
        typer.echo(f"... and {len(events) - EVENTS} more (--json names all)")
