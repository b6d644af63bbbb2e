"""The text of a model file with the coordinates of a solved position.

Coordinates of nodes, also of those that have none in the file, and the initial coordinates `at` of points and loads,
are replaced; the rest of the text stays as it is. The new file is read and all dimensions are compared, as many of
them may be taken from coordinates.
"""

from __future__ import annotations

import math
from codecs import BOM_UTF8 as BOM
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gimcli.canonical import beside
from gimcli.dynamic_data import NO_NODE
from gimcli.errors import ModelError, UsageError, refuse
from gimcli.mechanism import FRAME, ComplexArray, Mechanism
from gimcli.model.dimensions import written
from gimcli.model.edited_text import replaced, written_with
from gimcli.model.read import read_text
from gimcli.model.schema import Model
from gimcli.model.source import Where, read_yaml
from gimcli.model.tables import tables_of
from gimcli.output.model import ModelText
from gimcli.rounding import input_value
from gimcli.structure.carried import carried, measured

SAME = 1e-12
"""Largest change of a dimension, relative to the size (directions: in rad)."""

KEPT = 2.0
"""Change of a coordinate, in units of its last digit, up to which its text is kept."""

SAME_INPUT = 1e-9
"""Relative change of a law that counts as rounding."""

NAMED = 5
"""Number of dimensions that a message names."""

DIGITS = (12, 13, 14, 17)
"""Digits of coordinates, counted from the first digit of the size; more are used only if a dimension needs them."""


def model_text(mechanism: Mechanism, z: ComplexArray) -> ModelText:
    """Return the text of a mechanism's model file with the coordinates of a position z (nodes,) [normal frame].

    Raises UsageError if the mechanism was not read from a file, or if a dimension would change.
    """
    _refuse_without_file(mechanism, "coordinates")
    own = read_yaml(written_with(mechanism), Path("<text>"))
    wanted = _coordinates(mechanism, mechanism.written.model, z)
    wrong: list[str] = []
    for digits in DIGITS:
        text = replaced(own, _written(mechanism, wanted, digits))
        found = _read(mechanism, text)
        wrong = list(_changed(mechanism, found, z))
        if not wrong:
            return _content(mechanism, text, tuple(_remarks(mechanism, found)))
    names = f"{', '.join(wrong[:NAMED])}{', ...' * (len(wrong) > NAMED)}"
    raise UsageError(
        f"{mechanism.files[0].name}: the solved coordinates would change {names}, which the file takes from its"
        " coordinates: give these dimensions in the file (`length`, `shape`, `local`, `free`), or a smaller tolerance"
    )


def changed_text(mechanism: Mechanism, changes: Mapping[str, float]) -> ModelText:
    """Return the text of a mechanism's model file with other dimensions in place.

    Raises UsageError if the mechanism was not read from a file, or if a number cannot be replaced in its text.
    """
    _refuse_without_file(mechanism, "dimensions")
    return _content(mechanism, written_with(mechanism, changes))


def _refuse_without_file(mechanism: Mechanism, what: str) -> None:
    refuse(
        (
            mechanism.path is None,
            f"the mechanism was not read from a model file, so that there is no text for its {what}",
        )
    )


def _content(mechanism: Mechanism, text: str, remarks: tuple[str, ...] = ()) -> ModelText:
    """Return a text as the content of a model file, with the tables and the byte order mark of the one read before."""
    path, *tables = mechanism.files
    mark = BOM.decode() if path.read_bytes().startswith(BOM) else ""
    return ModelText(mark + text, tuple(zip(tables_of(mechanism.written.model), tables, strict=True)), remarks)


def _read(mechanism: Mechanism, text: str) -> Mechanism:
    """Return the mechanism of a new text; raise UsageError if it is not a valid model."""
    try:
        return read_text(text, mechanism.written.source.folder)
    except ModelError as error:
        name = mechanism.files[0].name
        raise UsageError(f"{name}: a model file does not allow these coordinates: {error}") from None


