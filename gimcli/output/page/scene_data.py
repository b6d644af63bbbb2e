"""A scene as JSON data: the strokes that script/symbols.js places, and what can be pointed at and named."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.output import style
from gimcli.output.anchors import Anchor
from gimcli.output.mechanism_symbols import light_symbols, point_marks, strong_symbols
from gimcli.output.scene import Scene
from gimcli.output.style import Mark, Pen
from gimcli.output.symbol import Seat, Stroke, Symbol
from gimcli.output.symbols import mark_strokes

DIGITS = 10
"""Significant digits of lengths and directions."""

ROLES = {
    style.INK: "ink", style.PAPER: "paper", style.PALE: "soft", style.PLATE.face: "plate",
    style.CYLINDER.face: "cylinder", style.LOAD.color: "load",
}  # fmt: skip
"""Names of the page's colours, which are others in the dark; areas of other colours are not filled."""


class SceneData:
    """The data of a scene; coordinates of the file are relative to `origin`."""

    def __init__(self, scene: Scene, origin: complex) -> None:
        self.scene, self.origin = scene, origin
        self.seats: list[dict[str, Any]] = []

    def data(self, far: float) -> dict[str, Any]:
        """Return all items; nodes that only define a guide, if they are at most `far` from the origin along x and y."""
        scene, mechanism = self.scene, self.scene.mechanism
        crosses = [k for k in scene.crosses if _apart(complex(scene.poses[0][k]) - self.origin) <= far]
        marks = [*point_marks(scene), *((mechanism.nodes[k], style.CROSS, Anchor(k)) for k in crosses)]
        named = {*scene.pins, *scene.plain, *crosses, *(node for slider in scene.sliders for node in slider.nodes)}
        tracers = [{"name": name, "at": self.place(anchor)} for name, anchor in scene.tracers.items()]
        return {
            "nodes": list(mechanism.nodes),
            "members": [member.name for member in mechanism.members],
            "carriers": [[carrier.origin, carrier.towards] for carrier in scene.carriers],
            "fixed": sorted(scene.fixed),
            "bodies": [{"member": b.member, "outline": [self.place(a) for a in b.outline]} for b in scene.bodies],
            "lines": self._lines(),
            "blocks": [{"name": slider.name, "nodes": list(slider.nodes)} for slider in scene.sliders],
            "loads": [{"name": load.name, "at": self.place(load.at)} for load in scene.loads],
            "asides": [
                *([d.nodes[0], *_pair(d.direction)] for d in scene.drives if d.kind == "turn"),
                *([support.node, 0.0, 1.0 if support.upward else -1.0] for support in scene.supports),
            ],
            "tracers": tracers,
            "named": [*([mechanism.nodes[k], k] for k in sorted(named)), *([t["name"], t["at"]] for t in tracers)],
            "strong": self._strokes((*strong_symbols(scene), *(self._mark(*mark) for mark in marks))),
            "light": self._strokes(light_symbols(scene)),
            "seats": self.seats,
        }  # fmt: skip

    def curves(self) -> list[dict[str, Any]]:
        """Return the traced points by name, each as a node or as a point of a member."""
        return [{"name": name, "at": self.place(anchor)} for name, anchor in self.scene.traced.items()]

    def place(self, anchor: Anchor) -> int | list[float]:
        """Return an anchor as a node, or as a member with the coordinates of a point in its coordinate system."""
        if anchor.node >= 0:
            return anchor.node
        fixed = self.scene.carriers[anchor.member].origin < 0
        return [anchor.member, *_pair(anchor.local - self.origin if fixed else anchor.local)]

    def _lines(self) -> list[dict[str, Any]]:
        """Return cylinders, springs and dampers between two places."""
        cylinders = [(drive.name, map(Anchor, drive.nodes)) for drive in self.scene.cylinders]
        elements = [(f"{one.kind} {one.name}", one.ends) for one in self.scene.elements if one.pivot < 0]
        return [{"name": name, "ends": [self.place(end) for end in ends]} for name, ends in (*cylinders, *elements)]

    def _mark(self, part: str, mark: Mark, at: Anchor) -> Symbol:
        return Symbol(part, mark_strokes(mark), Seat(at, None, 1.0), fixed=at.node in self.scene.fixed)

    def _strokes(self, symbols: Iterable[Symbol]) -> list[dict[str, Any]]:
        """Return the strokes of symbols from the lowest layer to the highest, in a layer lines before areas."""
        found = []
        for symbol in symbols:
            where = self._where(symbol)
            found += [{**where, **_drawn(stroke), "ground": symbol.fixed} for stroke in symbol.strokes]
        return sorted(found, key=lambda one: (one["layer"], "face" in one))

    def _where(self, symbol: Symbol) -> dict[str, Any]:
        """Return the number of the seat of a symbol, or its corners."""
        seat = symbol.seat
        if seat is None:
            return {"corners": [self.place(corner) for corner in symbol.corners]}
        self.seats.append({
            "at": self.place(seat.at), "to": None if seat.to is None else self.place(seat.to), "turn": seat.turn,
            "arm": None if seat.arm is None else self.place(seat.arm), "member": seat.member,
            "along": _pair(seat.along) if seat.along else None,
        })  # fmt: skip
        return {"seat": len(self.seats) - 1}


def _drawn(stroke: Stroke) -> dict[str, Any]:
    """Return the style of a stroke, and for each of its points share, points and lengths."""
    own = stroke.style
    drawn: dict[str, Any] = {"layer": own.layer, "width": own.width, "slant": _pair(stroke.slant)}
    if isinstance(own, Pen):
        drawn |= {"ink": ROLES[own.color], "dash": list(own.dash)}
    else:
        drawn |= {"ink": ROLES[own.edge], "face": ROLES.get(own.face)}
    share, points, lengths = np.broadcast_arrays(stroke.share, stroke.points, stroke.lengths)
    shape = np.stack([share, points.real, points.imag, lengths.real, lengths.imag], axis=-1)
    return drawn | {"shape": floats(shape.real)}


def floats(values: NDArray[Any]) -> str:
    """Return numbers as the base64 text of little-endian float32."""
    with np.errstate(over="ignore"):
        return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")


def window(scene: Scene) -> list[float]:
    """Return left, right, bottom, top of what all rows show, in coordinates of the file."""
    z = scene.extent()
    z = z[np.isfinite(z)]
    return [float(v) for v in (z.real.min(), z.real.max(), z.imag.min(), z.imag.max())]


def _apart(z: complex) -> float:
    """Return the larger of the distances along x and y."""
    return max(abs(z.real), abs(z.imag))


def _pair(z: complex) -> list[float]:
    return [float(f"{value:.{DIGITS}g}") for value in (z.real, z.imag)]
