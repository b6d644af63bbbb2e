"""What each key of the model file means, for editors that show it beside the key."""

from __future__ import annotations

from typing import Any

FILE = {
    "name": "Title of the mechanism",
    "source": "Where the dimensions come from; free text",
    "units": "Units of the file, in and out; default m, deg, kg",
    "nodes": "Drawn position of each node: the start, and the source of every dimension not given",
    "ground": "Nodes fixed to the frame, or {member: NAME} for a floating mechanism",
    "links": "Binary members, by name: [A, B], or {nodes: [A, B], length: L}",
    "elements": "Rigid members of three or more nodes, by name: [A, B, C], or {nodes: [...], shape: {...}}",
    "prismatic": "Sliding pairs, by name",
    "actuators": "Inputs, by name; one per freedom that is driven",
    "points": "Points carried by a member, by name; they cost nothing in the solution",
    "trace": "Points and nodes that are written out; default: all points, or every moving node",
    "duration": "Time of the whole motion [s]; default 1",
    "masses": "Mass of each member, by the member's name",
    "gravity": "Acceleration of gravity [m/s2], [x, y] in the frame",
    "loads": "Forces and torques on members, by name",
    "springs": "Springs between two nodes, along a guide or about a pivot, by name",
    "dampers": "Viscous dampers between two nodes, along a guide or about a pivot, by name",
    "friction": "Viscous friction of pairs, by node [N m s/rad] or sliding pair [N s/m]",
}
GAUGE = {
    "pivot": "Node about which the angle pivot -> arm is measured",
    "arm": "Node of the ray pivot -> arm",
    "reference": "Node of the ray from which the angle counts; default: the frame's +x direction",
    "nodes": "The two nodes whose distance is measured",
    "node": "Node whose travel along `guide` is measured",
    "guide": "Travel counts from the first node, positive towards the second",
}
PARTS = {
    "Units": {
        "length": "Unit of length; `unit` is no physical one",
        "angle": "Unit of angle",
        "mass": "Unit of mass",
    },
    "Ground": {"nodes": "Nodes fixed to the frame", "member": "Member held in a floating mechanism"},
    "Link": {"nodes": "The two nodes", "length": "Length; default: as drawn"},
    "Element": {
        "nodes": "The nodes, three or more",
        "shape": "Place of each node in the member's own frame; default: as drawn",
    },
    "Prismatic": {
        "node": "Node that stays on the line of the guide: a pin in a slot",
        "nodes": "Two nodes of one member that stay on the line: no relative rotation",
        "guide": "Two nodes of one member, or of the ground, that show the line",
        "offset": "Signed distance of the line to the left of the guide's direction",
    },
    "Profile": {
        "name": "Profile",
        "polynomial": "Coefficients c0, c1, ... in the normalised time 0..1",
        "table": "CSV file of time [s] and value, its path from the model's folder",
    },
    "Law": {
        "from": "First value, absolute",
        "to": "Last value, absolute",
        "by": "Increment on the drawn value",
        "profile": "How the input runs between its ends; default uniform",
        "polynomial": "Coefficients c0, c1, ... in the normalised time 0..1",
        "table": "CSV file of time [s] and value, its path from the model's folder",
    },
    "Actuator": {
        "type": "What is driven: an angle, or a distance or travel",
        "pivot": "Rotary: node about which the arm turns",
        "arm": "Rotary: node of the ray pivot -> arm",
        "reference": "Rotary: node of the ray from which the angle counts; default: the frame's +x direction",
        "nodes": "Linear: the two nodes whose distance is driven",
        "node": "Linear: node whose travel along `guide` is driven",
        "guide": "Linear: travel counts from the first node, positive towards the second",
        "law": "Value over the motion; default: the drawn value, and a rotary input turns once",
        "free": "Whether `gim simulate` lets the loads move it; default: it follows its law",
        "start": "Value at which `gim simulate` begins; default: where the law starts",
        "speed": "Speed at which `gim simulate` begins, in the file's unit per second; default 0",
        "effort": "Driving torque [N m] or force [N] of a free input: a number or a mapping",
    },
    "Effort": {
        "constant": "Constant torque [N m] or force [N]",
        "table": "CSV file of two columns, what `over` names and torque [N m] or force [N]",
        "over": "What the table runs over: time [s], the input's value or its speed; default time",
        "stall": "Torque or force at standstill",
        "idle": "Speed at which it has fallen to 0, in the file's unit per second",
    },
    "Spring": {
        **GAUGE,
        "stiffness": "Stiffness [N/m], or [N m/rad] about a pivot",
        "free": "Length, travel or angle without force; default: as drawn",
    },
    "Damper": {**GAUGE, "damping": "Damping [N s/m], or [N m s/rad] about a pivot"},
    "Tracer": {
        "on": "Member that carries the point",
        "at": "Drawn position [x, y]",
        "local": "Along, and to the left of, the member's first node -> second node",
    },
    "Mass": {
        "mass": "Mass",
        "inertia": "Moment of inertia about the centre of mass [kg m2]; default 0: a point mass",
        "centre": "Centre of mass: along, and to the left of, first node -> second; default: mean of the nodes",
    },
    "Load": {
        "on": "Member that is loaded",
        "at": "Point of the force, drawn position [x, y]",
        "local": "Point of the force: along, and to the left of, first node -> second node",
        "force": "Force [N], [x, y] in the frame",
        "follower": "Force [N] that turns with the member: along, and to the left of, first node -> second node",
        "torque": "Torque [N m]",
        "table": "CSV file of two columns, what `over` names and a factor of the load; the ends go on",
        "over": "What the table runs over: time [s], or an actuator by name; default time",
    },
}


def describe(schema: dict[str, Any]) -> None:
    """Set the descriptions of all keys in a JSON Schema of the file."""
    parts = [(schema, FILE), *((part, PARTS[name]) for name, part in schema["$defs"].items())]
    for part, texts in parts:
        for key in part["properties"]:
            part["properties"][key] = {**part["properties"][key], "description": texts[key]}
