"""The model file as written: its keys, their types and their meaning."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PrivateAttr, WithJsonSchema

SHORTEST, LONGEST = 1e-12, 1e12
"""Seconds that a motion may take: beyond, powers of them no longer are numbers."""
LARGEST = 1e30
"""Mass, force and the like: beyond, products of them soon are no numbers."""
MOST_COEFFICIENTS = 100
"""Of a polynomial: beyond, powers of the time no longer differ, and its roots are slow to find."""
PROFILES = ("uniform", "cubic", "quintic", "cycloidal", "harmonic")


def _word(value: Any) -> Any:
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


_WORD = WithJsonSchema({"type": ["string", "integer"]})
Name = Annotated[str, BeforeValidator(_word), Field(min_length=1), _WORD]
Text = Annotated[str, BeforeValidator(_word), _WORD]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Length = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=LARGEST)]
Amount = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
Seconds = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=SHORTEST, le=LONGEST)]
Place = Annotated[list[Number], Field(min_length=2, max_length=2)]
Vector = Annotated[list[Amount], Field(min_length=2, max_length=2)]


class Part(BaseModel):
    """A mapping whose keys are all known."""

    model_config = ConfigDict(extra="forbid", defer_build=True)


class Units(Part):
    """Units of the file, in and out."""

    length: Literal["m", "mm", "cm", "um", "km", "in", "ft", "unit"] = "m"
    angle: Literal["deg", "rad"] = "deg"
    mass: Literal["kg", "g", "t", "lb"] = "kg"


class Ground(Part):
    """Nodes fixed to the frame, or the member held in a floating mechanism."""

    nodes: list[Name] = []
    member: Name | None = None


class Link(Part):
    """Binary member: two nodes; the length is the drawn one unless given."""

    nodes: Annotated[list[Name], Field(min_length=2, max_length=2)]
    length: Length | None = None


class Element(Part):
    """n-ary rigid member; the shape is the drawn one unless given in the member's own frame."""

    nodes: Annotated[list[Name], Field(min_length=3)]
    shape: dict[str, Place] | None = None


class Prismatic(Part):
    """Sliding pair: `node`, a pin in a slot, or `nodes`, no relative rotation, on the line of `guide`."""

    node: Name | None = None
    nodes: Annotated[list[Name], Field(min_length=2, max_length=2)] | None = None
    guide: Annotated[list[Name], Field(min_length=2, max_length=2)]
    offset: Number = 0.0


class Profile(Part):
    """How an input runs from its first to its last value."""

    name: str = "uniform"
    polynomial: Annotated[list[Number], Field(min_length=1, max_length=MOST_COEFFICIENTS)] | None = None
    table: str | None = None


class Law(Part):
    """Absolute values `from`, `to`, or an increment `by` on the drawn value."""

    from_: Number | None = Field(default=None, alias="from")
    to: Number | None = None
    by: Number | None = None
    profile: Profile = Profile()


class Gauge(Part):
    """An angle about a pivot, a distance of two nodes, or the travel of a node along a guide."""

    pivot: Name | None = None
    arm: Name | None = None
    reference: Name | None = None
    nodes: Annotated[list[Name], Field(min_length=2, max_length=2)] | None = None
    node: Name | None = None
    guide: Annotated[list[Name], Field(min_length=2, max_length=2)] | None = None


class Effort(Part):
    """Driving torque or force: constant, from a table, or falling with speed from `stall` to 0 at `idle`."""

    constant: Number | None = None
    table: str | None = None
    over: Literal["time", "value", "speed"] = "time"
    stall: Number | None = None
    idle: Number | None = None


class Actuator(Gauge):
    """An input: a rotary or a linear actuator."""

    type: Literal["rotary", "linear"]
    law: Law | None = None
    free: Annotated[bool, Field(strict=True)] = False
    start: Number | None = None
    speed: Number = 0.0
    effort: Effort | None = None


class Tracer(Part):
    """A point carried by a member, at a drawn position or in the member's own frame."""

    on: Name
    at: Place | None = None
    local: Place | None = None


class Mass(Part):
    """Mass, moment of inertia about the centre of mass, and its place in the member's own frame."""

    mass: Positive
    inertia: Positive | None = None
    centre: Place | None = None


class Load(Part):
    """A force at a point of a member, or a torque on it; a table multiplies it."""

    on: Name
    at: Place | None = None
    local: Place | None = None
    force: Vector | None = None
    follower: Vector | None = None
    torque: Amount | None = None
    table: str | None = None
    over: Name = "time"


class Spring(Gauge):
    """A linear spring between two nodes or along a guide, or a torsion spring about a pivot."""

    stiffness: Length
    free: Number | None = None


class Damper(Gauge):
    """A viscous damper between two nodes or along a guide, or about a pivot."""

    damping: Positive


class Model(Part):
    """A planar mechanism."""

    name: Text = ""
    source: Text = ""
    units: Units = Units()
    nodes: dict[str, Place]
    ground: Ground
    links: dict[str, Link] = {}
    elements: dict[str, Element] = {}
    prismatic: dict[str, Prismatic] = {}
    actuators: dict[str, Actuator] = {}
    points: dict[str, Tracer] = {}
    trace: list[Name] = []
    duration: Seconds | None = None
    masses: dict[str, Mass] = {}
    gravity: Vector | None = None
    loads: dict[str, Load] = {}
    springs: dict[str, Spring] = {}
    dampers: dict[str, Damper] = {}
    friction: dict[str, Positive] = {}
    _elements_first: bool = PrivateAttr(default=False)

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


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of the file, short forms included, for editors."""
    from gimcli.model.descriptions import describe

    schema = Model.model_json_schema(by_alias=True)
    parts = schema["$defs"]
    names = {"type": "array", "items": {"type": ["string", "integer"]}}
    for section, part in (("links", "Link"), ("elements", "Element")):
        count = {"minItems": 2, "maxItems": 2} if part == "Link" else {"minItems": 3}
        options = [{**names, **count}, {"$ref": f"#/$defs/{part}"}]
        schema["properties"][section]["additionalProperties"] = {"anyOf": options}
    schema["properties"]["ground"] = {"anyOf": [names, {"$ref": "#/$defs/Ground"}]}
    profile = {"anyOf": [{"enum": list(PROFILES)}, {"$ref": "#/$defs/Profile"}]}
    parts["Law"]["properties"]["profile"] = profile
    for key in ("polynomial", "table"):
        parts["Law"]["properties"][key] = parts["Profile"]["properties"][key]
    parts["Actuator"]["properties"]["effort"] = {"anyOf": [{"type": "number"}, {"$ref": "#/$defs/Effort"}]}
    describe(schema)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "gim model file"}
