"""What is wrong with the type of a part, in the words of the file: what was met and what to do."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Collection, Sequence
from typing import Any

from gimcli.model.schema import Model
from gimcli.model.source import Source, Where

MOST_WORDS = 5_000
"""Near misses are looked for among so many names at most: the search is slow."""


def nearest(word: str, words: Collection[str]) -> str | None:
    """Return the word that was probably meant."""
    if len(words) > MOST_WORDS:
        return None
    folded = [w for w in words if w.lower() == word.lower()]
    best = folded or difflib.get_close_matches(word, list(words), 1, 0.6)
    return best[0] if best else None


def near(word: str, words: Collection[str]) -> str:
    """Return '; did you mean X?' for a near miss, else ''."""
    best = nearest(word, words)
    return f"; did you mean '{best}'?" if best else ""


def meant(where: Where) -> Where | None:
    """Return the path that an unknown key was probably meant to have."""
    best = nearest(str(where[-1]), known_keys(where[:-1]))
    return (*where[:-1], best) if best else None


def note(source: Source, error: dict[str, Any]) -> None:
    """Note one error of the schema's validation as a fault of the file."""
    where: Where = tuple(error["loc"])
    kind, met, limits = str(error["type"]), error.get("input"), error.get("ctx", {})
    if kind == "extra_forbidden":
        known = known_keys(where[:-1])
        hint = near(str(where[-1]), known) or f"; known here: {', '.join(known)}"
        source.fault(written(source, where), f"unknown key '{where[-1]}'{hint}", key=True)
    elif kind == "missing":
        source.fault(written(source, where[:-1]), f"'{where[-1]}' is missing; {_missing(where)}")
    else:
        name = ".".join(str(part) for part in where) or "the file"
        text = _TEXTS.get(kind, _other)(where, met, limits)
        source.fault(written(source, where), f"{name}: {text}")


def written(source: Source, where: Where) -> Where:
    """Return a part's path as the file has it: the short forms leave out `nodes` and `profile`."""
    if where in source.values:
        return where
    for k, part in enumerate(where):
        if part in ("nodes", "profile", "constant") and where[: k + 1] not in source.values:
            return written(source, (*where[:k], *where[k + 1 :]))
    return where


def shown(met: Any) -> str:
    """Return what was met, not too long."""
    text = "a mapping" if isinstance(met, dict) else "nothing" if met is None else repr(met)
    return text if len(text) <= 60 else text[:57] + "..."


def known_keys(where: Sequence[Any]) -> list[str]:
    """Return the keys that the mapping at a path may have."""
    schema = Model.schema
    for part in where:
        if schema["type"] == "model":
            field = schema["schema"]["fields"].get(part)
            schema = _bare(field["schema"]) if field else schema
        elif schema["type"] == "dict":
            schema = _bare(schema["values_schema"])
    return [field["validation_alias"] for field in schema["cls"].fields.values()] if schema["type"] == "model" else []


def _bare(schema: Any) -> Any:
    """Return a core schema without its default and null."""
    return _bare(schema["schema"]) if schema["type"] in ("default", "nullable") else schema


# -- sentences ------------------------------------------------------------------------------


def _missing(where: Where) -> str:
    if where == ("ground",):
        return "write `ground: [NODES]`, or `ground: {member: NAME}` for a floating mechanism"
    return f"add `{where[-1]}:`"


def _number(where: Where, met: Any, limits: dict[str, Any]) -> str:
    cure = "; the unit is told once, under `units:`" if isinstance(met, str) and met[:1].isdigit() else ""
    return f"a number is needed, met {shown(met)}{cure}"


def _bound(where: Where, met: Any, limits: dict[str, Any]) -> str:
    words = {"gt": "above", "ge": "at least", "le": "at most"}
    side = next(side for side in words if side in limits)
    return f"must be {words[side]} {limits[side]:g}, met {met}"


def _choice(where: Where, met: Any, limits: dict[str, Any]) -> str:
    words = str(limits.get("expected", "")).replace(" or ", ", ").split(",")
    allowed = [word.strip(" '") for word in words]
    return f"met {shown(met)}; choose {', '.join(allowed)}{near(str(met), allowed)}"


def _count(where: Where, met: Any, limits: dict[str, Any]) -> str:
    few = "min_length" in limits
    bound = f"at least {limits['min_length']}" if few else f"no more than {limits['max_length']}"
    entries = f"{bound} entries are needed, met {limits.get('actual_length')}"
    if where[0] == "links" and not few:
        return f"{entries}; list a member of three or more nodes under `elements:`"
    if where[0] == "elements" and where[2:] == ("nodes",):
        return f"{entries}; list a member of two nodes under `links:`"
    return entries


def _form(where: Where, met: Any, limits: dict[str, Any]) -> str:
    return f"{_forms(where)} is needed, met {shown(met)}"


def _forms(where: Where) -> str:
    if where == ("ground",):
        return "a list of nodes or {member: NAME}"
    if len(where) == 2 and where[0] in ("links", "elements"):
        return "a list of nodes such as [A, B] or a mapping of keys"
    return f"a mapping such as {{{known_keys(where)[0]}: ...}}" if known_keys(where) else "a mapping such as {A: ...}"


def _name(where: Where, met: Any, limits: dict[str, Any]) -> str:
    cure = "; write it in quotes if this is the name" if isinstance(met, bool | float) else ""
    return f"a name is needed, met {shown(met)}{cure}"


def _other(where: Where, met: Any, limits: dict[str, Any]) -> str:
    return f"met {shown(met)}, which cannot stand here"


_TEXTS: dict[str, Callable[[Where, Any, dict[str, Any]], str]] = {
    "float_type": _number,
    "float_parsing": _number,
    "bool_type": lambda where, met, limits: f"true or false is needed, met {shown(met)}",
    "finite_number": lambda where, met, limits: f"a finite number is needed, met {met}",
    "greater_than": _bound,
    "greater_than_equal": _bound,
    "less_than_equal": _bound,
    "literal_error": _choice,
    "too_short": _count,
    "too_long": _count,
    "list_type": lambda where, met, limits: f"a list such as {_list(where)} is needed, met {shown(met)}",
    "dict_type": _form,
    "model_type": _form,
    "string_type": _name,
    "string_too_short": _name,
}


def _list(where: Where) -> str:
    return (
        "[0, 0]"
        if where[0] == "nodes" or where[-1] in ("at", "local", "centre", "force", "follower", "gravity")
        else "[A, B]"
    )
