"""Picture and page of circuits: the paths of one point on all circuits, a graph over the input, and their motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.branching.enumeration import Circuits
from gimcli.branching.resampling import along, as_motion, lengths
from gimcli.branching.singularities import Singularity
from gimcli.continuation.circuit import Circuit, nearby
from gimcli.library.extras import Extras
from gimcli.library.trace_animation import event_text, first_graphs, row_at, rows_of, thinning, words
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.output.animation import Animation, Clip, Moment, shown_rows
from gimcli.output.curves import overlap, same_path
from gimcli.positions.options import TOLERANCE
from gimcli.quantities.motion_table import motion_table
from gimcli.structure.carried import carried_point
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.output.geometry import Geometry
    from gimcli.output.picture import Content

ROUND = 6.0
"""Time in which a circuit, which has no time of its own, is shown [s]."""

ROWS = 361
"""Number of rows of a circuit, without those of its events."""

PART = "part of the length"

NO_TIME = "a circuit has no time, so no velocities: trace the motion along the law"


@dataclass(frozen=True)
class SingularPlace:
    """A singular position on a circuit that is shown."""

    part: float  # of the length of the circuit, 0..1
    kind: str
    text: str
    p: FloatArray | None = field(default=None, repr=False)  # (n + 1,) position and parameter, for a row of its own


@dataclass(frozen=True)
class ShownCircuit:
    """A circuit with its name, a note and its singular positions."""

    name: str
    circuit: Circuit = field(repr=False)
    note: str
    places: tuple[SingularPlace, ...]


def circuits_animation(
    mechanism: Mechanism, title: str, circuits: Sequence[ShownCircuit], choice: str
) -> Animation | None:
    """Return the animation of circuits, one clip each, with a row at each singular position; None without circuits."""
    clips = []
    for one in circuits:
        ends = _ends(one.circuit)
        places = [_moved(place, *ends) for place in one.places]
        places = [place for place in places if 0.0 <= place.part <= 1.0]
        motion = _motion(one.circuit, places)
        clips.append(_clip(one.name, motion, motion_table(motion), places, one.circuit.closed, one.note))
    if not clips:
        return None
    over = mechanism.actuators[mechanism.drivers[0]].name if len(mechanism.drivers) == 1 else PART
    return Animation(title, mechanism, tuple(clips), first_graphs(clips[0].table, None, over), choice=choice)


def circuit_trace_animation(
    motions: Sequence[Motion], circuits: Sequence[Mapping[str, Any]], extras: Sequence[Extras]
) -> Animation:
    """Return the animation of a trace of circuits, one clip each.

    Args:
        motions: the rows of each circuit; their time is the part of its length.
        circuits: the report of each: number of its branch, whether it is closed, events.
        extras: the measures and graphs of each.
    """
    mechanism, clips = motions[0].mechanism, []
    for motion, circuit, own in zip(motions, circuits, extras, strict=True):
        table = own.with_expressions(own.apart(motion))
        places = [
            SingularPlace(one["way"], one["kind"], event_text(mechanism, one["kind"], one["at"]))
            for one in circuit["events"]
        ]
        name = f"branch {circuit['branch']}" if len(motions) > 1 else "circuit"
        clips.append(_clip(name, motion, table, places, circuit["closed"]))
    notes = thinning(max(len(clip.time) for clip in clips), max(len(motion.time) for motion in motions))
    first = first_graphs(clips[0].table, extras[0], PART)
    return Animation(f"{mechanism.name}: circuit", mechanism, tuple(clips), first, notes, "Circuit")


def part_of(circuit: Circuit, number: int, what: Singularity) -> float:
    """Return the part of the length of circuit `number` at which a singular position is."""
    if what.circuit == number:
        return what.fraction
    marks = lengths(circuit)
    apart = [float(np.linalg.norm(circuit.curve.apart(place.p, what.p))) for place in circuit.places]
    return float(marks[int(np.argmin(apart))] / marks[-1])


def _motion(circuit: Circuit, places: Sequence[SingularPlace]) -> Motion:
    """Return rows at equal distances along a circuit, with further rows at singular positions."""
    time, p = np.linspace(0.0, 1.0, ROWS), along(circuit, ROWS)
    for place in places:
        if place.p is not None and place.part not in time:
            k = int(np.searchsorted(time, place.part))
            own = _wound(circuit, place.p, float(p[-1, k]))
            time, p = np.insert(time, k, place.part), np.insert(p, k, own, axis=1)
    return as_motion(circuit, time, p, TOLERANCE)


def _wound(circuit: Circuit, p: FloatArray, near: float) -> FloatArray:
    """Return a position whose parameter is moved by whole turns to the turn of another parameter."""
    turn = circuit.curve.period
    if not (circuit.curve.single and circuit.curve.periodic):
        return p
    return np.append(p[:-1], near + (p[-1] - near + 0.5 * turn) % turn - 0.5 * turn)


def _ends(circuit: Circuit) -> tuple[float, float]:
    """Return the parts of the length between which a circuit is shown: not far outside, towards infinity."""
    marks = lengths(circuit)
    first, last = nearby(circuit)
    return float(marks[first] / marks[-1]), float(marks[last] / marks[-1])


def _moved(place: SingularPlace, first: float, last: float) -> SingularPlace:
    """Return a place with its part of the length that is shown."""
    return SingularPlace((place.part - first) / (last - first), place.kind, place.text, place.p)


def _clip(
    name: str, motion: Motion, table: Table, places: Sequence[SingularPlace], closed: bool, note: str = ""
) -> Clip:  # fmt: skip
    """Return the clip of a circuit; the time of the motion is the part of its length."""
    mechanism = motion.mechanism
    rows = shown_rows(motion.good, [row_at(motion.time, place.part) for place in places])
    columns = [Column(PART, motion.time), *(c for c in table.columns if c.name not in ("time", "sweeps"))]
    shown, kept = motion.rows(rows), rows_of(Table(tuple(columns)), rows)
    return Clip(
        name, mechanism.to_file(shown.z.T), shown.time * ROUND, words(shown.codes), kept, PART,
        tuple(Moment(row_at(shown.time, place.part), place.kind, place.text) for place in places),
        closed=closed, without=NO_TIME, note=note,
    )  # fmt: skip


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
    graph = _graph(found, lines, paths, labels)
    axis = "x" if all(np.ptp(p.imag) < 0.01 * np.ptp(p.real) for p in paths) else "y"
    together = list(curves.values())
    nested = any(overlap(a, b, _near(together)) for k, b in enumerate(together) for a in together[:k])
    drawing = motion_picture(mechanism, poses, curves, title, nested=nested)
    return with_panels(drawing, [graph_of(f"{name}.{axis}", graph(axis))])


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
    near, groups = _near(paths), list[list[int]]()
    if near == 0.0:
        return [list(range(len(paths)))]
    for k, path in enumerate(paths):
        own = next((group for group in groups if same_path(paths[group[0]], path, near)), None)
        if own is None:
            groups.append([k])
        else:
            own.append(k)
    return groups


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


def _graph(found: Circuits, lines: Sequence[FloatArray], paths: Sequence[ComplexArray], labels: Sequence[str]) -> Any:
    """Return a function of "x" or "y" that returns this coordinate of the paths over the input, a column a circuit."""
    across = np.concatenate([_values(found, p[-1]) for p in lines])

    def graph(axis: str) -> Table:
        columns = []
        for k, label in enumerate(labels):
            column = np.full(len(across), np.nan)
            first = sum(p.shape[1] for p in lines[:k])
            own = slice(first, first + lines[k].shape[1])
            column[own] = paths[k].imag if axis == "y" else paths[k].real
            jumps = np.flatnonzero(np.abs(np.diff(across[own])) > 0.5 * float(np.ptp(across))) + 1
            column[first + jumps] = np.nan
            columns.append(Column(f"circuit {label}", column, found.curve.mechanism.length_unit))
        return Table((Column(*_abscissa(found, across)), *columns))

    return graph


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
