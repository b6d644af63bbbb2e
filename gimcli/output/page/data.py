"""An animation and its scene as JSON data. Arrays are base64 texts of little-endian float32 numbers, NaN is a gap.

Positions are relative to the middle of the drawing, so that float32 is accurate to 1e-7 of its size. Columns are
rounded to six digits, which float32 keeps: the page shows the digits of the table. A scene has the strokes that
script/symbols.js places, and what can be pointed at and named.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.output import style
from gimcli.output.anchors import Anchor
from gimcli.output.animation import Animation, Clip, Moment
from gimcli.output.axis import value_window
from gimcli.output.scene import Scene
from gimcli.output.style import LONGEST_VECTOR, Mark, Pen
from gimcli.output.symbols import ARROWHEAD, NECK, Seat, Stroke, Symbol, mark_strokes
from gimcli.output.vectors import HEAD, HEADS, PENS, SHORT
from gimcli.rounding import Section
from gimcli.status import Status
from gimcli.table import Column, per_second

DIGITS = 6
"""Significant digits of the columns."""

BEYOND = 1.1
"""Size of the square, relative to the drawing, in which nodes are shown that only define a guide."""

ZERO = 1e-12
"""Part of a column's largest value below which a value is zero."""


def page_data(animation: Animation) -> dict[str, Any]:
    """Return the data of the page, without numbers that JSON does not have."""
    mechanism, scene = animation.mechanism, animation.scene
    left, right, bottom, top = window(scene)
    origin = complex((left + right) / 2, (bottom + top) / 2)
    far = 0.5 * BEYOND * max(right - left, top - bottom)
    length = "" if mechanism.length_unit == "unit" else mechanism.length_unit
    return {
        "title": animation.title,
        "unit": {"length": length, "angle": mechanism.angle_unit},
        "rateUnits": [per_second(mechanism.length_unit, order) for order in (1, 2)],
        "longest": LONGEST_VECTOR,
        "arrows": {
            "neck": NECK, "head": [[z.real, z.imag] for z in ARROWHEAD.tolist()], "short": SHORT, "greatest": HEAD,
            "pens": [
                {"width": pen.width, "dash": list(pen.dash), "edge": head.width}
                for pen, head in zip(PENS, HEADS, strict=True)
            ],
        },
        "origin": [origin.real, origin.imag],
        "box": [left - origin.real, right - origin.real, bottom - origin.imag, top - origin.imag],
        **_scene(scene, origin, far),
        "inputs": [a.name for a in mechanism.actuators],
        "clips": [_clip(clip, origin, far) for clip in animation.clips],
        "choice": animation.choice,
        "sliders": [{"name": s.name, "unit": s.unit, "values": list(s.values)} for s in animation.sliders],
        "graphs": [{"columns": list(graph.columns), "over": graph.over} for graph in animation.graphs],
        "reasons": {word: _reason(word) for clip in animation.clips for word in set(clip.status) if word != "ok"},
        "notes": list(animation.notes),
        "report": [_section(section) for section in animation.report],
        "autoplay": True,
    }  # fmt: skip


def _scene(scene: Scene, origin: complex, far: float) -> dict[str, Any]:
    """Return what is drawn of a mechanism; nodes that only define a guide, if they are not far."""
    found, ground = SceneData(scene, origin), floats(_interleaved(scene.poses[:1] - origin))
    return {"scene": found.data(far), "ground": ground, "curves": found.curves()}


def _clip(clip: Clip, origin: complex, far: float) -> dict[str, Any]:
    rates = [] if clip.rates is None else [floats(_interleaved(one)) for one in clip.rates]
    return {
        "name": clip.name, "note": clip.note, "rows": len(clip.time), "closed": clip.closed, "forward": clip.forward,
        "axis": clip.axis, "time": floats(clip.time), "positions": floats(_interleaved(clip.positions - origin)),
        "status": [[word, len(list(run))] for word, run in groupby(clip.status)],
        "events": [{"row": event.row, "kind": event.kind, "text": event.text} for event in clip.events],
        "breaks": list(clip.breaks),
        "columns": [_column(c, clip.events) for c in clip.table.columns if c.values.dtype.kind in "fiu"],
        "rates": rates, "without": clip.without,
        **({} if clip.scene is None else {"design": _scene(clip.scene, origin, far)}),
    }  # fmt: skip


def _column(column: Column, events: Sequence[Moment]) -> dict[str, Any]:
    """Return a column, with the range that graphs show."""
    unit, values = "" if column.unit == "unit" else column.unit, rounded(column.values)
    shown = value_window([values], [np.array([event.row for event in events])])
    return {"name": column.name, "unit": unit, "values": floats(values), "shown": shown}


