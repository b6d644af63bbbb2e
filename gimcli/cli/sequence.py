"""`gim sequence`: in which order restrictions are imposed, and why."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, At, Json, ModelPath, Strategy, StrategyOption, Tolerance, inputs_at

if TYPE_CHECKING:
    from gimcli.gim.report import SequenceGroupReport
    from gimcli.mechanism import Mechanism

NAME = "sequence"
HELP = (
    "Show the sequence of the Geometrical-Iterative Method: groups in order of solution, which node is moved about"
    " what, and how fast a sweep converges.\n\n"
    "Example: gim sequence models/double_butterfly.yaml --explain"
)


def command(
    model: ModelPath = MODEL,
    explain: Annotated[bool, typer.Option("--explain", help="Say for every step which rule placed it.")] = False,
    strategy: StrategyOption = Strategy.SPECTRAL,
    at: At = [],  # noqa: B006 - typer wants a list; nothing changes it
    tolerance: Tolerance = 1e-10,
    png: Annotated[Path | None, typer.Option("--png", help="Draw the mechanism with the steps numbered.")] = None,
    as_json: Json = False,
) -> None:
    """Search and show the sequence."""
    from gimcli.cli.console import print_json, tell_written
    from gimcli.cli.progress import end_bars
    from gimcli.gim.report import report
    from gimcli.model import load
    from gimcli.motion.solve import solve
    from gimcli.output import refuse_files
    from gimcli.positions.options import Options
    from gimcli.status import Status
    from gimcli.structure.drive_check import explained, refuse_contradiction

    mechanism = load(model)
    refuse_files(mechanism.files, None, png)
    with explained(mechanism):
        inputs = inputs_at(mechanism, at)
        position = solve(mechanism, inputs, Options(tolerance=tolerance))
        refuse_contradiction(mechanism, position.z, inputs, position.status, tolerance)
        z = position.z if position.status is Status.OK else mechanism.drawn
        groups = report(mechanism, z, inputs, strategy.value, tolerance)
    if png is not None:
        from gimcli.output import draw_sequence

        steps = [(s.number, s.about_numbers) for g in groups for s in g.steps]
        draw_sequence(mechanism, mechanism.to_file(z), steps, png, f"{mechanism.name}: sequence")
    if as_json:
        print_json({"groups": [_json(g) for g in groups], "png": str(png) if png else None})
        return
    end_bars()
    count = f"{len(groups)} group{'s' * (len(groups) != 1)}"
    typer.echo(f"{mechanism.name}: {count}, {sum(len(g.steps) for g in groups)} moves a sweep")
    for number, group in enumerate(groups, start=1):
        _print(mechanism, number, group, explain)
    tell_written(png)


def _json(group: SequenceGroupReport) -> dict[str, object]:
    return {
        "kind": group.kind,
        "nodes": list(group.nodes),
        "steps": [
            {
                "node": s.node, "about": list(s.about), "constraint": s.constraint, "rule": s.rule, "kind": s.kind,
                "states": s.states,
            }
            for s in group.steps
        ],
        "radius": group.radius,
        "classic_radius": group.classic_radius,
        "predicted_sweeps": group.predicted_sweeps,
        "observed_sweeps": group.observed_sweeps,
        "candidates": group.candidates,
    }  # fmt: skip


def _print(mechanism: Mechanism, number: int, group: SequenceGroupReport, explain: bool) -> None:
    from gimcli.cli.console import print_table

    predicted = "never" if group.predicted_sweeps is None else f"{group.predicted_sweeps:.0f}"
    observed = "did not converge" if group.observed_sweeps is None else str(group.observed_sweeps)
    title = f"{number}. {group.kind} {' '.join(group.nodes)}"
    head = ["step", "move", "about", "by", "rule"] + (["states after it"] if explain else [])
    rows = []
    for k, s in enumerate(group.steps, start=1):
        row = [str(k), s.node, " ".join(s.about), s.constraint, s.rule]
        if explain:
            row.append(" ".join(f"{n}:{t}" for n, t in s.states.items()))
        rows.append(row)
    print_table(title, head, rows)
    typer.echo(
        f"   spectral radius {group.radius:.4f} (classic {group.classic_radius:.4f}), {group.candidates} candidates;"
        f" sweeps predicted {predicted}, observed {observed}"
    )
    if explain:
        for k, s in enumerate(group.steps, start=1):
            typer.echo(f"   {k}. {s.reason}")
    typer.echo("")
