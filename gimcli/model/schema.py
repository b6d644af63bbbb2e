"""The model as written in the file: its keys, their types and their units.

"File's unit" is the unit that `units:` sets for an angle, a length or a mass.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from pydantic_core import core_schema

from gimcli.model.part import Part

if TYPE_CHECKING:
    from gimcli.language.expression import Expression

SHORTEST, LONGEST = 1e-12, 1e12
"""Least and greatest duration of a motion [s]; powers of other durations would underflow or overflow."""
LARGEST = 1e30
"""Greatest mass, force and the like; products of greater values would overflow."""
LONGEST_ARM = 1e15
"""Greatest coordinate of a centre of mass and of a point where a load acts: moments of inertia have its square."""
FARTHEST = 1e100
"""Greatest coordinate of a node or point, and offset of a guide, as of a mechanism's size."""
MOST_COEFFICIENTS = 100
"""Most coefficients of a polynomial: its roots take long to compute, and high powers of the time hardly differ."""
NO_FORMULAS: Mapping[tuple[str | int, ...], Expression] = MappingProxyType({})
WHOLE = ("duration", "gravity")
"""Sections with numbers but without names."""
DYNAMIC = ("masses", "loads", "springs", "dampers", "friction")
"""Sections on which positions do not depend."""
ENDS = ("to", "by", "turns")
"""Keys of which a law may have one; a rate needs none of them where the duration is known."""


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
VECTOR, ARM = _list(AMOUNT, 2, 2), _list(_number(ge=-LONGEST_ARM, le=LONGEST_ARM), 2, 2)
DISTANCE = _number(ge=-FARTHEST, le=FARTHEST)
POINT = _list(DISTANCE, 2, 2)
NAMES, PAIR = _list(NAME), _list(NAME, 2, 2)


# -- parts ----------------------------------------------------------------------------------


class Units(Part):
    """Units of the file and of the results; `unit` is a length without a physical unit."""

    length: str = _default(_choice("m", "mm", "cm", "um", "km", "in", "ft", "unit"), "m")
    angle: str = _default(_choice("deg", "rad"), "deg")
    mass: str = _default(_choice("kg", "g", "t", "lb"), "kg")


class OpenNode(Part):
    """A node without coordinates: they are computed from lengths, angles and shapes.

    Where two positions are possible, `side` chooses. Two distances: the side as seen from the first to the second of
    the two nodes from which they are measured, in the order of `nodes`. On a guide: `right` is farther along it.
    """

    side: str | None = _optional(_choice("left", "right"))


def _place_or_open(value: Any, place: Any) -> Any:
    """Return the coordinates of a node, or an open node for a mapping or an empty value."""
    return OpenNode.model_validate(value or {}) if value is None or isinstance(value, dict) else place(value)


class OpenNodes(NamedTuple):
    """The nodes of a model that have no coordinates in the file."""

    parts: Mapping[str, OpenNode] = MappingProxyType({})
    sides: Mapping[str, str] = MappingProxyType({})
    """The sides that are chosen, by node; nodes with only one position have none."""
    undecided: tuple[str, ...] = ()
    """The nodes whose side neither the file nor the other lengths determine; one of the two is used."""
    coupled: tuple[str, ...] = ()
    """The nodes that cannot be placed one after the other; their positions are rough until a configuration is found."""
    chosen: tuple[str, ...] = ()
    """Those of them whose configuration was chosen among several."""


NO_OPEN_NODES = OpenNodes()
NODE = core_schema.no_info_wrap_validator_function(_place_or_open, POINT)


class Ground(Part):
    """Nodes fixed to the frame, or the member held fixed in a floating mechanism (one without a ground)."""

    nodes: list[str] = _default(NAMES, [])
    member: str | None = _optional(NAME)


class Link(Part):
    """Binary member: two nodes; the length (file's unit) is taken from the initial coordinates unless given."""

    nodes: list[str] = PAIR
    length: float | None = _optional(LENGTH)


