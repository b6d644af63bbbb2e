"""The model file as written: its keys, their types and their meaning."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic_core import core_schema

from gimcli.model.part import Part

SHORTEST, LONGEST = 1e-12, 1e12
"""Seconds that a motion may take: beyond, powers of them no longer are numbers."""
LARGEST = 1e30
"""Mass, force and the like: beyond, products of them soon are no numbers."""
MOST_COEFFICIENTS = 100
"""Of a polynomial: beyond, powers of the time no longer differ, and its roots are slow to find."""
PROFILES = ("uniform", "cubic", "quintic", "cycloidal", "harmonic")


# -- values ---------------------------------------------------------------------------------


def _word(value: Any) -> Any:
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _number(**limits: Any) -> Any:
    return core_schema.float_schema(strict=True, allow_inf_nan=False, **limits)


def _choice(*words: str) -> Any:
    return core_schema.literal_schema(list(words))


def _list(entry: Any, least: int | None = None, most: int | None = None) -> Any:
    return core_schema.list_schema(entry, min_length=least, max_length=most)


def _default(schema: Any, value: Any) -> Any:
    return core_schema.with_default_schema(schema, default=value)


def _optional(schema: Any) -> Any:
    return _default(core_schema.nullable_schema(schema), None)


def _by_name(schema: Any) -> Any:
    return core_schema.dict_schema(core_schema.str_schema(), schema)


def _section(schema: Any) -> Any:
    return _default(_by_name(schema), {})


NAME: Any = core_schema.no_info_before_validator_function(_word, core_schema.str_schema(min_length=1))
TEXT: Any = core_schema.no_info_before_validator_function(_word, core_schema.str_schema())
STRING: Any = core_schema.str_schema()
NUMBER = _number()
LENGTH = _number(gt=0)
POSITIVE = _number(ge=0, le=LARGEST)
AMOUNT = _number(ge=-LARGEST, le=LARGEST)
SECONDS = _number(ge=SHORTEST, le=LONGEST)
PLACE, VECTOR = _list(NUMBER, 2, 2), _list(AMOUNT, 2, 2)
NAMES, PAIR = _list(NAME), _list(NAME, 2, 2)


# -- parts ----------------------------------------------------------------------------------


class Units(Part):
    """Units of the file, in and out."""

    length: str = _default(_choice("m", "mm", "cm", "um", "km", "in", "ft", "unit"), "m")
    angle: str = _default(_choice("deg", "rad"), "deg")
    mass: str = _default(_choice("kg", "g", "t", "lb"), "kg")


class Ground(Part):
    """Nodes fixed to the frame, or the member held in a floating mechanism."""

    nodes: list[str] = _default(NAMES, [])
    member: str | None = _optional(NAME)


class Link(Part):
    """Binary member: two nodes; the length is the drawn one unless given."""

    nodes: list[str] = PAIR
    length: float | None = _optional(LENGTH)


class Element(Part):
    """n-ary rigid member; the shape is the drawn one unless given in the member's own frame."""

    nodes: list[str] = _list(NAME, 3)
    shape: dict[str, list[float]] | None = _optional(_by_name(PLACE))


class Prismatic(Part):
    """Sliding pair: `node`, a pin in a slot, or `nodes`, no relative rotation, on the line of `guide`."""

    node: str | None = _optional(NAME)
    nodes: list[str] | None = _optional(PAIR)
    guide: list[str] = PAIR
    offset: float = _default(NUMBER, 0.0)


class Profile(Part):
    """How an input runs from its first to its last value."""

    name: str = _default(STRING, "uniform")
    polynomial: list[float] | None = _optional(_list(NUMBER, 1, MOST_COEFFICIENTS))
    table: str | None = _optional(STRING)


class Law(Part):
    """Absolute values `from`, `to`, or an increment `by` on the drawn value."""

    from_: float | None = _optional(NUMBER)
    to: float | None = _optional(NUMBER)
    by: float | None = _optional(NUMBER)
    profile: Profile = _default(Profile.schema, Profile())


class Gauge(Part):
    """An angle about a pivot, a distance of two nodes, or the travel of a node along a guide."""

    pivot: str | None = _optional(NAME)
    arm: str | None = _optional(NAME)
    reference: str | None = _optional(NAME)
    nodes: list[str] | None = _optional(PAIR)
    node: str | None = _optional(NAME)
    guide: list[str] | None = _optional(PAIR)


class Effort(Part):
    """Driving torque or force: constant, from a table, or falling with speed from `stall` to 0 at `idle`."""

    constant: float | None = _optional(NUMBER)
    table: str | None = _optional(STRING)
    over: str = _default(_choice("time", "value", "speed"), "time")
    stall: float | None = _optional(NUMBER)
    idle: float | None = _optional(NUMBER)


