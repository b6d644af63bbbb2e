"""Dimensions: the numbers of a model file by name, such as `a`, `crank.length`, `B.x` and `motor.to`.

A name is the path of keys without its section and without keys that it does not need. Numbers that the file does not
give, but that a key can give, are dimensions too: the length of a link between two nodes, for example.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from typing import Any, NamedTuple

from gimcli.errors import UsageError
from gimcli.mechanism import Mechanism
from gimcli.model.laws import run_times
from gimcli.model.part import Part
from gimcli.model.schema import WHOLE, Model
from gimcli.model.source import Where
from gimcli.model.units import TURN
from gimcli.nearest import near

AXES = ("x", "y")
NAMELESS = ("law", "profile", "constant")
"""Keys that a name leaves out; of a point also `at` and `local`."""
PLAIN = ("polynomial", "nodes", "guide", "teeth", "radii")
"""Keys of lists whose entries are no coordinates."""
GEOMETRY = ("nodes", "links", "elements", "prismatic", "points")
"""Sections whose numbers are lengths."""
UNITS = {
    **dict.fromkeys((("actuators", key) for key in ("from", "to", "by", "polynomial", "phase", "start")), "input"),
    ("actuators", "lead"): "length", ("springs", "free"): "input", ("masses", "mass"): "mass",
    ("friction", "radius"): "length", ("friction", "length"): "length",
    ("gears", "radii"): "length", ("gears", "pitch"): "length", ("gears", "pressure_angle"): "angle",
}  # fmt: skip
"""Kinds of units by section and key; "input": that of the quantity. Other numbers have none."""


class Dimension(NamedTuple):
    """A number of a model file."""

    name: str
    value: float  # file's unit; of a dimension that is not given, the value that is used
    unit: str  # "length", "angle" or "mass" in the file's unit, otherwise ""
    where: Where  # its path of keys
    given: bool  # whether the file has this key
    formula: str  # the text in place of the number, otherwise ""


def tolerances(mechanism: Mechanism) -> dict[str, float]:
    """Return the tolerances of the file (file's units) by the full names of their dimensions."""
    own = written(mechanism)
    return {own.dimension(name).name: value for name, value in own.model.tolerances.items()}


def written(mechanism: Mechanism) -> Any:
    """Return the model as written; raise UsageError if the mechanism was not read from one."""
    if mechanism.written is None:
        raise UsageError("the mechanism was not read from a model, so that its dimensions have no names")
    return mechanism.written


def found(named: dict[str, Dimension], name: str, opened: Collection[str] = ()) -> Dimension:
    """Return one of some dimensions by its name, or by the name of its link; raise UsageError for others.

    `opened` are the nodes without coordinates.
    """
    for full in (name, f"{name}.length"):
        if full in named:
            return named[full]
    if name in opened or name.removesuffix(".x").removesuffix(".y") in opened:
        raise UsageError(f"'{name}' is not a dimension: the node has no coordinates, they follow from other dimensions")
    own = [full for full in named if full.startswith(f"{name}.")]
    hint = f"; it has {', '.join(own[:8])}{', ...' * (len(own) > 8)}" if own else near(
        name, [*named, *(full.removesuffix(".length") for full in named)]
    )  # fmt: skip
    raise UsageError(f"'{name}' is not a dimension{hint or '; dimensions are named as crank.length, B.x or motor.to'}")


def dimensions_of(model: Model) -> dict[str, Dimension]:
    """Return the dimensions of a model by name."""
    result: dict[str, Dimension] = {}
    for where, value, given in _numbers(model):
        formula = model.formulas.get(where)
        name = name_of(where)
        text = "" if formula is None else formula.text
        result.setdefault(name, Dimension(name, value, _unit(model, where), where, given, text))
    return result


def name_of(where: Where) -> str:
    """Return the name of a dimension, or of a part, from its path of keys."""
    section, *keys = where or ("",)
    if section in WHOLE:
        keys = [section, *keys]
    left_out = (*NAMELESS, "at", "local") if section == "points" else NAMELESS
    keys = [*keys[:1], *(key for key in keys[1:] if key not in left_out)]
    if section == "friction":
        keys = [*keys[:1], "friction", *(key for key in keys[1:] if key != "viscous")]
    if keys and isinstance(keys[-1], int) and len(keys) > 1 and keys[-2] not in PLAIN:
        keys[-1] = AXES[keys[-1]]
    return ".".join(map(str, keys or where))


def _numbers(model: Model) -> Iterator[tuple[Where, float, bool]]:
    """Yield path, value and whether it is given, for every dimension."""
    yield from _in_part(model.parameters, ("parameters",))
    for section, part in vars(model).items():
        if section == "links":
            yield from _links(model)
        elif section == "actuators":
            yield from _actuators(model)
        elif section == "nodes":
            yield from _in_part({name: xy for name, xy in part.items() if name not in model.open.parts}, ("nodes",))
        elif section not in ("parameters", "tolerances", "quantities", "open"):
            yield from _in_part(part, (section,))
    laws = [a.law for a in model.actuators.values() if a.law is not None]
    timed = any(law.profile.table is not None or (law.rate is not None and law.end is not None) for law in laws)
    if model.duration is None and not timed:  # no table, and no rate with an end, gives it
        times = run_times(model, lambda *_: None, timed=False)
        yield ("duration",), times[0].seconds if times else 1.0, False


def _in_part(part: Any, where: Where) -> Iterator[tuple[Where, float, bool]]:
    """Yield the numbers inside a part."""
    if isinstance(part, float):
        yield where, part, True
    elif isinstance(part, Part):
        for key, value in vars(part).items():
            for at, number, given in _in_part(value, (*where, key.rstrip("_"))):
                yield at, number, given and key in part.given
    elif isinstance(part, dict | list):
        for name, value in part.items() if isinstance(part, dict) else enumerate(part):
            yield from _in_part(value, (*where, name))


def _links(model: Model) -> Iterator[tuple[Where, float, bool]]:
    for name, link in model.links.items():
        where = ("links", name, "length")
        if link.length is not None:
            yield where, link.length, True
        else:
            yield where, math.dist(*(model.nodes[node] for node in link.nodes)), False


def _actuators(model: Model) -> Iterator[tuple[Where, float, bool]]:
    turn = TURN[model.units.angle]
    for name, actuator in model.actuators.items():
        law = actuator.law
        if actuator.follows is None and (
            law is None
            or not (law.given & {"from_", "to", "by", "turns", "rate"} or law.profile.table or law.profile.polynomial)
        ):
            yield ("actuators", name, "law", "by"), turn if actuator.rotary else 0.0, False
        for where, value, given in _in_part(actuator, ("actuators", name)):
            if given or actuator.free:
                yield where, value, given


def _unit(model: Model, where: Sequence[Any]) -> str:
    """Return the kind of unit of a dimension."""
    section, last = where[0], [key for key in where if isinstance(key, str)][-1]
    kind = "length" if section in GEOMETRY or last in ("at", "local", "centre") else UNITS.get((section, last), "")
    if kind == "input":
        return "angle" if getattr(model, section)[where[1]].rotary else "length"
    return kind