class Element(Part):
    """Rigid member of three or more nodes.

    The shape is taken from the initial coordinates, unless `shape` gives the coordinates of each node (file's unit of
    length) in any frame fixed to the member.
    """

    nodes: list[str] = _list(NAME, 3)
    shape: dict[str, list[float]] | None = _optional(_by_name(POINT))


class Prismatic(Part):
    """Sliding pair: `node` is a pin in a slot; `nodes` are two nodes of a member that slides without turning.

    The line of sliding is parallel to the direction from the first to the second node of `guide`, at the distance
    `offset` (file's unit of length) from the guide nodes, positive to the left of that direction.
    """

    node: str | None = _optional(NAME)
    nodes: list[str] | None = _optional(PAIR)
    guide: list[str] = PAIR
    offset: float = _default(DISTANCE, 0.0)

    @property
    def sliding(self) -> list[str]:
        """The nodes that slide."""
        return [self.node] if self.node is not None else self.nodes or []


class Profile(Part):
    """Variation of an input between its first and last value: a name, a polynomial or a table.

    The polynomial is in the normalised time 0..1; the table is a CSV file of time [s] and value (file's unit).
    """

    name: str = _default(STRING, "uniform")
    polynomial: list[float] | None = _optional(_list(NUMBER, 1, MOST_COEFFICIENTS))
    table: str | None = _optional(STRING)


class Law(Part):
    """Law of motion, from `from` or the initial value, to `to` or over the increment `by` or `turns` (file's unit).

    `rate` is the mean speed (file's unit per second); with an end it gives the duration, with the duration the end.
    """

    from_: float | None = _optional(NUMBER)
    to: float | None = _optional(NUMBER)
    by: float | None = _optional(NUMBER)
    turns: float | None = _optional(NUMBER)
    rate: float | None = _optional(NUMBER)
    profile: Profile = _default(Profile.schema, Profile())

    @property
    def end(self) -> str | None:
        """The key of `ENDS` that is given, the first one; None if there is none."""
        return next((key for key in ENDS if getattr(self, key) is not None), None)


class Gauge(Part):
    """A measured quantity: the angle of the ray pivot -> arm, the distance of two nodes, or a travel along a guide.

    The angle is measured from the ray pivot -> reference, or from the frame's +x direction. The travel of `node` is
    measured along `guide`, from its first node, positive towards its second.
    """

    pivot: str | None = _optional(NAME)
    arm: str | None = _optional(NAME)
    reference: str | None = _optional(NAME)
    nodes: list[str] | None = _optional(PAIR)
    node: str | None = _optional(NAME)
    guide: list[str] | None = _optional(PAIR)

    @property
    def rotary(self) -> bool:
        """Whether the quantity is an angle; otherwise it is a length."""
        return self.pivot is not None or self.arm is not None

    @property
    def keyed(self) -> list[tuple[str, str]]:
        """The nodes of the quantity with their keys; those of its guide are the last ones."""
        single = ((key, getattr(self, key)) for key in ("pivot", "arm", "reference", "node"))
        listed = ((key, name) for key in ("nodes", "guide") for name in getattr(self, key) or [])
        return [*((key, name) for key, name in single if name is not None), *listed]

    @property
    def named(self) -> list[str]:
        """The nodes of the quantity; those of its guide are the last ones."""
        return [name for _, name in self.keyed]


class Effort(Part):
    """Driving torque [N m] or force [N]: constant, from a table, or linear in the speed.

    `over` names the first column of the table: `time` [s], `value` of the input (file's unit) or `speed` of the input
    (file's unit per second). The linear characteristic is `stall` at speed 0 and 0 at the speed `idle` (file's unit
    per second).
    """

    constant: float | None = _optional(AMOUNT)
    table: str | None = _optional(STRING)
    over: str = _default(_choice("time", "value", "speed"), "time")
    stall: float | None = _optional(AMOUNT)
    idle: float | None = _optional(AMOUNT)


