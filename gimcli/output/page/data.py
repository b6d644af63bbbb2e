"""An animation as JSON data. Arrays are base64 texts of little-endian float32 numbers, NaN is a gap.

Positions are relative to the middle of the drawing, so that float32 is accurate to 1e-7 of its size. Columns are
rounded to six digits, which float32 keeps: the page shows the digits of the table.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.output.animation import Animation, Clip, Moment, Section
from gimcli.output.page.scene_data import SceneData, floats, window
from gimcli.output.scene import Scene
from gimcli.output.style import LONGEST_VECTOR
from gimcli.output.value_window import value_window
from gimcli.status import Status
from gimcli.table import Column, Table, labelled, per_second

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
        "origin": [origin.real, origin.imag],
        "box": [left - origin.real, right - origin.real, bottom - origin.imag, top - origin.imag],
        **_drawn(scene, origin, far),
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


def _drawn(scene: Scene, origin: complex, far: float) -> dict[str, Any]:
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
        **({} if clip.scene is None else {"design": _drawn(clip.scene, origin, far)}),
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
    return {
        "heading": section.heading, "lines": list(section.lines), "warning": section.warning,
        "table": None if section.table is None else _table(section.table),
    }  # fmt: skip


def _table(table: Table) -> dict[str, Any]:
    return {
        "head": [labelled(column.name, column.unit) for column in table.columns],
        "rows": [[_cell(column.values[row]) for column in table.columns] for row in range(len(table))],
    }


def _cell(value: Any) -> float | str | None:
    if isinstance(value, str | np.str_):
        return str(value)
    return float(value) if np.isfinite(value) else None
