"""`gim circuits`: which configurations the motion joins."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.cli.arguments import MODEL, Json, ModelPath

if TYPE_CHECKING:
    from gimcli.branching.enumeration import Circuits, Strand

NAME = "circuits"
HELP = (
    "Find the circuits of a mechanism: which of its configurations the motion joins without taking it apart.\n\n"
    "All configurations are listed at --samples values of the input, and each is followed through limits and change"
    " points until it is home. A branch is a stretch of a circuit between two limits of the input. Circuits that meet"
    " at change points count as one, of several curves. A circuit whose input moves by less than the spacing of the"
    " samples may be missed: the report says how fine that is. Several inputs follow their laws together.\n\n"
    "Example: gim circuits models/stephenson_2.yaml --png circuits.png"
)
PLACES = 361
"""Places of a curve that are drawn."""

STILL = 1e-6
"""Change of a distance, in the normal frame, that is none."""

ROUND = 1e-12
"""Part of a turn or of the size below which a told value is 0."""


def command(
    model: ModelPath = MODEL,
    samples: Annotated[
        int, typer.Option("--samples", min=4, max=100_000, help="Values of the input at which all are listed.")
    ] = 72,
    png: Annotated[
        Path | None, typer.Option("--png", help="Draw the curves of the traced points, one circuit a line style.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Find the circuits and list them."""
    from gimcli.branching.enumeration import EnumerationConstants, circuits
    from gimcli.cli.console import print_json
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.model import load
    from gimcli.output import refuse_files
    from gimcli.structure.drive_check import explained

    mechanism = load(model)
    refuse_files(mechanism.files, None, png)
    with explained(mechanism):
        found = circuits(
            mechanism, EnumerationConstants(samples=samples), progress_bar("configurations and their circuits")
        )
    drawn = png is not None and bool(found.strands)
    if drawn:
        assert png is not None
        progress_bar(DRAWING)
        _draw(found, png)
    if as_json:
        print_json(_report(found, png if drawn else None))
    else:
        _print(found)
        if drawn:
            typer.echo(f"wrote {png}")
    if not found.strands:
        raise typer.Exit(5)


def _inputs(found: Circuits, q: float) -> dict[str, float]:
    """Return the inputs at a parameter in the file's units."""
    mechanism, u = found.curve.mechanism, found.curve.inputs(q)
    values = {a.name: float(mechanism.value_to_file(k, u[k : k + 1])[0]) for k, a in enumerate(mechanism.actuators)}
    return {name: value if abs(value) > ROUND else 0.0 for name, value in values.items()}


def _label(found: Circuits, index: int) -> str:
    """Return the name of a strand: the circuit's number, and a letter where it has several curves."""
    own = found.strands[index].number
    same = [k for k, s in enumerate(found.strands) if s.number == own]
    return f"{own + 1}" + ("" if len(same) == 1 else chr(ord("a") + same.index(index)))


def _span(found: Circuits, strand: Strand) -> dict[str, list[float]]:
    low, high = (_inputs(found, q) for q in strand.interval)
    return {name: sorted([low[name], high[name]]) for name in low}


def _report(found: Circuits, png: Path | None) -> dict[str, Any]:
    mechanism = found.curve.mechanism
    curves = [
        {
            "curve": _label(found, k), "circuit": s.number + 1, "closed": s.circuit.closed, "ended": s.circuit.ended,
            "turns": abs(s.circuit.turns), "interval": _span(found, s),
            "branches": [{"from": _inputs(found, b.start), "to": _inputs(found, b.end)} for b in s.branches],
        }
        for k, s in enumerate(found.strands)
    ]  # fmt: skip
    listed = []
    for z, at in zip(mechanism.to_file(found.start.z), found.places, strict=True):
        nodes = {n: [float(v.real), float(v.imag)] for n, v in zip(mechanism.nodes, z, strict=True)}
        listed.append(
            {
                "circuit": found.strands[at[0][0]].number + 1 if at else None,
                "branches": [f"{_label(found, k)}.{b + 1}" for k, b in at], "nodes": nodes,
            }
        )  # fmt: skip
    return {
        "circuits": found.count, "complete": found.complete, "samples": len(found.sampled),
        "spacing": _spacing(found)[0], "lost": found.lost,
        "curves": curves, "at": _inputs(found, found.curve.begin()), "configurations": listed,
        "png": str(png) if png else None,
    }  # fmt: skip