class Rotor(Part):
    """The rotor of the motor behind an actuator: moment of inertia [kg m^2], and the gear between both.

    A rotor turns `ratio` times per turn of a rotary input, and once per `lead` (file's unit of length) of a linear one.
    """

    inertia: float = POSITIVE
    ratio: float = _default(NUMBER, 1.0)
    lead: float | None = _optional(NUMBER)


class Actuator(Gauge):
    """An input: a rotary actuator (`pivot`, `arm`) or a linear one (`nodes`, or `node` and `guide`).

    The type may be given, too; it follows from the other keys.

    An input that `follows` another has the value `ratio` (default 1) times the other's value plus `phase` (file's
    units); without `phase` it agrees with the initial coordinates.

    `free`, `start`, `speed` and `effort` are for simulations, where a free input is moved by forces instead of its law:
    `start` is its initial value (file's unit of angle or length), `speed` its initial speed (that unit per second).
    `rotor` is the inertia of its motor.
    """

    type: str | None = _optional(_choice("rotary", "linear"))
    law: Law | None = _optional(Law.schema)
    follows: str | None = _optional(NAME)
    ratio: float | None = _optional(NUMBER)
    phase: float | None = _optional(AMOUNT)
    free: bool = _default(core_schema.bool_schema(strict=True), False)
    start: float | None = _optional(NUMBER)
    speed: float = _default(AMOUNT, 0.0)
    effort: Effort | None = _optional(Effort.schema)
    rotor: Rotor | None = _optional(Rotor.schema)


class Gear(Part):
    """Two members that turn about pivots of one carrier and are coupled by teeth or a belt; or a rack and pinion.

    `members` are the two wheels, `pivots` their nodes on the `carrier` (by default the ground, or the member that has
    both pivots). The wheels are given by `teeth`, by their pitch `radii` (file's unit of length), or by `ratio`: turns
    of the second member per turn of the first, relative to the carrier; its sense follows from `type`. `pitch` is the
    length of one tooth of a chain or toothed belt along the pitch line. `rack`: the second member slides on the
    carrier, `pivots` has the pinion's pivot, `radii` the pinion's radius. The wheels mesh as drawn.
    `pressure_angle` is that of the teeth (file's unit of angle, by default 20 deg).
    """

    type: str = _default(_choice("external", "internal", "belt", "crossed", "rack"), "external")
    members: list[str] = PAIR
    pivots: list[str] = _list(NAME, 1, 2)
    carrier: str | None = _optional(NAME)
    ratio: float | None = _optional(LENGTH)
    teeth: list[float] | None = _optional(_list(LENGTH, 2, 2))
    radii: list[float] | None = _optional(_list(LENGTH, 1, 2))
    pitch: float | None = _optional(LENGTH)
    pressure_angle: float | None = _optional(NUMBER)


class Tracer(Part):
    """A point fixed to a member, given by its initial coordinates `at` or by `local`.

    `local` is [x, y] in the member's own frame (file's unit of length): origin at the member's first node, x towards
    its second node, y to the left of that direction.
    """

    on: str = NAME
    at: list[float] | None = _optional(POINT)
    local: list[float] | None = _optional(POINT)


class Mass(Part):
    """Mass (file's unit), moment of inertia about the centre of mass [kg m^2], and the centre of mass.

    `centre` is [x, y] in the member's own frame, as `local` of a point. A mass at a node is a point mass.
    """

    mass: float = POSITIVE
    inertia: float | None = _optional(POSITIVE)
    centre: list[float] | None = _optional(ARM)