class Actuator(Gauge):
    """An input: a rotary or a linear actuator."""

    type: str = _choice("rotary", "linear")
    law: Law | None = _optional(Law.schema)
    free: bool = _default(core_schema.bool_schema(strict=True), False)
    start: float | None = _optional(NUMBER)
    speed: float = _default(NUMBER, 0.0)
    effort: Effort | None = _optional(Effort.schema)


class Tracer(Part):
    """A point carried by a member, at a drawn position or in the member's own frame."""

    on: str = NAME
    at: list[float] | None = _optional(PLACE)
    local: list[float] | None = _optional(PLACE)


class Mass(Part):
    """Mass, moment of inertia about the centre of mass, and its place in the member's own frame."""

    mass: float = POSITIVE
    inertia: float | None = _optional(POSITIVE)
    centre: list[float] | None = _optional(PLACE)


class Load(Part):
    """A force at a point of a member, or a torque on it; a table multiplies it."""

    on: str = NAME
    at: list[float] | None = _optional(PLACE)
    local: list[float] | None = _optional(PLACE)
    force: list[float] | None = _optional(VECTOR)
    follower: list[float] | None = _optional(VECTOR)
    torque: float | None = _optional(AMOUNT)
    table: str | None = _optional(STRING)
    over: str = _default(NAME, "time")


class Spring(Gauge):
    """A linear spring between two nodes or along a guide, or a torsion spring about a pivot."""

    stiffness: float = LENGTH
    free: float | None = _optional(NUMBER)


class Damper(Gauge):
    """A viscous damper between two nodes or along a guide, or about a pivot."""

    damping: float = POSITIVE


class Model(Part):
    """A planar mechanism."""

    name: str = _default(TEXT, "")
    source: str = _default(TEXT, "")
    units: Units = _default(Units.schema, Units())
    nodes: dict[str, list[float]] = _by_name(PLACE)
    ground: Ground = Ground.schema
    links: dict[str, Link] = _section(Link.schema)
    elements: dict[str, Element] = _section(Element.schema)
    prismatic: dict[str, Prismatic] = _section(Prismatic.schema)
    actuators: dict[str, Actuator] = _section(Actuator.schema)
    points: dict[str, Tracer] = _section(Tracer.schema)
    trace: list[str] = _default(NAMES, [])
    duration: float | None = _optional(SECONDS)
    masses: dict[str, Mass] = _section(Mass.schema)
    gravity: list[float] | None = _optional(VECTOR)
    loads: dict[str, Load] = _section(Load.schema)
    springs: dict[str, Spring] = _section(Spring.schema)
    dampers: dict[str, Damper] = _section(Damper.schema)
    friction: dict[str, float] = _section(POSITIVE)

    _elements_first = False

    def written_in(self, keys: Iterable[str]) -> None:
        """Note the order of the file's sections: which of two members is named first depends on it."""
        order = list(keys)
        both = {"links", "elements"} <= set(order)
        self._elements_first = both and order.index("elements") < order.index("links")

    @property
    def members(self) -> dict[str, Link | Element]:
        """All members in the order of the file."""
        parts: tuple[dict[str, Any], dict[str, Any]] = (self.links, self.elements)
        first, second = reversed(parts) if self._elements_first else parts
        return {**first, **second}


def long_form(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data with the short forms written out."""
    result = dict(data)
    for section in ("links", "elements"):
        if isinstance(result.get(section), dict):
            items = result[section].items()
            result[section] = {k: {"nodes": v} if isinstance(v, list) else v for k, v in items}
    if isinstance(result.get("ground"), list):
        result["ground"] = {"nodes": result["ground"]}
    if isinstance(result.get("actuators"), dict):
        result["actuators"] = {k: _long_actuator(v) for k, v in result["actuators"].items()}
    return {k: v for k, v in result.items() if v is not None or k in ("nodes", "ground")}


def _long_actuator(actuator: Any) -> Any:
    if isinstance(actuator, dict) and isinstance(actuator.get("effort"), int | float):
        actuator = {**actuator, "effort": {"constant": actuator["effort"]}}
    if not isinstance(actuator, dict) or not isinstance(actuator.get("law"), dict):
        return actuator
    law = dict(actuator["law"])
    profile = law.get("profile")
    if isinstance(profile, str):
        law["profile"] = {"name": profile}
    for key in ("polynomial", "table"):
        if key in law and "profile" not in law:
            law["profile"] = {key: law.pop(key)}
    return {**actuator, "law": law}
