"""The JSON Schema of the model file, generated from the pydantic-core schemas of its parts.

It has a description of each key, which editors show beside the key.
"""

from __future__ import annotations

from inspect import cleandoc
from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from gimcli.model.laws import PROFILES
from gimcli.model.part import Part
from gimcli.model.schema import Model, OpenNode

FILE = {
    "name": "Title of the mechanism",
    "source": "Source of the dimensions; free text",
    "units": "Units of the file and of the results; default m, deg, kg",
    "nodes": "Initial coordinates [x, y] of each node; dimensions that are not given are taken from them. "
    "Without coordinates (`B:` or `B: {side: left}`) they are computed from lengths, angles and shapes",
    "ground": "Nodes fixed to the frame, or {member: NAME} for a floating mechanism",
    "links": "Binary members, by name: [A, B], or {nodes: [A, B], length: L}",
    "elements": "Rigid members of three or more nodes, by name: [A, B, C], or {nodes: [...], shape: {...}}",
    "prismatic": "Sliding pairs, by name",
    "actuators": "Inputs, by name; one per driven degree of freedom",
    "gears": "Gears, belts, and racks with pinions, by name",
    "points": "Points fixed to a member, by name; they do not change the solution",
    "trace": "Points and nodes in the results; default: all points, or every moving node if there are no points",
    "duration": "Time of the whole motion [s]; default 1",
    "masses": "Masses of members, and point masses at nodes, by the name of the member or node: a number or a mapping",
    "gravity": "Acceleration of gravity [m/s^2], [x, y] in the frame; default [0, 0]",
    "loads": "Forces on members and nodes, and torques on members, by name",
    "springs": "Springs between two nodes, along a guide or about a pivot, by name",
    "dampers": "Viscous dampers between two nodes, along a guide or about a pivot, by name",
    "friction": "Friction of pairs by node or sliding pair: a number is viscous [N m s/rad, or N s/m]; "
    "{mu, radius} of a node and {mu, length} of a sliding pair are dry (Coulomb)",
    "parameters": "Numbers by name, for formulas such as 2*a + 3 in place of any number",
    "tolerances": "Tolerances (plus and minus, file's units) by dimension, such as crank, B.x, or a parameter",
    "quantities": "Expressions by name, such as hypot(S.x - 50, S.y), that every command knows by these names",
}
GAUGE = {
    "pivot": "Vertex of the measured angle",
    "arm": "Second node of the ray pivot -> arm, whose angle is measured",
    "reference": "The angle is measured from the ray pivot -> reference; default: the frame's +x direction",
    "nodes": "The two nodes whose distance is measured",
    "node": "Node whose travel along `guide` is measured",
    "guide": "Two nodes; the travel is 0 at the first, positive towards the second",
}
PARTS = {
    "Units": {
        "length": "Unit of length; `unit` is a length without a physical unit",
        "angle": "Unit of angle",
        "mass": "Unit of mass",
    },
    "OpenNode": {
        "side": "Which of two possible positions: left or right as seen from the first to the second of the two nodes "
        "from which distances are given; on a guide, right is farther along it",
    },
    "Ground": {"nodes": "Nodes fixed to the frame", "member": "Member held fixed in a floating mechanism"},
    "Link": {"nodes": "The two nodes", "length": "Length (file's unit); default: from the initial coordinates"},
    "Element": {
        "nodes": "The nodes, three or more",
        "shape": "Coordinates [x, y] of each node in any frame fixed to the member (file's unit of length); "
        "default: the initial coordinates",
    },
    "Prismatic": {
        "node": "Node that slides on the line of the guide and may turn: a pin in a slot",
        "nodes": "Two nodes of one member that slide on the line: the member cannot turn relative to the guide",
        "guide": "Two nodes of one member, or of the ground, that define the direction of the line",
        "offset": "Distance of the line of sliding from the guide nodes' line (file's unit of length), positive to the "
        "left when looking from the first guide node to the second; default 0",
    },
    "Profile": {
        "name": "Name of a profile",
        "polynomial": "Coefficients c0, c1, ... of c0 + c1 t + ..., t being the normalised time 0..1",
        "table": "CSV file of time [s] and value (file's unit); the path starts at the model's folder",
    },
    "Law": {
        "from": "First value, absolute (file's unit of angle or length); default: the initial value",
        "to": "Last value, absolute (file's unit of angle or length)",
        "by": "Increment added to the first value (file's unit of angle or length)",
        "turns": "Rotary: number of turns from the first value, counter-clockwise unless the rate is negative",
        "rate": "Mean speed: a number (file's unit of angle or length, per second) or text such as 60 rpm or 40 mm/s; "
        "with `to`, `by` or `turns` it gives the duration, otherwise the duration gives the last value",
        "profile": "Variation between the first and the last value; default uniform speed",
        "polynomial": "Coefficients c0, c1, ... of c0 + c1 t + ..., t being the normalised time 0..1",
        "table": "CSV file of time [s] and value (file's unit); the path starts at the model's folder",
    },
    "Actuator": {
        "type": "rotary: drives an angle; linear: drives a distance of two nodes, or a travel along a guide; "
        "default: follows from the other keys",
        "pivot": "Rotary: node about which the arm turns",
        "arm": "Rotary: second node of the ray pivot -> arm, whose angle is the input",
        "reference": "Rotary: the angle is measured from the ray pivot -> reference; default: the frame's +x direction",
        "nodes": "Linear: the two nodes whose distance is driven",
        "node": "Linear: node whose travel along `guide` is driven",
        "guide": "Linear: two nodes; the travel is 0 at the first, positive towards the second",
        "law": "Value during the motion; default: a full turn from the initial angle, or the constant initial length",
        "follows": "Name of the actuator that this one follows, with its input times `ratio` plus `phase`",
        "ratio": "Input per input of the actuator that it follows (file's units); default 1",
        "phase": "Input where that of the actuator that it follows is 0 (file's unit); default: as drawn",
        "free": "true: in `gim simulate` forces decide its motion; default false: it follows its law",
        "start": "Initial value of a free input in `gim simulate` (file's unit of angle or length); "
        "default: first value of the law",
        "speed": "Initial speed of a free input in `gim simulate` (file's unit per second, or text such as 60 rpm); "
        "default 0",
        "effort": "Driving torque [N m] or force [N] of a free input: a number or a mapping",
        "rotor": "Inertia of the motor's rotor, and the gear between motor and input",
    },
    "Rotor": {
        "inertia": "Moment of inertia of the rotor about its axis [kg m^2]",
        "ratio": "Rotary input: turns of the rotor per turn of the input, negative for the opposite sense; default 1",
        "lead": "Linear input: travel per turn of the rotor (file's unit of length)",
    },
    "Effort": {
        "constant": "Constant torque [N m] or force [N]",
        "table": "CSV file of two columns: the variable that `over` names, and torque [N m] or force [N]",
        "over": "First column of the table: `time` [s], `value` of the input (file's unit), "
        "or `speed` of the input (file's unit per second); default time",
        "stall": "Torque [N m] or force [N] at speed 0; it changes linearly to 0 at the speed `idle`",
        "idle": "Speed at which the torque or force is 0 (file's unit per second, or text such as 1500 rpm)",
    },
    "Spring": {
        **GAUGE,
        "stiffness": "Stiffness [N/m], or [N m/rad] about a pivot",
        "free": "Length, travel or angle without force (file's unit); default: from the initial coordinates",
    },
    "Damper": {**GAUGE, "damping": "Damping coefficient [N s/m], or [N m s/rad] about a pivot"},
    "PairFriction": {
        "viscous": "Viscous friction [N m s/rad] of a node, or [N s/m] of a sliding pair; default 0",
        "mu": "Coefficient of dry friction; default 0",
        "radius": "Radius of the pin at a node (file's unit of length)",
        "length": "Distance of the two contacts of a sliding pair with two nodes (file's unit of length); they lie on "
        "both sides of the middle of its nodes",
    },
    "Tracer": {
        "on": "Member to which the point is fixed",
        "member": "Another word for `on`",
        "at": "Initial coordinates [x, y] of the point (file's unit of length)",
        "local": "Coordinates [x, y] of the point in the member's own frame (file's unit of length): origin at the "
        "member's first node, x towards its second node, y to the left",
    },
    "Mass": {
        "mass": "Mass (file's unit of mass)",
        "inertia": "Moment of inertia about the centre of mass [kg m^2]; default 0: a point mass",
        "centre": "Centre of mass [x, y] in the member's own frame (file's unit of length): origin at its first node, "
        "x towards its second node, y to the left; default: mean of its nodes",
    },
    "Gear": {
        "type": "Teeth outside (external) or inside (internal) of one wheel, belt or crossed belt, or rack and pinion",
        "members": "The two wheels; of a rack, the pinion and the rack",
        "pivots": "The pivot of each wheel, a node of the wheel and of the carrier; of a rack, that of the pinion",
        "carrier": "Member on which both wheels turn; default: the ground, or the member that has both pivots",
        "ratio": "Turns of the second wheel per turn of the first, relative to the carrier, above 0; the type gives "
        "the sense",
        "teeth": "Numbers of teeth of the two wheels",
        "radii": "Pitch radii (file's unit of length) of the two wheels; of a rack, that of the pinion",
        "pitch": "Length of one tooth of a chain or toothed belt (file's unit); gives the radii of `teeth`",
        "pressure_angle": "Pressure angle of the teeth (file's unit of angle); default 20 deg",
    },
    "Load": {
        "on": "Member or node on which the load acts; a node takes a `force` only",
        "member": "Another word for `on`",
        "at": "Point of application, initial coordinates [x, y] (file's unit of length)",
        "local": "Point of application [x, y] in the member's own frame (file's unit of length): origin at its first "
        "node, x towards its second node, y to the left",
        "force": "Force [N], components [x, y] in the frame",
        "follower": "Force [N] that turns with the member: components [x, y] in the member's own frame",
        "torque": "Torque [N m], positive counter-clockwise",
        "table": "CSV file of two columns: the variable that `over` names, and a factor that multiplies the load; "
        "beyond its rows the factor stays constant",
        "over": "First column of the table: `time` [s], or the name of an actuator (its value, file's unit); "
        "default time",
    },
}


