"""Drawing exchange files (DXF) for CAD programs, written by ezdxf."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import chain, count
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
from ezdxf import options

from gimcli.output.atomic import written_text
from gimcli.output.geometry import Geometry, Shape

RELEASE = "R2010"
"""The version of the format: text in UTF-8, read by all programs in use."""

UNITS = {"unit": 0, "in": 1, "ft": 2, "mm": 4, "cm": 5, "m": 6, "km": 7, "um": 13}
"""Codes of $INSUNITS. Source: Autodesk, DXF Reference, header section."""

IMPERIAL = ("in", "ft")

COLOURS = {"frame": 8, "guides": 8, "blocks": 7, "pins": 7, "points": 3, "names": 3, "member": 7, "actuator": 30,
           "spring": 30, "damper": 30, "gear": 8, "curve": 1, "boundary": 5, "hole": 1, "inner": 4,
           "area": 9}  # fmt: skip
"""Colour numbers of layers by the first word of their names; 7 is black on white and white on black."""

CURVES = (1, 5, 3, 6, 30, 4)
"""Colour numbers of curves."""

LONGEST = 255
"""Largest number of letters in the name of a layer."""


def write_dxf(content: Geometry, path: Path | str) -> None:
    """Write shapes in true size, each layer with its name; the same content always gives the same bytes."""
    with _undated():
        drawing = ezdxf.new(RELEASE, units=UNITS[content.unit])
        drawing.header["$MEASUREMENT"] = 0 if content.unit in IMPERIAL else 1
        space, curves = drawing.modelspace(), 0
        for own, name in zip(layer_names(content.layers), content.layers, strict=True):
            kind = name.split(" ")[0]
            drawing.layers.add(own, color=CURVES[curves % len(CURVES)] if kind == "curve" else COLOURS.get(kind, 7))
            curves += kind == "curve"
            for shape in content.layers[name]:
                _add(space, shape, own)
        _show_all(drawing, content)
        for kind in sorted(drawing.entitydb.dxf_types_in_use()):  # ezdxf lists them in the order of a set
            drawing.classes.add_class(kind)
        with written_text(path) as handle:
            drawing.write(handle)


def layer_names(names: Iterable[str]) -> list[str]:
    """Return names of layers that the format accepts, and that differ not only in capital letters."""
    found: dict[str, str] = {}  # by the name in small letters
    for name in names:
        stem = re.sub(r'[<>/\\":;?*=`|,\x00-\x1f]', "_", name)[: LONGEST - 8]
        own = next(n for n in chain([stem], (f"{stem} ({k})" for k in count(2))) if n.casefold() not in found)
        found[own.casefold()] = own
    return list(found.values())


def _add(space: Any, shape: Shape, layer: str) -> None:
    """Add a shape to a layer; a polyline of two points is a line."""
    look, places = {"layer": layer}, list(map(_pair, shape.points.tolist()))
    if shape.text:
        text = space.add_text(re.sub(r"[\x00-\x1f]", " ", shape.text), height=shape.size, dxfattribs=look)
        text.dxf.insert = places[0]
    elif shape.size:
        space.add_circle(places[0], shape.size, look)
    elif len(places) == 1:
        space.add_point(places[0], look)
    elif len(places) == 2 and not shape.closed:
        space.add_line(*places, look)
    else:
        space.add_lwpolyline(places, "xy", close=shape.closed, dxfattribs=look)


def _pair(z: complex) -> tuple[float, float]:
    return z.real, z.imag


def _show_all(drawing: Any, content: Geometry) -> None:
    """Store the extent of the drawing, and show all of it when it is opened."""
    every = [(one.points, 0.0 if one.text else one.size) for shapes in content.layers.values() for one in shapes]
    z = np.concatenate([points + size * corner for points, size in every for corner in (-1 - 1j, 1 + 1j)])
    low, high = complex(z.real.min(), z.imag.min()), complex(z.real.max(), z.imag.max())
    drawing.header["$EXTMIN"], drawing.header["$EXTMAX"] = (*_pair(low), 0.0), (*_pair(high), 0.0)
    drawing.modelspace().reset_extents((*_pair(low), 0.0), (*_pair(high), 0.0))
    height = max((high - low).imag, (high - low).real / 1.5)
    drawing.set_modelspace_vport(1.2 * height or 1.0, _pair((low + high) / 2))


@contextmanager
def _undated() -> Iterator[None]:
    """Let ezdxf write neither the time nor new identification numbers (context manager)."""
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before
