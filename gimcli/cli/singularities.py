"""`gim singularities`: limits, dead points, change points and stationary positions of a circuit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import MODEL, Json, ModelPath

if TYPE_CHECKING:
    from gimcli.branching.singular_positions import Found, Survey
    from gimcli.branching.singularities import BranchRates
    from gimcli.mechanism import FloatArray

NAME = "singularities"
HELP = (
    "List where the mechanism is singular, along the whole circuit that it is drawn on and along every branch that"
    " meets it.\n\n"
    "limit: the input turns back, and cannot drive there. dead point: the input rests, the motion goes on. change"
    " point: branches cross, with the turning rates of the members on each. tangency: the constraints lose rank but one"
    " branch alone goes on. stationary: a member hinged to the frame, or a slider on it, turns back. Several inputs"
    " follow their laws together.\n\n"
    "Example: gim singularities models/parallelogram.yaml --png positions.png"
)
MEMBERS = 3
CURVES = 6
ALIKE = 1e-6
"""Part of the greatest difference between branches that is none: tangents are told to half the digits at the worst."""
DUST = 1e-14
"""An input below this, in rad or in the normal frame's length, is 0."""


def command(
    model: ModelPath = MODEL,
    png: Annotated[
        Path | None, typer.Option("--png", help="Draw the positions over the curves of the traced points.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Follow the circuits and list what is singular."""
    from gimcli.branching.singular_positions import survey
    from gimcli.cli.console import print_json
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.model import load
    from gimcli.output import refuse_files
    from gimcli.structure.drive_check import explained

    mechanism = load(model)
    refuse_files(mechanism.files, None, png)
    with explained(mechanism):
        found = survey(mechanism, progress=progress_bar("following branches"))
    if png is not None:
        progress_bar(DRAWING)
        _draw(found, png)
    if as_json:
        print_json(_report(found, png))
    else:
        _print(found, png)


def _inputs(found: Survey, u: FloatArray) -> dict[str, float]:
    import numpy as np

    mechanism = found.curve.mechanism
    u = np.where(np.abs(u) > DUST, u, 0.0)
    return {a.name: float(mechanism.value_to_file(k, u[k : k + 1])[0]) for k, a in enumerate(mechanism.actuators)}


def _interval(found: Survey, reach: tuple[float, float]) -> dict[str, list[float]]:
    low, high = (_inputs(found, found.curve.inputs(q)) for q in reach)
    return {name: sorted([low[name], high[name]]) for name in low}


def _tangents(found: Survey, one: Found) -> list[BranchRates]:
    from gimcli.branching.singularities import rates

    return [rates(found.curve, one.what.p, v) for v in one.what.branches]


def _report(found: Survey, png: Path | None) -> dict[str, Any]:
    mechanism = found.curve.mechanism
    listed = []
    for one in found.found:
        z = mechanism.to_file(found.curve.nodes(one.what.p))
        listed.append(
            {
                "kind": one.what.kind, "at": _inputs(found, _at(found, one)), "end": one.what.end or None,
                "about": list(one.what.about), "freer": one.what.loose, "branches": [k + 1 for k in one.circuits],
                "tangents": [{"inputs": t.inputs, "members": t.members} for t in _tangents(found, one)],
                 "nodes": dict(zip(mechanism.nodes, _pairs(z), strict=True)),
            }
        )  # fmt: skip
    circuits = [
        {"branch": k + 1, "closed": c.closed, "ended": c.ended, "turns": abs(c.turns), "interval": _interval(found, r)}
        for k, (c, r) in enumerate(zip(found.branches.circuits, found.reach, strict=True))
    ]
    return {
        "circuits": circuits, "singularities": listed, "complete": found.complete,
        "png": str(png) if png else None,
    }  # fmt: skip


def _pairs(z: Any) -> list[list[float]]:
    return [[float(v.real), float(v.imag)] for v in z]


def _at(found: Survey, one: Found) -> FloatArray:
    from gimcli.branching.singular_positions import inputs_of

    return inputs_of(found, float(one.what.p[-1]))


def _print(found: Survey, png: Path | None) -> None:
    from gimcli.cli.console import number, print_table
    from gimcli.cli.progress import end_bars

    end_bars()
    mechanism = found.curve.mechanism
    names = [a.name for a in mechanism.actuators]
    rows = []
    for k, one in enumerate(found.found):
        inputs = _inputs(found, _at(found, one))
        kind = f"{one.what.kind}{' (' + one.what.end + ')' if one.what.end else ''}"
        where = ", ".join(str(b + 1) for b in one.circuits)
        rows.append(
            (
                str(k + 1),
                kind,
                *(number(inputs[n], 12) for n in names),
                where,
                ", ".join(one.what.about),
                _rates(found, one),
            )
        )
    head = ("", "kind", *(f"{n}{_unit(mechanism, i)}" for i, n in enumerate(names)), "branch", "about", "rates")
    if rows:
        print_table(mechanism.name, head, rows, right=(0, *range(2, 2 + len(names))))
    else:
        typer.echo(f"{mechanism.name}: nothing is singular")
    for k, (circuit, reach) in enumerate(zip(found.branches.circuits, found.reach, strict=True)):
        way = "; ".join(f"{n} {number(a)} to {number(b)}" for n, (a, b) in _interval(found, reach).items())
        turns = f" after {abs(circuit.turns):g} turn{'s' * (abs(circuit.turns) != 1)}" if circuit.turns else ""
        typer.echo(f"branch {k + 1}: {'closed' + turns if circuit.closed else circuit.ended}; {way}")
    if not found.complete:
        typer.echo("more branches meet than are followed")
    if png is not None:
        typer.echo(f"wrote {png}")


def _unit(mechanism: Any, k: int) -> str:
    unit = mechanism.angle_unit if mechanism.actuators[k].drive.value == "rotary" else mechanism.length_unit
    return "" if unit in ("", "unit") else f" [{unit}]"


def _rates(found: Survey, one: Found) -> str:
    """Return, for every branch, the members whose rates differ most between branches."""
    told = _tangents(found, one)
    free = ["more than one freedom"] * one.what.loose
    if not told:
        return "".join(free)
    names = list(told[0].members)
    spread = {n: max(t.members[n] for t in told) - min(t.members[n] for t in told) for n in names}
    least = ALIKE * max(spread.values(), default=0.0)
    chosen = [n for n in sorted(names, key=lambda n: -spread[n])[:MEMBERS] if spread[n] > least] or names[:MEMBERS]
    lines = []
    for t in told:
        rest = "input rests: " if t.rests else ""
        lines.append(rest + ", ".join(f"{n} {t.members[n]:+.6g}" for n in chosen))
    return "\n".join(lines + free)


def _draw(found: Survey, png: Path) -> None:
    from gimcli.branching.resampling import along
    from gimcli.motion.coupler_points import carried_point
    from gimcli.output import draw_singularities
    from gimcli.output.singular import Shown

    curve, mechanism = found.curve, found.curve.mechanism
    several = len(found.branches.circuits) > 1
    names = mechanism.traced[: max(1, CURVES // len(found.branches.circuits))]
    curves = {}
    for k, circuit in enumerate(found.branches.circuits):
        z = curve.nodes(along(circuit, max(361, len(circuit.places))))
        for name in names:
            curves[f"{name}, branch {k + 1}" if several else name] = mechanism.to_file(
                carried_point(mechanism, name, z)
            )
    shown = []
    for number, one in enumerate(found.found, start=1):
        z = curve.nodes(one.what.p)
        at = tuple(complex(mechanism.to_file(carried_point(mechanism, n, z[:, None]))[0]) for n in names[:1])
        shown.append(Shown(number, one.what.kind, mechanism.to_file(z), at))
    draw_singularities(mechanism, shown, curves, png, f"{mechanism.name}: singular positions")
