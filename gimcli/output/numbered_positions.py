"""Pictures of numbered positions: singular ones with the curves of the traced points, and equilibria.

Stable equilibria have full lines, the others dashes. With one released input also potential and holding effort over it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.output.graph import Axis, Curve, CurveGraph
from gimcli.output.panels import with_panels
from gimcli.output.picture import LAYOUT, Content, Picture, PictureLayout, composition
from gimcli.output.pose import Drawing, Shown, solved
from gimcli.output.scene import Scene
from gimcli.output.style import GHOST_PIN, INK, PALETTE, Mark, Pen

if TYPE_CHECKING:
    from gimcli.dynamics.equilibria_curve import BalanceHistory, Equilibria

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
