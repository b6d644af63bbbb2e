"""The picture of circuits: the paths of one point on all circuits, and a graph over the input."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.branching.enumeration import Circuits
from gimcli.branching.resampling import along
from gimcli.connected import alike
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.output.curves import overlap, same_path
from gimcli.structure.carried import carried_point
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.output.geometry import Geometry
    from gimcli.output.picture import Content

PLACES = 361
"""Least number of positions on a circuit."""

TOGETHER = 6
"""With more paths, each has a panel of its own."""

PANELS = 36
"""Largest number of panels."""

STILL = 1e-6
"""Paths with a smaller extent, relative to the size, are points; arcs about a fixed node are found to this accuracy."""

ALIKE = 0.004
"""Paths at a smaller distance, relative to the extent of all paths, are drawn as one: about the width of a line."""


def circuits_picture(found: Circuits, labels: Sequence[str], title: str) -> Content:
    """Return the paths of the point that distinguishes the circuits best; `labels` are the names of the curves.

    Many circuits, and circuits with the same paths of all points, are side by side, with a position of each.
    """
    from gimcli.output.drawing import motion_picture
    from gimcli.output.gallery import gallery_picture
    from gimcli.output.graph import graph_of
    from gimcli.output.panels import with_panels

    curve, mechanism = found.curve, found.curve.mechanism
    lines = [along(s.circuit, max(PLACES, len(s.circuit.places))) for s in found.strands]
    name, paths, groups = _point(mechanism, [curve.nodes(p) for p in lines])
    starts = np.array([mechanism.to_file(curve.nodes(p[:, 0])) for p in lines])
    if len(groups) == 1 < len(lines) or len(groups) > TOGETHER:
        same = len(groups) == 1
        shown = list(range(len(lines)))[:PANELS] if same else [own[0] for own in groups[:PANELS]]
        titles = [_joined(labels, [k] if same else groups[i]) for i, k in enumerate(shown)]
        what = "all paths are the same" if same else f"path of {name}"
        drawn = [] if same else [paths[k] for k in shown]
        return gallery_picture(mechanism, starts[shown], titles, f"{title}, {what}", drawn)
    firsts = {s.number: k for k, s in reversed(list(enumerate(found.strands)))}
    poses = starts[[k for _, k in sorted(firsts.items())]]
    curves = {f"{name}, {_joined(labels, own)}": paths[own[0]] for own in groups}
    axis = "x" if all(np.ptp(p.imag) < 0.01 * np.ptp(p.real) for p in paths) else "y"
    together = list(curves.values())
    nested = any(overlap(a, b, _near(together)) for k, b in enumerate(together) for a in together[:k])
    drawing = motion_picture(mechanism, poses, curves, title, nested=nested)
    values = [path.imag if axis == "y" else path.real for path in paths]
    return with_panels(drawing, [graph_of(f"{name}.{axis}", _coordinates(found, lines, values, labels))])


def circuits_geometry(found: Circuits, labels: Sequence[str]) -> Geometry:
    """Return the paths of the traced points on all circuits, and a position on the first one, in true size."""
    from gimcli.output.geometry import Geometry

    mechanism = found.curve.mechanism
    geometry = Geometry(mechanism.length_unit)
    for k, (strand, label) in enumerate(zip(found.strands, labels, strict=True)):
        z = found.curve.nodes(along(strand.circuit, max(PLACES, len(strand.circuit.places))))
        for name in mechanism.traced:
            geometry.add_curve(f"curve {name} circuit {label}", mechanism.to_file(carried_point(mechanism, name, z)))
        if not k:
            geometry.add_mechanism(mechanism, mechanism.to_file(z[:, 0]))
    return geometry


def _point(mechanism: Mechanism, nodes: Sequence[ComplexArray]) -> tuple[str, list[ComplexArray], list[list[int]]]:
    """Return the point to draw, its path on each circuit, and the circuits with the same path together.

    It is the traced point, or else the node, with the largest number of different paths. Points that stay where they
    are or turn about a fixed node come last.
    """
    best: tuple[tuple[bool, int], str, list[ComplexArray], list[list[int]]] | None = None
    for name in dict.fromkeys((*mechanism.traced, *mechanism.nodes)):
        paths = [mechanism.to_file(carried_point(mechanism, name, z)) for z in nodes]
        groups = _alike(paths)
        merit = _free(mechanism, paths), len(groups)
        if best is None or merit > best[0]:
            best = merit, name, paths, groups
        if best[0] == (True, len(nodes)):
            break
    assert best is not None
    return best[1:]


def _alike(paths: Sequence[ComplexArray]) -> list[list[int]]:
    """Return the numbers of the paths, those that are the same together."""
    near = _near(paths)
    return alike(range(len(paths)), lambda k, first: near == 0.0 or same_path(paths[first], paths[k], near))


def _near(paths: Sequence[ComplexArray]) -> float:
    """Return the distance at which paths are not distinguished."""
    everything = np.concatenate(paths)
    return ALIKE * max(float(np.ptp(everything.real)), float(np.ptp(everything.imag)))


def _free(mechanism: Mechanism, paths: Sequence[ComplexArray]) -> bool:
    """Return whether the paths of a point are other than points, or circles around a node of the frame."""
    frame, still = mechanism.to_file(mechanism.members[0].shape), STILL * mechanism.scale
    return all(any(np.ptp(np.abs(path - centre)) > still for path in paths) for centre in frame) and any(
        np.ptp(path.real) > still or np.ptp(path.imag) > still for path in paths
    )


def _joined(labels: Sequence[str], own: Sequence[int]) -> str:
    return f"circuit{'s' * (len(own) > 1)} {', '.join(labels[k] for k in own)}"


def _coordinates(
    found: Circuits, lines: Sequence[FloatArray], values: Sequence[FloatArray], labels: Sequence[str]
) -> Table:
    """Return a coordinate on each circuit over the input, a column a circuit."""
    across = np.concatenate([_values(found, p[-1]) for p in lines])
    columns, last = [Column(*_abscissa(found, across))], 0
    for label, own in zip(labels, values, strict=True):
        first, last = last, last + len(own)
        column = np.full(len(across), np.nan)
        column[first:last] = own
        jumps = np.flatnonzero(np.abs(np.diff(across[first:last])) > 0.5 * float(np.ptp(across))) + 1
        column[first + jumps] = np.nan
        columns.append(Column(f"circuit {label}", column, found.curve.mechanism.length_unit))
    return Table(tuple(columns))


def _values(found: Circuits, q: Any) -> Any:
    """Return parameters, those of a rotary input within one period from the start of its law."""
    if not (found.curve.single and found.curve.periodic):
        return q
    begin = found.curve.begin()
    return begin + np.mod(q - begin, found.curve.period)


def _abscissa(found: Circuits, values: Any) -> tuple[str, Any, str]:
    """Return name, values and unit of the abscissa of the graph."""
    mechanism = found.curve.mechanism
    if found.curve.line is None:
        return "time", values / found.curve.span * mechanism.duration, "s"
    main = found.curve.line.main
    actuator = mechanism.actuators[main]
    return actuator.name, mechanism.value_to_file(main, values), mechanism.unit_of(actuator)