class Generator(GenerateJsonSchema):
    """Schema generator: names may be numbers, numbers formulas, and the docstring of a part is its description."""

    def float_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a number or a formula."""
        return {**super().float_schema(schema), "type": ["number", "string"]}

    def function_before_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a name."""
        return {"type": ["string", "integer"]}

    def model_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a part."""
        part = schema["cls"]
        own = {"title": part.__name__, "description": cleandoc(part.__doc__), "additionalProperties": False}
        return {**self.generate_inner(schema["schema"]), **own}

    def encode_default(self, dft: Any) -> Any:
        """Return a default as plain data."""
        return vars(dft) if isinstance(dft, Part) else super().encode_default(dft)


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of the model file, including the short forms of its sections."""
    schema = Generator(by_alias=True).generate(Model.schema)
    parts = schema["$defs"]
    names = {"type": "array", "items": {"type": ["string", "integer"]}}
    number = {"type": ["number", "string"]}
    alone = {
        "links": {**names, "minItems": 2, "maxItems": 2}, "elements": {**names, "minItems": 3},
        "masses": number, "friction": number,
    }  # fmt: skip
    for section, short in alone.items():
        own = schema["properties"][section]
        own["additionalProperties"] = {"anyOf": [short, own["additionalProperties"]]}
    place = schema["properties"]["nodes"]["additionalProperties"]
    sides = {"type": "object", "description": cleandoc(OpenNode.__doc__ or ""), "additionalProperties": False}
    sides["properties"] = {"side": {"enum": ["left", "right"], "description": PARTS["OpenNode"]["side"]}}
    schema["properties"]["nodes"]["additionalProperties"] = {"anyOf": [place, {"type": "null"}, sides]}
    schema["properties"]["ground"] = {"anyOf": [names, {"$ref": "#/$defs/Ground"}]}
    parts["Law"]["properties"]["profile"] = {"anyOf": [{"enum": list(PROFILES)}, {"$ref": "#/$defs/Profile"}]}
    for key in ("polynomial", "table"):
        parts["Law"]["properties"][key] = parts["Profile"]["properties"][key]
    parts["Actuator"]["properties"]["effort"] = {"anyOf": [number, {"$ref": "#/$defs/Effort"}]}
    for part in ("Tracer", "Load"):
        own = parts[part]
        own["properties"] = {"on": own["properties"]["on"], "member": own["properties"]["on"], **own["properties"]}
        own["required"] = [key for key in own.get("required", ()) if key != "on"]
        own["oneOf"] = [{"required": [key]} for key in ("on", "member")]
    describe(schema)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "gim model file"}


def describe(schema: dict[str, Any]) -> None:
    """Set the descriptions of all keys in a JSON Schema of the model file, in place."""
    parts = [(schema, FILE), *((part, PARTS[name]) for name, part in schema["$defs"].items())]
    for part, texts in parts:
        for key in part["properties"]:
            part["properties"][key] = {**part["properties"][key], "description": texts[key]}
