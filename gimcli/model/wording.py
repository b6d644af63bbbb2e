"""Messages for validation errors: what was expected, what the file has, and which key was probably meant."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gimcli.model.part import MEMBER_WORDS
from gimcli.model.schema import Model, OpenNode
from gimcli.model.source import Source, Where
from gimcli.nearest import near, nearest

NONE: Mapping[Where, str] = {}
SYNONYMS = {
    "joints": "nodes", "joint": "nodes", "pivots": "nodes", "pins": "nodes", "vertices": "nodes",
    "coordinates": "nodes", "positions": "nodes",
    "fixed": "ground", "frame": "ground", "base": "ground", "supports": "ground", "anchors": "ground",
    "bars": "links", "bar": "links", "rods": "links", "members": "links",
    "bodies": "elements", "body": "elements", "plates": "elements", "ternary": "elements",
    "sliders": "prismatic", "slider": "prismatic", "slides": "prismatic", "slots": "prismatic",
    "pistons": "prismatic",
    "motors": "actuators", "motor": "actuators", "inputs": "actuators", "input": "actuators", "drivers": "actuators",
    "driver": "actuators", "drives": "actuators", "cylinders": "actuators", "cranks": "actuators",
    "forces": "loads", "force": "loads", "torques": "loads", "moments": "loads",
    "mass": "masses", "inertias": "masses", "tracers": "points", "markers": "points", "output": "trace",
    "outputs": "trace", "title": "name", "time": "duration",
    "speed": "rate", "velocity": "rate", "omega": "rate", "rpm": "rate", "revolutions": "turns", "cycles": "turns",
    "speed_rpm": "rate", "rev": "turns", "stroke": "law", "k": "stiffness", "c": "damping",
    "rate": "law", "turns": "law", "by": "law", "from": "law", "to": "law", "profile": "law",
    "variables": "parameters", "params": "parameters", "constants": "parameters",
}  # fmt: skip
"""Keys of other programs and of everyday use, and the key of the model file for each."""
_ACTUATOR_HINTS = {
    "rpm": "write `rate: 60 rpm`", "speed_rpm": "write `rate: 60 rpm`", "stroke": "write `law: {from: ..., to: ...}`",
    "link": "a motor has a `pivot` and an `arm`, two nodes of the link",
}  # fmt: skip

GROUND = "write `ground: [NODES]`, or `ground: {member: NAME}` for a floating mechanism"
FORMS = {
    "ground": "a list of nodes or {member: NAME}", "masses": "a number or a mapping such as {mass: ...}",
    "friction": "a number or a mapping such as {mu: ..., radius: ...}",
    **dict.fromkeys(("links", "elements"), "a list of nodes such as [A, B] or a mapping of keys"),
}  # fmt: skip
"""What the ground, or a part of a section, may be written as."""


def intended(where: Where) -> Where | None:
    """Return the path of the key that was probably meant by an unknown key; None if there is no guess."""
    known = known_keys(where[:-1])
    synonym = SYNONYMS.get(str(where[-1]).lower())
    best = synonym if synonym in known else nearest(str(where[-1]), known)
    return (*where[:-1], best) if best else None


def record(source: Source, error: dict[str, Any], refused: Mapping[Where, str] = NONE) -> None:
    """Record one validation error of pydantic as an error of the file.

    `refused` has the reasons why texts in place of numbers have no value; those without a reason are not recorded.
    """
    where: Where = tuple(error["loc"])
    kind, got, limits = str(error["type"]), error.get("input"), error.get("ctx", {})
    if kind == "extra_forbidden" and where[0] in ("points", "loads") and where[-1] in MEMBER_WORDS:
        text = f"`{where[-1]}` is another word for `on`, and two of these words are given; remove one"
        source.fault(where, text, key=True)
    elif kind == "extra_forbidden":
        guess = intended(where)
        hint = f"did you mean '{guess[-1]}'?" if guess else f"known here: {', '.join(known_keys(where[:-1]))}"
        hint = "write coordinates as [x, y], or {side: left}" if where[0] == "nodes" and not guess else hint
        hint = _ACTUATOR_HINTS.get(str(where[-1]).lower(), hint) if where[0] == "actuators" else hint
        source.fault(written(source, where), f"unknown key '{where[-1]}'; {hint}", key=True)
    elif kind == "missing":
        cure = GROUND if where == ("ground",) else f"add `{where[-1]}:`"
        source.fault(written(source, where[:-1]), f"'{where[-1]}' is missing; {cure}")
    elif refused.get(where, kind):
        name = ".".join(str(part) for part in written(source, where)) or "the file"
        reason = f"; {refused[where]}" if where in refused else ""
        source.fault(written(source, where), f"{name}: {expected(where, kind, got, limits)}{reason}")


def expected(where: Where, kind: str, got: Any, limits: dict[str, Any]) -> str:
    """Return what was expected at a path and what was found, for a kind of error of pydantic."""
    return _TEXTS[kind](where, got, limits) if kind in _TEXTS else f"unexpected value {shown(got)}"


def written(source: Source, where: Where) -> Where:
    """Return the path of a part as it is in the file.

    Short forms have no `nodes`, `profile`, `constant`, `mass` and `viscous`. The key `on` has the word that the file
    uses for it.
    """
    if not where or where in source.values:
        return where
    if where[0] in ("points", "loads") and where[2:] == ("on",):
        words = (word for word in MEMBER_WORDS if (*where[:2], word) in source.values)
        return (*where[:2], next(words, "on"))
    for k, part in enumerate(where):
        if part in ("nodes", "profile", "constant", "mass", "viscous") and where[: k + 1] not in source.values:
            return written(source, (*where[:k], *where[k + 1 :]))
    return where


def shown(got: Any) -> str:
    """Return the text of a value, cut at 60 characters."""
    text = "a mapping" if isinstance(got, dict) else "nothing" if got is None else repr(got)
    return text if len(text) <= 60 else text[:57] + "..."


def known_keys(where: Sequence[Any]) -> list[str]:
    """Return the keys that the mapping at a path may have."""
    schema = OpenNode.schema if len(where) == 2 and where[0] == "nodes" else value_schema(where)
    return [field["validation_alias"] for field in schema["cls"].fields.values()] if schema["type"] == "model" else []


def value_schema(where: Sequence[Any]) -> Any:
    """Return the schema of the value at a path, or of the part around it that the format knows."""
    schema = Model.schema
    for part in where:
        if schema["type"] == "model":
            fields = schema["schema"]["fields"]
            field = fields.get(part) or fields.get(f"{part}_")
            schema = _bare(field["schema"]) if field else schema
        elif schema["type"] == "dict":
            schema = _bare(schema["values_schema"])
        elif schema["type"] == "list":
            schema = _bare(schema["items_schema"])
    return schema


def _bare(schema: Any) -> Any:
    """Return the schema inside the wrappers for a default, for null and for nodes without coordinates."""
    return _bare(schema["schema"]) if schema["type"] in ("default", "nullable", "function-wrap") else schema


# -- texts ----------------------------------------------------------------------------------


def _bound(where: Where, got: Any, limits: dict[str, Any]) -> str:
    words = {"gt": "above", "ge": "of at least", "le": "of at most"}
    side = next(side for side in words if side in limits)
    return f"expected a number {words[side]} {limits[side]:g}, got {got}"


def _choice(where: Where, got: Any, limits: dict[str, Any]) -> str:
    allowed = re.findall("'([^']*)'", limits["expected"])
    return f"expected one of {', '.join(allowed)}, got {shown(got)}{near(str(got), allowed)}"


def _count(where: Where, got: Any, limits: dict[str, Any]) -> str:
    few = "min_length" in limits
    bound = f"at least {limits['min_length']}" if few else f"at most {limits['max_length']}"
    entries = f"expected {bound} entries, got {limits.get('actual_length')}"
    if where[0] == "links" and not few:
        return f"{entries}; list a member of three or more nodes under `elements:`"
    if where[0] == "elements" and where[2:] == ("nodes",):
        return f"{entries}; list a member of two nodes under `links:`"
    return entries


def _forms(where: Where) -> str:
    if (len(where) == 2 and where[0] in FORMS) or where == ("ground",):
        return FORMS[str(where[0])]
    return f"a mapping such as {{{known_keys(where)[0]}: ...}}" if known_keys(where) else "a mapping such as {A: ...}"


def _name(where: Where, got: Any, limits: dict[str, Any]) -> str:
    cure = "; write it in quotes if this is the name" if isinstance(got, bool | float) else ""
    return f"expected a name, got {shown(got)}{cure}"


def _items(where: Where, got: Any, limits: dict[str, Any]) -> str:
    if len(where) == 2 and where[0] == "nodes" and got in ("left", "right"):
        return f"expected [x, y] or {{side: {got}}}, got {shown(got)}"
    return f"expected a list such as {_list(where)}, got {shown(got)}"


_TEXTS: dict[str, Callable[[Where, Any, dict[str, Any]], str]] = {
    "float_type": lambda where, got, limits: f"expected a number, got {shown(got)}",
    "bool_type": lambda where, got, limits: f"expected true or false, got {shown(got)}",
    "finite_number": lambda where, got, limits: f"expected a finite number, got {got}",
    "greater_than": _bound,
    "greater_than_equal": _bound,
    "less_than_equal": _bound,
    "literal_error": _choice,
    "too_short": _count,
    "too_long": _count,
    "list_type": _items,
    **dict.fromkeys(
        ("dict_type", "model_type"), lambda where, got, limits: f"expected {_forms(where)}, got {shown(got)}"
    ),
    "string_type": _name,
    "string_too_short": _name,
}


def _list(where: Where) -> str:
    if where[0] != "nodes" and where[-1] not in ("at", "local", "centre", "force", "follower", "gravity"):
        return "[A, B]"
    return "[0, 0] or {side: left}" if where[0] == "nodes" and len(where) == 2 else "[0, 0]"