def rounded(values: NDArray[Any]) -> NDArray[np.float64]:
    """Return numbers rounded to six digits; those below 1e-12 of the largest one are zero."""
    found = np.asarray(values, dtype=np.float64).copy()
    finite = np.isfinite(found) & (np.abs(found) > 0.0)
    if finite.any():
        finite &= np.abs(found) > ZERO * np.abs(found[finite]).max()
    found[np.isfinite(found) & ~finite] = 0.0
    power = DIGITS - 1 - np.floor(np.log10(np.abs(found[finite])))
    up, down = 10.0 ** np.maximum(power, 0.0), 10.0 ** np.maximum(-power, 0.0)
    found[finite] = np.rint(found[finite] * up / down) / up * down
    return found


def _interleaved(z: NDArray[np.complexfloating]) -> NDArray[np.float64]:
    """Return complex numbers as x, y, x, y ..."""
    return np.ascontiguousarray(z, dtype=np.complex128).view(np.float64).ravel()


def _reason(word: str) -> str:
    return next((status.text for status in Status if status.word == word), word)


def _section(section: Section) -> dict[str, Any]:
    more = [f"and {section.left_out} more: the file .json or .csv lists all"] * bool(section.left_out)
    return {
        "heading": section.heading, "lines": [*more, *section.warnings], "warning": bool(section.warnings),
        "table": {"head": section.head, "rows": section.rows} if section.rows else None,
    }  # fmt: skip


LENGTH_DIGITS = 10
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
        scene, mechanism, members = self.scene, self.scene.mechanism, [one.name for one in self.scene.mechanism.members]
        crosses = [k for k in scene.crosses if np.max(np.abs(_interleaved(scene.poses[0][k] - self.origin))) <= far]
        marks = [*scene.marks, *((mechanism.nodes[k], style.CROSS, Anchor(k)) for k in crosses)]
        blocks = [{"name": block.name, "nodes": [end.node for end in block.ends]} for block in scene.blocks]
        named = {*scene.pins, *scene.plain, *crosses, *(end.node for block in scene.blocks for end in block.ends)}
        tracers = [{"name": name, "at": self.place(anchor)} for name, anchor in scene.tracers.items()]
        return {
            "nodes": list(mechanism.nodes),
            "members": members,
            "carriers": [[carrier.origin, carrier.towards] for carrier in scene.carriers],
            "fixed": sorted(scene.fixed),
            "bodies": [{"member": members.index(b.name), "outline": self._places(b)} for b in scene.bodies],
            "lines": self._lines(),
            "blocks": blocks,
            "loads": [{"name": load.name, "at": self._places(load)[0]} for load in scene.loads],
            "asides": [
                [one.ends[0].node, *_pair(one.aside)] for one in (*scene.drives, *scene.supports) if one.aside
            ],
            "tracers": tracers,
            "named": [*([mechanism.nodes[k], k] for k in sorted(named)), *([t["name"], t["at"]] for t in tracers)],
            "strong": self._strokes((*scene.strong, *(self._mark(*mark) for mark in marks))),
            "light": self._strokes(scene.light),
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
        lines = [(drive.name, drive) for drive in self.scene.cylinders]
        lines += [(one.part.replace(":", " ", 1), one) for one in self.scene.elements if len(one.ends) == 2]
        return [{"name": name, "ends": self._places(symbol)} for name, symbol in lines]

    def _places(self, symbol: Symbol) -> list[int | list[float]]:
        return list(map(self.place, symbol.ends))

    def _mark(self, part: str, mark: Mark, at: Anchor) -> Symbol:
        return Symbol(part, mark_strokes(mark), Seat(at, None, 1.0), fixed=at.node in self.scene.fixed)

    def _strokes(self, symbols: Iterable[Symbol]) -> list[dict[str, Any]]:
        """Return the strokes of symbols from the lowest layer to the highest, in a layer lines before areas."""
        found = []
        for symbol in symbols:
            where = self._where(symbol)
            found += [{**where, **_stroke(stroke), "ground": symbol.fixed} for stroke in symbol.strokes]
        return sorted(found, key=lambda one: (one["layer"], "face" in one))

    def _where(self, symbol: Symbol) -> dict[str, Any]:
        """Return the number of the seat of a symbol, or its corners."""
        seat = symbol.seat
        if seat is None:
            return {"corners": self._places(symbol)}
        self.seats.append({
            "at": self.place(seat.at), "to": None if seat.to is None else self.place(seat.to), "turn": seat.turn,
            "arm": None if seat.arm is None else self.place(seat.arm), "member": seat.member,
            "along": _pair(seat.along) if seat.along else None,
        })  # fmt: skip
        return {"seat": len(self.seats) - 1}


def _stroke(stroke: Stroke) -> dict[str, Any]:
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


def _pair(z: complex) -> list[float]:
    return [float(f"{value:.{LENGTH_DIGITS}g}") for value in (z.real, z.imag)]
