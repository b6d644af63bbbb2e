"""`gim trace --circuit` and `--all-branches`: the closed curves of whole circuits."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from gimcli.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from gimcli.cli.asked import Asked
    from gimcli.continuation.circuit import Circuit
    from gimcli.mechanism import ComplexArray, Mechanism
    from gimcli.motion.motion import Motion
    from gimcli.table import Table

POSES = 6


def trace_circuit(
    mechanism: Mechanism, steps: int, tolerance: float, branch: int, every: bool, paths: tuple[Path, Path | None],
    as_json: bool, ask: Callable[[], Asked],
) -> bool:  # fmt: skip
    """Follow a circuit, or every branch that meets it; write and report. Return whether all rows are solved.

    `ask` makes the measures of one circuit.
    """
    from gimcli.branching.resampling import circuit_motion
    from gimcli.branching.singular_positions import drawn_circuit
    from gimcli.branching.singularities import singularities
    from gimcli.cli.progress import progress_bar
    from gimcli.continuation.branches import all_circuits

    progress_bar("following the circuit")
    circuits: tuple[Circuit, ...] = (drawn_circuit(mechanism, tolerance),)
    if every or branch > 1:
        circuits = all_circuits(circuits[0], progress=progress_bar("following branches")).circuits
    if branch > len(circuits):
        raise UsageError(
            f"--branch {branch}: {len(circuits)} circuit{'s meet' * (len(circuits) > 1) or ' there is'} here;"
            " `gim singularities` lists them"
        )
    numbers = list(range(1, len(circuits) + 1)) if every else [branch]
    progress_bar("positions along the circuit")
    motions = [circuit_motion(circuits[n - 1], steps + 1, tolerance) for n in numbers]
    asked = [ask() for _ in numbers]
    _write(motions, asked, numbers if every else [], paths)
    told = [
        _told(mechanism, n, circuits[n - 1], singularities(circuits[n - 1])) | own.report(motion)
        for n, own, motion in zip(numbers, asked, motions, strict=True)
    ]
    _report(mechanism, steps, motions, told, paths, as_json, asked[0])
    return all(bool(m.good.all()) for m in motions)


def _write(motions: list[Motion], asked: list[Asked], numbers: list[int], paths: tuple[Path, Path | None]) -> None:
    """Write the rows of all circuits one after another, with their `numbers` as a last column, and the picture."""
    import numpy as np

    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.output import CsvStream
    from gimcli.rates.motion_table import motion_table
    from gimcli.table import Column, Table

    csv_path, png_path = paths
    tables = [motion_table(m, more=own.columns(m)) for m, own in zip(motions, asked, strict=True)]
    if numbers:
        tables = [
            Table((*t.columns, Column("branch", np.full(len(t), n)))) for t, n in zip(tables, numbers, strict=True)
        ]
    with CsvStream(csv_path, tables[0].names) as stream:
        for table in tables:
            stream.append(table)
        if png_path:
            progress_bar(DRAWING)
            _draw(motions, asked, numbers, png_path)


def _draw(motions: list[Motion], asked: list[Asked], numbers: list[int], png: Path) -> None:
    """Draw poses of the first circuit, the curves, areas and graphs of all."""
    import numpy as np

    from gimcli.output import draw_motion
    from gimcli.rates.motion_table import traced_paths

    first, mechanism = motions[0], motions[0].mechanism
    chosen = np.flatnonzero(first.good)
    chosen = chosen[np.unique(np.linspace(0, len(chosen), POSES, endpoint=False).astype(int))]
    paths: dict[str, ComplexArray] = {}
    more: dict[str, ComplexArray] = {}
    outlines: list[ComplexArray] = []
    panels: dict[str, Table] = {}
    for k, (motion, own) in enumerate(zip(motions, asked, strict=True)):
        tail = f", branch {numbers[k]}" if len(motions) > 1 else ""
        paths |= {name + tail: curve for name, curve in traced_paths(motion).items()}
        more |= {name + tail: curve for name, curve in own.curves(motion).items()}
        outlines += own.outlines(motion)
        panels |= {name + tail: table for name, table in own.panels(motion).items()}
    poses = mechanism.to_file(first.z[:, chosen].T)
    draw_motion(mechanism, poses, paths, png, f"{mechanism.name}: circuit", more, outlines, panels)


def _told(mechanism: Mechanism, number: int, circuit: Circuit, found: list[Any]) -> dict[str, Any]:
    """Return what is told of a circuit: how it ends, what its inputs reach, its limits and change points."""
    from gimcli.branching.singularities import STATIONARY, interval

    low, high = (circuit.curve.inputs(q) for q in interval(circuit, found))
    reach, events = {}, []
    for k, a in enumerate(mechanism.actuators):
        reach[a.name] = sorted(float(mechanism.value_to_file(k, u[k : k + 1])[0]) for u in (low, high))
    for one in found:
        if one.kind != STATIONARY:
            u = circuit.curve.inputs(float(one.p[-1]))
            at = {a.name: float(mechanism.value_to_file(k, u[k : k + 1])[0]) for k, a in enumerate(mechanism.actuators)}
            events.append({"kind": one.kind, "at": at, "way": one.way})
    return {
        "branch": number, "closed": circuit.closed, "ended": circuit.ended, "turns": abs(circuit.turns),
        "interval": reach, "events": events,
    }  # fmt: skip


def _report(
    mechanism: Mechanism, steps: int, motions: list[Motion], told: list[dict[str, Any]],
    paths: tuple[Path, Path | None], as_json: bool, asked: Asked,
) -> None:  # fmt: skip
    import numpy as np

    from gimcli.cli.console import number, print_json
    from gimcli.cli.progress import end_bars

    end_bars()
    csv_path, png_path = paths
    solved = sum(m.solved for m in motions)
    worst = float(np.nanmax([np.nanmax(m.residual) for m in motions]))
    if as_json:
        reach = {a.name: [t["interval"][a.name] for t in told] for a in mechanism.actuators}
        events = [{"branch": t["branch"], **e} for t in told for e in t["events"]]
        print_json(
            {
                "csv": str(csv_path), "png": str(png_path) if png_path else None, "steps": steps, "solved": solved,
                "residual": worst, "reachable": reach, "events": events,
                "circuits": [{k: v for k, v in t.items() if k != "events"} for t in told],
                "status": next((m.overall.word for m in motions if not m.good.all()), "ok"),
                **({"measures": told[0]["measures"]} if len(told) == 1 and "measures" in told[0] else {}),
            }
        )  # fmt: skip
        return
    rows = sum(len(m.time) for m in motions)
    typer.echo(f"{mechanism.name}: {solved} of {rows} positions solved, worst residual {worst:.1e}")
    for t in told:
        ends = "; ".join(f"{n} {number(a)} to {number(b)}" for n, (a, b) in t["interval"].items())
        turns = f" after {t['turns']:g} turn{'s' * (t['turns'] != 1)}" if t["turns"] else ""
        typer.echo(f"branch {t['branch']}: {'closed' + turns if t['closed'] else t['ended']}; {ends}")
        for e in t["events"]:
            typer.echo(f"  {e['kind']} at " + ", ".join(f"{n} = {v:.12g}" for n, v in e["at"].items()))
        asked.tell(t)
    typer.echo(f"wrote {csv_path}" + (f" and {png_path}" if png_path else ""))