def _coordinates(mechanism: Mechanism, model: Model, z: ComplexArray) -> dict[Where, complex]:
    """Return the coordinates [file's unit] of nodes, points and loads by their paths of keys."""
    found: dict[Where, complex] = {("nodes", name): at for name, at in zip(mechanism.nodes, z.tolist(), strict=True)}
    for point in mechanism.points:
        if model.points[point.name].at is not None and point.member != FRAME:
            found["points", point.name, "at"] = carried(mechanism, z, point.member, point.local)
    for load in mechanism.dynamics.loads:
        if model.loads[load.name].at is not None and load.member != FRAME:
            found["loads", load.name, "at"] = carried(mechanism, z, load.member, load.point)
    return {where: complex(mechanism.to_file(np.asarray(at))) for where, at in found.items()}


def _written(mechanism: Mechanism, wanted: Mapping[Where, complex], digits: int) -> dict[Where, Any]:
    """Return the coordinates that change, by their paths of keys."""
    values = {dimension.where: dimension.value for dimension in written(mechanism).dimensions.values()}
    opened = mechanism.written.model.open.parts
    places = digits - 1 - math.floor(math.log10(mechanism.size * mechanism.scale))
    changes: dict[Where, Any] = {}
    for where, at in wanted.items():
        if where[0] == "nodes" and where[1] in opened:
            changes[where] = [round(at.real, places) + 0.0, round(at.imag, places) + 0.0]
            continue
        for part, value in enumerate((at.real, at.imag)):
            if abs(value - values[*where, part]) > KEPT * 10.0**-places + np.spacing(abs(value)):
                changes[*where, part] = round(value, places) + 0.0
    return changes


def _changed(old: Mechanism, new: Mechanism, z: ComplexArray) -> Iterator[str]:
    """Yield the names of the dimensions that differ between two mechanisms."""
    size = old.size * old.scale
    one, other = (_dimensions(mechanism, mechanism.scale / size) for mechanism in (old, new))
    rounding = 4.0 * np.spacing(abs(old.origin) + size) / size
    for name, values in one.items():
        its = other.get(name)
        if its is None or its.shape != values.shape or not np.all(np.abs(its - values) <= SAME + rounding):
            yield name
    for gauge, its_gauge in zip(old.gauges, new.gauges, strict=True):
        followed = float(beside(measured(old, gauge, z), gauge.drawn)) if gauge.rotary else its_gauge.drawn
        if abs(followed - its_gauge.drawn) > math.pi:
            yield f"the angle of {gauge.name} by a full turn"


def _dimensions(mechanism: Mechanism, unit: float) -> dict[str, ComplexArray]:
    """Return the dimensions by name: lengths times `unit`, directions as complex numbers of modulus 1."""
    dynamics = mechanism.dynamics
    rows = (*mechanism.pairs, *mechanism.actuators, *mechanism.gauges)
    bodies = [(mechanism.members[one.member].name, one) for one in dynamics.inertias if one.node == NO_NODE]
    found: dict[str, list[complex]] = {
        **{f"member {member.name}": [complex(s * unit) for s in member.shape] for member in mechanism.members},
        **{f"the line or angle of {r.name}": [r.point * unit, r.normal, r.arm, r.reference] for r in rows},
        **{f"point {point.name}": [point.local * unit] for point in mechanism.points},
        **{f"the centre of mass of {name}": [inertia.centre * unit] for name, inertia in bodies},
        **{f"load {load.name}": [load.point * unit] for load in dynamics.loads},
    }
    for spring in dynamics.springs:
        rotary = mechanism.gauges[spring.gauge].rotary
        found[f"`free` of spring {spring.name}"] = [complex(spring.free * (1.0 if rotary else unit))]
    return {name: np.array(values, dtype=complex) for name, values in found.items()}


def _remarks(old: Mechanism, new: Mechanism) -> Iterator[str]:
    """Yield a sentence for each law that begins at the drawn position, and so at another value than before."""
    ends = np.array([0.0, 1.0])
    for k, (before, after) in enumerate(zip(old.actuators, new.actuators, strict=True)):
        was, now = (m.value_to_file(k, a.law(ends)) for m, a in ((old, before), (new, after)))
        if np.max(np.abs(was - now)) > SAME_INPUT * max(1.0, float(np.max(np.abs(was)))):
            first, then = (" to ".join(input_value(old, before.name, float(v)) for v in law) for law in (now, was))
            yield (
                f"the law of {before.name} begins at the initial position: now {first} {old.unit_of(before)}, before"
                f" {then}; write `from` and `to` to keep it"
            )
