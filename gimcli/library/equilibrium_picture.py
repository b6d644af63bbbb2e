"""The picture of equilibria: the mechanism in each, and potential and holding effort over the released input."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gimcli.dynamics.equilibria import BalanceHistory, Equilibria
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.output.equilibria import ShownEquilibrium, equilibria_picture
from gimcli.output.graph import Axis, Curve, CurveGraph
from gimcli.output.panels import with_panels
from gimcli.output.picture import Content

OUTSIDE = 3.0
"""Coordinate, in sizes, up to which a curve that goes to infinity is shown, unless there are equilibria beyond."""

ORDER = ("unstable", "stable", "undecided")
"""Kinds in the order of the marks of events: an open circle, a filled square, an open diamond."""


def equilibrium_picture(mechanism: Mechanism, found: Equilibria, title: str) -> Content:
    """Return the mechanism in all equilibria, or in the start position, with graphs if one input is released."""
    shown = [ShownEquilibrium(k + 1, one.stability, mechanism.to_file(one.z)) for k, one in enumerate(found.found)] or [
        ShownEquilibrium(0, "", mechanism.to_file(found.start))
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