def _print(found: Circuits) -> None:
    from gimcli.cli.console import number, print_table

    mechanism = found.curve.mechanism
    rows = []
    for k, strand in enumerate(found.strands):
        ends = "\n".join(f"{n} {number(a)} to {number(b)}" for n, (a, b) in _span(found, strand).items())
        turns = abs(strand.circuit.turns)
        how = (
            strand.circuit.ended
            if not strand.circuit.closed
            else "closed" + (f" after {turns:g} turn{'s' * (turns != 1)}" if turns else "")
        )
        there = [
            f"{i + 1}" + (f" (branch {b + 1})" if len(strand.branches) > 1 else "")
            for i, at in enumerate(found.places) for j, b in at if j == k
        ]  # fmt: skip
        rows.append((_label(found, k), how, ends, str(len(strand.branches)), ", ".join(there) or "none"))
    at = ", ".join(f"{name} = {number(value)}" for name, value in _inputs(found, found.curve.begin()).items())
    title = f"{mechanism.name}: {found.count} circuit{'s' * (found.count != 1)}"
    print_table(title, ("circuit", "", "input", "branches", f"configurations at {at}"), rows, right=(3,))
    typer.echo(_verdict(found))


def _spacing(found: Circuits) -> tuple[float, str]:
    """Return the spacing of the values of the input looked at, and its unit; of several a part of their laws."""
    import numpy as np

    mechanism, spacing = found.curve.mechanism, np.array([found.spacing])
    if not found.curve.single:
        low, high = found.curve.laws
        return float(found.spacing / (high - low)), "of the laws' range"
    unit = mechanism.angle_unit if found.curve.rotary[0] else mechanism.length_unit
    return float(mechanism.value_to_file(0, spacing)[0]), "" if unit == "unit" else unit


def _verdict(found: Circuits) -> str:
    count = len(found.sampled)
    if not found.complete:
        lost = f"; {found.lost} configurations could not be followed" if found.lost else ""
        return f"at {count} values of the input not all configurations are proved to be known{lost}"
    step = "{:.3g} {}".format(*_spacing(found)).rstrip()
    return (
        f"complete at {count} values of the input: all configurations there are proved to be known, and each is on one"
        f" of these; a circuit that spans less than {step} may lie between them"
    )


def _draw(found: Circuits, png: Path) -> None:
    import numpy as np

    from gimcli.branching.resampling import along
    from gimcli.motion.coupler_points import carried_point
    from gimcli.output import draw_motion
    from gimcli.table import Column, Table

    curve, mechanism = found.curve, found.curve.mechanism
    ways = [along(s.circuit, max(PLACES, len(s.circuit.places))) for s in found.strands]
    paths = {
        name: [mechanism.to_file(carried_point(mechanism, name, curve.nodes(p))) for p in ways]
        for name in mechanism.traced
    }
    name = next((n for n in paths if _free(found, paths[n])), mechanism.traced[0])
    labels = [f"circuit {_label(found, k)}" for k in range(len(found.strands))]
    firsts = {s.number: k for k, s in reversed(list(enumerate(found.strands)))}
    poses = np.array([mechanism.to_file(curve.nodes(ways[k][:, 0])) for _, k in sorted(firsts.items())])
    across = np.concatenate([_values(found, p[-1]) for p in ways])
    columns = []
    for k, label in enumerate(labels):
        column = np.full(len(across), np.nan)
        first = sum(p.shape[1] for p in ways[:k])
        own = slice(first, first + ways[k].shape[1])
        column[own] = paths[name][k].imag
        jumps = np.flatnonzero(np.abs(np.diff(across[own])) > 0.5 * float(np.ptp(across))) + 1
        column[first + jumps] = np.nan
        columns.append(Column(label, column, mechanism.length_unit))
    title = f"{mechanism.name}: {found.count} circuit{'s' * (found.count != 1)}"
    curves = {f"{name}, {label}": path for label, path in zip(labels, paths[name], strict=True)}
    head = Column(*_abscissa(found, across))
    draw_motion(mechanism, poses, curves, png, title, panels={f"{name}.y": Table((head, *columns))})


def _free(found: Circuits, paths: list[Any]) -> bool:
    """Tell whether a point's paths are more than circles about a node of the frame."""
    import numpy as np

    mechanism = found.curve.mechanism
    frame = mechanism.to_file(mechanism.members[0].shape)
    return all(any(np.ptp(np.abs(path - centre)) > STILL * mechanism.scale for path in paths) for centre in frame)


def _values(found: Circuits, q: Any) -> Any:
    """Return parameters, those of a rotary input within one turn from the start of its law."""
    import numpy as np

    if not (found.curve.single and found.curve.rotary[0]):
        return q
    begin = found.curve.begin()
    return begin + np.mod(q - begin, 2.0 * np.pi)


def _abscissa(found: Circuits, values: Any) -> tuple[str, Any, str]:
    """Return name, values and unit of what the graph is drawn over."""
    mechanism = found.curve.mechanism
    if found.curve.line is None:
        return "time", values / found.curve.span * mechanism.duration, "s"
    main = found.curve.line.main
    unit = mechanism.angle_unit if found.curve.rotary[main] else mechanism.length_unit
    return mechanism.actuators[main].name, mechanism.value_to_file(main, values), unit