class Load(Part):
    """A force [N] at a point of a member or at a node, or a torque [N m]; a table gives a factor that multiplies it.

    `force` keeps its direction in the frame, `follower` turns with the member. `over` names the first column of the
    table: `time` [s] or an actuator (its value in the file's unit).
    """

    on: str = NAME
    at: list[float] | None = _optional(ARM)
    local: list[float] | None = _optional(ARM)
    force: list[float] | None = _optional(VECTOR)
    follower: list[float] | None = _optional(VECTOR)
    torque: float | None = _optional(AMOUNT)
    table: str | None = _optional(STRING)
    over: str = _default(NAME, "time")


class Spring(Gauge):
    """A linear spring between two nodes or along a guide [N/m], or a torsion spring about a pivot [N m/rad].

    `free` is the length, travel or angle without force (file's unit).
    """

    stiffness: float = _number(gt=0, le=LARGEST)
    free: float | None = _optional(AMOUNT)


class Damper(Gauge):
    """A viscous damper between two nodes or along a guide [N s/m], or about a pivot [N m s/rad]."""

    damping: float = POSITIVE


class PairFriction(Part):
    """Friction of the revolute pairs at a node, or of a sliding pair: viscous, dry (Coulomb), or both.

    Dry friction needs `mu`, and at a node the `radius` of the pin (file's unit of length). In a sliding pair with two
    nodes, `length` (file's unit) is the distance of the two contacts that bear its moment; they lie on both sides of
    the middle of its nodes.
    """

    viscous: float | None = _optional(POSITIVE)
    mu: float | None = _optional(POSITIVE)
    radius: float | None = _optional(LENGTH)
    length: float | None = _optional(LENGTH)


class Model(Part):
    """A planar mechanism."""

    name: str = _default(TEXT, "")
    source: str = _default(TEXT, "")
    units: Units = _default(Units.schema, Units())
    nodes: dict[str, list[float]] = _by_name(NODE)
    ground: Ground = Ground.schema
    links: dict[str, Link] = _section(Link.schema)
    elements: dict[str, Element] = _section(Element.schema)
    prismatic: dict[str, Prismatic] = _section(Prismatic.schema)
    actuators: dict[str, Actuator] = _section(Actuator.schema)
    gears: dict[str, Gear] = _section(Gear.schema)
    points: dict[str, Tracer] = _section(Tracer.schema)
    trace: list[str] = _default(NAMES, [])
    duration: float | None = _optional(SECONDS)
    masses: dict[str, Mass] = _section(Mass.schema)
    gravity: list[float] | None = _optional(VECTOR)
    loads: dict[str, Load] = _section(Load.schema)
    springs: dict[str, Spring] = _section(Spring.schema)
    dampers: dict[str, Damper] = _section(Damper.schema)
    friction: dict[str, PairFriction] = _section(PairFriction.schema)
    parameters: dict[str, float] = _section(NUMBER)
    tolerances: dict[str, float] = _section(LENGTH)
    quantities: dict[str, str] = _section(TEXT)

    _elements_first = False
    formulas = NO_FORMULAS
    """The formulas by the paths of their numbers; those of parameters first, in the order of their evaluation."""
    open = NO_OPEN_NODES
    """The nodes without coordinates in the file; `nodes` has their positions."""

    def written_in(self, keys: Iterable[str]) -> None:
        """Store the order of the sections `links` and `elements` in the file; `members` keeps it."""
        order = list(keys)
        self._elements_first = {"links", "elements"} <= set(order) and order.index("elements") < order.index("links")

    def without_dynamics(self) -> Model:
        """Return a copy without the parts on which positions do not depend."""
        model = self
        for section in DYNAMIC:
            model = model.with_value(section, lambda _: {})
        return model.with_value(
            "actuators", lambda old: {name: one.with_value("rotor", lambda _: None) for name, one in old.items()}
        )

    @property
    def members(self) -> dict[str, Link | Element]:
        """All members by name, in the order of the file."""
        parts: tuple[dict[str, Any], dict[str, Any]] = (self.links, self.elements)
        first, second = reversed(parts) if self._elements_first else parts
        return {**first, **second}
