"""Pictures of circuits, and of numbered positions on them: singular ones and equilibria.

Circuits are the paths of one point on all circuits, and a graph over the input. Stable equilibria have full lines, the
others dashes; with one released input also potential and holding effort over it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.branching.enumeration import Circuits
from gimcli.branching.resampling import along
from gimcli.connected import alike
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.output.curves import overlap, same_path
from gimcli.output.drawing import motion_picture
from gimcli.output.gallery import gallery_picture
from gimcli.output.geometry import Geometry
from gimcli.output.graph import Axis, Curve, CurveGraph
from gimcli.output.panels import with_panels
from gimcli.output.picture import LAYOUT, Content, Picture, PictureLayout, composition
from gimcli.output.pose import Drawing, Shown, solved
from gimcli.output.scene import Scene
from gimcli.output.style import GHOST_PIN, INK, PALETTE, Mark, Pen
from gimcli.structure.carried import carried_point

if TYPE_CHECKING:
    from gimcli.dynamics.equilibria_curve import BalanceHistory, Equilibria

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
    return with_panels(drawing, [_graph(found, lines, values, labels, f"{name}.{axis}")])


def circuits_geometry(found: Circuits, labels: Sequence[str]) -> Geometry:
    """Return the paths of the traced points on all circuits, and a position on the first one, in true size."""
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


def _graph(
    found: Circuits, lines: Sequence[FloatArray], values: Sequence[FloatArray], labels: Sequence[str], name: str
) -> CurveGraph:
    """Return a coordinate on each circuit over the input; a curve has a gap where a rotary input begins again."""
    every = [_values(found, p[-1]) for p in lines]
    turn, curves = 0.5 * float(np.ptp(np.concatenate(every))), []
    for label, q, own in zip(labels, every, values, strict=True):
        jumps = np.abs(np.diff(q, prepend=q[:1])) > turn
        curves.append(Curve(f"circuit {label}", _abscissa(found, q)[1], np.where(jumps, np.nan, own)))
    across, _, unit = _abscissa(found, every[0])
    return CurveGraph(Axis(across, unit), Axis(name, found.curve.mechanism.length_unit), curves)


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


SINGULAR = {
    "change point": Mark("s", 7.0, width=1.4, layer=9),
    "tangency": Mark("D", 6.0, layer=9),
    "limit": Mark("^", 7.0, face=INK, layer=9),
    "dead point": Mark("X", 7.0, face=INK, width=0.4, layer=9),
    "stationary": Mark("o", 5.0, layer=9),
}
"""The mark of each kind of singular position."""


@composition
def singular_picture(
    mechanism: Mechanism, shown: Sequence[Shown], curves: Mapping[str, ComplexArray], title: str, *,
    layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return the first position in the order of the kinds strong, some others light, and numbered marks."""
    order = list(SINGULAR)
    chosen = sorted(shown, key=lambda one: order.index(one.kind))[: layout.ghosts + 1]
    scene = solved(mechanism, np.array([one.pose for one in chosen])) if chosen else None
    drawing = Drawing.around(mechanism, scene, title, curves.values(), layout)
    drawing.poses(range(1, len(chosen)), layout.members)
    drawing.curves(curves)
    drawing.numbered(shown, SINGULAR, PALETTE[0])
    return drawing.write(sorted(scene.used) if scene else (), {})


STABLE = Pen(1.6, "#3577bd", layer=4)
OTHER = Pen(1.3, "#a50f15", (3.0, 2.0), layer=3)
"""Lines of the members in further stable positions, and in the others."""

BALANCED = {
    "stable": Mark("s", 5.5, face=INK, width=0.5, layer=11),
    "unstable": Mark("o", 5.5, width=1.1, layer=11),
    "undecided": Mark("D", 5.0, layer=11),
}
"""The mark of each stability at a point that moves."""

MOST = 12
"""Largest number of positions that are drawn."""


@composition
def equilibria_picture(
    mechanism: Mechanism, shown: Sequence[Shown], title: str, *, layout: PictureLayout = LAYOUT
) -> Picture:
    """Return the mechanism in each equilibrium, the first stable one with all symbols; at least one is needed."""
    strong = next((one for one in shown if one.kind == "stable"), shown[0])
    drawn = [strong, *(one for one in shown if one is not strong)][:MOST]
    scene = Scene(mechanism, np.array([one.pose for one in drawn]))
    drawing = Drawing.around(mechanism, scene, title, (), layout)
    for one in drawn[1:]:
        with drawing.picture.named(f"equilibrium:{one.number}"):
            drawing.lines(scene, one.pose, STABLE if one.kind == "stable" else OTHER, GHOST_PIN)
    drawing.poses()
    node = _free_node(scene)
    placed = [replace(one, at=(complex(one.pose[node]),)) for one in sorted(drawn, key=lambda one: one.number)]
    drawing.numbered(placed, BALANCED, size=10.0)
    return drawing.write(sorted(scene.used & scene.fixed), {})


def _free_node(scene: Scene) -> int:
    """Return the node with the greatest distances between its places; of a single position, one that moves."""
    moving = [node for node in sorted(scene.used) if node not in scene.fixed] or [0]
    spread = [float(np.abs(scene.poses[:, node] - scene.poses[:, node].mean()).max()) for node in moving]
    return moving[int(np.argmax(spread))]


OUTSIDE = 3.0
"""Coordinate, in sizes, up to which a curve that goes to infinity is shown, unless there are equilibria beyond."""

ORDER = ("unstable", "stable", "undecided")
"""Kinds in the order of the marks of events: an open circle, a filled square, an open diamond."""


def equilibrium_picture(mechanism: Mechanism, found: Equilibria, title: str) -> Content:
    """Return the mechanism in all equilibria, or in the start position, with graphs if one input is released."""
    shown = [Shown(k + 1, one.stability, mechanism.to_file(one.z)) for k, one in enumerate(found.found)] or [
        Shown(0, "", mechanism.to_file(found.start))
    ]
    picture = equilibria_picture(mechanism, shown, title)
    return picture if found.history is None else with_panels(picture, _graphs(mechanism, found, found.history))


def _graphs(mechanism: Mechanism, found: Equilibria, history: BalanceHistory) -> list[CurveGraph]:
    """Return potential and effort over the released input, with the equilibria."""
    main = found.released[0]
    actuator, rows = mechanism.actuators[main], _shown_rows(found, history)
    q = mechanism.value_to_file(main, history.inputs[main, rows])
    places = mechanism.value_to_file(main, np.array([one.inputs[main] for one in found.found]))
    effort = np.where(np.isfinite(history.effort), history.effort, np.nan)[rows]
    over, unit = Axis(actuator.name, mechanism.unit_of(actuator)), "N m" if actuator.rotary else "N"
    numbers = [(float(x), str(k + 1)) for k, x in enumerate(places)]
    return [
        CurveGraph(
            over, Axis("potential", "J"), [Curve("potential", q, history.potential[rows])], verticals=numbers,
            events=_marks(found, places, [one.potential for one in found.found]),
        ),
        CurveGraph(
            over, Axis("holding effort", unit), [Curve("holding effort", q, effort)],
            events=_marks(found, places, [0.0] * len(places)),
        ),
    ]  # fmt: skip


def _marks(found: Equilibria, x: FloatArray, y: Sequence[float]) -> Mapping[str, list[complex]]:
    """Return the places of the equilibria in a graph by their kind."""
    every = list(zip(found.found, x.tolist(), y, strict=True))
    return {kind: [complex(a, b) for one, a, b in every if one.stability == kind] for kind in ORDER}


def _shown_rows(found: Equilibria, history: BalanceHistory) -> IntArray:
    """Return the numbers of the rows that are not far outside the mechanism."""
    far = max([OUTSIDE, *(1.5 * _reach(one.z[:, None])[0] for one in found.found)])
    return np.asarray(np.flatnonzero(_reach(history.z) <= far))


def _reach(z: ComplexArray) -> FloatArray:
    """Return the greatest coordinate of some positions (nodes, rows)."""
    return np.asarray(np.max(np.maximum(np.abs(z.real), np.abs(z.imag)), axis=0))
